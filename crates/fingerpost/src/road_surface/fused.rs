//! The network and what the drive itself shows of its road, as evidence that errs together.
//!
//! The network has seen roads of many kinds and none of today's; [`Appearance`] knows today's alone. Both give log-odds of road, and
//! these are added. As both are misled by the same things (pavement of the road's tone, deep shade) neither counts in full.
//!
//! Limits: what neither tells from the road becomes road; a weight that is right on average is not right on every day.

use fingerpost_vision::picture::Plane;
use fingerpost_vision::road_network::RoadNetwork;

use super::{Appearance, Network, RoadDetector, RoadError, RoadEvidence, RoadInput};

/// What the network's log-odds count, and what those of the appearance count. Logistic regression on labelled pictures of a real day (CamVid
/// val) gives 0.88 and 0.80 and no offset, on sixteen simulated drives of nine kinds of day 0.97 and 0.25 and an offset of -1.7, as pavement
/// of the road's tone is more common there. The weights lie between; with an offset of -0.4 the junction of KITTI 00 is placed 1.8 to 3.2 m
/// off from a camera 1.6 m high, 0.6 to 1.4 m without.
const NETWORK_COUNTS: f64 = 0.9;
const APPEARANCE_COUNTS: f64 = 0.6;

/// Steps of a natural unit of log-odds.
const STEPS: f64 = 32.0;
/// Steps either way from which a probability is the surest of 8 bits.
const MOST_STEPS: i16 = 256;

/// The detector that adds both.
pub(super) struct Fused {
    appearance: Appearance,
    network: Network,
    by_network: Plane<u8>,
    weights: Box<Weights>,
}

/// Tables of what a probability of 255 counts.
struct Weights {
    network: [i16; 256],
    appearance: [i16; 256],
    /// Probability of road, 255 being 1, by log-odds in steps from [`MOST_STEPS`] below even ones.
    probability: [u8; 2 * MOST_STEPS as usize],
}

impl Weights {
    fn new() -> Self {
        let steps = |log_odds: f64| (STEPS * log_odds).round() as i16;
        let log_odds = |byte: u8| {
            // Half a level of 255, where the odds would be endless.
            let p = f64::from(byte).clamp(0.5, 254.5) / 255.0;
            libm::log(p / (1.0 - p))
        };
        let table = |counts: f64| {
            let mut table = [0; 256];
            (0..=u8::MAX).zip(&mut table).for_each(|(p, entry)| *entry = steps(counts * log_odds(p)));
            table
        };
        let mut probability = [0; 2 * MOST_STEPS as usize];
        for (step, p) in (-MOST_STEPS..).zip(&mut probability) {
            *p = (255.0 / (1.0 + libm::exp(-f64::from(step) / STEPS))).round() as u8;
        }
        Self { network: table(NETWORK_COUNTS), appearance: table(APPEARANCE_COUNTS), probability }
    }

    /// The probability of road that follows from both.
    #[inline]
    fn fused(&self, by_network: u8, by_appearance: u8) -> u8 {
        let steps = self.network[usize::from(by_network)] + self.appearance[usize::from(by_appearance)];
        self.probability[(steps.clamp(-MOST_STEPS, MOST_STEPS - 1) + MOST_STEPS) as usize]
    }
}

impl Fused {
    pub(super) fn new(appearance: Appearance) -> Result<Self, RoadError> {
        Ok(Self {
            appearance,
            network: Network::new()?,
            by_network: Plane::default(),
            weights: Box::new(Weights::new()),
        })
    }

    /// Adds the network's evidence to the appearance's in `probability`. Gives the share of the places that may show road in which this
    /// drive decided against the network alone.
    fn fuse(&self, input: RoadInput<'_>, probability: &mut Plane<u8>) -> f64 {
        let mut turned = 0;
        for y in 0..probability.height() {
            let by_network = self.by_network.row(y);
            let row = probability.row_mut(y);
            for run in input.validity.runs(y) {
                let places = run.start..run.end;
                for (place, &by_network) in row[places.clone()].iter_mut().zip(&by_network[places]) {
                    let fused = self.weights.fused(by_network, *place);
                    turned += usize::from((by_network > EVEN) != (fused > EVEN));
                    *place = fused;
                }
            }
        }
        turned as f64 / input.validity.seen().max(1) as f64
    }
}

/// Greatest probability, of 255, that is no more than even odds.
const EVEN: u8 = 127;

impl RoadDetector for Fused {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let evidence = self.appearance.estimate(input, probability)?;
        let RoadEvidence { reduced_rows, .. } = self.network.estimate(input, &mut self.by_network)?;
        let by_colours = self.fuse(input, probability);
        Ok(RoadEvidence { by_colours: Some(by_colours), uninformed_log_odds: 0.0, reduced_rows, ..evidence })
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.network.network()
    }

    fn reset(&mut self) {
        self.appearance.reset();
        self.network.reset();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_count_and_what_one_does_not_know_the_other_decides() {
        let weights = Weights::new();
        let fused = |by_network, by_appearance| weights.fused(by_network, by_appearance);
        assert!(fused(250, 250) > 250 && fused(5, 5) < 5);
        assert!(fused(250, 128) > 200 && fused(128, 250) > 200 && fused(5, 128) < 50 && fused(128, 5) < 50);
        assert!(fused(220, 128) < 220, "what says nothing makes no surer");
    }

    #[test]
    fn more_evidence_for_road_never_makes_it_less_probable() {
        let weights = Weights::new();
        for other in [0, 60, 128, 200, 255] {
            for p in 0..u8::MAX {
                assert!(weights.fused(p, other) <= weights.fused(p + 1, other));
                assert!(weights.fused(other, p) <= weights.fused(other, p + 1));
            }
        }
    }

    #[test]
    fn equal_and_opposite_evidence_of_both_is_weighed_by_the_regression() {
        let expected = |p: f64, q: f64| {
            let log_odds = |p: f64| libm::log(p / (1.0 - p));
            255.0 / (1.0 + libm::exp(-(0.9 * log_odds(p) + 0.6 * log_odds(q))))
        };
        let weights = Weights::new();
        for (p, q) in [(204, 51), (51, 204), (128, 128), (230, 100)] {
            let found = f64::from(weights.fused(p, q));
            assert!(
                (found - expected(f64::from(p) / 255.0, f64::from(q) / 255.0)).abs() < 3.0,
                "{p} {q} {found}"
            );
        }
    }
}
