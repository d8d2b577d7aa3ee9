//! The road in cross-section: from the vehicle's way outwards the ground goes on level, or rises by a kerb's height.
//!
//! What a window shows of its height is weak, ambiguous or nothing, and a road falls to its sides by as much as a kerb is high. But
//! roads have no steps, and kerbs are steps: so the heights along a row of the view are a hidden Markov chain whose states are the
//! height and whether a kerb has been climbed since the vehicle's way, and the forward-backward algorithm (L. Rabiner, "A tutorial
//! on hidden Markov models", 1989, III-A) gives the probability of that for each place. What lies behind a kerb has been climbed to even
//! where it shows nothing itself.

use fingerpost_vision::parallax::rise_chain::{ByHeight, LANES, Lanes, RiseChain, RiseSteps};

use super::MOST_LOG_ODDS;
use super::height_map::{Below, HEIGHTS, likelihoods};

/// Heights of kerbs, in steps: 5 to 17.5 cm.
const LOWEST_KERB: usize = 2;
const HIGHEST_KERB: usize = 7;
/// Kerbs in a metre across: a country road has none, and a street one on either side.
const KERBS_A_METRE: f32 = 0.01;
/// Probability that a metre of ground gets a step of height higher, and as much lower: roads fall by 1 to 3 % to either side.
const DRIFT_A_METRE: f32 = 0.2;

/// The chains, with their memory.
#[derive(Debug)]
pub(super) struct CrossSections {
    likelihoods: [f32; 256],
    chain: RiseChain<HEIGHTS, LOWEST_KERB, HIGHEST_KERB>,
    seen: Vec<ByHeight<HEIGHTS>>,
    log_odds: Vec<Lanes>,
}

impl Default for CrossSections {
    fn default() -> Self {
        Self {
            likelihoods: likelihoods(),
            chain: RiseChain::default(),
            seen: Vec::new(),
            log_odds: Vec::new(),
        }
    }
}

impl CrossSections {
    /// Log-odds that each of `places` places lies beyond a kerb, against what would be thought without looking, in as many
    /// cross-sections as there are lanes; `heights` are those of a place and lane. Places lie `step_m` apart, and the road begins
    /// as far before the first.
    pub(super) fn log_odds(
        &mut self,
        places: usize,
        heights: impl Fn(usize, usize) -> Below,
        step_m: f64,
    ) -> &[Lanes] {
        let step_m = step_m as f32;
        let steps = RiseSteps { rise: KERBS_A_METRE * step_m, drift: DRIFT_A_METRE * step_m };
        let Self { likelihoods, chain, seen, log_odds } = self;
        seen.clear();
        for place in 0..places {
            let mut by_height = [[0.0; LANES]; HEIGHTS];
            for lane in 0..LANES {
                for (lanes, below) in by_height.iter_mut().zip(heights(place, lane)) {
                    lanes[lane] = likelihoods[usize::from(below)];
                }
            }
            seen.push(by_height);
        }
        log_odds.clear();
        let mut level = 1.0;
        for odds in chain.odds(&steps, seen) {
            level *= 1.0 - steps.rise;
            let unseen = libm::logf((1.0 - level) / level);
            let against_unseen = |odds: f32| (libm::logf(odds) - unseen).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS);
            log_odds.push(odds.map(against_unseen));
        }
        log_odds
    }
}

#[cfg(test)]
mod tests {
    use super::super::height_map::{HEIGHT_STEP_M, height_m};
    use super::*;

    /// A place where heights agree the less the farther they are from `at_m`.
    fn seen(at_m: f64) -> Below {
        std::array::from_fn(|index| {
            let off = (height_m(index) - at_m) / HEIGHT_STEP_M;
            (40.0 * (1.0 - libm::exp(-0.5 * off * off))) as u8
        })
    }

    fn odds(heights_m: impl Fn(f64) -> Option<f64>) -> Vec<f32> {
        let heights = |place: usize, lane: usize| {
            let at_m = heights_m(0.2 * place as f64).filter(|_| lane == 3);
            at_m.map_or([0; HEIGHTS], seen)
        };
        let mut sections = CrossSections::default();
        let lanes = sections.log_odds(40, heights, 0.2);
        assert!(lanes.iter().all(|lanes| lanes[2].abs() < 0.05), "lanes do not mix");
        lanes.iter().map(|lanes| lanes[3]).collect()
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
