//! Heights of streets by places that are known.

use super::*;

fn place(along_m: f32, left_m: f32, half_width_m: f32) -> LocalPlace {
    LocalPlace { chain: 3, along_m, left_m, half_width_m, direction: [1.0, 0.0] }
}

/// A road along x of that half width, far from any other.
fn at(street: &Street, x: f32, y: f32, half_width_m: f32) -> StreetPoint {
    let ground = GroundPoint {
        edge_m: y.abs() - half_width_m,
        edge_slope: [0.0, y.signum()],
        stroke: Some(0),
        ..GroundPoint::OPEN
    };
    street.at([x, y], &ground, &place(x, y, half_width_m))
}

fn street(conditions: Conditions) -> Street {
    Street::new(5, &conditions).unwrap()
}

#[test]
fn a_road_without_kerbs_is_no_street() {
    assert!(Street::new(5, &Conditions::CLEAR).is_none());
}

#[test]
fn pavements_lie_a_kerb_above_the_road() {
    let street = street(Conditions { kerbs: 1.0, cross_fall: 0.0, parking_bays: 0.0, ..Conditions::STREET });
    let (mut lowest_m, mut highest_m, mut lowered) = (1.0_f32, 0.0_f32, 0);
    for i in 0..4000 {
        let x = 0.5 * i as f32;
        let [road, foot, pavement] = [2.0, 2.999, 3.05].map(|y| at(&street, x, y, 3.0));
        assert!(road.height_m.abs() < 1e-6 && foot.height_m.abs() < 1e-6);
        let rise_m = pavement.height_m - PAVEMENT_FALL * 0.05;
        assert!((rise_m - pavement.kerb_m).abs() < 1e-4, "{rise_m} {}", pavement.kerb_m);
        (lowest_m, highest_m) = (lowest_m.min(rise_m), highest_m.max(rise_m));
        lowered += usize::from(rise_m < 0.03);
    }
    assert!(lowest_m < 0.03 && highest_m > 0.15 && highest_m <= 0.16, "{lowest_m} {highest_m}");
    assert!((200..1400).contains(&lowered), "driveways: {lowered}");
}

#[test]
fn a_bay_is_as_high_as_the_road_and_the_kerb_stands_behind_it() {
    let street = street(Conditions { kerbs: 1.0, cross_fall: 0.0, parking_bays: 1.0, ..Conditions::STREET });
    // The middle of a stretch, whose ends have none.
    let [bay, behind] = [4.9, 5.2].map(|y| at(&street, 20.0, y, 3.0));
    assert!(bay.height_m.abs() < 1e-6 && behind.height_m > 0.02);
    assert!((bay.behind_kerb_m + 0.2).abs() < 1e-5, "{}", bay.behind_kerb_m);
    let end = at(&street, 40.0, 3.2, 3.0);
    assert!(end.height_m > 0.02, "no bay where the stretch ends");
}

#[test]
fn heights_jump_at_the_kerb_alone() {
    let street = street(Conditions::STREET);
    let heights = |y: f32| (0..20_000).map(move |i| 0.05 * i as f32).map(move |x| (x, y));
    for (x, y) in [-6.0_f32, -4.1, -2.0, 1.0, 4.1, 7.0].into_iter().flat_map(heights) {
        let [here, next] = [x, x + 0.05].map(|x| at(&street, x, y, 3.0));
        let crosses = (here.behind_kerb_m < FACE_M) != (next.behind_kerb_m < FACE_M);
        let jump_m = (next.height_m - here.height_m).abs();
        assert!(crosses || jump_m < 0.02, "{jump_m} m at {x}, {y}");
    }
}

#[test]
fn roads_fall_by_one_to_three_percent() {
    let street = street(Conditions::STREET);
    let falls: Vec<f32> = (0..40)
        .map(|chain| {
            let ground = GroundPoint { edge_m: -1.0, stroke: Some(0), ..GroundPoint::OPEN };
            let height_m = |left_m: f32| {
                let place = LocalPlace { chain, ..place(5.0, left_m, 3.0) };
                street.fallen_m(&ground, &place)
            };
            assert!(height_m(0.0).abs() < 1e-6);
            height_m(2.0) / 2.0
        })
        .collect();
    assert!(falls.iter().all(|fall| (0.0099..=0.0301).contains(&fall.abs())), "{falls:?}");
    assert!(falls.iter().any(|fall| *fall > 0.0) && falls.iter().any(|fall| *fall < 0.0));
    let ground = GroundPoint { edge_m: -1.0, other_m: 0.0, stroke: Some(0), ..GroundPoint::OPEN };
    assert!(street.fallen_m(&ground, &place(5.0, 2.0, 3.0)).abs() < 1e-6, "level where roads meet");
}

#[test]
fn wide_roads_have_islands_and_narrow_ones_none() {
    let street = street(Conditions { cross_fall: 0.0, ..Conditions::STREET });
    let islands = |half_width_m: f32| {
        (0..4000).filter(|i| at(&street, 0.25 * *i as f32, 0.0, half_width_m).height_m > 0.05).count()
    };
    assert!(islands(5.0) > 100 && islands(3.0) == 0);
    let first = (0..4000).map(|i| 0.25 * i as f32).find(|x| at(&street, *x, 0.0, 5.0).height_m > 0.05);
    let x = first.unwrap() + 1.5;
    // Its sides are edges of the road.
    let edges: Vec<f32> = [0.0, 0.4, 0.9].map(|y| at(&street, x, y, 5.0).ground.edge_m).to_vec();
    assert!(edges[0] > edges[1] && edges[1] > edges[2] && edges[2] < 0.0, "{edges:?}");
}
