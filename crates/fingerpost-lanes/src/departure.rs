//! Departure warning: a wheel that is about to cross the edge of its lane without the driver's having said so.
//!
//! Paper 3 (sections I and II) names the purpose and asks that the warning be silent in intended lane changes. A filter
//! (`filter`) joins what both edges and their directions say into the distance of the front wheels' outer sides from either
//! edge and the speed across the lane. The warning comes when the wheel reaches the edge, `lead_s` earlier if wished; it
//! stays until the wheel is back, and `Hush` says why a crossing is passed over in silence.
//!
//! Over a gap in time nothing of the lane is carried on: a wheel must be seen inside its edge again before it can leave.
//!
//! Limits: an edge that is given out for long at another place than it is (the other side of its marking) shifts the
//! warning by as much; wheels are taken to stand as far out as the body.

mod config;
mod filter;
mod hush;

pub use config::DepartureConfig;
pub use hush::Silence;

use self::filter::{LateralFilter, VehicleMotion};
use self::hush::{Hush, SETTLED_MPS};
use super::Side;
use super::geometry::LaneOnRoad;
use fingerpost_control::VehicleState;
use fingerpost_control::vehicle::VehicleConfig;

/// Standard deviation of a wheel's distance up to which it is known well enough to warn, metres: half of what a crossing
/// is told by.
const MAX_SIGMA_M: f64 = 0.15;
/// Slowest approach that has a time to crossing, m/s: below it the time is minutes and says nothing.
const MIN_CLOSING_MPS: f64 = 0.02;
/// Longest time between two frames over which the place in the lane is carried on, seconds: in a longer one even a vehicle
/// that has settled moves across by more than a wheel's distance may be unsure.
const LONGEST_STEP_S: f64 = MAX_SIGMA_M / SETTLED_MPS;

/// What is said of a departure.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DepartureOutput {
    /// The side on which the lane is being left without a sign that this is wanted.
    pub warning: Option<Side>,
    /// Speed across the lane, m/s, positive to the left; none while no edge is known.
    pub lateral_speed_mps: Option<f64>,
    /// Time until a front wheel reaches the edge ahead of it, seconds, 0 where it is on or beyond it; none while it moves
    /// towards neither.
    pub time_to_crossing_s: Option<f64>,
    /// Why no warning is given although a wheel is at an edge.
    pub silence: Option<Silence>,
}

/// How a departure was judged; of two, the left one comes first.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DepartureEvidence {
    /// How far the outer side of the front wheel is from the edge, metres, negative beyond it.
    pub clearance_m: [Option<f64>; 2],
    /// Its standard deviation, metres; never zero.
    pub clearance_sigma_m: [Option<f64>; 2],
    /// How far the measured edge was from the expected one, metres; none where nothing new was seen.
    pub innovation_m: [Option<f64>; 2],
    /// By how much all edges seem to be turned against the road, radians: the camera's yaw.
    pub heading_bias_rad: f64,
}

/// The warning with its state.
#[derive(Debug, Clone, Default)]
pub struct DepartureWarning {
    filter: LateralFilter,
    hush: Hush,
    warning: Option<Side>,
}

impl DepartureWarning {
    /// Takes one frame in, `dt_s` after the frame before.
    pub fn step(
        &mut self,
        config: &DepartureConfig,
        vehicle: &VehicleConfig,
        lane: &LaneOnRoad,
        state: &VehicleState,
        dt_s: f64,
    ) -> (DepartureOutput, DepartureEvidence) {
        let dt_s = if dt_s.is_finite() { dt_s.max(0.0) } else { 0.0 };
        let speed_mps = state.speed_mps.filter(|mps| mps.is_finite());
        let yaw_rate_rps = state.yaw_rate_rps.filter(|rps| rps.is_finite());
        if dt_s > LONGEST_STEP_S {
            self.filter = LateralFilter::default();
            self.hush.forget_edges();
            self.warning = None;
        }
        let seen = self.filter.step(config, lane, VehicleMotion { speed_mps, yaw_rate_rps, dt_s });
        self.hush.begin_frame(config, state, speed_mps, &seen, dt_s);
        let Some(lateral_mps) = self.filter.lateral_speed_mps() else {
            // What the driver meant goes on where no edge is seen: in the middle of a lane change often none is.
            self.hush.unsettle();
            self.warning = None;
            return (DepartureOutput::default(), DepartureEvidence::default());
        };
        let clearance = Side::BOTH.map(|side| {
            let ahead_m = config.front_axle_m;
            let edge = self.filter.edge_at(side, ahead_m, speed_mps)?;
            Some((-side.outward() * edge.left_m - 0.5 * vehicle.width_m, edge.sigma_m))
        });
        let clearance_m = clearance.map(|known| known.map(|(clearance_m, _)| clearance_m));
        let closing_mps = Side::BOTH.map(|side| -side.outward() * lateral_mps);
        // The next frame would be as much too late as this one is too early: half a frame is split.
        let at_edge = Side::BOTH.into_iter().find(|&side| {
            let closing_mps = closing_mps[side.index()];
            // An edge that comes into view under the vehicle may be a seam; one that is crossed was beside it before.
            self.hush.has_been_inside(side)
                && clearance[side.index()].is_some_and(|(clearance_m, sigma_m)| {
                    closing_mps >= config.min_drift_mps
                        && sigma_m <= MAX_SIGMA_M
                        && clearance_m <= closing_mps * (config.lead_s + 0.5 * dt_s)
                })
        });
        let silence = at_edge.and_then(|side| self.hush.silence(config, side));
        if let Some(side) = at_edge.filter(|_| silence.is_none()) {
            self.warning = Some(side);
            self.hush.has_warned();
        }
        self.warning = self.warning.filter(|&side| {
            let back = clearance_m[side.index()].is_none_or(|m| m > config.hysteresis_m);
            !back && !self.hush.has_warned_long_enough()
        });
        self.hush.end_frame(config, clearance_m, lateral_mps, dt_s);

        let output = DepartureOutput {
            warning: self.warning,
            lateral_speed_mps: Some(lateral_mps),
            time_to_crossing_s: time_to_crossing_s(clearance_m, closing_mps),
            // A warning that is being given needs no excuse for not being given again.
            silence: silence.filter(|_| self.warning.is_none()),
        };
        let evidence = DepartureEvidence {
            clearance_m,
            clearance_sigma_m: clearance.map(|known| known.map(|(_, sigma_m)| sigma_m)),
            innovation_m: seen.innovation_m,
            heading_bias_rad: self.filter.heading_bias_rad(),
        };
        (output, evidence)
    }
}

/// When the edge that the vehicle closes in on is reached, seconds, by clearances in metres and closing speeds in metres a second
/// to the left and right; none where it drifts to neither.
fn time_to_crossing_s(clearance_m: [Option<f64>; 2], closing_mps: [f64; 2]) -> Option<f64> {
    Side::BOTH
        .into_iter()
        .filter(|&side| closing_mps[side.index()] >= MIN_CLOSING_MPS)
        .find_map(|side| Some(clearance_m[side.index()]?.max(0.0) / closing_mps[side.index()]))
}

#[cfg(test)]
mod tests;
