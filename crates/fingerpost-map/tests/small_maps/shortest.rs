//! Planned lengths against all shortest lengths by Floyd's algorithm, on random maps with one-way streets.

use fingerpost_map::{FeatureOptions, RouteError, plan};
use proptest::prelude::*;

use crate::town::{Town, at};

/// Places in metres and streets between them (from, to, one-way or not).
type Streets = (Vec<(f64, f64)>, Vec<(usize, usize, bool)>);

fn streets() -> impl Strategy<Value = Streets> {
    (4_usize..12).prop_flat_map(|count| {
        let street = (0..count, 0..count, any::<bool>());
        (
            prop::collection::vec((0.0..400.0, 0.0..400.0), count),
            prop::collection::vec(street, count..3 * count),
        )
    })
}

fn floyd((places, streets): &Streets) -> Vec<Vec<f64>> {
    let count = places.len();
    let mut length_m = vec![vec![f64::INFINITY; count]; count];
    for &(from, to, is_one_way) in streets.iter().filter(|(from, to, _)| from != to) {
        let street_m = libm::hypot(places[from].0 - places[to].0, places[from].1 - places[to].1);
        length_m[from][to] = length_m[from][to].min(street_m);
        if !is_one_way {
            length_m[to][from] = length_m[to][from].min(street_m);
        }
    }
    for via in 0..count {
        for from in 0..count {
            for to in 0..count {
                length_m[from][to] = length_m[from][to].min(length_m[from][via] + length_m[via][to]);
            }
        }
    }
    length_m
}

proptest! {
    #![proptest_config(ProptestConfig { rng_seed: prop::test_runner::RngSeed::Fixed(11), ..ProptestConfig::default() })]

    #[test]
    fn planned_routes_are_the_shortest(map in streets()) {
        let used = |place: usize| map.1.iter().any(|&(from, to, _)| from != to && (from == place || to == place));
        let ends: Vec<usize> = (0..map.0.len()).filter(|&place| used(place)).collect();
        prop_assume!(ends.len() >= 2);
        // Places on one another would be one node to the planner and two to Floyd.
        let apart = |a: (f64, f64), b: (f64, f64)| libm::hypot(a.0 - b.0, a.1 - b.1) > 1.0;
        prop_assume!((0..map.0.len()).all(|a| (0..a).all(|b| apart(map.0[a], map.0[b]))));
        let mut town = Town::default();
        for (id, &(x, y)) in (0..).zip(&map.0) {
            town = town.node(id, x, y);
        }
        for (id, &(from, to, is_one_way)) in (0..).zip(&map.1) {
            let one_way = if is_one_way { "oneway=yes" } else { "oneway=no" };
            town = town.way(id, &[from as i64, to as i64], &["highway=residential", one_way]);
        }
        let graph = town.graph();
        let (from, to) = (ends[0], ends[ends.len() - 1]);
        let [start, end] = [from, to].map(|place| at(map.0[place].0, map.0[place].1));
        // A street that passes through a place without a node there takes the stop: leave such maps out.
        let snaps_to = |place: usize| {
            let p_in_map = graph.nodes()[graph.node_index(place as i64).unwrap()].p_in_map;
            graph.within(p_in_map, 0.01).iter().all(|snap| {
                let ends = graph.segments()[snap.segment];
                [ends.start, ends.end].iter().any(|&node| graph.nodes()[node].id == place as i64)
            })
        };
        prop_assume!(snaps_to(from) && snaps_to(to));
        let expected_m = floyd(&map)[from][to];
        match plan(&graph, &[start, end], &FeatureOptions::default()) {
            Ok(route) => {
                let length_m = route.polyline().unwrap().length_m();
                prop_assert!((length_m - expected_m).abs() < 1e-3, "{length_m}, not {expected_m}");
            }
            Err(error) => {
                let expected = RouteError::Unreachable { from_stop: 1, to_stop: 2 };
                prop_assert_eq!(error, expected);
                prop_assert!(expected_m.is_infinite());
            }
        }
    }
}
