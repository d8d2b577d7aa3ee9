//! Intrinsics and lens distortion from pictures of a flat board, by Zhang's method.
//!
//! Z. Zhang, "A flexible new technique for camera calibration", 2000 (IEEE PAMI 22(11), pages 1330 to 1334): each picture of
//! the board gives a plane-to-plane map (`plane_map.rs`), the maps give the intrinsics in closed form (section 3.1,
//! `closed_form.rs`), and intrinsics, distortion and every board's pose are then refined together until the points appear
//! where they were seen (sections 3.2 and 3.3, `refinement.rs`). Pictures that fit far worse than the others are left out,
//! the worst first. Distortion is Brown-Conrady's with the five coefficients of OpenCV; pixels are not skewed.
//!
//! Limits: boards must be flat, and tilted in different directions; lenses of far more than 120 degrees need another model.

mod closed_form;
mod error;
mod plane_map;
mod projection;
mod refinement;

use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount, Pixel};
use nalgebra::{Isometry3, Point2, Vector3};

use self::refinement::{Fit, refine};

pub use self::error::LensCalibrationError;

/// A point of a board and where a picture shows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BoardPoint {
    /// Its place on the board, metres or any other unit.
    pub p_in_board: Point2<f64>,
    /// Where it was seen.
    pub pixel: Pixel,
}

/// A lens as pictures of a board show it.
#[derive(Debug, Clone, PartialEq)]
pub struct LensCalibration {
    /// Focal lengths and principal point, pixels.
    pub intrinsics: Intrinsics,
    /// Their standard deviations, pixels; none is zero.
    pub intrinsics_sigma: Intrinsics,
    /// Brown-Conrady coefficients in OpenCV's order, `k1 k2 p1 p2 k3`.
    pub coefficients: [f64; 5],
    /// Their standard deviations; none is zero.
    pub coefficients_sigma: [f64; 5],
    /// Root mean square distance between where points were seen and where they would be, pixels, of the boards used.
    pub rms_px: f64,
    /// What became of each board, in the order given.
    pub boards: Vec<BoardOutcome>,
}

impl LensCalibration {
    /// The camera with this lens on a mount, for pictures of `width` x `height` pixels, which should be those calibrated with.
    ///
    /// # Errors
    /// [`GeometryError`] when no camera has this lens, as one that folds back inside the picture, or is mounted so.
    pub fn camera(&self, width: usize, height: usize, mount: Mount) -> Result<Camera, GeometryError> {
        let distortion = Distortion::brown_conrady(&self.coefficients)?;
        Camera::calibrated(width, height, self.intrinsics, distortion, mount)
    }
}

/// What became of one picture's board.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BoardOutcome {
    /// It was used.
    Used {
        /// Takes points of the board, z towards its back, to the camera frame; in the unit of the board's points.
        camera_from_board: Isometry3<f64>,
        /// Root mean square distance of its points, pixels.
        rms_px: f64,
    },
    /// It fitted far worse than the others and was left out.
    LeftOut {
        /// Root mean square distance of its points while it was used, pixels.
        rms_px: f64,
        /// Median of those of all boards used with it, pixels.
        median_px: f64,
    },
}

impl BoardOutcome {
    /// Angle between the board and a plane that faces the camera squarely, radians, 0 to pi/2; none of a board that was left out.
    pub fn tilt_rad(&self) -> Option<f64> {
        let Self::Used { camera_from_board, .. } = self else { return None };
        let normal = camera_from_board.rotation * Vector3::z();
        Some(libm::acos(normal.z.abs().min(1.0)))
    }
}

/// Fewest boards: two fix focal lengths and principal point (Zhang 2000, section 3.1), a third shows whether they agree.
const LEAST_BOARDS: usize = 3;
/// Boards whose error is so many times the median of all are left out, but never for less than half a pixel.
const FAR_ABOVE: f64 = 3.0;
const LEAST_FAR_PX: f64 = 0.5;
/// Least angle between the planes of two of the boards, degrees: the focal length follows from how planes are tilted.
const LEAST_SPREAD_DEG: f64 = 10.0;
/// Largest standard deviation of a focal length that is trusted, as a share of it; places on the road are off by as much.
const MOST_FOCAL_SIGMA: f64 = 0.02;
/// Largest standard deviation of the principal point that is trusted, as a share of the picture's width.
const MOST_CENTRE_SIGMA: f64 = 0.02;
/// Largest error that is trusted, as a share of the picture's width: 5 pixels of 1280.
const MOST_RMS: f64 = 0.004;
/// Least noise of a seen point, pixels: standard deviations are never smaller than it makes them.
const LEAST_NOISE_PX: f64 = 0.01;

/// The lens with which a camera with pictures of `width` x `height` pixels saw the boards, one list of points a picture.
///
/// # Errors
/// [`LensCalibrationError`] when the boards are too few, do not fix the lens, or contradict each other.
///
/// ```
/// use fingerpost_calibration::{BoardPoint, calibrate_lens};
/// use fingerpost_geometry::{Intrinsics, Pixel};
/// use nalgebra::{Isometry3, Point2, Point3, Vector3};
/// let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 310.0, cy: 245.0 };
/// let tilts = [Vector3::new(0.5, 0.0, 0.0), Vector3::new(0.0, -0.5, 0.1), Vector3::new(-0.3, 0.4, 0.0)];
/// let boards = tilts.map(|tilt| {
///     let camera_from_board = Isometry3::new(Vector3::new(-0.1, -0.1, 0.5), tilt);
///     let corners = (0..54).map(|i| Point2::new(f64::from(i % 9), f64::from(i / 9)) * 0.025);
///     let seen = |p_in_board: Point2<f64>| {
///         let p = camera_from_board * Point3::new(p_in_board.x, p_in_board.y, 0.0);
///         Pixel::new(500.0 * p.x / p.z + 310.0, 500.0 * p.y / p.z + 245.0)
///     };
///     corners.map(|p_in_board| BoardPoint { p_in_board, pixel: seen(p_in_board) }).collect()
/// });
/// let found = calibrate_lens(&boards, 640, 480)?;
/// assert!((found.intrinsics.cx - 310.0).abs() < 1e-3 && found.rms_px < 1e-3);
/// # Ok::<(), fingerpost_calibration::LensCalibrationError>(())
/// ```
pub fn calibrate_lens(
    boards: &[Vec<BoardPoint>],
    width: usize,
    height: usize,
) -> Result<LensCalibration, LensCalibrationError> {
    let mut used: Vec<usize> = (0..boards.len()).collect();
    let mut left_out = vec![None; boards.len()];
    loop {
        let views: Vec<&[BoardPoint]> = used.iter().map(|&board| boards[board].as_slice()).collect();
        if views.len() < LEAST_BOARDS {
            return Err(LensCalibrationError::TooFewBoards { found: views.len(), needed: LEAST_BOARDS });
        }
        let start = closed_form::start(&views, width, height)?;
        let fit = refine(&views, start).ok_or(LensCalibrationError::Undetermined)?;
        let Some((worst, outcome)) = far_above(&fit.rms_px) else {
            check(&fit, width)?;
            return Ok(calibration(&fit, &used, left_out));
        };
        left_out[used.remove(worst)] = Some(outcome);
    }
}

/// The board that fits far worse than the others.
fn far_above(rms_px: &[f64]) -> Option<(usize, BoardOutcome)> {
    let mut sorted = rms_px.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median_px = *sorted.get(sorted.len() / 2)?;
    let (worst, &rms_px) = rms_px.iter().enumerate().max_by(|(_, a), (_, b)| a.total_cmp(b))?;
    (rms_px > (FAR_ABOVE * median_px).max(LEAST_FAR_PX))
        .then_some((worst, BoardOutcome::LeftOut { rms_px, median_px }))
}

/// Whether the boards fix the lens and agree with it.
fn check(fit: &Fit, width: usize) -> Result<(), LensCalibrationError> {
    let spread_deg = spread_rad(&fit.camera_from_board).to_degrees();
    if spread_deg < LEAST_SPREAD_DEG {
        return Err(LensCalibrationError::NotTilted { spread_deg, needed_deg: LEAST_SPREAD_DEG });
    }
    let most_px = MOST_RMS * width as f64;
    if fit.total_rms_px > most_px {
        return Err(LensCalibrationError::PoorFit { rms_px: fit.total_rms_px, most_px });
    }
    let (value, sigma) = (fit.lens.intrinsics(), fit.sigma.intrinsics());
    let most_centre_px = MOST_CENTRE_SIGMA * width as f64;
    for (name, sigma_px, most_px) in [
        ("fx", sigma.fx, MOST_FOCAL_SIGMA * value.fx),
        ("fy", sigma.fy, MOST_FOCAL_SIGMA * value.fy),
        ("cx", sigma.cx, most_centre_px),
        ("cy", sigma.cy, most_centre_px),
    ] {
        let is_trusted = sigma_px.is_finite() && sigma_px <= most_px;
        if !is_trusted {
            return Err(LensCalibrationError::Uncertain { name, sigma_px, most_px });
        }
    }
    Ok(())
}

/// Largest angle between two of the boards' planes, radians.
fn spread_rad(camera_from_board: &[Isometry3<f64>]) -> f64 {
    let normals: Vec<Vector3<f64>> =
        camera_from_board.iter().map(|pose| pose.rotation * Vector3::z()).collect();
    let angles = normals.iter().enumerate().flat_map(|(i, a)| {
        // A plane seen from either side is the same plane.
        normals[i + 1..].iter().map(move |b| libm::acos(a.dot(b).abs().min(1.0)))
    });
    angles.fold(0.0, f64::max)
}

fn calibration(fit: &Fit, used: &[usize], left_out: Vec<Option<BoardOutcome>>) -> LensCalibration {
    let used_outcome = |board: usize| {
        let at = used.binary_search(&board).ok()?;
        let (camera_from_board, rms_px) = (*fit.camera_from_board.get(at)?, *fit.rms_px.get(at)?);
        Some(BoardOutcome::Used { camera_from_board, rms_px })
    };
    let outcomes = left_out.into_iter().enumerate();
    LensCalibration {
        intrinsics: fit.lens.intrinsics(),
        intrinsics_sigma: fit.sigma.intrinsics(),
        coefficients: fit.lens.coefficients(),
        coefficients_sigma: fit.sigma.coefficients(),
        rms_px: fit.total_rms_px,
        boards: outcomes.filter_map(|(board, left_out)| left_out.or_else(|| used_outcome(board))).collect(),
    }
}

#[cfg(test)]
mod tests;
