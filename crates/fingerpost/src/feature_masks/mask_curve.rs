//! Mask curve: the papers' driving path curve, by which a feature is found and arrived at.
//!
//! Paper 1, section V-B: a quadratic Bezier curve from the approach over the feature to the exit. The approach and
//! exit points are set back from the node until the tightest curvature respects the vehicle's turning circle; for a
//! symmetric curve that turns by theta the set-back d gives the radius d cos^2(theta/2) / sin(theta/2). Where that would
//! take the curve's ends too far, its corner is given less weight instead: a rational curve of the same three points
//! grows rounder as the weight falls, until at cos(theta/2) it is the arc of a circle of radius d / tan(theta/2) (Farin:
//! Curves and surfaces for CAGD, 2002, section 12.5).
//!
//! It is one of the feature's masks, and its ends say when the vehicle turns in and has turned out. Nobody steers along it: it
//! cuts corners that a [`DrivingLine`](crate::driving_line::DrivingLine) goes round in its lane. What is found by it must not change with how
//! the vehicle is to be steered.

use fingerpost_geometry::{GeometryError, Polyline};
use nalgebra::Point2;

use super::FeatureMaskConfig;
use crate::conic::Conic;
use crate::feature_model::FeatureModel;
use crate::vehicle::VehicleConfig;

/// Growth of the set-back from one try to the next, metres.
const SETBACK_STEP_M: f64 = 0.25;

/// The papers' curve through a feature, in the feature frame.
#[derive(Debug, Clone, PartialEq)]
pub struct MaskCurve {
    /// The three control points: approach, corner, exit; metres.
    pub control: [Point2<f64>; 3],
    /// The curve, sampled, metres.
    pub curve: Polyline,
    /// Radius at the tightest place of the curve, metres (infinite on a straight one).
    pub tightest_radius_m: f64,
}

impl MaskCurve {
    /// The curve of `vehicle` through `feature`; none when the feature has no approach or exit.
    ///
    /// # Errors
    /// [`GeometryError`] when the arms leave no room for a curve.
    pub fn new(
        config: &FeatureMaskConfig,
        vehicle: &VehicleConfig,
        feature: &FeatureModel,
    ) -> Result<Option<Self>, GeometryError> {
        let (Some(approach), Some(exit)) = (feature.approach(), feature.exit()) else { return Ok(None) };
        let share = vehicle.traffic.left_share();
        let inbound = approach.course.reversed().offset(share * approach.width_m)?;
        let outbound = exit.course.offset(share * exit.width_m)?;
        let most_m = config.curve_max_setback_m.max(config.curve_min_setback_m);
        let mut setback_m = config.curve_min_setback_m;
        let mut curve = Conic::between(&inbound, &outbound, [setback_m; 2]);
        while curve.tightest_radius_m() < vehicle.turning_radius_m && setback_m + SETBACK_STEP_M <= most_m {
            setback_m += SETBACK_STEP_M;
            curve = Conic::between(&inbound, &outbound, [setback_m; 2]);
        }
        curve.round_up_to(vehicle.turning_radius_m);
        Ok(Some(Self {
            control: curve.control,
            curve: curve.sampled()?,
            tightest_radius_m: curve.tightest_radius_m(),
        }))
    }

    /// Where the curve begins, feature frame, metres.
    pub const fn start(&self) -> Point2<f64> {
        self.control[0]
    }

    /// Where the curve ends, feature frame, metres.
    pub const fn end(&self) -> Point2<f64> {
        self.control[2]
    }
}
