//! When a wheel crosses a line.

use fingerpost_format::Side;
use serde::{Deserialize, Serialize};

use crate::drive::{Drive, VehicleState};
use crate::truth::{LaneEdges, LinesPassed};

/// Steps of the search in a second.
const STEPS_PER_S: f64 = 100.0;

/// A wheel's outer side has come over the inner edge of a line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Crossing {
    /// The first frame in which it is over the edge.
    pub frame: u64,
    /// When it crossed the edge, seconds since the first frame, to a hundredth.
    pub t_s: f64,
    /// The side of the vehicle.
    pub side: Side,
}

fingerpost_format::json_records!(Crossing);

/// All crossings of a drive in the time of so many frames, in the order of time.
pub(crate) fn crossings(drive: &Drive, lanes: &LaneEdges, frames: usize, fps: f64) -> Vec<Crossing> {
    let steps = (frames.saturating_sub(1) as f64 / fps * STEPS_PER_S).floor() as usize;
    let passed = |state: &VehicleState| lanes.lines_passed(state.p_in_map, state.route_m, state.heading_rad);
    let mut found = Vec::new();
    let mut before: Option<LinesPassed> = None;
    for t_s in (0..=steps).map(|step| step as f64 / STEPS_PER_S) {
        let now = passed(&drive.at(t_s));
        if let (Some(before), Some(now)) =
            (before, now.filter(|now| before.is_some_and(|b| b.layout == now.layout)))
        {
            let mut add = |side| found.push(Crossing { frame: (t_s * fps).ceil() as u64, t_s, side });
            if now.by_left_wheels > before.by_left_wheels {
                add(Side::Left);
            }
            if now.by_right_wheels > before.by_right_wheels {
                add(Side::Right);
            }
        }
        before = now;
    }
    found
}
