//! The road in cross-section: from the vehicle's way outwards the ground goes on level, or rises by a kerb's height.
//!
//! What a window shows of its height is weak, ambiguous or nothing, and a road falls to its sides by as much as a kerb is high. But
//! roads have no steps, and kerbs are steps: so the heights along a row of the view are a hidden Markov chain whose states are the
//! height and whether a kerb has been climbed since the vehicle's way, and the forward-backward algorithm (L. Rabiner, "A tutorial
//! on hidden Markov models", 1989, III-A) gives the probability of that for each place. What lies behind a kerb has been climbed to even
//! where it shows nothing itself.

use nalgebra::SVector;

use super::MOST_LOG_ODDS;
use super::height_map::{Below, HEIGHTS, likelihoods};

/// Heights of kerbs, in steps: 5 to 17.5 cm.
const RISES: std::ops::RangeInclusive<usize> = 2..=7;
/// Kerbs in a metre across: a country road has none, and a street one on either side.
const KERBS_A_METRE: f32 = 0.01;
/// Probability that a metre of ground gets a step of height higher, and as much lower: roads fall by 1 to 3 % to either side.
const DRIFT_A_METRE: f32 = 0.2;
/// Cross-sections that are followed at once, a lane each: all of a chain's sums are then of whole lanes.
pub(super) const LANES: usize = 8;
pub(super) type Lanes = SVector<f32, LANES>;
type ByHeight = [Lanes; HEIGHTS];
/// What is believed of a place: level heights, then raised ones.
type Belief = [ByHeight; 2];

/// The chains, with their memory.
#[derive(Debug)]
pub(super) struct CrossSections {
    likelihoods: [f32; 256],
    forward: Vec<Belief>,
    seen: Vec<ByHeight>,
    log_odds: Vec<Lanes>,
}

impl Default for CrossSections {
    fn default() -> Self {
        Self { likelihoods: likelihoods(), forward: Vec::new(), seen: Vec::new(), log_odds: Vec::new() }
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
        let step = Step::over(step_m as f32);
        let Self { likelihoods, forward, seen, log_odds } = self;
        seen.clear();
        for place in 0..places {
            let mut by_height = [Lanes::zeros(); HEIGHTS];
            for lane in 0..LANES {
                for (lanes, below) in by_height.iter_mut().zip(heights(place, lane)) {
                    lanes[lane] = likelihoods[usize::from(below)];
                }
            }
            seen.push(by_height);
        }
        log_odds.clear();
        log_odds.resize(places, Lanes::zeros());
        forward.clear();
        let mut belief = [[Lanes::repeat(1.0); HEIGHTS], [Lanes::zeros(); HEIGHTS]];
        for seen in seen.iter() {
            belief = step.onwards(&belief);
            weigh(&mut belief, seen);
            forward.push(belief);
        }
        let mut backward = [[Lanes::repeat(1.0); HEIGHTS]; 2];
        for (place, (seen, forward)) in seen.iter().zip(forward.iter()).enumerate().rev() {
            let [level, raised] = [&forward[0], &forward[1]];
            let (level, raised) = (product(level, &backward[0]), product(raised, &backward[1]));
            let odds = |raised: f32, level: f32| raised.max(f32::MIN_POSITIVE) / level.max(f32::MIN_POSITIVE);
            log_odds[place] = raised.zip_map(&level, |raised, level| libm::logf(odds(raised, level)));
            weigh(&mut backward, seen);
            backward = step.backwards(&backward);
        }
        let mut level = 1.0;
        for log_odds in log_odds.iter_mut() {
            level *= 1.0 - step.kerb;
            let unseen = libm::logf((1.0 - level) / level);
            log_odds.apply(|log_odds| *log_odds = (*log_odds - unseen).clamp(-MOST_LOG_ODDS, MOST_LOG_ODDS));
        }
        log_odds
    }
}

/// The chain's step from a place to the next one outwards: probabilities of a kerb, and of a step of height up and as much down.
#[derive(Debug, Clone, Copy)]
struct Step {
    kerb: f32,
    drift: f32,
}

impl Step {
    fn over(step_m: f32) -> Self {
        Self { kerb: KERBS_A_METRE * step_m, drift: DRIFT_A_METRE * step_m }
    }

    fn onwards(self, [level, raised]: &Belief) -> Belief {
        let mut next = [self.drifted(level, 1.0 - self.kerb), self.drifted(raised, 1.0)];
        for (index, level) in level.iter().enumerate() {
            let each = level * self.each_rise();
            beyond_kerb(index).for_each(|beyond| next[1][beyond] += each);
        }
        next
    }

    fn backwards(self, [level, raised]: &Belief) -> Belief {
        let mut before = [self.drifted(level, 1.0 - self.kerb), self.drifted(raised, 1.0)];
        for (index, before) in before[0].iter_mut().enumerate() {
            beyond_kerb(index).for_each(|beyond| *before += raised[beyond] * self.each_rise());
        }
        before
    }

    fn each_rise(self) -> f32 {
        self.kerb / RISES.count() as f32
    }

    /// `share` of what meets no kerb: heights go one up, one down or stay.
    fn drifted(self, from: &ByHeight, share: f32) -> ByHeight {
        let (stays, goes) = (share * (1.0 - 2.0 * self.drift), share * self.drift);
        let mut to = *from;
        scale(&mut to, &Lanes::repeat(stays));
        for (index, from) in from.iter().enumerate() {
            let goes = from * goes;
            to[index.saturating_sub(1)] += goes;
            to[(index + 1).min(HEIGHTS - 1)] += goes;
        }
        to
    }
}

/// Heights that a kerb at a height leads to; the highest stands for all above it.
fn beyond_kerb(index: usize) -> impl Iterator<Item = usize> {
    RISES.map(move |rise| (index + rise).min(HEIGHTS - 1))
}

fn scale(values: &mut ByHeight, by: &Lanes) {
    for lanes in values {
        *lanes = lanes.component_mul(by);
    }
}

fn product(a: &ByHeight, b: &ByHeight) -> Lanes {
    let mut sums = Lanes::zeros();
    for (a, b) in a.iter().zip(b) {
        sums += a.component_mul(b);
    }
    sums
}

/// Multiplies by what is seen, and to a sum of one.
fn weigh(belief: &mut Belief, seen: &ByHeight) {
    let mut sums = Lanes::repeat(f32::MIN_POSITIVE);
    for kind in belief.iter_mut() {
        for (lanes, seen) in kind.iter_mut().zip(seen) {
            *lanes = lanes.component_mul(seen);
            sums += *lanes;
        }
    }
    let by = sums.map(|sum| 1.0 / sum);
    belief.iter_mut().for_each(|kind| scale(kind, &by));
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
