//! An alignment through several levels, and how far it is to be believed.
//!
//! Whether a picture tells one motion from another is judged at the finest level: what a coarse one shows may be lines along
//! the road, the vehicle's own light or a mirrored sky alone, which look alike however far the road went by.

use fingerpost_vision::alignment::Residuals;
use nalgebra::Isometry2;

use super::gauss_newton::{Estimate, Prior, align};
use super::patch::{Level, Patch};
use super::plane_warp::{Displacement, Views};
use super::start::cost;
use crate::motion::distinctness;

/// Shift along the road that a good motion must be told from by the picture, metres.
const TELL_SHIFT_M: f64 = 0.3;
/// Shares of the texture that agree from which an alignment is believed a little and in full. On good roads it is 0.3 to
/// 0.7; where a reflection or the edges of a lane outweigh what moves, 0.05 to 0.2.
const AGREEING: [f64; 2] = [0.1, 0.3];
/// What is left of the quality when the last level was still changing.
const NOT_CONVERGED: f64 = 0.5;

/// An alignment and how good it is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Aligned {
    pub(super) estimate: Estimate,
    /// What it leaves at the finest level.
    pub(super) cost: f64,
    /// How far it is to be believed, 0 to 1.
    pub(super) quality: f64,
    /// How far it was to be believed that the vehicle stands, where the camera is seen to travel; else 0.
    pub(super) stands_still: f64,
}

impl Aligned {
    /// From `at` through the finest levels, so many of them; none where nothing is seen.
    pub(super) fn through(
        levels: usize,
        (patch, residuals): (&mut Patch, &mut Residuals),
        (prior, views): (&Prior, &Views),
        iterations: usize,
        at: Displacement,
    ) -> Option<Self> {
        let mut estimate = Estimate::at(at);
        for level in patch.levels[patch.finest..].iter_mut().take(levels).rev() {
            estimate = align(level, residuals, (prior, views), iterations, estimate)?;
        }
        let finest = patch.levels.get(patch.finest)?;
        let (cost, shifted) = costs(finest, residuals, (&estimate, views));
        let quality = quality(&estimate, distinctness(cost, shifted));
        Some(Self { estimate, cost, quality, stands_still: 0.0 })
    }
}

/// What an alignment leaves at a level, and what a motion a little longer or shorter would leave at the least.
pub(super) fn costs(
    level: &Level,
    residuals: &mut Residuals,
    (estimate, views): (&Estimate, &Views),
) -> (f64, f64) {
    let Estimate { displacement, brightness, .. } = *estimate;
    let mut cost_when_moved = |shift_m| {
        let current_from_previous = Isometry2::translation(shift_m, 0.0) * displacement.current_from_previous;
        let displacement = Displacement { current_from_previous, ..displacement };
        cost((level, &level.template), residuals, &displacement, views, brightness)
    };
    let shifted = [-TELL_SHIFT_M, TELL_SHIFT_M].map(&mut cost_when_moved);
    (cost_when_moved(0.0), shifted[0].min(shifted[1]))
}

/// How far a motion is to be believed, 0 to 1: whether the picture tells it from a longer one, whether the road's texture
/// agrees with it, and how much of the patch was seen.
fn quality(estimate: &Estimate, told: f64) -> f64 {
    let [little, full] = AGREEING;
    let agreeing = ((estimate.agreeing - little) / (full - little)).clamp(0.0, 1.0);
    let converged = if estimate.has_converged { 1.0 } else { NOT_CONVERGED };
    told * agreeing * converged * estimate.seen.clamp(0.0, 1.0)
}
