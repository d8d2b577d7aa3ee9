//! Hypotheses that say the same become one.

use std::sync::Arc;

use crate::hypothesis::Hypothesis;
use crate::state::{HEADING, OFFSET, State};

/// Hypotheses whose means are less than this many standard deviations apart are the same.
const SAME_SIGMAS: f64 = 0.7;

/// Nor is one that is wider by more than this, in variance: its tails are what protection levels are made of.
const MOST_WIDER: f64 = 2.0;

/// Merges neighbours on the same course; the rest keep their order, heaviest first.
#[allow(clippy::vec_box, reason = "as the belief keeps them")]
pub(crate) fn merge_alike(hypotheses: &mut Vec<Box<Hypothesis>>) {
    let course = |hypothesis: &Hypothesis| Arc::as_ptr(&hypothesis.course) as usize;
    // By course as edges, not by address: the order must be the same every time.
    hypotheses.sort_by(|a, b| {
        a.course
            .edges
            .cmp(&b.course.edges)
            .then(a.along_m.total_cmp(&b.along_m))
            .then(b.log_weight.total_cmp(&a.log_weight))
    });
    hypotheses.dedup_by(|next, kept| {
        let same = course(next) == course(kept)
            && next.placed_by == kept.placed_by
            && are_alike(&next.state, &kept.state);
        if same {
            merge(kept, next);
        }
        same
    });
    hypotheses.sort_by(|a, b| b.log_weight.total_cmp(&a.log_weight));
}

fn are_alike(one: &State, other: &State) -> bool {
    let widths =
        [one, other].map(|state| [state.place_covariance().trace(), state.covariance[(OFFSET, OFFSET)]]);
    let is_as_wide = |[one, other]: [f64; 2]| one <= MOST_WIDER * other && other <= MOST_WIDER * one;
    if !(0..2).all(|number| is_as_wide([widths[0][number], widths[1][number]])) {
        return false;
    }
    let apart = one.mean - other.mean;
    // Along every axis of its own: cheaper than the joint distance, and no looser where the states are alike in shape.
    (0..apart.len()).all(|number| {
        let variance = one.covariance[(number, number)].min(other.covariance[(number, number)]);
        apart[number].powi(2) <= SAME_SIGMAS.powi(2) * variance
    })
}

/// Mean and covariance of two together.
fn merge(kept: &mut Hypothesis, next: &Hypothesis) {
    let most = kept.log_weight.max(next.log_weight);
    let [one, other] = [kept.log_weight, next.log_weight].map(|weight| libm::exp(weight - most));
    let share = other / (one + other);
    kept.along_m += (next.along_m - kept.along_m) * share;
    kept.state = mixed(&kept.state, &next.state, share);
    kept.log_weight = most + libm::log(one + other);
}

/// Mean and covariance of a mixture of which `other` has a share.
pub(crate) fn mixed(one: &State, other: &State, share: f64) -> State {
    let mut apart = other.mean - one.mean;
    apart[HEADING] = fingerpost_geometry::wrap_angle(apart[HEADING]);
    State {
        mean: one.mean + apart * share,
        covariance: one.covariance * (1.0 - share)
            + other.covariance * share
            + apart * apart.transpose() * (share * (1.0 - share)),
    }
}
