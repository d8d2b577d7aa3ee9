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
use fingerpost_vision::histogram::Histogram;
use fingerpost_vision::picture::Rect;
use fingerpost_vision::span::SpanMask;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, RoadSurface, SampleUse};

/// Settings of histogram back-projection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BackprojectionConfig {
    /// Hue bins, 2 to 180; default 32.
    pub hue_bins: u16,
    /// Saturation bins, 2 to 256; default 32.
    pub saturation_bins: u16,
    /// Frames in the rolling mean of the model histogram, at least 1; default 5 (paper 1, IV-B).
    pub frames: usize,
    /// Share of the ground view expected to be road, above 0 to 1; default 0.8.
    pub prior: f64,
    /// Standard deviation of the histograms' smoothing, bins, 0 or more; default 1.2.
    pub smoothing_bins: f64,
    /// Radius of the disc, pixels, 0 or more; default 2 (a 5 x 5 disc).
    pub disc_radius_px: u16,
    /// A sample whose mean probability under the model so far is below this is left out, 0 to 1; default 0.3.
    pub min_sample_probability: f64,
    /// Frames after which a sample so unlike the model is learned all the same; default 20.
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
    bins: HueSaturationBins,
    projector: BackProjector,
    recent: VecDeque<Histogram>,
    left_out: usize,
    lookup: Vec<u8>,
}

impl Backprojection {
    /// A detector that has learned nothing yet.
    ///
    /// # Errors
    /// [`RoadError`] when the numbers of bins or the disc's radius cannot be used.
    pub fn new(config: &BackprojectionConfig) -> Result<Self, RoadError> {
        let bins = config.bins();
        bins.check()?;
        Ok(Self {
            config: config.clone(),
            bins,
            projector: BackProjector::new(config.disc_radius_px)?,
            recent: VecDeque::new(),
            left_out: 0,
            lookup: Vec::new(),
        })
    }

    /// The smoothed histogram of a region, mass 1; none where nothing of it is seen.
    fn histogram(&self, input: &RoadInput<'_>, region: Rect) -> Result<Option<Histogram>, RoadError> {
        let mut histogram = Histogram::new(self.bins)?;
        histogram.count(input.bin.view(), input.validity.plane().view(), &SpanMask::from_rect(region))?;
        histogram.smooth(self.config.smoothing_bins, self.config.smoothing_bins)?;
        histogram.normalise();
        Ok((histogram.total() > 0.0).then_some(histogram))
    }

    fn learn(&mut self, sample: Histogram) {
        self.left_out = 0;
        if self.recent.len() >= self.config.frames.max(1) {
            self.recent.pop_front();
        }
        self.recent.push_back(sample);
    }

    /// Sets the look-up of P(road | bin) from the rolling mean and the picture's own histogram.
    fn tabulate(&mut self, picture: &Histogram) -> Result<(), RoadError> {
        match Histogram::mean_of(&self.recent)? {
            Some(model) => ratio_lookup(&model, picture, self.config.prior, &mut self.lookup)?,
            None => self.lookup.fill(0),
        }
        Ok(())
    }

    /// Mean probability that the look-up gives to the pixels of `sample`.
    fn probability_of(&self, sample: &Histogram) -> f64 {
        sample.masses().iter().zip(&self.lookup).map(|(mass, &p)| mass * f64::from(p) / 255.0).sum()
    }

    /// Learns from the sample or leaves it out, and says which.
    fn consider(&mut self, sample: Histogram) -> SampleUse {
        let familiar =
            self.recent.is_empty() || self.probability_of(&sample) >= self.config.min_sample_probability;
        if familiar {
            self.learn(sample);
            return SampleUse::Learned;
        }
        if self.left_out < self.config.patience_frames {
            self.left_out += 1;
            return SampleUse::LeftOut;
        }
        self.recent.clear();
        self.learn(sample);
        SampleUse::SurfaceChanged
    }
}

impl RoadDetector for Backprojection {
    fn detect(&mut self, input: RoadInput<'_>, surface: &mut RoadSurface) -> Result<RoadEvidence, RoadError> {
        let (width, height) = input.colour.size();
        self.lookup.resize(self.bins.count(), 0);
        let whole = Rect { x: 0, y: 0, width, height };
        let picture = self.histogram(&input, whole)?;
        let sample = self.histogram(&input, input.sample)?;
        let mut sample_use = SampleUse::Unseen;
        let mut sample_probability = 0.0;
        if let Some(picture) = &picture {
            self.tabulate(picture)?;
            if let Some(sample) = sample {
                sample_use = self.consider(sample.clone());
                self.tabulate(picture)?;
                sample_probability = self.probability_of(&sample);
            }
        }
        if surface.probability.size() != (width, height) {
            surface.probability.reset(width, height, 0);
        }
        let seen = input.validity.plane();
        self.projector.project(input.bin, seen, &self.lookup, &mut surface.probability)?;
        surface.sums.rebuild(surface.probability.view(), seen.view())?;
        Ok(RoadEvidence {
            detector: "backprojection",
            sample: input.sample,
            sample_use,
            sample_probability,
            histograms: self.recent.len(),
        })
    }

    fn reset(&mut self) {
        self.recent.clear();
        self.left_out = 0;
    }
}
