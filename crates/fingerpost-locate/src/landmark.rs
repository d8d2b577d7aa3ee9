//! Landmarks: places of the map that the vehicle sees, such as a junction ahead.
//!
//! All sightings of one landmark share their errors: the map has it in a wrong place once, and who follows it adds up what it has seen
//! itself. So a landmark moves a hypothesis once; seen again, it only says how well it fits. While it is in sight the belief is kept as
//! it is without it, and each fix is that belief conditioned afresh on the newest sighting (as a channel filter keeps apart what two
//! estimators have in common: S. Grime and H. Durrant-Whyte, "Data fusion in decentralized sensor networks", Control Engineering
//! Practice 1994). When it is out of sight the conditioning stays.
//!
//! A sighting may be of something else. Every hypothesis then becomes two: the landmark is there and says where the vehicle is, or it
//! says nothing.

use std::f64::consts::FRAC_PI_2;

use fingerpost_geometry::wrap_angle;
use nalgebra::{Isometry2, Matrix3, SMatrix, Vector2, Vector3};

use crate::belief::{Belief, OFFSET_MODEL};
use crate::fix::{Estimate, Status};
use crate::hypothesis::Hypothesis;
use crate::odometry::Motion;
use crate::state::{EAST, HEADING, NUMBERS, State};

/// Standard deviation of a landmark's place against the vehicle beside what the one who sees it knows of, metres along every axis: on two
/// recorded streets whose calibration is a degree or 5 cm off, junctions were found 1.9 and 0.7 m from their node, which is 1.2
/// standard deviations of such an error.
const PLACE_SIGMA_M: f64 = 1.6;
/// The same of the direction of its approach, radians: the map's line is straight where the road is not, by a metre in 10 m.
const DIRECTION_SIGMA_RAD: f64 = 0.1;
/// Density of what is taken for a landmark and is none, 1/(m² rad): anywhere in the view, 20 m long and 10 m wide, and within a
/// quarter of a radian to either side.
const CLUTTER: f64 = 0.01;
/// Distance driven without seeing it behind which a landmark is out of sight, metres: that of two looks at the road.
const OUT_OF_SIGHT_M: f64 = 5.0;
/// What is farther off than this cannot be the same, standard deviations.
const REACH_SIGMAS: f64 = 8.0;
/// Hypotheses that a fix resolves, the heaviest; all lighter ones count as being elsewhere.
const MOST_RESOLVED: usize = 64;
/// Weights below this part of all are not followed up.
const LEAST_SHARE: f64 = 1e-9;

/// A landmark in sight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sighting {
    /// Which one, by a number of whoever sees it.
    pub landmark: usize,
    /// Its pose on the map: metres in the plane of the graph, x along its approach.
    pub map_from_landmark: Isometry2<f64>,
    /// Its pose in the vehicle frame.
    pub vehicle_from_landmark: Isometry2<f64>,
    /// Covariance of its forward (m), left (m) and heading (rad) as whoever sees it knows it.
    pub covariance: Matrix3<f64>,
    /// Probability that it is what it is taken for.
    pub present: f64,
}

/// What was made of a sighting.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SightingEvidence {
    /// Which landmark.
    pub landmark: usize,
    /// Where it puts the vehicle against what is believed without it, of the possibilities near by; none where there are none, and for one
    /// that does not count again.
    pub innovation: Option<PoseInnovation>,
    /// Probability that it is what it is taken for, now that it is known where the vehicle may be; 0 where no possibility is near.
    pub present: f64,
    /// Whether it counts.
    pub verdict: Verdict,
}

/// Where a landmark puts the vehicle against where it was expected without it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseInnovation {
    /// How far forward and left of that, metres, and turned to the left, radians.
    pub off: [f64; 3],
    /// Standard deviations of the three.
    pub sigma: [f64; 3],
}

/// Whether a sighting counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Verdict {
    /// It does.
    Accepted,
    /// It is more probably something else: it was hardly thought to be there.
    Unlikely,
    /// It is more probably something else: no possible place of the vehicle agrees with it.
    Disagrees,
    /// It has been in sight before and counts once.
    Counted,
}

/// The vehicle's pose by a landmark, moved on with the vehicle since it was seen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Seen {
    landmark: usize,
    /// Of which place and heading alone are known; the rest is as unknown as at the start.
    state: State,
    present: f64,
    /// Distance driven since, metres.
    unseen_m: f64,
}

/// What landmarks say.
#[derive(Debug, Clone, Default)]
pub(crate) struct Landmarks {
    pub(crate) in_sight: Option<Seen>,
}

impl Sighting {
    /// Whether all its numbers are some.
    pub(crate) fn is_sound(&self) -> bool {
        let poses = [&self.map_from_landmark, &self.vehicle_from_landmark];
        let finite = |pose: &Isometry2<f64>| {
            pose.translation.vector.iter().all(|number| number.is_finite())
                && pose.rotation.angle().is_finite()
        };
        poses.into_iter().all(finite)
            && self.covariance.iter().all(|number| number.is_finite())
            && self.present.is_finite()
    }

    /// East, north and heading of the vehicle that sees it.
    fn pose(&self) -> Vector3<f64> {
        let map_from_vehicle = self.map_from_landmark * self.vehicle_from_landmark.inverse();
        let place = map_from_vehicle.translation.vector;
        Vector3::new(place.x, place.y, map_from_vehicle.rotation.angle())
    }

    /// Derivative of [`Sighting::pose`] by the landmark's forward, left and heading in the vehicle frame.
    fn pose_by_sighting(&self) -> Matrix3<f64> {
        let heading = (self.map_from_landmark.rotation / self.vehicle_from_landmark.rotation).angle();
        let (sine, cosine) = libm::sincos(heading);
        let off = self.map_from_landmark.translation.vector - self.pose().xy();
        Matrix3::new(-cosine, sine, -off.y, -sine, -cosine, off.x, 0.0, 0.0, -1.0)
    }

    fn seen(&self) -> Seen {
        let own = self.covariance
            + Matrix3::from_diagonal(&Vector3::new(
                PLACE_SIGMA_M.powi(2),
                PLACE_SIGMA_M.powi(2),
                DIRECTION_SIGMA_RAD.powi(2),
            ));
        let by_sighting = self.pose_by_sighting();
        let state = State::of_pose(self.pose(), by_sighting * own * by_sighting.transpose());
        let present = self.present.clamp(0.0, 1.0);
        Seen { landmark: self.landmark, state, present, unseen_m: 0.0 }
    }
}

impl Landmarks {
    /// Moves on with the vehicle; gives the landmark that is now out of sight.
    pub(crate) fn go(&mut self, motion: &Motion) -> Option<Seen> {
        let seen = self.in_sight.as_mut()?;
        seen.state.go(motion, &OFFSET_MODEL);
        seen.unseen_m += motion.driven_m;
        if seen.unseen_m <= OUT_OF_SIGHT_M {
            return None;
        }
        self.in_sight.take()
    }

    /// Takes in a sound sighting; gives the landmark that is out of sight because of it.
    pub(crate) fn see(&mut self, sighting: &Sighting) -> Option<Seen> {
        let before = self.in_sight.replace(sighting.seen());
        before.filter(|before| before.landmark != sighting.landmark)
    }
}

impl Seen {
    /// Where a state's pose and covariance are against what is seen: innovation, its precision, and the logarithm of its density.
    fn against(&self, state: &State) -> Option<Innovation> {
        let apart = self.state.place() - state.place();
        let wide = self.state.place_covariance().trace() + state.place_covariance().trace();
        if apart.norm_squared() > REACH_SIGMAS * REACH_SIGMAS * wide {
            return None;
        }
        let turn = wrap_angle(self.state.mean[HEADING] - state.mean[HEADING]);
        let off = Vector3::new(apart.x, apart.y, turn);
        let expected = pose_covariance(&self.state) + pose_covariance(state);
        let precision = expected.try_inverse()?;
        let squared = off.dot(&(precision * off));
        let log_density =
            -0.5 * (squared + libm::log(expected.determinant()) + 3.0 * libm::log(std::f64::consts::TAU));
        log_density.is_finite().then_some(Innovation { off, expected, precision, log_density })
    }

    /// A hypothesis as it is where the landmark is what it is taken for; none where it cannot be.
    fn condition(&self, hypothesis: &Hypothesis) -> Option<Hypothesis> {
        let innovation = self.against(&hypothesis.state)?;
        let log_weight = hypothesis.log_weight + libm::log(self.present) + innovation.log_density;
        if log_weight < libm::log(LEAST_SHARE) + self.log_elsewhere() {
            return None;
        }
        let mut seeing = hypothesis.clone();
        seeing.log_weight = log_weight;
        if seeing.placed_by != Some(self.landmark) {
            seeing.placed_by = Some(self.landmark);
            seeing.state.take_pose(&innovation);
            seeing.along_m += (seeing.state.place() - hypothesis.state.place()).dot(&hypothesis.ahead());
        }
        Some(seeing)
    }

    /// Logarithm of the likelihood of the sighting where it is something else.
    fn log_elsewhere(&self) -> f64 {
        libm::log((1.0 - self.present).max(LEAST_SHARE) * CLUTTER)
    }
}

fn pose_covariance(state: &State) -> Matrix3<f64> {
    state.covariance.fixed_view::<3, 3>(EAST, EAST).into_owned()
}

/// What was seen beyond what was expected.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Innovation {
    /// East, north and heading.
    off: Vector3<f64>,
    expected: Matrix3<f64>,
    precision: Matrix3<f64>,
    log_density: f64,
}

impl State {
    /// Takes in a measured place and heading.
    fn take_pose(&mut self, innovation: &Innovation) {
        let crossed: SMatrix<f64, NUMBERS, 3> =
            self.covariance.fixed_view::<NUMBERS, 3>(0, EAST).into_owned();
        let gain = crossed * innovation.precision;
        self.mean += gain * innovation.off;
        let covariance = self.covariance - gain * crossed.transpose();
        self.covariance = (covariance + covariance.transpose()) * 0.5;
    }
}

/// A belief that is conditioned on a landmark.
struct Conditioned {
    /// What each hypothesis becomes where it is what it is taken for.
    #[allow(clippy::vec_box, reason = "as the belief keeps them")]
    seeing: Vec<Box<Hypothesis>>,
    /// Logarithm of the weight of all together.
    log_total: f64,
    /// Probability that it is what it is taken for.
    present: f64,
    /// That part of it in which it was seen before.
    again: f64,
}

/// What was expected of a landmark by several hypotheses together.
#[derive(Debug, Clone, Copy, Default)]
struct Expected {
    weight: f64,
    off: Vector3<f64>,
    squares: Matrix3<f64>,
    ahead: Vector2<f64>,
}

impl Expected {
    fn add(&mut self, hypothesis: &Hypothesis, innovation: &Innovation) {
        let (weight, off) = (libm::exp(hypothesis.log_weight), innovation.off);
        self.weight += weight;
        self.off += off * weight;
        self.squares += (innovation.expected + off * off.transpose()) * weight;
        self.ahead += hypothesis.ahead() * weight;
    }

    /// In a vehicle that heads as they do; none where there were none.
    fn innovation(&self) -> Option<PoseInnovation> {
        let ahead = self.ahead.try_normalize(1e-12)?;
        let off = self.off / self.weight;
        let covariance = self.squares / self.weight - off * off.transpose();
        let place = covariance.fixed_view::<2, 2>(0, 0);
        let axes = [ahead, Vector2::new(-ahead.y, ahead.x)];
        let [forward, left] = axes.map(|axis| off.xy().dot(&axis));
        let [forward_sigma, left_sigma] = axes.map(|axis| axis.dot(&(place * axis)).max(0.0).sqrt());
        let turn_sigma = covariance[(2, 2)].max(0.0).sqrt();
        Some(PoseInnovation { off: [forward, left, off.z], sigma: [forward_sigma, left_sigma, turn_sigma] })
    }
}

impl Belief {
    fn seeing(&self, seen: &Seen) -> Conditioned {
        let (mut there, mut again) = (0.0, 0.0);
        let mut seeing = Vec::new();
        for hypothesis in &self.hypotheses {
            let Some(conditioned) = seen.condition(hypothesis) else { continue };
            let weight = libm::exp(conditioned.log_weight);
            there += weight;
            if hypothesis.placed_by == Some(seen.landmark) {
                again += weight;
            }
            seeing.push(Box::new(conditioned));
        }
        let total = there + libm::exp(seen.log_elsewhere());
        Conditioned { seeing, log_total: libm::log(total), present: there / total, again: again / total }
    }

    /// The estimate of what is believed once a landmark in sight is taken in.
    pub(crate) fn estimate_seeing(&mut self, seen: &Seen, before: Status) -> Option<Estimate> {
        let Conditioned { mut seeing, log_total, .. } = self.seeing(seen);
        let log_elsewhere = seen.log_elsewhere() - log_total;
        seeing.iter_mut().for_each(|hypothesis| hypothesis.log_weight -= log_total);
        seeing.extend(self.hypotheses.iter().take(MOST_RESOLVED).map(|hypothesis| {
            let mut unseeing = hypothesis.clone();
            unseeing.log_weight += log_elsewhere;
            unseeing
        }));
        seeing.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
        let log_off_map = self.log_off_map;
        let without = std::mem::replace(&mut self.hypotheses, seeing);
        self.log_off_map = log_off_map + log_elsewhere;
        let estimate = self.estimate(before);
        self.hypotheses = without;
        self.log_off_map = log_off_map;
        estimate
    }

    /// Takes in a landmark that is out of sight.
    pub(crate) fn take_seen(&mut self, seen: &Seen) {
        let Conditioned { mut seeing, log_total, .. } = self.seeing(seen);
        let log_elsewhere = seen.log_elsewhere() - log_total;
        seeing.iter_mut().for_each(|hypothesis| hypothesis.log_weight -= log_total);
        self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.log_weight += log_elsewhere);
        self.log_off_map += log_elsewhere;
        self.hypotheses.append(&mut seeing);
        self.normalise();
    }

    /// What is made of a landmark in sight.
    pub(crate) fn evidence(&self, seen: &Seen) -> SightingEvidence {
        let Conditioned { present, again, .. } = self.seeing(seen);
        let mut expected = Expected::default();
        for hypothesis in &self.hypotheses {
            // Those that go the other way expect nothing of it.
            let innovation = seen.against(&hypothesis.state);
            let innovation = innovation.filter(|innovation| innovation.off.z.abs() < FRAC_PI_2);
            innovation.iter().for_each(|innovation| expected.add(hypothesis, innovation));
        }
        let verdict = match () {
            () if present > 0.5 && again > 0.5 * present => Verdict::Counted,
            () if present > 0.5 => Verdict::Accepted,
            () if seen.present <= 0.5 => Verdict::Unlikely,
            () => Verdict::Disagrees,
        };
        let innovation = expected.innovation().filter(|_| verdict != Verdict::Counted);
        SightingEvidence { landmark: seen.landmark, innovation, present, verdict }
    }
}

#[cfg(test)]
mod tests;
