//! Road from the small network that comes with the program.
//!
//! [`RoadNetwork`] looks at the part of the camera picture that shows the ground wanted ([`LookedAt`]), stretched to its own size, and
//! gives the log-odds of road, and of what else it was trained on, at half of that. These are interpolated into the picture that is asked for, where what the colour of each pixel says
//! ([`DriveColours`]) is added to those of road, so that an edge is as sharp as its colours are; as the two err together, both count what they
//! count on simulated drives. Only then are they made probabilities, so that an edge stays where the odds are even. `docs/src/method/road.md` has the network's equations.
//!
//! Limits: it was trained on simulated pictures alone (`training/`), and is least sure of what these lack; nothing finer than two of
//! its own pixels is seen.

use fingerpost_vision::picture::Plane;
use fingerpost_vision::road_network::{LOGIT_STEPS, RoadNetwork};

use super::drive_colours::DriveColours;
use super::looked_at::LookedAt;
use super::perspective::clear_unseen;
use super::reduced_frame::{ReducedFrame, evidence_of_a_network};
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, RoadMethod};

/// The weights that come with the program, as [`Network::from_bytes`] reads them.
pub const NETWORK_WEIGHTS: &[u8] = include_bytes!("road_network.weights");

/// What the network's outputs say, each by itself: log-odds at the places of [`RoadNetwork::logits`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NetworkOutput {
    /// Road that is seen.
    Road = 0,
    /// Paint on the road.
    Paint = 1,
    /// Raised ground, as pavements.
    Raised = 2,
    /// Ground that a vehicle or another thing hides.
    Hidden = 3,
}

impl NetworkOutput {
    /// Its index among the network's outputs.
    #[must_use]
    pub const fn index(self) -> usize {
        self as usize
    }
}

/// What each piece of evidence counts in the log-odds of road.
#[derive(Debug, Clone, Copy)]
struct EvidenceWeights {
    /// What the network's log-odds count.
    network: f32,
    /// What those of the drive's colours count.
    colours: f32,
    offset: f32,
}

/// The detector that asks the network.
pub struct Network {
    network: RoadNetwork,
    colours: DriveColours,
    evidence_weights: EvidenceWeights,
    /// Log-odds of road without the colours in the network's steps, as bytes without a sign; 0 is none.
    odds: Plane<u8>,
    looked_at: LookedAt,
    reduced: ReducedFrame,
    /// Probability of road by these bytes.
    probability: [u8; 256],
}

/// What stands for even odds.
const EVEN: u8 = 128;

/// Bytes of [`EvidenceWeights`] at the end of a file.
const EVIDENCE_WEIGHTS_BYTES: usize = 12;

impl EvidenceWeights {
    fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let (numbers, []) = bytes.as_chunks() else { return None };
        let [network, colours, offset] = *numbers else { return None };
        let [network, colours, offset] = [network, colours, offset].map(f32::from_le_bytes);
        [network, colours, offset].iter().all(|number| number.is_finite()).then_some(Self {
            network,
            colours,
            offset,
        })
    }

    /// Log-odds of road without the colours, in the network's steps from [`EVEN`], of one of its logits.
    fn byte(self, logit: i8) -> u8 {
        let weighted = self.network * f32::from(logit) + LOGIT_STEPS * self.offset;
        EVEN.wrapping_add_signed(weighted.round().clamp(-127.0, 127.0) as i8)
    }
}

impl Network {
    /// With the weights of a file: a network as [`RoadNetwork::from_bytes`] reads it, and then three `f32`, little endian: what its
    /// log-odds of road count, what those of the drive's colours count, and an offset.
    ///
    /// # Errors
    /// [`RoadError::Weights`] when the bytes are no such file, [`RoadError::EvidenceWeights`] when one of the three is not finite.
    pub fn from_bytes(weights: &[u8]) -> Result<Self, RoadError> {
        let (weights, last) = weights.split_at(weights.len().saturating_sub(EVIDENCE_WEIGHTS_BYTES));
        let network = RoadNetwork::from_bytes(weights)?;
        let evidence_weights = EvidenceWeights::from_bytes(last).ok_or(RoadError::EvidenceWeights)?;
        let (width, height) = network.logit_size();
        let probability = |byte: u8| {
            let log_odds = (f64::from(byte) - f64::from(EVEN)) / f64::from(LOGIT_STEPS);
            if byte == 0 { 0 } else { (255.0 / (1.0 + libm::exp(-log_odds))).round() as u8 }
        };
        let mut table = [0; 256];
        (0..=u8::MAX).zip(&mut table).for_each(|(byte, entry)| *entry = probability(byte));
        let odds = Plane::new(width, height, 0);
        let colours = DriveColours::new();
        Ok(Self {
            network,
            colours,
            evidence_weights,
            odds,
            looked_at: LookedAt::default(),
            reduced: ReducedFrame::default(),
            probability: table,
        })
    }

    /// Joins what the colours of the picture that is asked for add to log-odds in the network's steps, and makes them probabilities. Gives the
    /// share of the places that may show road in which the colours decided against the network alone.
    fn join_colours(&mut self, input: &RoadInput<'_>, probability: &mut Plane<u8>) -> f64 {
        self.colours.weigh(LOGIT_STEPS * self.evidence_weights.colours);
        let mut turned = 0;
        for y in 0..probability.height() {
            let pixels = input.picture.colour.row(y).as_chunks::<3>().0;
            let row = probability.row_mut(y);
            for run in input.validity.runs(y) {
                let places = run.start..run.end;
                for (place, &pixel) in row[places.clone()].iter_mut().zip(&pixels[places]) {
                    let joined = place.saturating_add_signed(self.colours.steps(pixel)).max(1);
                    turned += usize::from((*place > EVEN) != (joined > EVEN));
                    *place = self.probability[usize::from(joined)];
                }
            }
        }
        turned as f64 / input.validity.seen().max(1) as f64
    }

    /// With the weights that come with the program.
    ///
    /// # Errors
    /// [`RoadError::Weights`] when these are damaged.
    pub fn new() -> Result<Self, RoadError> {
        Self::from_bytes(NETWORK_WEIGHTS)
    }
}

impl RoadDetector for Network {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let part = self.looked_at.part(&input);
        self.network.see(input.camera_picture(), part)?;
        if let Some(road) = self.network.logits(NetworkOutput::Road.index()) {
            let horizon = input.vanishing_point();
            let [_, row] = self.network.logit_place([horizon.u, horizon.v]);
            let first_row = (row + 0.5).ceil().clamp(0.0, road.height() as f64) as usize;
            self.colours.learn(self.network.picture(), road, first_row);
            for y in 0..road.height() {
                for (byte, &logit) in self.odds.row_mut(y).iter_mut().zip(road.row(y)) {
                    *byte = self.evidence_weights.byte(logit);
                }
            }
        }
        self.reduced.lay_into(&input, (part, &self.odds), probability)?;
        let by_colours = self.join_colours(&input, probability);
        let reduced_rows = part.height as f64 / self.network.picture().height().max(1) as f64;
        clear_unseen(input.validity, probability);
        let evidence = evidence_of_a_network(RoadMethod::Network.name(), &input, reduced_rows, probability);
        Ok(RoadEvidence { by_colours: Some(by_colours), ..evidence })
    }

    fn network(&self) -> Option<&RoadNetwork> {
        Some(&self.network)
    }

    fn reset(&mut self) {
        self.colours.forget();
    }
}

#[cfg(test)]
mod tests;
