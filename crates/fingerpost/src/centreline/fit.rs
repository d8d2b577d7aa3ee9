//! One curve through the middles of the sections, followed from frame to frame.
//!
//! The curve y(x) = offset + slope x + curvature x² / 2 is what the frame before left of it, moved by the vehicle's own
//! motion, joined by least squares with what the sections of this frame say.

use nalgebra::{Matrix3, Vector3};

use super::{Centreline, CentrelineConfig, NoCentreline, SectionEvidence, SectionUse};
use crate::motion::Motion;

/// How far the road's width in a section may be from that of most, as a share: beyond, a side road or a yard begins.
const WIDTH_TOLERANCE: f64 = 0.2;
/// How far off a section's middle is, one standard deviation, metres, from both edges and from one; and its direction, as a
/// slope. Frames that follow each other err alike, which these make up for.
const BOTH_SIGMA: (f64, f64) = (0.2, 0.12);
const ONE_SIGMA: (f64, f64) = (0.5, 0.25);
/// Before anything is known: how far off the road's middle may be, metres, its slope, and its curvature, 1/m: a bend of 30 m.
const FIRST_SIGMA: [f64; 3] = [10.0, 0.3, 0.03];
/// How the three wander on a metre of road beyond what the curve says.
const WANDER_PER_M: [f64; 3] = [0.03, 0.02, 0.008];
/// How far a middle may be from the curve, metres, beside what the curve itself may be off.
const MAX_RESIDUAL_M: f64 = 0.35;
/// Least sections that make a curve.
const MIN_SECTIONS: usize = 2;
/// How far the vehicle goes with no sections that agree until the curve is forgotten, metres.
const FORGOTTEN_M: f64 = 6.0;

/// The road's middle in a section.
#[derive(Debug, Clone, Copy)]
pub(super) struct Middle {
    forward_m: f64,
    left_m: f64,
    slope: f64,
    sigma: (f64, f64),
}

/// The road's middle as far as it is known.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// Offset, slope and curvature at the vehicle.
    curve: Vector3<f64>,
    covariance: Matrix3<f64>,
    /// Driven since sections agreed, metres.
    unseen_m: f64,
}

impl Default for Course {
    fn default() -> Self {
        let sigma = Vector3::from(FIRST_SIGMA);
        Self {
            curve: Vector3::zeros(),
            covariance: Matrix3::from_diagonal(&sigma.component_mul(&sigma)),
            unseen_m: 0.0,
        }
    }
}

impl Course {
    /// Where the road's middle is expected at some distance ahead, metres to the left, and its slope there.
    pub(super) fn at(&self, forward_m: f64) -> [f64; 2] {
        [left_m(&self.curve, forward_m), self.curve[1] + self.curve[2] * forward_m]
    }

    /// Moves the curve with the vehicle; without a motion nothing is known any more.
    pub(super) fn move_on(&mut self, motion: Option<&Motion>) {
        let Some(motion) = motion.filter(|_| self.unseen_m < FORGOTTEN_M) else {
            *self = Self::default();
            return;
        };
        let pose = &motion.previous_from_current;
        let (ahead_m, turn_rad) = (pose.translation.x, pose.rotation.angle());
        let moved = Matrix3::new(1.0, ahead_m, 0.5 * ahead_m * ahead_m, 0.0, 1.0, ahead_m, 0.0, 0.0, 1.0);
        self.curve = moved * self.curve - Vector3::new(pose.translation.y, turn_rad, 0.0);
        let wander = Vector3::from(WANDER_PER_M);
        self.covariance = moved * self.covariance * moved.transpose()
            + Matrix3::from_diagonal(&wander.component_mul(&wander)) * ahead_m.abs();
        self.unseen_m += ahead_m.abs();
    }

    /// Takes in the sections of a frame; marks what became of each.
    pub(super) fn take(
        &mut self,
        config: &CentrelineConfig,
        sections: &mut [SectionEvidence],
        middles: &mut Vec<Middle>,
    ) -> Result<Centreline, NoCentreline> {
        let width_m = common_width_m(config, sections, middles).ok_or(NoCentreline::NoEdges)?;
        middles.clear();
        for section in sections {
            middles.extend(middle(section, width_m));
        }
        let first = self.joined(middles).ok_or(NoCentreline::TooFewSections)?;
        middles.retain(|middle| {
            let x = powers(middle.forward_m);
            let sigma_m = (x.transpose() * first.covariance * x)[0].max(0.0).sqrt();
            (left_m(&first.curve, middle.forward_m) - middle.left_m).abs() <= MAX_RESIDUAL_M + sigma_m
        });
        if middles.len() < MIN_SECTIONS {
            return Err(NoCentreline::TooFewSections);
        }
        *self = self.joined(middles).ok_or(NoCentreline::TooFewSections)?;
        let [offset_m, slope, curvature_per_m] = self.curve.into();
        Ok(Centreline { offset_m, heading_rad: slope.atan(), curvature_per_m, width_m, steer_rad: 0.0 })
    }

    /// What is known with these middles.
    fn joined(&self, middles: &[Middle]) -> Option<Self> {
        let mut information = self.covariance.try_inverse()?;
        let mut vector = information * self.curve;
        for middle in middles {
            let (place_sigma, slope_sigma) = middle.sigma;
            let rows = [
                (powers(middle.forward_m), middle.left_m, place_sigma),
                (Vector3::new(0.0, 1.0, middle.forward_m), middle.slope, slope_sigma),
            ];
            for (row, value, sigma) in rows {
                let weight = 1.0 / (sigma * sigma);
                information += weight * row * row.transpose();
                vector += weight * value * row;
            }
        }
        let covariance = information.try_inverse()?;
        Some(Self { curve: covariance * vector, covariance, unseen_m: 0.0 })
    }
}

/// The median width of the sections with both edges.
fn common_width_m(
    config: &CentrelineConfig,
    sections: &[SectionEvidence],
    widths: &mut Vec<Middle>,
) -> Option<f64> {
    // The list of middles serves for the widths first, so that no frame needs new memory.
    widths.clear();
    let found = sections.iter().filter_map(|section| {
        let width_m = width_m(section).filter(|m| (config.min_width_m..=config.max_width_m).contains(m))?;
        Some(Middle { forward_m: 0.0, left_m: width_m, slope: 0.0, sigma: BOTH_SIGMA })
    });
    widths.extend(found);
    widths.sort_unstable_by(|a, b| a.left_m.total_cmp(&b.left_m));
    widths.get(widths.len() / 2).map(|width| width.left_m)
}

fn width_m(section: &SectionEvidence) -> Option<f64> {
    let [left, right] = section.edges;
    let (left, right) = left.zip(right)?;
    let slope = 0.5 * (left.slope + right.slope);
    // Across the road, not across the vehicle.
    Some((left.left_m - right.left_m) / slope.hypot(1.0))
}

fn middle(section: &mut SectionEvidence, road_width_m: f64) -> Option<Middle> {
    let forward_m = 0.5 * (section.forward_m[0] + section.forward_m[1]);
    if width_m(section).is_some_and(|m| (m - road_width_m).abs() > WIDTH_TOLERANCE * road_width_m) {
        section.section_use = SectionUse::OtherWidth;
        return None;
    }
    let half_m = |slope: f64| 0.5 * road_width_m * slope.hypot(1.0);
    let (left_m, slope, sigma) = match section.edges {
        [Some(left), Some(right)] => {
            (0.5 * (left.left_m + right.left_m), 0.5 * (left.slope + right.slope), BOTH_SIGMA)
        }
        [Some(left), None] => (left.left_m - half_m(left.slope), left.slope, ONE_SIGMA),
        [None, Some(right)] => (right.left_m + half_m(right.slope), right.slope, ONE_SIGMA),
        [None, None] => return None,
    };
    Some(Middle { forward_m, left_m, slope, sigma })
}

/// How much offset, slope and curvature move the curve at some distance ahead.
fn powers(forward_m: f64) -> Vector3<f64> {
    Vector3::new(1.0, forward_m, 0.5 * forward_m * forward_m)
}

fn left_m(curve: &Vector3<f64>, forward_m: f64) -> f64 {
    curve.dot(&powers(forward_m))
}
