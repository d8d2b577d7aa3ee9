//! Poses on the ground, from truth files and from KITTI's pose files.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use fingerpost_format::TruthRecord;
use thiserror::Error;

/// A pose on the ground, in any fixed frame with x and y in the plane and angles positive to the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarPose {
    /// Metres along x.
    pub x_m: f64,
    /// Metres along y.
    pub y_m: f64,
    /// Radians anticlockwise from x.
    pub heading_rad: f64,
}

impl PlanarPose {
    /// The step from here to `next`: metres forward and left, radians to the left.
    pub(crate) fn step_to(&self, next: &Self) -> [f64; 3] {
        let (dx, dy) = (next.x_m - self.x_m, next.y_m - self.y_m);
        let (sin, cos) = libm::sincos(self.heading_rad);
        [cos * dx + sin * dy, cos * dy - sin * dx, wrapped(next.heading_rad - self.heading_rad)]
    }
}

/// The angle in `[-pi, pi)`.
pub(crate) fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

/// Poses that cannot be read.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum PosesError {
    /// A line is no pose.
    #[error(
        "line {line} has {found} finite numbers, and a pose is 12 of them and no other word; give a KITTI odometry pose file"
    )]
    Line {
        /// Line number, from one.
        line: usize,
        /// Finite numbers on it.
        found: usize,
    },
}

/// The vehicle's poses of a truth, by frame.
pub fn poses_from_truth(truth: &[TruthRecord]) -> BTreeMap<u64, PlanarPose> {
    let pose =
        |truth: &TruthRecord| PlanarPose { x_m: truth.x_m, y_m: truth.y_m, heading_rad: truth.heading_rad };
    truth.iter().map(|truth| (truth.frame, pose(truth))).collect()
}

/// The camera's poses of a KITTI odometry pose file, by frame: one line a frame, the 3 x 4 matrix that takes camera
/// coordinates (x right, y down, z forward) to those of the first camera, row by row.
///
/// In the plane, x is the first camera's z and y its negative x. Height, pitch and roll are left out. The poses are the
/// camera's: in turns they step sideways more than the rear axle does.
///
/// # Errors
/// [`PosesError`] names the first line that is no pose.
pub fn poses_from_kitti(text: &str) -> Result<BTreeMap<u64, PlanarPose>, PosesError> {
    text.lines()
        .enumerate()
        .filter(|(_, line)| !line.trim().is_empty())
        .enumerate()
        .map(|(frame, (i, line))| {
            let number = |word: &str| word.parse().ok().filter(|number: &f64| number.is_finite());
            let words: Vec<Option<f64>> = line.split_whitespace().map(number).collect();
            let found = words.iter().flatten().count();
            // A word that is no number is not passed over: which of the others would be which?
            let numbers: Option<Vec<f64>> = words.into_iter().collect();
            let Some([_, _, forward_x, x, _, _, _, _, _, _, forward_z, z]) = numbers.as_deref() else {
                return Err(PosesError::Line { line: i + 1, found });
            };
            let pose = PlanarPose { x_m: *z, y_m: -x, heading_rad: libm::atan2(-forward_x, *forward_z) };
            Ok((frame as u64, pose))
        })
        .collect()
}
