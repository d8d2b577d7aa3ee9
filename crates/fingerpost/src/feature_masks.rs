//! Feature masks: a route feature as row spans of the ground view.
//!
//! Paper 1, section V-A; paper 2, sections 3.2, 3.3, 4 and "Extension of feature masks". One sub-mask an arm, drawn
//! along the arm's own nodes out to beyond the ground view's edge, and one of the papers' driving path curve at the
//! vehicle's own width. Spans are relative to the feature's node, so that one drawing serves every place at the same heading;
//! drawings are kept by heading. Beside the arms lie strips where their verges are expected (`verge.rs`).

mod mask_curve;
mod verge;

use std::collections::BTreeMap;
use std::sync::Arc;

use fingerpost_geometry::{GroundGrid, Polyline, wrap_angle};
use fingerpost_map::ArmRole;
use fingerpost_vision::span::{SpanError, SpanMask};
use nalgebra::{Isometry2, Point2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::feature_model::FeatureModel;
use crate::vehicle::VehicleConfig;

pub use mask_curve::MaskCurve;
pub use verge::{VergeStrip, VergeStrips};

/// Settings of the feature masks.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct FeatureMaskConfig {
    /// Width of an arm's mask as a share of the vehicle's width (paper 2, 3.2).
    #[schemars(range(min = 0.05, max = 2.0))]
    pub arm_width_share: f64,
    /// Step between headings at which masks are drawn, degrees.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub heading_step_deg: f64,
    /// Shortest distance of the ends of the papers' curve from the node, metres.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub curve_min_setback_m: f64,
    /// Longest distance of the ends of the papers' curve from the node, metres: farther away a wide curve leaves the road.
    #[schemars(range(min = 0.5, max = 40.0))]
    pub curve_max_setback_m: f64,
    /// Width of a band in which an arm's verge is looked for, metres.
    #[schemars(range(min = 0.1, max = 2.0))]
    pub verge_width_m: f64,
    /// Narrowest road beside which a verge is looked for, as a share of the map's width.
    #[schemars(range(min = 0.2, max = 1.0))]
    pub verge_from_share: f64,
    /// How far beyond the road's half width by the map a verge is looked for, metres: streets with room for parked
    /// cars are wider than the map says.
    #[schemars(range(min = 0.5, max = 10.0))]
    pub verge_reach_m: f64,
}

impl Default for FeatureMaskConfig {
    fn default() -> Self {
        Self {
            arm_width_share: 0.25,
            heading_step_deg: 0.5,
            curve_min_setback_m: 3.0,
            curve_max_setback_m: 12.0,
            verge_width_m: 0.5,
            verge_from_share: 0.8,
            verge_reach_m: 2.0,
        }
    }
}

/// What a sub-mask stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SubMaskKind {
    /// An arm of the feature.
    Arm {
        /// What the route does with it.
        role: ArmRole,
        /// Index of the arm in the feature's model.
        index: usize,
    },
    /// The papers' driving path curve at the vehicle's width.
    DrivingLine,
}

/// One sub-mask, relative to the feature's node.
#[derive(Debug, Clone)]
pub struct SubMask {
    /// What it stands for.
    pub kind: SubMaskKind,
    /// `approach`, `exit`, `side_1`, ..., `driving_line`.
    pub label: Arc<str>,
    /// The mask, pixels from the node's pixel.
    pub spans: SpanMask,
    /// Pixels of it that lie on the crossing roads rather than on the arm itself.
    pub mouth_px: u64,
    /// Width with which it is drawn, pixels.
    pub width_px: f64,
    /// Whether it leaves the line of the approach: without such an arm a plain road would match.
    pub leaves_the_line: bool,
}

/// All sub-masks of a feature at one heading.
#[derive(Debug, Clone)]
pub struct FeatureMasks {
    /// The heading at which they are drawn, radians.
    pub heading_rad: f64,
    /// The sub-masks; the driving line last.
    pub subs: Vec<SubMask>,
}

/// Masks laid on a ground view.
#[derive(Debug, Clone, Copy)]
pub struct PlacedMasks<'a> {
    /// The masks, relative to the feature's node.
    pub masks: &'a FeatureMasks,
    /// Column of the node's pixel.
    pub column: i32,
    /// Row of the node's pixel.
    pub row: i32,
}

/// What of an arm is drawn.
#[derive(Debug)]
struct DrawnArm {
    kind: SubMaskKind,
    label: Arc<str>,
    course: Polyline,
    mouth_m: f64,
    leaves_the_line: bool,
    verges: VergeStrips<Polyline>,
}

/// The masks of one feature, drawn when first asked for and kept by heading: at most one drawing for each of the
/// [`FeatureMaskConfig::heading_step_deg`] of a full circle, of which a vehicle on the road ever asks for a few dozen.
#[derive(Debug)]
pub struct MaskCache {
    arms: Vec<DrawnArm>,
    curve: Option<Polyline>,
    arm_width_m: f64,
    line_width_m: f64,
    heading_step_rad: f64,
    metres_per_pixel: f64,
    drawn: BTreeMap<i64, FeatureMasks>,
    drawn_verges: BTreeMap<i64, Vec<VergeStrips<SpanMask>>>,
}

impl MaskCache {
    /// A cache for `feature`, whose kerbs have the radius `kerb_radius_m` (metres), and the papers' curve through it on the raster
    /// `grid`.
    pub fn new(
        config: &FeatureMaskConfig,
        kerb_radius_m: f64,
        vehicle: &VehicleConfig,
        grid: &GroundGrid,
        feature: &FeatureModel,
        curve: Option<&MaskCurve>,
    ) -> Self {
        // From any place in view an arm this long leaves the view.
        let reach_m = libm::hypot(grid.far_m() - grid.near_m(), 2.0 * grid.half_width_m());
        let arms = feature
            .arms
            .iter()
            .enumerate()
            .map(|(index, arm)| DrawnArm {
                kind: SubMaskKind::Arm { role: arm.role, index },
                label: arm.label.clone(),
                course: drawn_course(&arm.course, reach_m),
                mouth_m: arm.leaves_after_m.map_or(arm.mouth_m, |on_line_m| arm.mouth_m.max(on_line_m)),
                leaves_the_line: arm.leaves_the_line(),
                verges: verge::courses(config, kerb_radius_m, feature, arm),
            })
            .collect();
        Self {
            arms,
            curve: curve.map(|curve| curve.curve.clone()),
            arm_width_m: config.arm_width_share * vehicle.width_m,
            line_width_m: vehicle.width_m + 2.0 * vehicle.margin_m,
            heading_step_rad: config.heading_step_deg.to_radians(),
            metres_per_pixel: grid.metres_per_pixel(),
            drawn: BTreeMap::new(),
            drawn_verges: BTreeMap::new(),
        }
    }

    /// The masks at the drawn heading nearest to `heading_rad`.
    ///
    /// # Errors
    /// [`SpanError`] when an arm's coordinates cannot be drawn, as in a damaged route file.
    pub fn at(&mut self, heading_rad: f64) -> Result<&FeatureMasks, SpanError> {
        let key = self.key(heading_rad);
        if !self.drawn.contains_key(&key) {
            let masks = self.draw(key as f64 * self.heading_step_rad)?;
            self.drawn.insert(key, masks);
        }
        Ok(&self.drawn[&key])
    }

    /// The masks nearest to `heading_rad`, if they have been drawn.
    pub fn drawn(&self, heading_rad: f64) -> Option<&FeatureMasks> {
        self.drawn.get(&self.key(heading_rad))
    }

    /// The strips beside every arm, in the arms' order, at the drawn heading nearest to `heading_rad`.
    ///
    /// # Errors
    /// [`SpanError`] as for [`MaskCache::at`].
    pub fn verges_at(&mut self, heading_rad: f64) -> Result<&[VergeStrips<SpanMask>], SpanError> {
        let key = self.key(heading_rad);
        if !self.drawn_verges.contains_key(&key) {
            let verges = self.draw_verges(key as f64 * self.heading_step_rad)?;
            self.drawn_verges.insert(key, verges);
        }
        Ok(&self.drawn_verges[&key])
    }

    /// Draws all that a vehicle asks for while its heading stays within `reach_rad` of `heading_rad`, so that no frame in
    /// which it does has to.
    ///
    /// # Errors
    /// [`SpanError`] as for [`MaskCache::at`].
    pub(crate) fn draw_about(&mut self, heading_rad: f64, reach_rad: f64) -> Result<(), SpanError> {
        let steps = (reach_rad / self.heading_step_rad).ceil() as i32;
        for step in -steps..=steps {
            let heading_rad = heading_rad + self.heading_step_rad * f64::from(step);
            self.at(heading_rad)?;
            self.verges_at(heading_rad)?;
        }
        Ok(())
    }

    /// Frees the drawings of a feature that lies behind.
    pub(crate) fn clear(&mut self) {
        self.drawn.clear();
        self.drawn_verges.clear();
    }

    /// Number of the drawing that serves a heading.
    pub(crate) fn key(&self, heading_rad: f64) -> i64 {
        (wrap_angle(heading_rad) / self.heading_step_rad).round() as i64
    }

    fn draw(&self, heading_rad: f64) -> Result<FeatureMasks, SpanError> {
        let width_px = self.arm_width_m / self.metres_per_pixel;
        let mut subs = Vec::new();
        for arm in &self.arms {
            subs.push(SubMask {
                kind: arm.kind,
                label: arm.label.clone(),
                spans: self.stroke(&arm.course, heading_rad, width_px)?,
                mouth_px: (arm.mouth_m / self.metres_per_pixel * width_px).round() as u64,
                width_px,
                leaves_the_line: arm.leaves_the_line,
            });
        }
        if let Some(curve) = &self.curve {
            let width_px = self.line_width_m / self.metres_per_pixel;
            subs.push(SubMask {
                kind: SubMaskKind::DrivingLine,
                label: "driving_line".into(),
                spans: self.stroke(curve, heading_rad, width_px)?,
                mouth_px: 0,
                width_px,
                leaves_the_line: false,
            });
        }
        Ok(FeatureMasks { heading_rad, subs })
    }

    fn draw_verges(&self, heading_rad: f64) -> Result<Vec<VergeStrips<SpanMask>>, SpanError> {
        let side = |strip: &Option<VergeStrip<Polyline>>| {
            let drawn = |strip: &VergeStrip<Polyline>| {
                let width_px = strip.band_width_m / self.metres_per_pixel;
                strip.drawn(|course| self.stroke(course, heading_rad, width_px))
            };
            strip.as_ref().map(drawn).transpose()
        };
        self.arms.iter().map(|arm| Ok([side(&arm.verges[0])?, side(&arm.verges[1])?])).collect()
    }

    fn stroke(&self, course: &Polyline, heading_rad: f64, width_px: f64) -> Result<SpanMask, SpanError> {
        let turned = course.transformed(&Isometry2::rotation(heading_rad));
        let pixels: Vec<[f64; 2]> = turned.points().iter().map(|p| self.offset_px(p.coords)).collect();
        SpanMask::stroke(&pixels, width_px)
    }

    /// Pixels right of and below the node for a displacement in the vehicle frame, metres.
    fn offset_px(&self, d_in_vehicle: Vector2<f64>) -> [f64; 2] {
        [-d_in_vehicle.y / self.metres_per_pixel, -d_in_vehicle.x / self.metres_per_pixel]
    }
}

/// The course cut at, or carried straight on to, `reach_m`.
fn drawn_course(course: &Polyline, reach_m: f64) -> Polyline {
    let end: Point2<f64> = course.at(reach_m).0;
    let kept = course.points().iter().copied().take_while(|p| course.nearest(*p).along_m < reach_m);
    Polyline::new(kept.chain([end])).unwrap_or_else(|_| course.clone())
}

/// Whole pixels from the ground view's corner to the pixel in which the feature's node lies.
pub fn node_pixel(grid: &GroundGrid, vehicle_from_feature: &Isometry2<f64>) -> (i32, i32) {
    let pixel = grid.ground_from_vehicle(Point2::from(vehicle_from_feature.translation.vector));
    (pixel.column.round() as i32, pixel.row.round() as i32)
}
