//! What the motion would be on no road of the map: on a road that the map lacks, in a yard, or on another map.
//!
//! A hypothesis on the map says where the road goes; here it bends at random, as much as the map's roads do. Its density of the
//! vehicle's place beside such a road is what a road of the map has to beat to be believed: straight driving fits any straight road
//! and tells little, turns at the right places tell much. Three Kalman filters, on a straight road, on a winding one and in a corner,
//! are mixed as an interacting multiple model does (H. Blom and Y. Bar-Shalom, IEEE Transactions on Automatic Control 33, 1988). The
//! mixing leaves a stretch a little as wide as the corner that it might have come from: with a corner in a hundred metres this
//! hypothesis loses some 3 % of its weight on a straight metre, three times what is due for the corners that do not come.

use nalgebra::{Matrix2, Vector2};

use crate::hypothesis::{LINE_NOISE_M, log_normal};
use crate::odometry::Motion;
use crate::roads::Bends;
use crate::state::OffsetModel;

/// Length of a corner, metres: the arc of a right angle at the radius of 9 m with which a course's corners are rounded.
const CORNER_M: f64 = 14.0;
/// Turn of a corner, radians: a right angle.
const CORNER_RAD: f64 = std::f64::consts::FRAC_PI_2;
/// Standard deviation of the heading against the road where nothing is known yet, radians.
const HEADING_SIGMA: f64 = 0.1;

/// A road of either kind, and a corner.
const MODES: usize = 3;
const CORNER: usize = 2;

/// Place left of the road's line beyond the vehicle's offset (metres) and heading against it (radians).
#[derive(Debug, Clone, Copy, PartialEq)]
struct Beside {
    weight: f64,
    mean: Vector2<f64>,
    covariance: Matrix2<f64>,
}

/// A road that may bend anywhere.
#[derive(Debug, Clone)]
pub(crate) struct UnmappedRoad {
    bends: Bends,
    modes: [Beside; MODES],
}

impl UnmappedRoad {
    /// One of which nothing has been driven, like the roads of a map.
    pub(crate) fn like(bends: Bends) -> Self {
        let corner = (bends.corners_per_m * CORNER_M).min(0.5);
        let [one, other] = bends.kinds.map(|kind| kind.part * (1.0 - corner));
        Self { bends, modes: [one, other, corner].map(Beside::start) }
    }

    /// A part of the probability has just left a road of the map, in a corner.
    pub(crate) fn leave(&mut self, part: f64) {
        let part = part.clamp(0.0, 1.0);
        self.modes.iter_mut().for_each(|mode| mode.weight *= 1.0 - part);
        self.modes[CORNER] = mixed(&[self.modes[CORNER], Beside::start(part)]);
    }

    /// Moves by what was measured and holds to the road: gives the logarithm of the density of the place beside it, 1/m.
    pub(crate) fn go(&mut self, motion: &Motion, offset: &OffsetModel) -> f64 {
        let changes = self.changes(motion.driven_m);
        let before = self.modes;
        let [one, other] = self.bends.kinds.map(|kind| kind.rad2_per_m);
        let bending = [one, other, CORNER_RAD * CORNER_RAD / CORNER_M];
        let mut density = 0.0;
        for (to, (mode, rad2_per_m)) in self.modes.iter_mut().zip(bending).enumerate() {
            let mut parts = before;
            parts.iter_mut().zip(&changes).for_each(|(part, changes)| part.weight *= changes[to]);
            *mode = mixed(&parts);
            mode.go(motion, offset, rad2_per_m);
            mode.weight *= libm::exp(mode.hold());
            density += mode.weight;
        }
        let density = density.max(f64::MIN_POSITIVE);
        self.modes.iter_mut().for_each(|mode| mode.weight /= density);
        libm::log(density)
    }

    /// Probabilities of each mode's becoming each other one over a distance.
    fn changes(&self, driven_m: f64) -> [[f64; MODES]; MODES] {
        let enters = (self.bends.corners_per_m * driven_m).min(0.5);
        let leaves = (driven_m / CORNER_M).min(0.5);
        let another = (self.bends.ends_per_m * driven_m).min(1.0);
        let [one, other] = self.bends.kinds.map(|kind| kind.part);
        let from = |stays: [f64; 2]| {
            let onto = |stays: f64, part: f64| (1.0 - enters) * ((1.0 - another) * stays + another * part);
            [onto(stays[0], one), onto(stays[1], other), enters]
        };
        [from([1.0, 0.0]), from([0.0, 1.0]), [leaves * one, leaves * other, 1.0 - leaves]]
    }
}

impl Beside {
    fn start(weight: f64) -> Self {
        let covariance = Matrix2::from_diagonal(&Vector2::new(0.0, HEADING_SIGMA * HEADING_SIGMA));
        Self { weight, mean: Vector2::zeros(), covariance }
    }

    fn go(&mut self, motion: &Motion, offset: &OffsetModel, rad2_per_m: f64) {
        let (sine, cosine) = libm::sincos(self.mean[1]);
        let by_heading = motion.place_m.x * cosine - motion.place_m.y * sine;
        self.mean += Vector2::new(motion.place_m.x * sine + motion.place_m.y * cosine, motion.turn_rad);
        let moved = Matrix2::new(1.0, by_heading, 0.0, 1.0);
        let across = motion.covariance.fixed_view::<2, 2>(1, 1);
        // The road bends evenly over the step: half of it counts for the way.
        let bend = Vector2::new(-0.5 * motion.driven_m, -1.0);
        let kept = offset.kept(motion);
        self.covariance = moved * self.covariance * moved.transpose()
            + across
            + bend * bend.transpose() * (rad2_per_m * motion.driven_m);
        self.covariance[(0, 0)] += offset.sigma_m.powi(2) * (1.0 - kept * kept);
    }

    /// Takes in that the vehicle is on the road: gives the logarithm of the density, 1/m.
    fn hold(&mut self) -> f64 {
        let crossed = self.covariance.column(0).into_owned();
        let expected = crossed[0] + LINE_NOISE_M * LINE_NOISE_M;
        let innovation = -self.mean[0];
        self.mean += crossed * (innovation / expected);
        self.covariance -= crossed * crossed.transpose() / expected;
        log_normal(innovation * innovation, expected)
    }
}

/// Some as one Gaussian.
fn mixed(parts: &[Beside]) -> Beside {
    let weight = parts.iter().map(|part| part.weight).sum::<f64>();
    let share = |part: &Beside| part.weight / weight.max(f64::MIN_POSITIVE);
    let mean: Vector2<f64> = parts.iter().map(|part| part.mean * share(part)).sum();
    let covariance = parts.iter().map(|part| {
        let off = part.mean - mean;
        (part.covariance + off * off.transpose()) * share(part)
    });
    Beside { weight, mean, covariance: covariance.sum() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::roads::Kind;

    const OFFSET_MODEL: OffsetModel = OffsetModel { sigma_m: 2.0, distance_m: 100.0, turn_rad: 1.57 };

    fn bends(corners_per_m: f64) -> Bends {
        let kind = |part: f64, rad2_per_m: f64| Kind { part, rad2_per_m };
        Bends { corners_per_m, ends_per_m: 0.01, kinds: [kind(0.7, 5e-5), kind(0.3, 1e-3)] }
    }

    /// Logarithm of the density of a drive of looks of 2.5 m at these yaw rates, radians a second.
    fn density(road: &mut UnmappedRoad, yaw_rates_rps: impl IntoIterator<Item = f64>) -> f64 {
        let look = |yaw_rate_rps: f64| {
            let mut motion = Motion::default();
            motion.go_on(10.0, yaw_rate_rps, 0.25);
            road.go(&motion, &OFFSET_MODEL)
        };
        yaw_rates_rps.into_iter().map(look).sum()
    }

    /// Straight on, a right angle to the left on an arc of 10 m, and straight on.
    fn turn() -> impl Iterator<Item = f64> {
        let straight = || std::iter::repeat_n(0.0, 12);
        straight().chain(std::iter::repeat_n(std::f64::consts::FRAC_PI_2 / 1.5, 6)).chain(straight())
    }

    #[test]
    fn a_corner_is_as_surprising_as_it_is_rare() {
        let [often, rarely] =
            [0.01, 0.001].map(|per_m| density(&mut UnmappedRoad::like(bends(per_m)), turn()));
        let rarer = libm::log(10.0_f64);
        assert!((often - rarely - rarer).abs() < 0.5, "{often} {rarely}");
    }

    #[test]
    fn corners_that_do_not_come_are_missed() {
        let straight = || std::iter::repeat_n(0.0, 80);
        let [often, never] =
            [0.01, 0.0].map(|per_m| density(&mut UnmappedRoad::like(bends(per_m)), straight()));
        // Two corners are expected in the 200 m: their absence alone has the logarithm -2.
        assert!(never - often > 2.0, "{often} {never}");
    }

    #[test]
    fn what_leaves_a_road_on_a_straight_has_to_explain_why_it_does_not_turn() {
        let mut stays = UnmappedRoad::like(bends(0.01));
        density(&mut stays, std::iter::repeat_n(0.0, 40));
        let mut leaves = stays.clone();
        leaves.leave(1.0);
        let straight = || std::iter::repeat_n(0.0, 8);
        let [stays, leaves] = [&mut stays, &mut leaves].map(|road| density(road, straight()));
        assert!(stays - leaves > 1.0, "{stays} {leaves}");
    }
}
