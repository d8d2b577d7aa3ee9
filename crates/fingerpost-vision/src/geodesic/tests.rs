use proptest::prelude::*;

use super::*;
use crate::test_pictures::config;

/// Bellman and Ford's relaxation until nothing changes.
fn plain(cost: &Plane<u32>, seeds: &Plane<u32>) -> Plane<u32> {
    let (width, height) = cost.size();
    let mut distance = seeds.clone();
    loop {
        let before = distance.clone();
        for y in 0..height {
            for x in 0..width {
                for (dx, dy) in [(-1, -1), (0, -1), (1, -1), (-1, 0), (1, 0), (-1, 1), (0, 1), (1, 1)] {
                    let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
                        continue;
                    };
                    let Some(from) = distance.get(nx, ny) else { continue };
                    let sum = cost.row(y)[x] + cost.row(ny)[nx];
                    let step = if dx != 0 && dy != 0 { (sum * 181) >> 7 } else { sum };
                    distance.row_mut(y)[x] = distance.row(y)[x].min(from + step);
                }
            }
        }
        if distance.as_slice() == before.as_slice() {
            return distance;
        }
    }
}

fn scenes() -> impl Strategy<Value = (Plane<u32>, Plane<u32>)> {
    (1..40_usize, 1..20_usize, any::<u64>()).prop_map(|(width, height, seed)| {
        let mut state = seed;
        let mut next = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 40
        };
        let costs =
            (0..width * height).map(|_| if next() % 5 == 0 { 4_000 } else { 1 + (next() % 200) as u32 });
        let cost = Plane::from_vec(width, height, costs.collect()).unwrap();
        let mut seeds = Plane::new(width, height, UNREACHED);
        seeds.row_mut(height - 1)[width / 2] = 0;
        (cost, seeds)
    })
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn many_sweeps_find_the_cheapest_ways_on_every_path((cost, seeds) in scenes()) {
        let expected = plain(&cost, &seeds);
        for path in CodePath::available() {
            let mut distance = seeds.clone();
            GeodesicSweeps::default().spread_on(path, &cost, 0, 40, &mut distance).unwrap();
            prop_assert_eq!(distance.as_slice(), expected.as_slice());
        }
    }

    #[test]
    fn few_sweeps_are_never_below_the_cheapest_way_and_the_same_on_every_path((cost, seeds) in scenes()) {
        let least = plain(&cost, &seeds);
        let mut first: Option<Plane<u32>> = None;
        for path in CodePath::available() {
            let mut distance = seeds.clone();
            GeodesicSweeps::default().spread_on(path, &cost, 0, 3, &mut distance).unwrap();
            prop_assert!(distance.as_slice().iter().zip(least.as_slice()).all(|(found, least)| found >= least));
            prop_assert!(first.as_ref().is_none_or(|first| first.as_slice() == distance.as_slice()));
            first = Some(distance);
        }
    }
}

#[test]
fn a_wall_is_gone_round_through_its_gap() {
    let mut cost = Plane::new(9, 5, 1);
    cost.row_mut(2)[..8].fill(MAX_COST);
    let mut distance = Plane::new(9, 5, UNREACHED);
    distance.row_mut(4)[0] = 0;
    GeodesicSweeps::default().spread(&cost, 0, 3, &mut distance).unwrap();
    assert!(distance.row(0)[0] < 40, "{}", distance.row(0)[0]);
    let mut near = Plane::new(9, 5, 0);
    nearness(&distance, 18, &mut near).unwrap();
    assert_eq!(near.row(4)[0], 255);
    assert_eq!(near.row(4)[8], 150);
    assert_eq!(near.row(2)[3], 0);
}

#[test]
fn rows_above_the_first_are_left_out() {
    let mut distance = Plane::new(3, 3, UNREACHED);
    distance.row_mut(2)[0] = 0;
    GeodesicSweeps::default().spread(&Plane::new(3, 3, 2), 1, 3, &mut distance).unwrap();
    assert_eq!(distance.as_slice(), &[UNREACHED, UNREACHED, UNREACHED, 4, 5, 9, 0, 4, 8]);
}

#[test]
fn without_seeds_nothing_is_reached() {
    let mut distance = Plane::new(4, 3, UNREACHED);
    GeodesicSweeps::default().spread(&Plane::new(4, 3, 5), 0, 3, &mut distance).unwrap();
    assert!(distance.as_slice().iter().all(|&distance| distance >= UNREACHED));
    let mut near = Plane::new(4, 3, 9);
    nearness(&distance, 1_000, &mut near).unwrap();
    assert!(near.as_slice().iter().all(|&near| near == 0));
}
