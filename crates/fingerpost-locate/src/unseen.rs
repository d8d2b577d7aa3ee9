//! Driving of which nothing was measured: the motion log has a gap.

use crate::belief::{Belief, OFF_MAP_AT_START};
use crate::hypothesis::{BRANCH_AHEAD_M, Hypothesis};
use crate::merging::merge_alike;
use crate::seeding::{JUNCTION_HEADING_SIGMA, start};

/// Standard deviation of the distance driven, as a part of what the speeds before and after the gap say: that of anything from
/// standing to twice as much.
const DISTANCE_SIGMA: f64 = 0.58;
/// Beyond this the vehicle may be anywhere, metres: some junctions, of which each doubles the possibilities.
const FARTHEST_M: f64 = 500.0;

impl Belief {
    /// Every hypothesis goes on along its course, by every exit; with the probability of the start the vehicle is elsewhere by then.
    pub(crate) fn go_unseen(&mut self, driven_m: f64) {
        self.agreed_m = 0.0;
        if driven_m > FARTHEST_M {
            return self.begin_anywhere();
        }
        let mut left_m = driven_m;
        while left_m > 0.0 {
            // No farther than a course reaches before it branches.
            let step_m = left_m.min(BRANCH_AHEAD_M);
            left_m -= step_m;
            for hypothesis in &mut self.hypotheses {
                hypothesis.along_m = (hypothesis.along_m + step_m).min(hypothesis.course.length_m);
            }
            self.branch();
            self.normalise();
            merge_alike(&mut self.hypotheses);
        }
        for hypothesis in &mut self.hypotheses {
            hypothesis.follow_course(DISTANCE_SIGMA * driven_m);
        }
        self.be_elsewhere(OFF_MAP_AT_START);
        self.normalise();
    }
}

impl Hypothesis {
    /// The vehicle is where its course is, as sure along it as before and by this much less, metres. Errors of speed and yaw rate
    /// are what they were.
    fn follow_course(&mut self, more_sigma_m: f64) {
        let Some(sample) = self.course.between(self.along_m, self.along_m).1.first() else { return };
        let along_sigma_m = libm::hypot(self.state.sigma_along_m(self.ahead()), more_sigma_m);
        let before = self.state;
        self.state = start(sample, along_sigma_m, JUNCTION_HEADING_SIGMA);
        self.state.keep_instruments(&before);
    }
}
