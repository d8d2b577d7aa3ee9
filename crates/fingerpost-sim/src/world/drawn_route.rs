//! A route on the map that is known, along roads that are there.

use fingerpost_map::{FeatureKind, RoadGraph, Route, RouteFeature, RoutePoint};

use crate::SimError;
use crate::random_drive::{RandomRouteOptions, random_route_that};

/// The route that `seed` draws on the `known` map, and the same as it is driven on the roads that are there.
pub(super) fn drawn(
    known: &RoadGraph,
    roads: &RoadGraph,
    seed: u64,
    options: &RandomRouteOptions,
) -> Result<(Route, Route), SimError> {
    random_route_that(known, seed, options, |route| Some((route.clone(), as_driven(route, roads)?)))
}

/// A route of the known map on the roads that are there; none where one of its roads is not.
fn as_driven(route: &Route, roads: &RoadGraph) -> Option<Route> {
    let nodes: Vec<usize> = route
        .line
        .iter()
        .map(|point| point.node.and_then(|id| roads.node_index(id)))
        .collect::<Option<_>>()?;
    let joined = |pair: &[usize]| {
        let ends = roads.nodes()[pair[0]].segments.iter().map(|&segment| roads.segments()[segment]);
        ends.into_iter().any(|segment| segment.start == pair[1] || segment.end == pair[1])
    };
    if !nodes.windows(2).all(joined) {
        return None;
    }
    let line: Vec<RoutePoint> = route
        .line
        .iter()
        .zip(&nodes)
        .map(|(point, &node)| RoutePoint { at: roads.nodes()[node].at, ..*point })
        .collect();
    let mut driven = Route { name: route.name.clone(), line, features: Vec::new() };
    let along_m = distances_m(&driven)?;
    // The features of a route are at nodes of its line, in their order; a node may be passed twice.
    let mut from = 0;
    for feature in &route.features {
        let at = (from..nodes.len()).find(|&i| route.line[i].node == Some(feature.id))?;
        from = at + 1;
        if is_there(feature, roads, nodes[at]) {
            let route_m = along_m.get(at).copied()?;
            driven.features.push(RouteFeature {
                at: roads.nodes()[nodes[at]].at,
                route_m,
                ..feature.clone()
            });
        }
    }
    (!driven.features.is_empty()).then_some(driven)
}

/// Distance of each point of a route's line along it, metres.
fn distances_m(route: &Route) -> Option<Vec<f64>> {
    let plane = route.plane()?;
    let places = route.line.iter().map(|point| plane.map_from_wgs84(point.at));
    let (mut along_m, mut before) = (0.0, None);
    let distance_m = places.map(|place| {
        along_m += before.map_or(0.0, |before: nalgebra::Point2<f64>| (place - before).norm());
        before = Some(place);
        along_m
    });
    Some(distance_m.collect())
}

/// Whether a feature of the map is in the world: a road that bends does so, others need a third road.
fn is_there(feature: &RouteFeature, roads: &RoadGraph, node: usize) -> bool {
    feature.kind == FeatureKind::Bend || roads.nodes()[node].segments.len() >= 3
}
