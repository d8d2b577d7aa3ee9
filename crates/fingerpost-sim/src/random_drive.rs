//! A short drive somewhere on a map, drawn from a seed: route, speed and the sun's direction.

use std::f64::consts::PI;
use std::ops::RangeInclusive;

use fingerpost_map::{FeatureOptions, RoadGraph, RoadNode, Route, plan};

use crate::noise::Stream;
use crate::{Conditions, SimConfig, SimError};

/// What is asked of a drawn route.
#[derive(Debug, Clone, PartialEq)]
pub struct RandomRouteOptions {
    /// Length, metres (default 100 to 260).
    pub length_m: RangeInclusive<f64>,
    /// Features on it (default 2 to 4).
    pub features: RangeInclusive<usize>,
    /// Distance of the first feature from the route's start, metres (default 35 to 80: at the least a ground view's
    /// length and the metres behind the vehicle).
    pub first_feature_m: RangeInclusive<f64>,
    /// Least distance of the last feature from the route's end, metres (default 20: the vehicle passes it).
    pub behind_last_m: f64,
}

impl Default for RandomRouteOptions {
    fn default() -> Self {
        Self { length_m: 100.0..=260.0, features: 2..=4, first_feature_m: 35.0..=80.0, behind_last_m: 20.0 }
    }
}

/// Pairs of nodes that are tried; a town has a fitting one in some tens.
const ATTEMPTS: usize = 5000;

/// Slowest and fastest cruising speed, m/s: 22 and 36 km/h, as on side streets.
const SPEEDS_MPS: [f64; 2] = [6.0, 10.0];

/// The configuration that `seed` draws: these conditions with the sun somewhere, and a speed. Everything else is as in
/// [`SimConfig::default`].
pub fn random_drive(seed: u64, conditions: &Conditions) -> SimConfig {
    let mut stream = Stream::new(seed, 0x4452_4956);
    let sun_azimuth_rad = stream.between(-PI, PI);
    SimConfig {
        seed,
        conditions: Conditions { sun_azimuth_rad, ..*conditions },
        cruise_speed_mps: stream.between(SPEEDS_MPS[0], SPEEDS_MPS[1]),
        ..SimConfig::default()
    }
}

/// The route that `seed` draws on `graph`: the shortest one between two of its nodes, the first drawn pair that fits
/// `options`. Another seed gives another route, as a rule.
///
/// # Errors
/// [`SimError::NoRandomRoute`] when no drawn pair fits.
pub fn random_route(graph: &RoadGraph, seed: u64, options: &RandomRouteOptions) -> Result<Route, SimError> {
    random_route_that(graph, seed, options, |route| Some(route.clone()))
}

/// As [`random_route`]: what `accept` makes of the first drawn route that fits and for which it gives something.
pub(crate) fn random_route_that<T>(
    graph: &RoadGraph,
    seed: u64,
    options: &RandomRouteOptions,
    accept: impl Fn(&Route) -> Option<T>,
) -> Result<T, SimError> {
    let mut stream = Stream::new(seed, 0x524f_5554);
    let nodes: Vec<&RoadNode> = graph.nodes().iter().filter(|node| !node.segments.is_empty()).collect();
    let mut draw = || nodes.get((stream.unit() * nodes.len() as f64) as usize).copied();
    for _ in 0..ATTEMPTS {
        let Some((from, to)) = draw().zip(draw()) else { break };
        let apart_m = (from.p_in_map - to.p_in_map).norm();
        // A path is no shorter than the straight line: most pairs need no search.
        if apart_m < 1.0 || apart_m > *options.length_m.end() {
            continue;
        }
        let route = plan(graph, &[from.at, to.at], &FeatureOptions::default());
        if let Some(accepted) = route.ok().filter(|route| fits(route, options)).as_ref().and_then(&accept) {
            return Ok(accepted);
        }
    }
    Err(SimError::NoRandomRoute { attempts: ATTEMPTS })
}

fn fits(route: &Route, options: &RandomRouteOptions) -> bool {
    let Ok(line) = route.polyline() else { return false };
    let (first, last) = (route.features.first(), route.features.last());
    options.length_m.contains(&line.length_m())
        && options.features.contains(&route.features.len())
        && first.is_none_or(|feature| options.first_feature_m.contains(&feature.route_m))
        && last.is_none_or(|feature| line.length_m() - feature.route_m >= options.behind_last_m)
}

#[cfg(test)]
mod tests {
    use fingerpost_map::OsmData;

    use super::*;

    #[test]
    fn seeds_draw_different_routes_that_fit() {
        let town = OsmData::from_bytes(include_bytes!("../assets/town.osm")).unwrap();
        let graph = RoadGraph::from_osm(&town).unwrap();
        let options = RandomRouteOptions::default();
        let routes: Vec<Route> = (1..=20).map(|seed| random_route(&graph, seed, &options).unwrap()).collect();
        for route in &routes {
            assert!((2..=4).contains(&route.features.len()));
            assert!(route.features[0].route_m >= 35.0);
        }
        let mut starts: Vec<String> = routes.iter().map(|route| format!("{:?}", route.line)).collect();
        starts.sort();
        starts.dedup();
        assert!(starts.len() >= 18, "{} different ones of 20", starts.len());
        assert_eq!(routes[4], random_route(&graph, 5, &options).unwrap());
    }

    #[test]
    fn seeds_draw_different_drives() {
        let drives = [1, 2].map(|seed| random_drive(seed, &Conditions::SHADOWS));
        drives.iter().for_each(|drive| drive.check().unwrap());
        assert!((drives[0].cruise_speed_mps - drives[1].cruise_speed_mps).abs() > 1e-3);
        let [one, other] = drives.map(|drive| drive.conditions.sun_azimuth_rad);
        assert!((one - other).abs() > 1e-3);
    }

    #[test]
    fn what_no_route_fits_is_refused() {
        let town = OsmData::from_bytes(include_bytes!("../assets/town.osm")).unwrap();
        let graph = RoadGraph::from_osm(&town).unwrap();
        let options = RandomRouteOptions { features: 90..=99, ..RandomRouteOptions::default() };
        let refused = random_route(&graph, 1, &options).unwrap_err().to_string();
        assert!(refused.contains("larger"), "{refused}");
    }
}
