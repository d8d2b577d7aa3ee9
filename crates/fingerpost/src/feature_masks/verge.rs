//! Verge strips: where beside an arm its verge is expected.
//!
//! Paper 1, section VII, warns that a wide paved area matches every mask. A road ends at its verge; so narrow bands run
//! along either side of an arm, at every distance from its middle at which its edge may lie by the map's width and the
//! width's uncertainty. They begin where the kerb's arc into the neighbouring arm ends and stop before another arm.

use std::ops::Range;

use fingerpost_geometry::{GeometryError, Polyline};
use nalgebra::{Point2, Vector2};

use super::FeatureMaskConfig;
use crate::feature_model::{ArmModel, FeatureModel};
use crate::kerbs::kerb_ends_m;

/// Farthest along an arm that its verge is looked for, metres: beyond it arms bend away from the map.
const MAX_ALONG_M: f64 = 16.0;
/// Step at which a strip's way is looked at, metres.
const STEP_M: f64 = 0.5;
/// Shortest stretch worth a strip, metres.
const MIN_STRETCH_M: f64 = 1.0;
/// Room between a strip and the edge of another arm by the map, metres: maps are not more exact.
const CLEARANCE_M: f64 = 1.0;

/// What is looked at on one side of an arm, each thing drawn as a course or as a mask.
#[derive(Debug, Clone)]
pub struct VergeStrip<T> {
    /// The arm itself beside the bands.
    pub arm: T,
    /// Bands along it, the innermost first.
    pub bands: Vec<T>,
    /// Distance of the middle of each band from the middle of the arm, metres.
    pub beyond_m: Vec<f64>,
    /// Width of the bands and of the part of the arm beside them, metres.
    pub band_width_m: f64,
}

/// The two sides of an arm, left and right when one looks outwards along it; none where there is no room for a strip.
pub type VergeStrips<T> = [Option<VergeStrip<T>>; 2];

impl<T> VergeStrip<T> {
    /// The same strip with everything drawn in another way.
    pub(super) fn drawn<U, E>(&self, draw: impl Fn(&T) -> Result<U, E>) -> Result<VergeStrip<U>, E> {
        Ok(VergeStrip {
            arm: draw(&self.arm)?,
            bands: self.bands.iter().map(&draw).collect::<Result<_, _>>()?,
            beyond_m: self.beyond_m.clone(),
            band_width_m: self.band_width_m,
        })
    }
}

/// The courses of the strips at both sides of `arm`, feature frame, metres.
pub(super) fn courses(
    config: &FeatureMaskConfig,
    kerb_radius_m: f64,
    feature: &FeatureModel,
    arm: &ArmModel,
) -> VergeStrips<Polyline> {
    let kerb_ends_m = kerb_ends_m(feature, arm, kerb_radius_m);
    [0, 1].map(|side| {
        let beyond_m = beyond_m(config, arm.width_m);
        let outwards = if side == 0 { 1.0 } else { -1.0 };
        let span_m = [beyond_m.first()?, beyond_m.last()?].map(|m| outwards * m);
        let stretch = stretch(feature, arm, kerb_ends_m[side].max(arm.mouth_m), span_m)?;
        let arm_course = arm.course.part(stretch.start, stretch.end).ok()?;
        let band = |m: &f64| arm_course.offset(outwards * m);
        let bands = beyond_m.iter().map(band).collect::<Result<Vec<_>, GeometryError>>().ok()?;
        Some(VergeStrip { arm: arm_course, bands, beyond_m, band_width_m: config.verge_width_m })
    })
}

/// Distances of the bands' middles from the middle of an arm, metres, the nearest first.
fn beyond_m(config: &FeatureMaskConfig, width_m: f64) -> Vec<f64> {
    let first_m = 0.5 * (config.verge_from_share * width_m + config.verge_width_m);
    let last_m = 0.5 * (width_m - config.verge_width_m) + config.verge_reach_m;
    let steps = ((last_m - first_m) / config.verge_width_m).ceil().max(0.0) as usize;
    (0..=steps).map(|i| first_m + config.verge_width_m * i as f64).collect()
}

/// The first stretch of an arm from `from_m` on beside which no other arm runs.
fn stretch(feature: &FeatureModel, arm: &ArmModel, from_m: f64, span_m: [f64; 2]) -> Option<Range<f64>> {
    let end_m = MAX_ALONG_M.min(arm.course.length_m());
    let free = |along_m: &f64| {
        let (p, along) = arm.course.at(*along_m);
        let left = Vector2::new(-along.y, along.x);
        span_m.iter().all(|&left_m| is_free(feature, arm, p + left * left_m))
    };
    let steps = ((end_m - from_m) / STEP_M).floor().max(0.0) as usize;
    let mut places =
        (0..=steps).map(|i| from_m + STEP_M * i as f64).skip_while(|along_m| !free(along_m)).take_while(free);
    let start = places.next()?;
    let end = places.last()?;
    (end - start >= MIN_STRETCH_M).then_some(start..end)
}

/// Whether a place lies beside all arms but `arm`.
fn is_free(feature: &FeatureModel, arm: &ArmModel, place: Point2<f64>) -> bool {
    let others = feature.arms.iter().filter(|other| other.label != arm.label);
    others
        .map(|other| (other.course.nearest(place), other))
        .all(|(foot, other)| foot.left_m.abs() > 0.5 * other.width_m + CLEARANCE_M)
}
