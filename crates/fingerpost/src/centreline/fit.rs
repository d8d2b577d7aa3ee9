//! One curve along the road's middle and the road's width, through edges ahead of the vehicle and beneath it.
//!
//! Where the road passes the rear axle no camera sees it: it was seen metres before. A curve that is drawn back from what
//! is ahead leaves a bend by metres of error in its curvature. So the edges that were found stay where they lie on the
//! road while the vehicle moves over them, and the curve y(x) = offset + slope x + curvature x² / 2 is fitted by least
//! squares to those about the vehicle, half of a width to its left and to its right. With one width for all of them a single
//! edge says where the middle is as soon as both have been seen.

use std::f64::consts::LN_2;

use nalgebra::{Matrix4, Point2, Vector4};

use super::turn::RoadLine;
use super::{Centreline, CentrelineConfig, NoCentreline, RoadEdge, SectionEvidence, SectionUse};
use crate::motion::Motion;

/// How far the road's width in a section may be from that of most, as a share: beyond, a side road or a yard begins.
const WIDTH_TOLERANCE: f64 = 0.2;
/// How far off an edge is, one standard deviation: metres at the vehicle, more for each metre ahead, and for each metre
/// that it was moved since. Sections that follow each other err alike, which these make up for.
const EDGE_SIGMA_M: f64 = 0.15;
const AHEAD_SIGMA: f64 = 0.015;
const MOVED_SIGMA: f64 = 0.015;
/// Contrast of a road that stands out clearly, at which an edge is off by no more than that.
const CLEAR_CONTRAST: f64 = 0.8;
/// Before anything is known: how far off the road's middle may be, metres, its slope, its curvature, 1/m, a bend of 30 m,
/// and its width, metres.
const FIRST_SIGMA: [f64; 4] = [10.0, 0.3, 0.03, 5.0];
/// Width of a road before any is seen, metres.
const FIRST_WIDTH_M: f64 = 7.0;
/// How far the width may be from that of before, metres, in a frame.
const WIDTH_SIGMA_M: f64 = 1.0;
/// How far ahead an edge may be shown too far, metres for each square metre: a fifth of a degree of pitch from 1.5 m above the
/// road, what a suspension adds. Of an edge that lies askew it is also beside.
const PITCH_PER_M: f64 = 0.0023;
/// How far off the direction of a section's edge is, one standard deviation, as a slope.
const SLOPE_SIGMA: f64 = 0.1;
/// How far an edge may be from the curve, metres, beside what the curve itself may be off.
const MAX_RESIDUAL_M: f64 = 0.35;
/// How the three and the width wander on a metre of road beyond what the curve says.
const WANDER_PER_M: [f64; 4] = [0.03, 0.02, 0.008, 0.05];
/// Outwards, from the left and from the right edge.
const SIDES: [f64; 2] = [1.0, -1.0];
/// Most edges that are kept.
const MOST_KEPT: usize = 512;
/// Least sections that make a curve.
const MIN_SECTIONS: usize = 2;
/// How far the vehicle goes with no sections that agree until all is forgotten, metres.
const FORGOTTEN_M: f64 = 6.0;
/// How far behind the rear axle edges are kept, metres, and how far apart the places are from which they are.
const KEPT_BEHIND_M: f64 = 8.0;
const KEPT_EVERY_M: f64 = 1.0;
/// Edges of a road farther from the vehicle's direction are not kept, as a slope (10 degrees): seen askew they are beside their
/// place by what the pitch puts them too far, and the more so the more they are turned away.
const KEPT_SLOPE: f64 = 0.176;
/// Quality from which a motion is believed, and metres of wander in a frame without one.
const MIN_MOTION_QUALITY: f64 = 0.05;
const BLIND_STEP_M: f64 = 0.1;
/// How far the vehicle turns until an edge is let go, radians: beyond, no curve of this kind holds both.
const KEPT_TURN_RAD: f64 = 0.5;
/// How far from the vehicle an edge says half as much of the curve, metres.
const REACH_M: f64 = 10.0;
/// How far off the road behind a corner may be when its first edges are taken: its offset, metres, its slope, its curvature, 1/m
/// (maps have nodes where a road leaves the straight by half a metre in 20 m), and its width, metres, a sixth.
const BEGIN_SIGMA: [f64; 2] = [0.5, 0.1];
const BEGIN_CURVATURE_SIGMA: f64 = 0.0025;
const BEGIN_WIDTH_SIGMA_M: f64 = 1.0;
/// How far off the offset may be to be told, metres.
const MAX_SIGMA_M: f64 = 0.5;
/// Rounds in which edges off the curve are left out.
const ROUNDS: usize = 3;

/// How long a road is believed of which no edges are seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Lasts {
    /// For [`FORGOTTEN_M`].
    Along,
    /// As long as it is sure: at a corner there are none.
    RoundCorner,
}

/// An edge of the road where a section showed it, in the vehicle's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct EdgePoint {
    place: Point2<f64>,
    /// 1 of the left edge, -1 of the right one.
    side: f64,
    slope: f64,
    sigma_m: f64,
    /// How far the vehicle has turned since, radians.
    turned_rad: f64,
    /// Section of this frame.
    section: usize,
}

/// A road that begins behind a corner.
#[derive(Debug, Clone)]
struct Begun {
    curve: Vector4<f64>,
    covariance: Matrix4<f64>,
    /// Driven since, metres: farther, edges behind each other tell all of it.
    ago_m: f64,
}

/// The road's middle as far as it is known.
#[derive(Debug, Clone)]
pub(super) struct Course {
    /// Offset, slope, curvature and width.
    curve: Vector4<f64>,
    covariance: Matrix4<f64>,
    /// Whether edges have told them.
    known: bool,
    /// What is known of the curve beside all edges: the road behind a corner, from what lay ahead before it.
    begun: Option<Begun>,
    /// Whether the motion since the frame before is known; if not, the curve of before is all that is left of it.
    moved: bool,
    /// Edges of frames before.
    kept: Vec<EdgePoint>,
    /// Edges of this frame.
    fresh: Vec<EdgePoint>,
    widths: Vec<f64>,
    /// Driven since sections agreed, and since edges were kept, metres.
    unseen_m: f64,
    unkept_m: f64,
}

impl Default for Course {
    fn default() -> Self {
        Self {
            curve: Vector4::new(0.0, 0.0, 0.0, FIRST_WIDTH_M),
            covariance: first_covariance(),
            known: false,
            begun: None,
            moved: false,
            kept: Vec::with_capacity(MOST_KEPT),
            fresh: Vec::new(),
            widths: Vec::new(),
            unseen_m: 0.0,
            unkept_m: 0.0,
        }
    }
}

impl Course {
    /// The road's width, metres.
    pub(super) fn width_m(&self) -> f64 {
        self.curve[3]
    }

    /// Where the road's middle is expected at some distance ahead, metres to the left, and its slope there.
    pub(super) fn at(&self, forward_m: f64) -> [f64; 2] {
        [self.middle_m(forward_m), self.curve[1] + self.curve[2] * forward_m]
    }

    /// Moves all with the vehicle. Without a motion edges cannot be kept; the curve is taken to go on as before, as that of
    /// a fast road does.
    pub(super) fn move_on(&mut self, motion: Option<&Motion>, lasts: Lasts) {
        if self.unseen_m >= FORGOTTEN_M && lasts == Lasts::Along {
            self.forget();
            return;
        }
        let Some(motion) = motion.filter(|motion| motion.quality >= MIN_MOTION_QUALITY) else {
            self.kept.clear();
            self.moved = false;
            let wander = Vector4::from(WANDER_PER_M);
            self.covariance += Matrix4::from_diagonal(&wander.component_mul(&wander)) * BLIND_STEP_M;
            self.unseen_m += BLIND_STEP_M;
            self.unkept_m = KEPT_EVERY_M;
            return;
        };
        self.moved = true;
        let current_from_previous = motion.previous_from_current.inverse();
        let pose = &motion.previous_from_current;
        let (ahead_m, turn_rad) = (pose.translation.x, pose.rotation.angle());
        for edge in &mut self.kept {
            edge.place = current_from_previous * edge.place;
            edge.sigma_m += MOVED_SIGMA * ahead_m.abs();
            edge.turned_rad += turn_rad;
        }
        self.kept.retain(|edge| edge.place.x > -KEPT_BEHIND_M && edge.turned_rad.abs() < KEPT_TURN_RAD);
        let mut moved = Matrix4::identity();
        moved[(0, 1)] = ahead_m;
        moved[(0, 2)] = 0.5 * ahead_m * ahead_m;
        moved[(1, 2)] = ahead_m;
        let wander = Vector4::from(WANDER_PER_M);
        let wandered = Matrix4::from_diagonal(&wander.component_mul(&wander)) * ahead_m.abs();
        let carried = |curve: &Vector4<f64>, covariance: &Matrix4<f64>| {
            let mut carried = moved * curve;
            carried[0] -= pose.translation.y;
            carried[1] = libm::tan(libm::atan(carried[1]) - turn_rad);
            (carried, moved * covariance * moved.transpose() + wandered)
        };
        (self.curve, self.covariance) = carried(&self.curve, &self.covariance);
        self.begun = self.begun.take().filter(|begun| begun.ago_m < REACH_M).map(|begun| {
            let (curve, covariance) = carried(&begun.curve, &begun.covariance);
            // Straight on, as it began.
            let curvature = begun.covariance[(2, 2)];
            let mut covariance = covariance;
            covariance[(2, 2)] = curvature;
            Begun { curve, covariance, ago_m: begun.ago_m + ahead_m.abs() }
        });
        self.unseen_m += ahead_m.abs();
        self.unkept_m += ahead_m.abs();
    }

    /// Takes in the sections of a frame; marks what became of each.
    pub(super) fn take(
        &mut self,
        config: &CentrelineConfig,
        sections: &mut [SectionEvidence],
    ) -> Result<Centreline, NoCentreline> {
        if !self.known {
            let width_m = self.common_width_m(config, sections).ok_or(NoCentreline::NoEdges)?;
            self.curve[3] = width_m;
        }
        let width_m = self.curve[3];
        self.list_edges(sections);
        let (mut curve, mut covariance) = (self.curve, self.covariance);
        if !self.known {
            // Before a curve is known a section is judged by its width alone.
            let alike = |section: &SectionEvidence| {
                section_width_m(section).is_some_and(|m| (m - width_m).abs() <= WIDTH_TOLERANCE * width_m)
            };
            (curve, covariance) =
                self.fitted(&curve, |edge| alike(&sections[edge.section])).ok_or(NoCentreline::NoEdges)?;
        }
        for _ in 0..ROUNDS {
            let near = |edge: &EdgePoint| is_near(edge, &curve, &covariance);
            let next = self.fitted(&curve, near).ok_or(NoCentreline::NoEdges)?;
            (curve, covariance) = next;
        }
        self.fresh.retain(|edge| is_near(edge, &curve, &covariance));
        let agree = self.mark_section_use(sections);
        let [offset_m, _, _, width_m] = curve.into();
        let on_road = offset_m.abs() <= 0.5 * width_m;
        let is_road = (config.min_width_m..=config.max_width_m).contains(&width_m);
        if agree < MIN_SECTIONS || !on_road || !is_road {
            return Err(NoCentreline::TooFewSections);
        }
        (self.curve, self.covariance, self.known, self.unseen_m) = (curve, covariance, true, 0.0);
        let is_along = self.curve[1].abs() < KEPT_SLOPE;
        if is_along && self.unkept_m >= KEPT_EVERY_M && self.kept.len() + self.fresh.len() <= MOST_KEPT {
            self.kept.extend(&self.fresh);
            self.unkept_m = 0.0;
        }
        self.believed().ok_or(NoCentreline::Unsure)
    }

    /// Lists the edges of these sections in place of the last frame's.
    fn list_edges(&mut self, sections: &[SectionEvidence]) {
        self.fresh.clear();
        for (index, section) in sections.iter().enumerate() {
            let forward_m = 0.5 * (section.forward_m[0] + section.forward_m[1]);
            for (edge, side) in section.edges.iter().zip(SIDES) {
                self.fresh.extend(edge.map(|edge| EdgePoint {
                    place: Point2::new(forward_m, edge.left_m),
                    side,
                    slope: edge.slope,
                    sigma_m: edge_sigma_m(&edge, forward_m),
                    turned_rad: 0.0,
                    section: index,
                }));
            }
        }
    }

    /// Marks each section with what became of its edges; returns how many sections agree with the curve.
    fn mark_section_use(&self, sections: &mut [SectionEvidence]) -> usize {
        let mut agree = 0;
        for (index, section) in sections.iter_mut().enumerate() {
            let found = section.edges.iter().flatten().count();
            let used = self.fresh.iter().filter(|edge| edge.section == index).count();
            section.section_use = match (found, used) {
                (0, _) => SectionUse::NoEdges,
                (_, 0) => SectionUse::OtherWidth,
                (_, 1) => SectionUse::OneEdge,
                _ => SectionUse::BothEdges,
            };
            agree += usize::from(used > 0);
        }
        agree
    }

    /// Begins anew with a straight road of the width of before, along a line whose offset (metres) and direction (radians) are so
    /// sure.
    pub(super) fn begin(&mut self, line: &RoadLine, [sigma_m, sigma_rad]: [f64; 2]) {
        let slope = libm::tan(line.heading_rad);
        self.curve = Vector4::new(line.offset_m(), slope, 0.0, self.curve[3]);
        let slope_sigma = sigma_rad * (1.0 + slope * slope);
        let sigma = Vector4::new(sigma_m, slope_sigma, BEGIN_CURVATURE_SIGMA, BEGIN_WIDTH_SIGMA_M);
        self.covariance = Matrix4::from_diagonal(&sigma.component_mul(&sigma));
        // For edges to correct: all of it was seen from before the corner, askew.
        let loose = sigma.sup(&Vector4::new(BEGIN_SIGMA[0], BEGIN_SIGMA[1], 0.0, 0.0));
        let covariance = Matrix4::from_diagonal(&loose.component_mul(&loose));
        self.begun = Some(Begun { curve: self.curve, covariance, ago_m: 0.0 });
        self.kept.clear();
        (self.known, self.unseen_m, self.unkept_m) = (true, 0.0, KEPT_EVERY_M);
    }

    /// Standard deviations of offset, metres, and direction, radians.
    pub(super) fn line_sigma(&self) -> [f64; 2] {
        let sigma = |i: usize| self.covariance[(i, i)].max(f64::MIN_POSITIVE).sqrt();
        [sigma(0), sigma(1) / (1.0 + self.curve[1] * self.curve[1])]
    }

    /// Whether anything is known of it.
    pub(super) const fn is_known(&self) -> bool {
        self.known
    }

    /// The curve, however sure it is.
    pub(super) fn road(&self) -> Centreline {
        let [offset_m, slope, curvature_per_m, width_m] = self.curve.into();
        let sigma_m = self.covariance[(0, 0)].max(f64::MIN_POSITIVE).sqrt();
        let heading_rad = libm::atan(slope);
        Centreline { offset_m, sigma_m, heading_rad, curvature_per_m, width_m, ..Centreline::default() }
    }

    /// The curve whether or not this frame's edges tell it; none where its offset is not known or not sure enough.
    pub(super) fn believed(&self) -> Option<Centreline> {
        let road = self.road();
        (self.known && road.sigma_m <= MAX_SIGMA_M / libm::cos(road.heading_rad)).then_some(road)
    }

    fn forget(&mut self) {
        self.kept.clear();
        self.begun = None;
        self.curve = Vector4::new(0.0, 0.0, 0.0, FIRST_WIDTH_M);
        (self.covariance, self.known) = (first_covariance(), false);
        (self.unseen_m, self.unkept_m) = (0.0, KEPT_EVERY_M);
    }

    fn middle_m(&self, forward_m: f64) -> f64 {
        self.curve.dot(&row(forward_m, 0.0))
    }

    /// Curve and covariance by the edges that are `near`.
    fn fitted(
        &self,
        curve: &Vector4<f64>,
        near: impl Fn(&EdgePoint) -> bool,
    ) -> Option<(Vector4<f64>, Matrix4<f64>)> {
        let (mut expected, mut prior) = (self.curve, self.covariance);
        if self.moved {
            // The kept edges say what the curve of before said; of that the width alone is left.
            expected.fixed_rows_mut::<3>(0).fill(0.0);
            prior = first_covariance();
            prior[(3, 3)] = WIDTH_SIGMA_M * WIDTH_SIGMA_M;
            if let Some(begun) = &self.begun {
                (expected, prior) = (begun.curve, begun.covariance);
            }
        }
        let mut information = prior.try_inverse()?;
        let mut vector = information * expected;
        let mut add = |row: Vector4<f64>, value: f64, weight: f64| {
            information += weight * row * row.transpose();
            vector += weight * value * row;
        };
        for edge in self.fresh.iter().chain(&self.kept).filter(|edge| near(edge)) {
            let x = edge.place.x;
            let far = if self.moved { x / REACH_M } else { 0.0 };
            let share = libm::exp(-LN_2 * far * far);
            let outwards = edge.side * libm::hypot(curve[1] + curve[2] * x, 1.0);
            add(row(x, outwards), edge.place.y, share / (edge.sigma_m * edge.sigma_m));
        }
        // Directions are coarse: they serve until places behind each other tell more.
        for edge in self.fresh.iter().filter(|edge| !self.moved && near(edge)) {
            let of_slope = Vector4::new(0.0, 1.0, edge.place.x, 0.0);
            add(of_slope, edge.slope, 1.0 / (SLOPE_SIGMA * SLOPE_SIGMA));
        }
        let covariance = information.try_inverse()?;
        Some((covariance * vector, covariance))
    }

    /// The median width of the sections with both edges.
    fn common_width_m(&mut self, config: &CentrelineConfig, sections: &[SectionEvidence]) -> Option<f64> {
        self.widths.clear();
        let widths = sections.iter().filter_map(section_width_m);
        self.widths.extend(widths.filter(|m| (config.min_width_m..=config.max_width_m).contains(m)));
        self.widths.sort_unstable_by(f64::total_cmp);
        self.widths.get(self.widths.len() / 2).copied()
    }
}

/// How far off an edge is, one standard deviation, metres: the less the road stands out from what is beside it, the more.
fn edge_sigma_m(edge: &RoadEdge, forward_m: f64) -> f64 {
    let across_m = EDGE_SIGMA_M * (CLEAR_CONTRAST / edge.contrast).max(1.0) + AHEAD_SIGMA * forward_m;
    libm::hypot(across_m, edge.slope * PITCH_PER_M * forward_m * forward_m)
}

/// Whether an edge is where the curve has it.
fn is_near(edge: &EdgePoint, curve: &Vector4<f64>, covariance: &Matrix4<f64>) -> bool {
    let x = edge.place.x;
    let row = row(x, edge.side * libm::hypot(curve[1] + curve[2] * x, 1.0));
    let sigma_m = (row.transpose() * covariance * row)[0].max(0.0).sqrt();
    (curve.dot(&row) - edge.place.y).abs() <= MAX_RESIDUAL_M + 2.0 * sigma_m
}

/// How much offset, slope, curvature and width move the edge at some distance ahead; `outwards` is 1 or -1, more across a
/// slope, and 0 of the middle.
fn row(forward_m: f64, outwards: f64) -> Vector4<f64> {
    Vector4::new(1.0, forward_m, 0.5 * forward_m * forward_m, 0.5 * outwards)
}

fn first_covariance() -> Matrix4<f64> {
    let sigma = Vector4::from(FIRST_SIGMA);
    Matrix4::from_diagonal(&sigma.component_mul(&sigma))
}

fn section_width_m(section: &SectionEvidence) -> Option<f64> {
    let [left, right] = section.edges;
    let (left, right) = left.zip(right)?;
    let slope = 0.5 * (left.slope + right.slope);
    // Across the road, not across the vehicle.
    Some((left.left_m - right.left_m) / libm::hypot(slope, 1.0))
}
