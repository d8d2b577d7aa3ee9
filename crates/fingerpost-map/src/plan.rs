//! Planning: the shortest route over places.

use crate::cut::cut;
use crate::path::Path;
use crate::search::{Aim, Leg, arrivals, departures, shortest};
use crate::{FeatureOptions, LatLon, RoadGraph, Route, RouteError, Snap};

/// A stop farther than this from every road is not meant for the map, metres.
const STOP_REACH_M: f64 = 100.0;

/// The shortest route that starts at the first stop, passes the others in their order and ends at the last.
///
/// Stops are moved to the nearest road; the line starts and ends there, between nodes if need be. One-way streets are
/// respected. At a stop the route goes on in the direction it came, and turns round only where there is no other way.
///
/// # Errors
/// [`RouteError::TooFewStops`], [`RouteError::StopOffRoad`], [`RouteError::Unreachable`], [`RouteError::NoLength`].
pub fn plan(graph: &RoadGraph, stops: &[LatLon], options: &FeatureOptions) -> Result<Route, RouteError> {
    if stops.len() < 2 {
        return Err(RouteError::TooFewStops { found: stops.len() });
    }
    let snaps = stops
        .iter()
        .enumerate()
        .map(|(index, &at)| snap_stop(graph, index, at))
        .collect::<Result<Vec<Snap>, RouteError>>()?;
    let mut legs: Vec<Leg> = Vec::with_capacity(snaps.len() - 1);
    for (index, ends) in snaps.windows(2).enumerate() {
        let leg = leg(graph, legs.last(), &ends[0], &ends[1]);
        legs.push(leg.ok_or(RouteError::Unreachable { from_stop: index + 1, to_stop: index + 2 })?);
    }
    cut(graph, &Path::along(graph, &legs), options)
}

fn snap_stop(graph: &RoadGraph, index: usize, at: LatLon) -> Result<Snap, RouteError> {
    let p_in_map = graph.plane().map_from_wgs84(at);
    graph.nearest(p_in_map, STOP_REACH_M).ok_or_else(|| RouteError::StopOffRoad {
        stop: index + 1,
        lat_deg: at.lat_deg,
        lon_deg: at.lon_deg,
        nearest_m: graph.nearest(p_in_map, f64::INFINITY).map_or(f64::INFINITY, |snap| snap.distance_m),
    })
}

fn leg(graph: &RoadGraph, before: Option<&Leg>, from: &Snap, to: &Snap) -> Option<Leg> {
    let goals = arrivals(graph, to);
    let find =
        |starts: &[_]| shortest(graph, starts, &goals, Aim::Place(to.p_in_map)).into_iter().flatten().next();
    let starts = departures(graph, from);
    let onwards: Vec<_> = starts
        .iter()
        .copied()
        .filter(|start| before.is_none_or(|leg| start.step != leg.to.step.reversed()))
        .collect();
    find(&onwards).or_else(|| find(&starts))
}
