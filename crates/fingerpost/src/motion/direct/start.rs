//! A start for the alignment: the vehicle stands, moves on as before, or whatever of many motions fits best.

use fingerpost_vision::alignment::{Brightness, Residuals, Template};
use nalgebra::{Isometry2, Vector2};

use super::curvature_per_m;
use super::gauss_newton::FIRST_SCALE;
use super::patch::Level;
use super::plane_warp::{Displacement, Views};
use crate::motion::FlowStart;

/// Farthest the vehicle is taken to move in a frame, metres: 40 m/s at ten frames a second.
const MAX_FORWARD_M: f64 = 4.0;
/// How far it may roll back, metres.
const MAX_BACKWARD_M: f64 = 0.6;
/// Sideways reach, metres.
const MAX_LEFT_M: f64 = 0.3;
/// Reach of the turn, radians: 50 degrees a second at ten frames a second.
const MAX_YAW_RAD: f64 = 0.09;
/// Steps of the search: what the alignment makes good from the coarsest level on.
const STEP_M: f64 = 0.3;
const STEP_YAW_RAD: f64 = 0.0225;
/// Step of the search among the finest texture, metres: a third of a grain.
pub(super) const FINE_STEP_M: f64 = 0.06;
/// Least part of the template that must be led to seen pixels for a start to be judged.
const MIN_SEEN: f32 = 0.5;

/// How badly a displacement explains at a level what is newer by points of what is older: robust mean square of the residuals, grey levels squared; infinite
/// where too little is seen.
pub(super) fn cost(
    (level, template): (&Level, &Template),
    residuals: &mut Residuals,
    displacement: &Displacement,
    views: &Views,
    brightness: Brightness,
) -> f64 {
    let warp = level.raster.warp(displacement, views);
    residuals.measure(template, &level.target, &warp, brightness, FIRST_SCALE as f32);
    if residuals.seen > 0.0 && residuals.seen >= MIN_SEEN * template.len() as f32 {
        f64::from(residuals.square_sum / residuals.seen)
    } else {
        f64::INFINITY
    }
}

/// Where to begin by the costs of motions: standing, or as `last`; a search over the whole reach when both cost more than
/// `bearable`.
pub(super) fn start(
    mut cost_of: impl FnMut(Isometry2<f64>) -> f64,
    last: Isometry2<f64>,
    bearable: f64,
) -> (FlowStart, Isometry2<f64>) {
    let (standing, same) = (cost_of(Isometry2::identity()), cost_of(last));
    if standing.min(same) > bearable {
        (FlowStart::CoarseSearch, search(cost_of))
    } else if standing <= same {
        (FlowStart::Standing, Isometry2::identity())
    } else {
        (FlowStart::SameAsBefore, last)
    }
}

/// The motion `current_from_previous` of least cost; standing where nothing can be judged.
fn search(mut cost_of: impl FnMut(Isometry2<f64>) -> f64) -> Isometry2<f64> {
    let mut best = (f64::INFINITY, Isometry2::identity());
    for yaw in steps(-MAX_YAW_RAD, MAX_YAW_RAD, STEP_YAW_RAD) {
        for left in steps(-MAX_LEFT_M, MAX_LEFT_M, STEP_M) {
            for forward in steps(-MAX_BACKWARD_M, MAX_FORWARD_M, STEP_M) {
                let motion = Isometry2::new(Vector2::new(forward, left), yaw).inverse();
                let cost = cost_of(motion);
                if cost < best.0 {
                    best = (cost, motion);
                }
            }
        }
    }
    best.1
}

/// The motion `current_from_previous` of least cost along the arc of `last`, within `reach_m` of it, in steps that a road's
/// finest texture needs.
pub(super) fn search_along(
    mut cost_of: impl FnMut(Isometry2<f64>) -> f64,
    last: Isometry2<f64>,
    reach_m: f64,
) -> Isometry2<f64> {
    let last_m = last.inverse().translation.x;
    let yaw_per_m = curvature_per_m(&last.inverse());
    let mut best = (f64::INFINITY, last);
    let low_m = (last_m - reach_m).max(-MAX_BACKWARD_M);
    for forward in steps(low_m, (last_m + reach_m).clamp(low_m, MAX_FORWARD_M), FINE_STEP_M) {
        let motion = Isometry2::new(Vector2::new(forward, 0.0), yaw_per_m * forward).inverse();
        let cost = cost_of(motion);
        if cost < best.0 {
            best = (cost, motion);
        }
    }
    best.1
}

fn steps(low: f64, high: f64, step: f64) -> impl Iterator<Item = f64> {
    let count = ((high - low) / step).round().max(1.0) as usize;
    (0..=count).map(move |i| low + (high - low) * i as f64 / count as f64)
}
