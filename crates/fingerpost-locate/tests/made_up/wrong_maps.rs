//! Made-up drives in the built-in town on maps that lack a road or have a junction in a wrong place, beyond what all maps have
//! wrong.

use fingerpost_locate::Status;
use fingerpost_map::{LatLon, OsmData, RoadGraph};
use nalgebra::Point2;

use crate::drives::{Drive, Numbers, Road, drive, line, typical_faults};
use crate::simulated::longest_run;

const TOWN: &[u8] = include_bytes!("../../../fingerpost-sim/assets/town.osm");
/// Rows of three seconds.
const THREE_S: usize = 30;

/// Drives of 2 km on the roads of the town, located on the map that `change` makes of it at a place of the road driven, metres along
/// it.
fn located(change_at_m: f64, change: impl Fn(&mut OsmData, &RoadGraph, Point2<f64>)) {
    let town = OsmData::from_bytes(TOWN).unwrap();
    let roads = RoadGraph::from_osm(&town).unwrap();
    for seed in 0..6 {
        let mut numbers = Numbers(300 + seed);
        let road: Road =
            std::iter::repeat_with(|| line(&roads, 2000.0, &mut numbers)).flatten().next().unwrap();
        let rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
        let mut map = town.clone();
        change(&mut map, &roads, road.line.at(change_at_m).0);
        assert!(map != town);
        let fixes = Drive::with_map(&town, &map, &mut numbers).fixes(&rows);
        let longest = longest_run(fixes.iter().map(|(fix, truth)| {
            fix.status == Status::Converged && (fix.place_m - truth).norm() > fix.level_m.unwrap()
        }));
        let converged = fixes.iter().filter(|(fix, _)| fix.status == Status::Converged).count();
        let (last, truth) = fixes.last().unwrap();
        println!(
            "seed {seed}: {converged} of {} rows converged, {longest} in a row outside the level, at the end {:?}, {:.1} m off",
            fixes.len(),
            last.status,
            (last.place_m - truth).norm()
        );
        assert!(longest <= THREE_S);
        assert!((last.place_m - truth).norm() < 25.0);
    }
}

/// Distance of a place from the line between two nodes, metres.
fn off_m(roads: &RoadGraph, ends: [LatLon; 2], place: Point2<f64>) -> f64 {
    let [one, other] = ends.map(|at| roads.plane().map_from_wgs84(at));
    let along = other - one;
    let part = ((place - one).dot(&along) / along.norm_squared().max(1e-9)).clamp(0.0, 1.0);
    (one + along * part - place).norm()
}

/// The map lacks the road that is driven a kilometre after the start. No road beside it is claimed for more than three seconds, and
/// the vehicle is found again behind it.
#[test]
fn a_road_that_the_map_lacks_is_no_other_road() {
    located(1000.0, |map, roads, place| {
        let at = |id: i64| map.nodes.iter().find(|node| node.id == id).unwrap().at;
        let nearest_m = |nodes: &[i64]| {
            let pairs = nodes.windows(2).map(|pair| off_m(roads, [at(pair[0]), at(pair[1])], place));
            pairs.fold(f64::INFINITY, f64::min)
        };
        let distances: Vec<f64> = map.ways.iter().map(|way| nearest_m(&way.nodes)).collect();
        let nearest = (0..distances.len()).min_by(|a, b| distances[*a].total_cmp(&distances[*b])).unwrap();
        map.ways.remove(nearest);
    });
}

/// Somebody has dragged the node next to the road driven a kilometre after the start by 5 m. The place stays within its level.
#[test]
fn a_node_dragged_by_five_metres_leads_nobody_astray() {
    located(1000.0, |map, roads, place| {
        let on_ways: std::collections::BTreeSet<i64> =
            map.ways.iter().flat_map(|way| way.nodes.iter().copied()).collect();
        let off_m = |at: LatLon| (roads.plane().map_from_wgs84(at) - place).norm();
        let nodes = map.nodes.iter_mut().filter(|node| on_ways.contains(&node.id));
        let nearest = nodes.min_by(|a, b| off_m(a.at).total_cmp(&off_m(b.at))).unwrap();
        nearest.at.lat_deg += 3.0 / 111_320.0;
        nearest.at.lon_deg -= 4.0 / (111_320.0 * libm::cos(nearest.at.lat_deg.to_radians()));
    });
}
