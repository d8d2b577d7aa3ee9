//! All hypotheses with their weights, and the one that the vehicle is on no road of the map.

use std::f64::consts::FRAC_PI_2;

use fingerpost_map::RoadGraph;

use crate::fix::RISK;
use crate::hypothesis::Hypothesis;
use crate::merging::merge_alike;
use crate::odometry::Motion;
use crate::path::Courses;
use crate::random::Random;
use crate::roads::{Roads, Traffic};
use crate::state::OffsetModel;
use crate::unmapped::UnmappedRoad;

/// How the vehicle's place beside the line that it should drive is distributed: lane and driver put it up to half a narrow road
/// off (1.5 m), and the roads of OpenStreetMap extracts lie 0.5 to 1.3 m from lines driven with a survey's GPS. It keeps over the
/// length of a street and not round a right angle.
pub(crate) const OFFSET_MODEL: OffsetModel =
    OffsetModel { sigma_m: 2.0, distance_m: 100.0, turn_rad: FRAC_PI_2 };
/// Number of hypotheses that are kept.
const MOST_KEPT: usize = 100_000;
/// Probability at the start of being on no road of the map.
pub(crate) const OFF_MAP_AT_START: f64 = 0.05;
/// Roads left for places off the map, per metre: one yard or unmapped road in fifty kilometres.
const LEAVES_MAP_PER_M: f64 = 2e-5;
/// How far a vehicle stays near the road that it has left, metres: the length of a car park or a bay. It comes back to that road or
/// goes elsewhere, as often the one as the other. How much less it knows of where on the road it is back.
const NEAR_FOR_M: f64 = 50.0;
const RETURN_SIGMA_M: f64 = 5.0;
const RETURN_SIGMA_RAD: f64 = 0.1;
/// Returns that are less than this part of what matters are not followed up.
const LEAST_RETURN: f64 = 0.1;
/// Map lines that jump to the side by more than [`OFFSET_MODEL`] has, per metre: one in two kilometres, as junctions of
/// dual carriageways drawn as one and roads traced from shifted imagery; and by how much, metres.
const OTHER_LINE_PER_M: f64 = 5e-4;
const OTHER_LINE_SIGMA_M: f64 = 6.0;
/// Such a jump is thought of where the road is off by more than this, squared standard deviations (2.4 standard deviations), and where
/// the hypothesis has at least this weight, so that it can make up a part of the risk.
const SURPRISE: f64 = 6.0;
const MATTERS: f64 = 1e-3;
/// Distance driven off the map after which all roads are tried again, metres.
const TRY_AGAIN_M: f64 = 50.0;
/// How far a vehicle that is elsewhere stays off the map, metres: some streets that the map lacks.
const ELSEWHERE_FOR_M: f64 = 500.0;
/// Weights below this are dropped: far less than the risk even of all hypotheses together.
const LEAST_WEIGHT: f64 = 1e-9;

/// What is believed.
#[derive(Debug, Clone)]
pub(crate) struct Belief {
    pub(crate) roads: Roads,
    pub(crate) courses: Courses,
    /// Heaviest first.
    #[allow(clippy::vec_box, reason = "sorting would move 400 bytes for each: a third of a step's time")]
    pub(crate) hypotheses: Vec<Box<Hypothesis>>,
    /// Logarithm of the probability of being on no road of the map.
    pub(crate) log_off_map: f64,
    /// The part of it that is near the road that was left.
    near: f64,
    /// What is driven there.
    unmapped: UnmappedRoad,
    /// Distance driven since the map was last in doubt, metres.
    pub(crate) agreed_m: f64,
    pub(crate) random: Random,
    /// Distance driven since all roads were tried, metres.
    pub(crate) tried_m: f64,
    /// Memory for the estimate: squared distances (square metres) and numbers of hypotheses that are elsewhere.
    pub(crate) farthest: Vec<(f64, usize)>,
    #[allow(clippy::vec_box, reason = "they go to the hypotheses")]
    waiting: Vec<Box<Hypothesis>>,
}

impl Belief {
    /// The vehicle may be on any road, either way.
    pub(crate) fn anywhere(graph: &RoadGraph, traffic: Traffic, seed: u64) -> Self {
        let mut belief = Self::off_map_alone(graph, traffic, seed);
        belief.begin_anywhere();
        belief
    }

    /// A map without hypotheses on it.
    pub(crate) fn off_map_alone(graph: &RoadGraph, traffic: Traffic, seed: u64) -> Self {
        let roads = Roads::of(graph, traffic);
        Self {
            unmapped: UnmappedRoad::like(roads.bends()),
            roads,
            courses: Courses::default(),
            hypotheses: Vec::new(),
            log_off_map: libm::log(OFF_MAP_AT_START),
            near: 0.0,
            agreed_m: 0.0,
            random: Random::new(seed),
            tried_m: 0.0,
            farthest: Vec::new(),
            waiting: Vec::new(),
        }
    }

    /// Forgets everything.
    pub(crate) fn begin_anywhere(&mut self) {
        self.hypotheses.clear();
        self.log_off_map = libm::log(OFF_MAP_AT_START);
        self.near = 0.0;
        self.unmapped = UnmappedRoad::like(self.roads.bends());
        self.seed(1.0 - OFF_MAP_AT_START);
        self.normalise();
    }

    /// The vehicle may have gone elsewhere, off the map, with this probability.
    pub(crate) fn be_elsewhere(&mut self, probability: f64) {
        let off_map = self.off_map();
        let went = probability * (1.0 - off_map);
        self.near *= off_map / (off_map + went).max(f64::MIN_POSITIVE);
        self.log_off_map = libm::log(off_map + went);
        for hypothesis in &mut self.hypotheses {
            hypothesis.log_weight += libm::log(1.0 - probability);
        }
    }

    /// Probability of being on no road of the map.
    pub(crate) fn off_map(&self) -> f64 {
        libm::exp(self.log_off_map)
    }

    /// Moves all hypotheses and weighs them by the roads that they are on.
    pub(crate) fn go(&mut self, motion: &Motion) {
        for hypothesis in &mut self.hypotheses {
            hypothesis.go(motion, &OFFSET_MODEL);
        }
        self.come_back(motion.driven_m);
        self.branch();
        let leaves = (LEAVES_MAP_PER_M * motion.driven_m).min(0.5);
        let off_map = self.off_map();
        let leaving = leaves * (1.0 - off_map);
        self.unmapped.leave(leaving / (off_map + leaving).max(f64::MIN_POSITIVE));
        self.near = (off_map * self.near + leaving) / (off_map + leaving).max(f64::MIN_POSITIVE);
        self.log_off_map = libm::log(off_map + leaving) + self.unmapped.go(motion, &OFFSET_MODEL);
        let stays = libm::log(1.0 - leaves);
        let other_line = (OTHER_LINE_PER_M * motion.driven_m).min(0.5);
        let (same_line, other_line) = (libm::log(1.0 - other_line), libm::log(other_line));
        for hypothesis in &mut self.hypotheses {
            let before =
                (hypothesis.log_weight > libm::log(MATTERS)).then(|| hypothesis.off_line(OTHER_LINE_SIGMA_M));
            let fit = hypothesis.hold_to_road();
            hypothesis.log_weight += stays + same_line + fit.log_density;
            if let Some(mut off) = before.filter(|_| fit.surprise > SURPRISE) {
                off.log_weight += stays + other_line + off.hold_to_road().log_density;
                self.waiting.push(Box::new(off));
            }
        }
        self.hypotheses.append(&mut self.waiting);
        self.normalise();
        self.agreed_m = if self.off_map() > RISK { 0.0 } else { self.agreed_m + motion.driven_m };
        self.tried_m += motion.driven_m;
        if self.off_map() > 0.5 && self.tried_m > TRY_AGAIN_M {
            let mass = (self.tried_m / ELSEWHERE_FOR_M).min(0.5) * self.off_map();
            self.log_off_map = libm::log(self.off_map() - mass);
            self.seed(mass);
            self.normalise();
        }
        merge_alike(&mut self.hypotheses);
        self.courses.forget_unused();
    }

    /// What has left the map may be back on the road near where it left it, or go elsewhere.
    fn come_back(&mut self, driven_m: f64) {
        let off_map = self.off_map();
        let part = 0.5 * (driven_m / NEAR_FOR_M).min(1.0);
        let returns = part * self.near * off_map;
        if returns < MATTERS * LEAST_RETURN {
            self.near *= 1.0 - part;
            return;
        }
        let heavy =
            self.hypotheses.iter().take_while(|hypothesis| hypothesis.log_weight > libm::log(MATTERS));
        let on_map = 1.0 - off_map;
        self.waiting.extend(heavy.map(|hypothesis| {
            let mut back = hypothesis.come_back(RETURN_SIGMA_M, RETURN_SIGMA_RAD);
            back.log_weight += libm::log(returns / on_map.max(returns));
            Box::new(back)
        }));
        self.log_off_map = libm::log(off_map - returns);
        // As much again goes elsewhere.
        self.near = (self.near - 2.0 * part * self.near) / (1.0 - part * self.near);
        self.hypotheses.append(&mut self.waiting);
    }

    /// Gives every hypothesis whose course may end a course for each exit.
    pub(crate) fn branch(&mut self) {
        let Self { hypotheses, waiting, courses, roads, .. } = self;
        let mut index = 0;
        while index < hypotheses.len() {
            let hypothesis = &hypotheses[index];
            let exits = hypothesis.exits(roads);
            if exits.is_empty() || !hypothesis.nears_end() {
                index += 1;
                continue;
            }
            for &(exit, probability) in exits {
                let extended = courses.extended(roads, &hypothesis.course, exit, hypothesis.along_m);
                let Some((course, shorter_m)) = extended else { continue };
                let mut branch = hypothesis.clone();
                branch.course = course;
                branch.along_m -= shorter_m;
                branch.log_weight += libm::log(probability);
                waiting.push(branch);
            }
            // The branches are looked at again: an exit may be shorter than the reach ahead.
            hypotheses.swap_remove(index);
            hypotheses.append(waiting);
        }
    }

    /// Weighs and moves every hypothesis by what does not say whether the vehicle is on a road.
    pub(crate) fn weigh(&mut self, mut by: impl FnMut(&mut Hypothesis)) {
        let (mut before, mut after) = (0.0, 0.0);
        for hypothesis in &mut self.hypotheses {
            before += libm::exp(hypothesis.log_weight);
            by(hypothesis);
            after += libm::exp(hypothesis.log_weight);
        }
        self.log_off_map += libm::log(after.max(f64::MIN_POSITIVE) / before.max(f64::MIN_POSITIVE));
        self.normalise();
    }

    /// Makes the probabilities one together, heaviest first, and drops what is too light to matter.
    pub(crate) fn normalise(&mut self) {
        let weights = self.hypotheses.iter().map(|hypothesis| hypothesis.log_weight);
        let most = weights.clone().fold(self.log_off_map, f64::max);
        let least = most + libm::log(LEAST_WEIGHT);
        self.hypotheses.retain(|hypothesis| hypothesis.log_weight > least);
        self.hypotheses.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        self.hypotheses.truncate(MOST_KEPT);
        let weights = self.hypotheses.iter().map(|hypothesis| hypothesis.log_weight);
        let sum: f64 = weights.map(|weight| libm::exp(weight - most)).sum();
        let total = most + libm::log(sum + libm::exp(self.log_off_map - most));
        self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.log_weight -= total);
        self.log_off_map -= total;
    }
}
