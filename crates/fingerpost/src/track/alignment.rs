//! Alignment: where the road's middle really is under each arm.
//!
//! P(F) is flat while the narrow masks stay on the wide road, so the match alone leaves the place open by half a
//! road's width; paper 1, section V-C, suggests bracketing about the detected point. Here every arm is cut into short
//! pieces; each is slid across its road with the method's one primitive, and the two edges at which the probability
//! falls give the road's middle, its width, and how far the arm lies from it. An arm thus measures the feature's
//! place across itself, and arms at different angles fix it.
//!
//! A pavement of the road's colour makes it too wide: where the map and a change of the grey say so, the kerb is the edge.
//!
//! Limits: a road whose edges are not seen, or which is far from as wide as the map says, measures nothing.

mod lines;
mod measured;
mod pavement;
mod pieces;
mod profile;
mod section;
mod slide;

use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Point2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::pitch_doubt::PitchDoubt;
use super::pose_filter::{LineMeasurement, PoseFilter, SlopeMeasurement, Update};
use crate::ground_view::Viewpoint;
use crate::matching::LaidSurface;
use crate::motion::CameraAttitude;
use measured::{Edge, Measured, heading, leave_out_beside_lines, measured_width_m, slope_by_pose};
use slide::Slide;

pub(super) use pieces::ArmPieces;
pub use section::{CrossSection, CrossSectionUse};

/// Settings of the alignment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct AlignmentConfig {
    /// Length of a piece of an arm, metres.
    #[schemars(range(min = 0.5, max = 10.0))]
    pub piece_length_m: f64,
    /// Width of a piece, metres.
    #[schemars(range(min = 0.1, max = 2.0))]
    pub piece_width_m: f64,
    /// How far beyond the road's half width a piece is slid, metres.
    #[schemars(range(min = 0.2, max = 10.0))]
    pub slide_beyond_m: f64,
    /// Step of the slide, metres.
    #[schemars(range(min = 0.02, max = 1.0))]
    pub slide_step_m: f64,
    /// Least fall of the probability at an edge; half of it for the mean of a whole arm, which has less noise.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub min_edge_step: f64,
    /// Narrowest road believed, as a share of the map's width.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_width_share: f64,
    /// How much wider than on the map a road may be, metres: room for parked cars, which the map does not count.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub max_wider_m: f64,
    /// Standard deviation of a road's middle between its edges, metres.
    #[schemars(range(min = 0.01, max = 5.0))]
    pub sigma_m: f64,
    /// Standard deviation of a road's width against the map's, as a share of it: what a single edge says.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub width_sigma_share: f64,
    /// Radius of the kerbs where roads meet, metres: within them a road's edge is not its own.
    #[schemars(range(min = 0.0, max = 50.0))]
    pub kerb_radius_m: f64,
}

impl Default for AlignmentConfig {
    fn default() -> Self {
        Self {
            piece_length_m: 1.5,
            piece_width_m: 0.3,
            slide_beyond_m: 3.0,
            slide_step_m: 0.1,
            min_edge_step: 0.15,
            min_width_share: 0.55,
            max_wider_m: 4.0,
            sigma_m: 0.2,
            width_sigma_share: 0.16,
            kerb_radius_m: 4.0,
        }
    }
}

/// Standard deviation of an edge of a whole arm of which no piece shows one, metres: far and soft.
const SOFT_EDGE_SIGMA_M: f64 = 0.6;
/// Standard deviation of a width that was measured on the same arm, metres.
const MEASURED_WIDTH_SIGMA_M: f64 = 0.25;

/// Measures the arms of features and moves their poses accordingly; its memory is reused from frame to frame.
#[derive(Debug)]
pub(super) struct Aligner {
    config: AlignmentConfig,
    pitch: PitchDoubt,
    slide: Slide,
    arm: Vec<Measured>,
    sections: Vec<CrossSection>,
    lines: Vec<Option<LineMeasurement>>,
    slopes: Vec<SlopeMeasurement>,
    /// How much wider than on the map the arms are of which both edges are seen.
    wider: Vec<f64>,
}

impl Aligner {
    /// An aligner for a camera at this place.
    pub(super) fn new(config: &AlignmentConfig, viewpoint: Viewpoint) -> Self {
        Self {
            config: config.clone(),
            pitch: PitchDoubt::of_calibration(viewpoint),
            slide: Slide::new(config),
            arm: Vec::new(),
            sections: Vec::new(),
            lines: Vec::new(),
            slopes: Vec::new(),
            wider: Vec::new(),
        }
    }

    /// Takes over how well the camera's pitch is known now: far places are less sure, in however many frames they are seen.
    pub(super) fn know_attitude(&mut self, attitude: &CameraAttitude) {
        self.pitch = self.pitch.of_attitude(attitude);
    }

    /// What is not known of the camera's pitch.
    pub(super) const fn pitch(&self) -> PitchDoubt {
        self.pitch
    }

    /// Measures every arm of a feature and moves `filter` accordingly; returns what was seen.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    pub(super) fn align(
        &mut self,
        laid: &LaidSurface<'_>,
        arms: &[ArmPieces],
        filter: &mut PoseFilter,
    ) -> Result<&[CrossSection], SpanError> {
        let believed = *filter.pose();
        self.sections.clear();
        self.lines.clear();
        self.slopes.clear();
        self.wider.clear();
        for arm in arms {
            self.measure(laid, arm, &believed)?;
            let node = Point2::from(believed.translation.vector);
            self.slopes.extend(heading(&self.arm).map(|(innovation_rad, sigma_rad)| SlopeMeasurement {
                by_pose: slope_by_pose(&self.arm, node),
                innovation_rad,
                sigma_rad,
            }));
            let first = self.lines.len();
            let measured = measured_width_m(&self.arm);
            self.wider.extend(measured.map(|width_m| width_m / arm.width_m));
            let width = measured.map_or_else(
                || assumed_width(&self.config, arm.width_m, mean(self.wider.iter().copied())),
                |width_m| (width_m, MEASURED_WIDTH_SIGMA_M),
            );
            let (config, pitch) = (&self.config, self.pitch);
            self.lines.extend(self.arm.iter().map(|piece| line(config, pitch, piece, width, &believed)));
            // Pieces of one arm share the errors of map and pitch: together they are worth little more than one.
            let lines = &mut self.lines[first..];
            let used = lines.iter().flatten().count().max(1) as f64;
            lines.iter_mut().flatten().for_each(|line| line.sigma_m *= used.sqrt());
            self.sections.extend(self.arm.drain(..).map(|piece| piece.section));
        }
        for slope in &self.slopes {
            filter.update_slope(slope, &believed);
        }
        for (section, line) in self.sections.iter_mut().zip(&self.lines) {
            let Some(line) = line else { continue };
            // Earlier measurements have moved the filter: the innovation is against where it is now.
            let moved = filter.pose() * line.p_in_feature - believed * line.p_in_feature;
            let innovation_m = line.innovation_m - line.normal.dot(&moved);
            match filter.update(&LineMeasurement { innovation_m, ..*line }) {
                Update::Accepted => section.section_use = CrossSectionUse::Accepted,
                Update::Gated(sigmas) => section.section_use = CrossSectionUse::Gated { sigmas },
            }
        }
        Ok(&self.sections)
    }

    /// Slides the pieces of an arm that are seen across its road, from its mouth outwards.
    fn measure(
        &mut self,
        laid: &LaidSurface<'_>,
        arm: &ArmPieces,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Result<(), SpanError> {
        self.arm.clear();
        self.slide.start_arm();
        for piece in &arm.pieces {
            self.slide.across(laid, arm, piece, vehicle_from_feature)?;
        }
        let measured = &mut self.arm;
        self.slide.slid(arm, &mut |slid| measured.push(Measured::of(slid)));
        leave_out_beside_lines(&mut self.arm);
        if self.arm.iter().all(|piece| piece.section.edges_m == [None, None])
            && let Some((section, along_m)) = self.slide.whole_arm(arm, vehicle_from_feature)
        {
            let believable = section.section_use == CrossSectionUse::InTheMouth;
            let soft = |left_m: f64| Edge { left_m, sigma_m: SOFT_EDGE_SIGMA_M };
            let edges = section.edges_m.map(|edge| edge.filter(|_| believable).map(soft));
            self.arm.push(Measured { section, along_m, edges });
        }
        Ok(())
    }
}

/// The width of an arm of which one edge is seen at most, and its standard deviation, metres: the map's, which is
/// believed the less the more the arms with two edges are wider or narrower than it says.
fn assumed_width(config: &AlignmentConfig, map_width_m: f64, wider: Option<f64>) -> (f64, f64) {
    let beyond = (wider.unwrap_or(1.0) - 1.0).abs() - config.width_sigma_share;
    (map_width_m, map_width_m * libm::hypot(config.width_sigma_share, beyond.max(0.0)))
}

/// The mean; none of nothing.
fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (count, sum) = values.fold((0.0, 0.0), |(count, sum), value| (count + 1.0, sum + value));
    (count > 0.0).then(|| sum / count)
}

/// The measurement of a piece: how far the road's middle lies from it.
fn line(
    config: &AlignmentConfig,
    pitch: PitchDoubt,
    piece: &Measured,
    (width_m, width_sigma_m): (f64, f64),
    vehicle_from_feature: &Isometry2<f64>,
) -> Option<LineMeasurement> {
    let (innovation_m, seen_sigma_m) = match piece.edges {
        [Some(left), Some(right)] => {
            (0.5 * (left.left_m + right.left_m), 0.5 * libm::hypot(left.sigma_m, right.sigma_m))
        }
        [Some(edge), None] => (edge.left_m - 0.5 * width_m, libm::hypot(edge.sigma_m, 0.5 * width_sigma_m)),
        [None, Some(edge)] => (edge.left_m + 0.5 * width_m, libm::hypot(edge.sigma_m, 0.5 * width_sigma_m)),
        [None, None] => return None,
    };
    let own_sigma_m = libm::hypot(config.sigma_m, seen_sigma_m);
    let CrossSection { p_in_vehicle, left, .. } = piece.section;
    Some(LineMeasurement {
        p_in_feature: vehicle_from_feature.inverse() * p_in_vehicle,
        normal: left,
        innovation_m,
        sigma_m: own_sigma_m,
        by_pitch_m: left.dot(&pitch.moves_m(p_in_vehicle)),
    })
}
