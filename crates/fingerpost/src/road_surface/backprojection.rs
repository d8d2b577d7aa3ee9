//! The papers' detector: histogram back-projection.
//!
//! Paper 1, section IV-B; M. J. Swain and D. H. Ballard, "Indexing via color histograms", 1992. The hue-saturation
//! histogram of the assumed road, mean of the last five frames, is divided by the picture's own histogram,
//! back-projected, and convolved with a small disc.
//!
//! With both histograms at mass 1 the ratio is Bayes' rule: P(road | bin) = P(road) p(bin | road) / p(bin). Swain and
//! Ballard's pixel counts are the case in which the sample is all the road there is; here the sample is a small part
//! of it, so the prior share of road in the view stands in (`prior`).
//!
//! Limits: grey on grey, and shadows that the sample does not reach. A sample that does not look like the road so far
//! (the vehicle turning across a verge) is left out unless that lasts.

use std::collections::VecDeque;

use fingerpost_vision::backprojection::{BackProjector, ratio_lookup};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::histogram::{BinCounter, Histogram, Smoothing};
use fingerpost_vision::picture::{Plane, Rect};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::region::Region;
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, SampleUse, UNINFORMED_LOG_ODDS_BY_COLOUR};

/// Settings of histogram back-projection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BackprojectionConfig {
    /// Hue bins.
    #[schemars(range(min = 2, max = 180))]
    pub hue_bins: u16,
    /// Saturation bins.
    #[schemars(range(min = 2, max = 256))]
    pub saturation_bins: u16,
    /// Frames in the rolling mean of the model histogram (paper 1, IV-B).
    #[schemars(range(min = 1, max = 1000))]
    pub frames: usize,
    /// Share of the ground view expected to be road.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub prior: f64,
    /// Standard deviation of the histograms' smoothing, bins; 0 for none.
    #[schemars(range(min = 0.0, max = 60.0))]
    pub smoothing_bins: f64,
    /// Radius of the disc, pixels; 0 for none, 2 for a disc of 5 x 5.
    #[schemars(range(min = 0, max = 32))]
    pub disc_radius_px: u16,
    /// A sample whose mean probability under the model so far is below this is left out.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_sample_probability: f64,
    /// Frames after which a sample so unlike the model is learned all the same.
    #[schemars(range(min = 0, max = 1000))]
    pub patience_frames: usize,
}

impl Default for BackprojectionConfig {
    fn default() -> Self {
        Self {
            hue_bins: 32,
            saturation_bins: 32,
            frames: 5,
            prior: 0.8,
            smoothing_bins: 1.2,
            disc_radius_px: 2,
            min_sample_probability: 0.3,
            patience_frames: 20,
        }
    }
}

impl BackprojectionConfig {
    /// The division of hue and saturation into bins.
    pub const fn bins(&self) -> HueSaturationBins {
        HueSaturationBins { hue: self.hue_bins, saturation: self.saturation_bins }
    }
}

/// The papers' road detector and what it has learned.
#[derive(Debug)]
pub struct Backprojection {
    config: BackprojectionConfig,
    counter: BinCounter,
    smoothing: Smoothing,
    projector: BackProjector,
    whole: Region,
    sample: Region,
    /// Mean of the recent samples.
    model: Histogram,
    recent: VecDeque<Histogram>,
    /// Memory of histograms that are recent no more.
    spare: Vec<Histogram>,
    left_out: usize,
    lookup: Vec<u8>,
}

impl Backprojection {
    /// A detector that has learned nothing yet.
    ///
    /// # Errors
    /// [`RoadError`] when the numbers of bins, the smoothing or the disc's radius cannot be used.
    pub fn new(config: &BackprojectionConfig) -> Result<Self, RoadError> {
        let bins = config.bins();
        Ok(Self {
            config: config.clone(),
            counter: BinCounter::default(),
            smoothing: Smoothing::new(bins, config.smoothing_bins, config.smoothing_bins)?,
            projector: BackProjector::new(config.disc_radius_px)?,
            whole: Region::new(bins)?,
            sample: Region::new(bins)?,
            model: Histogram::new(bins)?,
            recent: VecDeque::new(),
            spare: Vec::new(),
            left_out: 0,
            lookup: vec![0; bins.count()],
        })
    }

    fn learn(&mut self) {
        self.left_out = 0;
        if self.recent.len() >= self.config.frames.max(1) {
            self.spare.extend(self.recent.pop_front());
        }
        let mut learned = self.spare.pop().unwrap_or_else(|| self.sample.histogram.clone());
        learned.clone_from(&self.sample.histogram);
        self.recent.push_back(learned);
    }

    fn forget(&mut self) {
        self.left_out = 0;
        self.spare.extend(self.recent.drain(..));
    }

    /// Sets the look-up of P(road | bin) from the rolling mean and the picture's own histogram.
    fn tabulate(&mut self) -> Result<(), RoadError> {
        self.model.set_to_mean(&self.recent)?;
        Ok(ratio_lookup(&self.model, &self.whole.histogram, self.config.prior, &mut self.lookup)?)
    }

    /// Mean probability that the look-up gives to the pixels of the sample.
    fn sample_probability(&self) -> f64 {
        let masses = self.sample.histogram.masses().iter();
        masses.zip(&self.lookup).map(|(mass, &p)| mass * f64::from(p) / 255.0).sum()
    }

    /// Learns from the sample or leaves it out, and says which.
    fn consider(&mut self) -> SampleUse {
        if self.recent.is_empty() || self.sample_probability() >= self.config.min_sample_probability {
            self.learn();
            return SampleUse::Learned;
        }
        if self.left_out < self.config.patience_frames {
            self.left_out += 1;
            return SampleUse::LeftOut;
        }
        self.forget();
        self.learn();
        SampleUse::SurfaceChanged
    }
}

impl Backprojection {
    /// Learns from a picture and says how its sample looks, without the other pixels' probabilities.
    pub(super) fn learn_from(&mut self, input: RoadInput<'_>) -> Result<RoadEvidence, RoadError> {
        let (width, height) = input.picture.bin.size();
        let whole = Rect { x: 0, y: 0, width, height };
        let (bin, validity) = (input.picture.bin.view(), input.validity);
        for (region, rect) in [(&mut self.whole, whole), (&mut self.sample, input.sample)] {
            region.measure(rect, bin, validity, &mut self.counter, &mut self.smoothing)?;
        }
        let mut sample_use = SampleUse::Unseen;
        let mut sample_probability = 0.0;
        if self.whole.is_seen() {
            self.tabulate()?;
            if self.sample.is_seen() {
                sample_use = self.consider();
                self.tabulate()?;
                sample_probability = self.sample_probability();
            }
        }
        Ok(RoadEvidence {
            detector: "backprojection",
            uninformed_log_odds: UNINFORMED_LOG_ODDS_BY_COLOUR,
            sample: input.sample,
            sample_use,
            sample_probability,
            histograms: self.recent.len(),
            ..RoadEvidence::default()
        })
    }

    /// Fills `probability` for the picture that was learned from last.
    pub(super) fn project(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<(), RoadError> {
        let (width, height) = input.picture.bin.size();
        if probability.size() != (width, height) {
            probability.reset(width, height, 0);
        }
        Ok(self.projector.project(&input.picture.bin, input.validity, &self.lookup, probability)?)
    }
}

impl RoadDetector for Backprojection {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let evidence = self.learn_from(input)?;
        self.project(input, probability)?;
        Ok(evidence)
    }

    fn reset(&mut self) {
        self.forget();
    }
}
