//! The next turn of the route that is not in sight: the vehicle comes to it slowly enough to turn, and with time to find it.

use fingerpost_control::TurnAhead;

use super::line::turns;
use crate::track::{RouteStop, TrackOutput};

/// A feature at which the route turns, expected ahead and not followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ExpectedTurn {
    /// Its index in the route.
    pub(super) index: usize,
    /// Its driving line, one standard deviation of the vehicle's place on the route nearer than it is believed.
    pub(super) ahead: TurnAhead,
}

impl ExpectedTurn {
    /// The next one by the place on the route; none where that is unknown or the route turns no more.
    pub(super) fn next(track: &TrackOutput, stops: &[RouteStop]) -> Option<Self> {
        let farthest_m = track.route_m? + track.route_sigma_m?;
        let nearest_m = track.route_m? - track.route_sigma_m?;
        let followed = track.followed.as_ref().map_or(0, |followed| followed.index + 1);
        let is_ahead = |(index, stop): &(usize, &RouteStop)| {
            *index >= followed && stop.model.route_m > nearest_m && turns(stop)
        };
        let (index, stop) = stops.iter().enumerate().find(is_ahead)?;
        let line = stop.line.as_ref()?;
        let setback_m = line.start().coords.norm();
        let turn_rad = stop.model.exit()?.direction_rad();
        let ahead = TurnAhead {
            ahead_m: stop.model.route_m - setback_m - farthest_m,
            curvature_per_m: turn_rad.signum() / line.tightest_radius_m,
        };
        Some(Self { index, ahead })
    }
}
