//! The road in cross-section: from the vehicle's way outwards the ground goes on level, or rises by a kerb's height.
//!
//! What a window shows of its height is weak, ambiguous or nothing, and a road falls to its sides by as much as a kerb is high. But
//! roads have no steps, and kerbs are steps: so the heights along a row of the view are a hidden Markov chain whose states are the
//! height and whether a kerb has been climbed since the vehicle's way, and the forward-backward algorithm (L. Rabiner, "A tutorial
//! on hidden Markov models", 1989, III-A) gives the probability of that for each place. What lies behind a kerb has been climbed to even
//! where it shows nothing itself.

use super::MOST_LOG_ODDS;
use super::height_map::{HEIGHTS, Heights, height_m, likelihoods};

/// Heights of kerbs, in steps: 5 to 17.5 cm.
const RISES: std::ops::RangeInclusive<usize> = 2..=7;
/// Kerbs up and down in a metre across: a country road has none, and a street one on either side.
const UP_A_METRE: f32 = 0.01;
const DOWN_A_METRE: f32 = 0.01;
/// Probability that a metre of ground gets a step of height higher, and as much lower: roads fall by 1 to 3 % to either side.
const DRIFT_A_METRE: f32 = 0.2;
/// Share of that within the vehicle's way, where the road's plane is fitted: kerbs are not driven over.
const WAY_SHARE: f32 = 0.02;
/// Probability that the ground ahead of the vehicle is beyond a kerb.
const STARTS_RAISED: f32 = 0.001;
/// Standard deviation of the ground ahead against the plane fitted to it, metres.
const START_SIGMA_M: f64 = 0.06;
/// No place makes a height less likely than this against the likeliest: some of what is seen does not lie still.
const LEAST_LIKELIHOOD: f32 = 1e-4;

/// What is believed of a place: level heights, then raised ones.
type Belief = [[f32; HEIGHTS]; 2];

/// The chain, with its memory.
#[derive(Debug)]
pub(super) struct CrossSection {
    likelihoods: [f32; 256],
    start: Belief,
    forward: Vec<Belief>,
    seen: Vec<[f32; HEIGHTS]>,
}

impl Default for CrossSection {
    fn default() -> Self {
        let of_start = |height_m: f64| (-0.5 * (height_m / START_SIGMA_M).powi(2)).exp() as f32;
        let level: [f32; HEIGHTS] = std::array::from_fn(|index| of_start(height_m(index)));
        let mut start = [level, [0.0; HEIGHTS]];
        risen(&level, &mut start[1]);
        for (belief, share) in start.iter_mut().zip([1.0 - STARTS_RAISED, STARTS_RAISED]) {
            scale(belief, share);
        }
        Self { likelihoods: likelihoods(), start, forward: Vec::new(), seen: Vec::new() }
    }
}

impl CrossSection {
    /// Log-odds that each place has been climbed to since the first, against what would be thought without looking; places lie
    /// `step_m` apart, and so many of them `in_way` of the vehicle.
    pub(super) fn log_odds(
        &mut self,
        places: impl Iterator<Item = Heights>,
        (step_m, in_way): (f64, usize),
        log_odds: &mut Vec<f32>,
    ) {
        let step_to = |place: usize| Step::over(step_m as f32, if place < in_way { WAY_SHARE } else { 1.0 });
        let Self { likelihoods, start, forward, seen } = self;
        seen.clear();
        seen.extend(places.map(|heights| {
            let most = heights.into_iter().max().unwrap_or(0);
            heights.map(|height| likelihoods[usize::from(most - height)].max(LEAST_LIKELIHOOD))
        }));
        log_odds.clear();
        log_odds.resize(seen.len(), 0.0);
        forward.clear();
        forward.reserve(seen.len());
        if seen.iter().flatten().all(|&likelihood| likelihood >= 1.0) {
            return;
        }
        let mut belief = *start;
        for (place, seen) in seen.iter().enumerate() {
            if place > 0 {
                belief = step_to(place).onwards(&belief);
            }
            weigh(&mut belief, seen);
            forward.push(belief);
        }
        let mut backward = [[1.0; HEIGHTS]; 2];
        for place in (0..seen.len()).rev() {
            let [level, raised] = [0, 1].map(|kind| {
                forward[place][kind].iter().zip(&backward[kind]).map(|(a, b)| a * b).sum::<f32>()
            });
            log_odds[place] = (raised.max(f32::MIN_POSITIVE) / level.max(f32::MIN_POSITIVE)).ln();
            weigh(&mut backward, &seen[place]);
            backward = step_to(place).backwards(&backward);
        }
        let mut raised = STARTS_RAISED;
        for (place, log_odds) in log_odds.iter_mut().enumerate() {
            *log_odds = (*log_odds - (raised / (1.0 - raised)).ln()).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
            let step = step_to(place + 1);
            raised = raised * (1.0 - step.down) + (1.0 - raised) * step.up;
        }
    }
}

/// The chain's step from a place to the next one outwards.
#[derive(Debug, Clone, Copy)]
struct Step {
    up: f32,
    down: f32,
    drift: f32,
}

impl Step {
    fn over(step_m: f32, kerbs_share: f32) -> Self {
        let kerbs = kerbs_share * step_m;
        Self { up: UP_A_METRE * kerbs, down: DOWN_A_METRE * kerbs, drift: DRIFT_A_METRE * step_m }
    }

    fn onwards(self, [level, raised]: &Belief) -> Belief {
        let mut next = [[0.0; HEIGHTS]; 2];
        fallen(raised, &mut next[0]);
        scale(&mut next[0], self.down);
        risen(level, &mut next[1]);
        scale(&mut next[1], self.up);
        self.drifted(level, 1.0 - self.up, &mut next[0]);
        self.drifted(raised, 1.0 - self.down, &mut next[1]);
        next
    }

    fn backwards(self, [level, raised]: &Belief) -> Belief {
        let mut before = [[0.0; HEIGHTS]; 2];
        fallen(raised, &mut before[0]);
        scale(&mut before[0], self.up);
        risen(level, &mut before[1]);
        scale(&mut before[1], self.down);
        self.drifted(level, 1.0 - self.up, &mut before[0]);
        self.drifted(raised, 1.0 - self.down, &mut before[1]);
        before
    }

    /// Adds `share` of what goes on level: heights go one up, one down or stay.
    fn drifted(self, from: &[f32; HEIGHTS], share: f32, to: &mut [f32; HEIGHTS]) {
        let (stays, goes) = (share * (1.0 - 2.0 * self.drift), share * self.drift);
        for (to, from) in to.iter_mut().zip(from) {
            *to += stays * from;
        }
        for (to, from) in to[1..].iter_mut().zip(from) {
            *to += goes * from;
        }
        for (to, from) in to.iter_mut().zip(&from[1..]) {
            *to += goes * from;
        }
    }
}

/// Adds what stands a kerb higher.
fn risen(from: &[f32; HEIGHTS], to: &mut [f32; HEIGHTS]) {
    let share = 1.0 / RISES.count() as f32;
    for rise in RISES {
        for (to, from) in to[rise..].iter_mut().zip(from) {
            *to += share * from;
        }
    }
}

/// Adds what stands a kerb lower.
fn fallen(from: &[f32; HEIGHTS], to: &mut [f32; HEIGHTS]) {
    let share = 1.0 / RISES.count() as f32;
    for rise in RISES {
        for (to, from) in to.iter_mut().zip(&from[rise..]) {
            *to += share * from;
        }
    }
}

fn scale(belief: &mut [f32; HEIGHTS], by: f32) {
    belief.iter_mut().for_each(|value| *value *= by);
}

/// Multiplies by what is seen, and to a sum of one.
fn weigh(belief: &mut Belief, seen: &[f32; HEIGHTS]) {
    let mut sum = 0.0;
    for (value, seen) in belief.iter_mut().flat_map(|kind| kind.iter_mut().zip(seen)) {
        *value *= seen;
        sum += *value;
    }
    let by = 1.0 / sum.max(f32::MIN_POSITIVE);
    belief.iter_mut().for_each(|kind| scale(kind, by));
}

#[cfg(test)]
mod tests {
    use super::super::height_map::HEIGHT_STEP_M;
    use super::*;

    /// A place where heights agree up to how far they are from `height_m`.
    fn seen(at_m: f64, sure: f64) -> Heights {
        std::array::from_fn(|index| {
            let off = (height_m(index) - at_m) / HEIGHT_STEP_M;
            (sure * (-0.5 * off * off).exp()) as u8
        })
    }

    fn odds(heights_m: impl Fn(f64) -> Option<f64>) -> Vec<f32> {
        let places = (0..40).map(|i| heights_m(0.2 * f64::from(i)).map_or([0; HEIGHTS], |at| seen(at, 40.0)));
        let mut log_odds = Vec::new();
        CrossSection::default().log_odds(places, (0.2, 5), &mut log_odds);
        log_odds
    }

    #[test]
    fn a_road_that_falls_away_is_level_and_a_kerb_at_its_far_side_is_none() {
        let fall_m = |y: f64| -0.06 * (y - 2.0).max(0.0);
        let road = odds(|y| Some(fall_m(y).max(-0.2)));
        assert!(road.iter().all(|&odds| odds < 1.0), "{road:?}");
        let kerbed = odds(|y| Some(fall_m(y).max(-0.18) + if y > 5.1 { 0.12 } else { 0.0 }));
        assert!(kerbed[..25].iter().all(|&odds| odds < -1.0), "{kerbed:?}");
        assert!(kerbed[26..].iter().all(|&odds| odds > 2.0), "{kerbed:?}");
    }

    #[test]
    fn what_lies_behind_a_kerb_has_been_climbed_to_though_nothing_is_seen_of_it() {
        let kerbed = odds(|y| (y < 4.0).then_some(if y > 3.1 { 0.1 } else { 0.0 }));
        assert!(kerbed[20..].iter().all(|&odds| odds > 2.0), "{kerbed:?}");
        let unseen = odds(|_| None);
        assert!(unseen.iter().all(|&odds| odds.abs() < 0.05), "{unseen:?}");
    }
}
