//! Ego-motion against true poses.

use std::collections::BTreeMap;

use fingerpost_format::{ErrorQuantiles, FrameRecord};
use serde::Serialize;

use crate::error::check_ascending;
use crate::pose::wrapped;
use crate::{EvalError, PlanarPose, error_quantiles};

/// A run's ego-motion against true poses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionEvaluation {
    /// Steps compared: frames with a motion, whose pose and that of the frame before are known.
    pub steps: u64,
    /// Summed length of the estimated steps, metres.
    pub distance_m: f64,
    /// Summed length of the true steps, metres.
    pub true_distance_m: f64,
    /// Difference of the two lengths, percent of the true one.
    pub motion_error_pct: f64,
    /// Difference of the summed turns, degrees.
    pub end_heading_error_deg: f64,
    /// Error of a step forward, absolute, metres.
    pub forward_error_m: Option<ErrorQuantiles>,
    /// Error of a step to the left, absolute, metres.
    pub left_error_m: Option<ErrorQuantiles>,
    /// Error of a step's turn, absolute, degrees.
    pub yaw_error_deg: Option<ErrorQuantiles>,
}

/// One step, estimated and true: metres forward and left, radians to the left.
struct Step {
    estimated: [f64; 3],
    truth: [f64; 3],
}

/// Compares a run's motion with true poses, by frame.
///
/// A step goes from the last frame that was not broken to the one at hand; steps without a motion or without poses at
/// both ends are left out on both sides.
///
/// # Errors
/// [`EvalError`] when frames do not ascend, nothing can be compared, or the truth stands still.
pub fn evaluate_motion(
    records: &[FrameRecord],
    poses: &BTreeMap<u64, PlanarPose>,
) -> Result<MotionEvaluation, EvalError> {
    check_ascending("run", records.iter().map(|record| record.frame))?;
    let steps = steps(records, poses);
    if steps.is_empty() {
        return Err(EvalError::NoMotion);
    }
    let motion_error_pct = error_pct(&steps).ok_or(EvalError::Standing)?;
    let turn_errors_rad = steps.iter().map(|step| wrapped(step.estimated[2] - step.truth[2]));
    let absolute =
        |axis: usize| steps.iter().map(move |step| (step.estimated[axis] - step.truth[axis]).abs());
    Ok(MotionEvaluation {
        steps: steps.len() as u64,
        distance_m: steps.iter().map(|step| length_m(step.estimated)).sum(),
        true_distance_m: steps.iter().map(|step| length_m(step.truth)).sum(),
        motion_error_pct,
        end_heading_error_deg: turn_errors_rad.clone().sum::<f64>().abs().to_degrees(),
        forward_error_m: error_quantiles(absolute(0)),
        left_error_m: error_quantiles(absolute(1)),
        yaw_error_deg: error_quantiles(turn_errors_rad.map(|error_rad| error_rad.abs().to_degrees())),
    })
}

/// Error of the summed path length, percent; none where nothing can be compared or the truth stands still.
pub(crate) fn distance_error_pct(records: &[FrameRecord], poses: &BTreeMap<u64, PlanarPose>) -> Option<f64> {
    error_pct(&steps(records, poses))
}

fn error_pct(steps: &[Step]) -> Option<f64> {
    // A tenth of a metre in all is what a standing vehicle's truth may jitter by.
    const STANDING_M: f64 = 0.1;
    let estimated_m: f64 = steps.iter().map(|step| length_m(step.estimated)).sum();
    let true_m: f64 = steps.iter().map(|step| length_m(step.truth)).sum();
    (true_m > STANDING_M).then(|| 100.0 * (estimated_m - true_m).abs() / true_m)
}

fn steps(records: &[FrameRecord], poses: &BTreeMap<u64, PlanarPose>) -> Vec<Step> {
    let sound: Vec<&FrameRecord> = records.iter().filter(|record| record.error.is_none()).collect();
    sound
        .windows(2)
        .filter_map(|pair| {
            let motion = pair[1].motion?;
            let (from, to) = (poses.get(&pair[0].frame)?, poses.get(&pair[1].frame)?);
            let estimated = [motion.forward_m, motion.left_m, motion.yaw_rad];
            Some(Step { estimated, truth: from.step_to(to) })
        })
        .collect()
}

fn length_m([forward_m, left_m, _]: [f64; 3]) -> f64 {
    libm::hypot(forward_m, left_m)
}
