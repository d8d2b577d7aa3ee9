//! Planning: the shortest route over places.

use crate::cut::cut;
use crate::path::Path;
use crate::search::{Aim, Leg, arrivals, departures, node_at, shortest};
use crate::{FeatureOptions, LatLon, RoadGraph, Route, RouteError, Snap};

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
    graph.place_on_road(at).map_err(|off| RouteError::StopOffRoad { stop: index + 1, off })
}

fn leg(graph: &RoadGraph, before: Option<&Leg>, from: &Snap, to: &Snap) -> Option<Leg> {
    let goals = arrivals(graph, to);
    let find =
        |starts: &[_]| shortest(graph, starts, &goals, Aim::Place(to.p_in_map)).into_iter().flatten().next();
    let mut starts = departures(graph, from);
    // A stop at a barrier is left on the side from which it was reached.
    if let Some(before) = before
        && node_at(graph, from.segment, from.along_m).is_some_and(|node| graph.nodes()[node].is_closed)
    {
        starts.retain(|start| start.step.segment == before.to.step.segment);
    }
    let onwards: Vec<_> = starts
        .iter()
        .copied()
        .filter(|start| before.is_none_or(|leg| start.step != leg.to.step.reversed()))
        .collect();
    find(&onwards).or_else(|| find(&starts))
}
