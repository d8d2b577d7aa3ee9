//! Hypotheses evenly along roads, at the start and where the vehicle is looked for again.

use nalgebra::Vector3;

use crate::belief::{Belief, OFFSET_MODEL};
use crate::hypothesis::Hypothesis;
use crate::path::{Sample, has_course};
use crate::state::{EAST, Mean, NORTH, OFFSET, State};

/// Standard deviation of the heading against the road at the start, radians.
pub(crate) const HEADING_SIGMA: f64 = 0.1;
/// The same this near to a junction, metres, where the vehicle may be half round a corner.
pub(crate) const JUNCTION_HEADING_SIGMA: f64 = 0.4;
const JUNCTION_M: f64 = 10.0;
/// Distance between hypotheses at the start, metres, where their number allows it.
const SEED_SPACING_M: f64 = 10.0;
/// Standard deviation along the road at the start, as a part of the spacing: sums of such bells are even within 2 %.
const SEED_SIGMA: f64 = 0.6;
/// Number of hypotheses at the start.
const MOST_SEEDS: f64 = 40_000.0;

/// How hypotheses lie along all roads of a map.
#[derive(Debug, Clone)]
pub(crate) struct Seeding {
    /// Probability that they share.
    mass: f64,
    spacing_m: f64,
    /// Length of all roads, each as probable as it is to be on it, metres.
    shared_m: f64,
    /// Where on its piece of an edge each of the edge's hypotheses lies, as a part of the piece; none on edges without a course.
    firsts: Vec<Option<f64>>,
}

/// The hypotheses of one edge.
#[derive(Debug, Clone, Copy)]
pub(crate) struct EdgeSeeds {
    count: usize,
    step_m: f64,
    first: f64,
    /// Logarithm of each one's weight.
    pub(crate) log_weight: f64,
    /// Standard deviation of each one's place along the edge, metres.
    pub(crate) sigma_m: f64,
}

impl Seeding {
    /// One that shares a probability, drawn anew.
    pub(crate) fn draw(belief: &mut Belief, mass: f64) -> Self {
        belief.tried_m = 0.0;
        let Belief { roads, random, .. } = belief;
        let total_m: f64 = roads.edges().iter().map(|edge| edge.line.length_m()).sum();
        Self {
            mass,
            spacing_m: SEED_SPACING_M.max(total_m / MOST_SEEDS),
            shared_m: roads.edges().iter().map(|edge| edge.line.length_m() * edge.prior).sum(),
            firsts: roads.edges().iter().map(|edge| has_course(&edge.line).then(|| random.unit())).collect(),
        }
    }

    /// The hypotheses of an edge; none of one without a course.
    pub(crate) fn of_edge(&self, belief: &Belief, index: u32) -> Option<EdgeSeeds> {
        let first = self.firsts.get(index as usize).copied().flatten()?;
        let edge = belief.roads.edge(index);
        let count = (edge.line.length_m() / self.spacing_m).ceil().max(1.0);
        let step_m = edge.line.length_m() / count;
        Some(EdgeSeeds {
            count: count as usize,
            step_m,
            first,
            log_weight: libm::log(self.mass * step_m * edge.prior / self.shared_m),
            sigma_m: step_m * SEED_SIGMA,
        })
    }
}

impl Belief {
    /// Hypotheses evenly along all roads, with a probability that they share.
    pub(crate) fn seed(&mut self, mass: f64) {
        let seeding = Seeding::draw(self, mass);
        for index in 0..self.roads.edges().len() as u32 {
            if let Some(seeds) = seeding.of_edge(self, index) {
                self.seed_edge(index, &seeds);
            }
        }
    }

    /// Adds the hypotheses of an edge.
    pub(crate) fn seed_edge(&mut self, index: u32, seeds: &EdgeSeeds) {
        let Self { roads, courses, hypotheses, .. } = self;
        let Some(course) = courses.of_edge(roads, index) else { return };
        let length_m = roads.edge(index).line.length_m();
        for i in 0..seeds.count {
            let along_m = (i as f64 + seeds.first) * seeds.step_m;
            let Some(sample) = course.between(along_m, along_m).1.first() else { continue };
            let from_end_m = along_m.min(length_m - along_m);
            let heading_sigma = if from_end_m < JUNCTION_M { JUNCTION_HEADING_SIGMA } else { HEADING_SIGMA };
            hypotheses.push(Box::new(Hypothesis {
                course: course.clone(),
                along_m,
                state: start(sample, seeds.sigma_m, heading_sigma),
                log_weight: seeds.log_weight,
                placed_by: None,
            }));
        }
    }
}

/// A vehicle at a place of a road, as sure as `along_m` along it.
pub(crate) fn start(sample: &Sample, along_m: f64, heading_sigma: f64) -> State {
    let heading_rad = sample.heading_rad;
    let (sine, cosine) = libm::sincos(heading_rad);
    let ahead = Vector3::new(cosine, sine, 0.0);
    let mut of_pose = ahead * ahead.transpose() * along_m.powi(2);
    of_pose[(2, 2)] = heading_sigma.powi(2);
    let mut state = State::of_pose(Vector3::new(sample.point.x, sample.point.y, heading_rad), of_pose);
    // The vehicle is as far beside the line as its offset says.
    let mut beside = Mean::zeros();
    (beside[EAST], beside[NORTH], beside[OFFSET]) = (-sine, cosine, 1.0);
    state.covariance += beside * beside.transpose() * OFFSET_MODEL.sigma_m.powi(2);
    state
}
