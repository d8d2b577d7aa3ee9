//! Whether a calibration can show the ground view at all.
//!
//! [`Camera`] refuses numbers that no camera has. What is left are calibrations that are possible and yet not those of a
//! camera above this road: they are found by what the ground view would have to be made of.

use fingerpost_geometry::Camera;
use nalgebra::Point2;
use thiserror::Error;

use crate::ground_view::GroundViewConfig;

/// A calibration that does not fit the ground view.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum CalibrationFault {
    /// The road ends before the far edge.
    #[error(
        "the horizon of the calibration lies in the ground view: nothing straight ahead beyond {last_m:.1} m is road, and \
         ground_view.far_m is {far_m}; check the mount's pitch and height or the four points, or make far_m smaller"
    )]
    Horizon {
        /// Farthest place straight ahead that the calibration has as road, metres.
        last_m: f64,
        /// Far edge, metres.
        far_m: f64,
    },
    /// The far edge lies so near the horizon that it cannot be told from it.
    #[error(
        "a single pixel at the far edge of the ground view, {far_m} m ahead, covers {pixel_m:.1} m of road, so near to the \
         horizon is it; check that mount.height_m is in metres, or make ground_view.far_m smaller"
    )]
    TooFlat {
        /// Far edge, metres.
        far_m: f64,
        /// Length of road under a pixel there, metres.
        pixel_m: f64,
    },
}

/// Steps in which the road straight ahead is looked at.
const STEPS: usize = 64;
/// Share of the far edge's distance that a pixel may cover there: beyond, far and near are one pixel apart.
const MOST_PIXEL_SHARE: f64 = 0.5;

/// Checks the camera against the ground view that it is to show.
///
/// # Errors
/// [`CalibrationFault`] with the first thing that cannot be right. What lies outside the picture is no fault here.
pub(crate) fn check(camera: &Camera, view: &GroundViewConfig) -> Result<(), CalibrationFault> {
    let GroundViewConfig { near_m, far_m, .. } = *view;
    let ahead = |x: f64| camera.pixel_of_ground(Point2::new(x, 0.0));
    let places = (0..=STEPS).map(|step| near_m + (far_m - near_m) * step as f64 / STEPS as f64);
    // What is nearer than the first place that is seen lies behind the camera.
    let mut last_m = None;
    for x in places {
        match (ahead(x), last_m) {
            (Some(_), _) => last_m = Some(x),
            (None, Some(last_m)) => return Err(CalibrationFault::Horizon { last_m, far_m }),
            (None, None) => {}
        }
    }
    let step_m = 1e-3 * far_m;
    if let (Some(far), Some(nearer)) = (ahead(far_m), ahead(far_m - step_m)) {
        let pixel_m = step_m / far.distance(nearer).max(1e-12);
        if pixel_m > MOST_PIXEL_SHARE * far_m {
            return Err(CalibrationFault::TooFlat { far_m, pixel_m });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics, Mount, Pixel};

    use super::*;

    #[test]
    fn a_horizon_in_the_view_is_told_from_one_beyond() {
        let road_m = [(5.0, 2.0), (5.0, -2.0), (9.0, 2.0), (9.0, -2.0)].map(|(x, y)| Point2::new(x, y));
        let camera = |upper_px: f64| {
            let image =
                [(100.0, 400.0), (540.0, 400.0), (320.0 - upper_px, 250.0), (320.0 + upper_px, 250.0)];
            Camera::from_points(640, 480, image.map(|(u, v)| Pixel::new(u, v)), road_m).unwrap()
        };
        assert_eq!(check(&camera(120.0), &GroundViewConfig::default()), Ok(()));
        let far = GroundViewConfig { far_m: 60.0, ..Default::default() };
        let fault = check(&camera(420.0), &far).unwrap_err();
        assert!(matches!(fault, CalibrationFault::Horizon { last_m, .. } if last_m < 20.0), "{fault}");
        let fault = check(&camera(20.0), &far).unwrap_err();
        assert!(matches!(fault, CalibrationFault::TooFlat { .. }), "{fault}");
    }

    #[test]
    fn a_height_in_the_wrong_unit_is_found() {
        let intrinsics = Intrinsics { fx: 420.0, fy: 420.0, cx: 320.0, cy: 240.0 };
        let camera = |height_m: f64| {
            Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(height_m)).unwrap()
        };
        assert_eq!(check(&camera(1.2), &GroundViewConfig::default()), Ok(()));
        assert!(matches!(
            check(&camera(0.06), &GroundViewConfig::default()),
            Err(CalibrationFault::TooFlat { .. })
        ));
    }
}
