//! What the belief says of the vehicle's place, and what it promises.

use nalgebra::{Matrix2, Point2};

use crate::belief::{Belief, OFFSET_MODEL};
use crate::hypothesis::Hypothesis;
use crate::level::{Part, protection_level_m};
use crate::merging::mixed;
use crate::state::{HEADING, State};

/// Probability with which the vehicle may be outside its protection level.
pub const RISK: f64 = 1e-3;
/// Greatest protection level with which a fix counts as converged, metres: half the distance between parallel streets of a town.
pub const ALERT_LIMIT_M: f64 = 25.0;
/// Hypotheses no farther apart than this are one place, metres, with headings no farther apart than half a right angle.
const ONE_PLACE_M: f64 = 15.0;
const ONE_HEADING_RAD: f64 = std::f64::consts::FRAC_PI_4;
/// Parts of the mixture that the protection level looks at; all others count as outside.
const MOST_PARTS: usize = 64;

/// How much a fix is worth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Status {
    /// One place has all but the risk, and its protection level is within the alert limit.
    Converged,
    /// Several places are possible.
    Ambiguous,
    /// It was converged and the place is still more probable than all else together, but not to within the risk.
    Coasting,
    /// Most probably on no road of the map.
    Lost,
}

/// The places that are none of the heaviest one's hypotheses, but for the farthest of them that have no more than [`RISK`] together, as a
/// protection level leaves them out: a road kilometres away with a part in a million would be most of every variance.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Elsewhere {
    /// Their probability.
    mass: f64,
    /// Their mean square about the place, times their probability, square metres.
    squares_m2: Matrix2<f64>,
}

impl Elsewhere {
    /// The mean square about a place of what is believed, where the place's own part of it has a probability `mass` and a covariance.
    pub(crate) fn with(&self, mass: f64, covariance_m2: Matrix2<f64>) -> Matrix2<f64> {
        (covariance_m2 * mass + self.squares_m2) / (mass + self.mass).max(f64::MIN_POSITIVE)
    }
}

/// The belief in a few numbers.
#[derive(Debug, Clone)]
pub(crate) struct Estimate {
    pub(crate) state: State,
    pub(crate) mass: f64,
    pub(crate) rivals: Elsewhere,
    pub(crate) level_m: Option<f64>,
    pub(crate) status: Status,
}

impl Belief {
    /// The heaviest place; none before there are hypotheses.
    /// `before` is the status of the estimate before.
    pub(crate) fn estimate(&mut self, before: Status) -> Option<Estimate> {
        let mut farthest = std::mem::take(&mut self.farthest);
        let estimate = self.estimate_in(before, &mut farthest);
        self.farthest = farthest;
        estimate
    }

    fn estimate_in(&self, before: Status, farthest: &mut Vec<(f64, usize)>) -> Option<Estimate> {
        let best = self.heaviest_place()?;
        let mut state = best.state;
        let mut mass = 0.0;
        for hypothesis in self.hypotheses.iter().filter(|hypothesis| is_one_place(hypothesis, best)) {
            let weight = libm::exp(hypothesis.log_weight);
            mass += weight;
            state = mixed(&state, &hypothesis.state, weight / mass);
        }
        let level_m = self.level_m(&state);
        let rivals = self.elsewhere(best, state.place(), farthest);
        let off_map = self.off_map();
        let was_converged = matches!(before, Status::Converged | Status::Coasting);
        // What has surprised once can only be mended by roads whose errors are independent of those of the roads before.
        let is_in_doubt = self.agreed_m < OFFSET_MODEL.distance_m;
        let status = match level_m {
            Some(level_m) if level_m <= ALERT_LIMIT_M && !is_in_doubt => Status::Converged,
            _ if off_map > 0.5 => Status::Lost,
            _ if mass > 0.5 && was_converged => Status::Coasting,
            _ => Status::Ambiguous,
        };
        Some(Estimate { state, mass, rivals, level_m, status })
    }

    fn heaviest_place(&self) -> Option<&Hypothesis> {
        // The place of most mass is about one of the heaviest hypotheses unless all are light, when nothing is known.
        let mass = |centre: &Hypothesis| {
            let near = self.hypotheses.iter().filter(|other| is_one_place(other, centre));
            near.map(|hypothesis| libm::exp(hypothesis.log_weight)).sum::<f64>()
        };
        let first: &Hypothesis = self.hypotheses.first()?;
        if libm::exp(first.log_weight) < 1e-2 {
            return Some(first);
        }
        let heaviest = self.hypotheses.iter().take(8).map(|centre| (mass(centre), centre.as_ref()));
        heaviest
            .reduce(|best, next| if next.0 > best.0 + 1e-9 { next } else { best })
            .map(|(_, centre)| centre)
    }

    /// What is not the place of `best`, about `place`.
    fn elsewhere(
        &self,
        best: &Hypothesis,
        place: Point2<f64>,
        farthest: &mut Vec<(f64, usize)>,
    ) -> Elsewhere {
        farthest.clear();
        let others = self.hypotheses.iter().enumerate().filter(|(_, other)| !is_one_place(other, best));
        farthest.extend(others.map(|(number, other)| ((other.state.place() - place).norm_squared(), number)));
        farthest.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let (mut left_out, mut elsewhere) = (0.0, Elsewhere::default());
        for &(_, number) in &*farthest {
            let other = &self.hypotheses[number];
            let weight = libm::exp(other.log_weight);
            left_out += weight;
            if left_out > RISK {
                let off = other.state.place() - place;
                elsewhere.mass += weight;
                elsewhere.squares_m2 += (other.state.place_covariance() + off * off.transpose()) * weight;
            }
        }
        elsewhere
    }

    fn level_m(&self, state: &State) -> Option<f64> {
        let parts: Vec<Part> = self
            .hypotheses
            .iter()
            .take(MOST_PARTS)
            .filter(|hypothesis| is_one_heading(&hypothesis.state, state))
            .map(|hypothesis| Part {
                mass: libm::exp(hypothesis.log_weight),
                off_m: hypothesis.state.place() - state.place(),
                covariance: hypothesis.state.place_covariance(),
            })
            .collect();
        let seen: f64 = parts.iter().map(|part| part.mass).sum();
        protection_level_m(&parts, 1.0 - seen, RISK)
    }
}

fn is_one_place(one: &Hypothesis, other: &Hypothesis) -> bool {
    is_near(one.state.place(), other.state.place()) && is_one_heading(&one.state, &other.state)
}

fn is_near(one_m: Point2<f64>, other_m: Point2<f64>) -> bool {
    (one_m - other_m).norm() <= ONE_PLACE_M
}

fn is_one_heading(one: &State, other: &State) -> bool {
    are_alike(one.mean[HEADING], other.mean[HEADING])
}

fn are_alike(one_rad: f64, other_rad: f64) -> bool {
    fingerpost_geometry::wrap_angle(one_rad - other_rad).abs() < ONE_HEADING_RAD
}

/// Where the vehicle is.
#[derive(Debug, Clone, PartialEq)]
pub struct Fix {
    /// Time, seconds.
    pub t_s: f64,
    /// Distance driven so far by the measured speeds, metres.
    pub driven_m: f64,
    /// Place, metres in the plane of the map's graph.
    pub place_m: Point2<f64>,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Mean square of the vehicle's distance from the place, square metres: the covariance of all places that are possible, but for the
    /// farthest that have no more than [`RISK`] together.
    pub covariance_m2: Matrix2<f64>,
    /// What the true speed is greater than the measured one by, as a part of it, with its standard deviation.
    pub speed_scale: [f64; 2],
    /// The vehicle is within this of the place but for [`RISK`], metres; none where that cannot be said.
    pub level_m: Option<f64>,
    /// What it is worth.
    pub status: Status,
    /// Probability of this place.
    pub mass: f64,
    /// Probability of being on no road of the map.
    pub off_map: f64,
    /// Places with their probabilities, the heaviest first.
    pub rivals: Vec<Rival>,
    /// How many hypotheses there are.
    pub hypotheses: usize,
}

/// A place where the vehicle may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rival {
    /// Place, metres in the plane of the map's graph.
    pub place_m: Point2<f64>,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Its probability.
    pub weight: f64,
}

impl Rival {
    /// Whether another is the same place as this one: no farther away than two hypotheses of one place, and headed alike.
    pub fn is_one_place(&self, other: &Self) -> bool {
        is_near(self.place_m, other.place_m) && are_alike(self.heading_rad, other.heading_rad)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rivals_widen_a_fix_by_how_far_and_how_probable_they_are() {
        let own = Matrix2::identity();
        let alone = Elsewhere::default().with(0.7, own);
        assert!((alone - own).norm() < 1e-12);
        // Half as probable 100 m east: a third of 100 m squared.
        let rival = Elsewhere { mass: 0.2, squares_m2: Matrix2::new(1e4 + 1.0, 0.0, 0.0, 1.0) * 0.2 };
        let both = rival.with(0.4, own);
        assert!((both[(0, 0)] - (1.0 + 1e4 / 3.0)).abs() < 1e-6 && (both[(1, 1)] - 1.0).abs() < 1e-9);
    }
}
