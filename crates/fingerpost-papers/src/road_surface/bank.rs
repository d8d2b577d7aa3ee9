//! A bank of known surfaces: the road is what looks like any of them.
//!
//! Paper 2, section 7.4. A rolling mean of the road just ahead loses the road for a moment where its surface changes. So every
//! surface that the road has had is kept ([`SurfaceMemory`]); each is back-projected as in the papers, and a pixel's probability is
//! the largest of all, that of the rolling mean among them. The surface under way has a name.
//!
//! Limits: the more surfaces are known, the more of what lies beside the road looks like one; those long not met count less.

use std::collections::VecDeque;

use fingerpost::road_surface::{
    BankConfig, Region, RoadDetector, RoadError, RoadEvidence, RoadInput, SampleUse, SurfaceFile,
    SurfaceMemory, UNINFORMED_LOG_ODDS_BY_COLOUR,
};
use fingerpost_vision::backprojection::{BackProjector, ratio_lookup};
use fingerpost_vision::histogram::Histogram;
use fingerpost_vision::picture::Plane;

/// The detector by known surfaces.
#[derive(Debug)]
pub struct Bank {
    config: BankConfig,
    memory: SurfaceMemory,
    projector: BackProjector,
    recent: VecDeque<Histogram>,
    mean: Histogram,
    whole: Region,
    /// P(road | tone) of one surface, and the largest of all.
    of_one: Vec<u8>,
    largest: Vec<u8>,
}

impl Bank {
    /// A detector that knows no surface yet.
    ///
    /// # Errors
    /// [`RoadError`] when the disc's radius cannot be used.
    pub fn new(config: &BankConfig) -> Result<Self, RoadError> {
        Ok(Self {
            config: config.clone(),
            memory: SurfaceMemory::new(config)?,
            projector: BackProjector::new(config.disc_radius_px)?,
            recent: VecDeque::new(),
            mean: Histogram::new(SurfaceMemory::TONES)?,
            whole: Region::new(SurfaceMemory::TONES)?,
            of_one: Vec::new(),
            largest: Vec::new(),
        })
    }

    /// Takes the frame's sample into the rolling mean.
    fn roll(&mut self) -> Result<(), RoadError> {
        let full = self.recent.len() >= self.config.frames.max(1);
        let sample = self.memory.sample();
        let mut recent = if full { self.recent.pop_front() } else { None }.unwrap_or_else(|| sample.clone());
        recent.clone_from(sample);
        self.recent.push_back(recent);
        Ok(self.mean.set_to_mean(&self.recent)?)
    }

    /// Sets the largest probability of every tone; the share of the picture that is road by it, and the share of that at which
    /// the surface under way wins.
    fn tabulate(&mut self) -> Result<(f64, f64), RoadError> {
        let Self {
            config,
            memory,
            mean,
            whole: Region { histogram: whole, .. },
            of_one,
            largest,
            recent,
            ..
        } = self;
        largest.clear();
        largest.resize(SurfaceMemory::TONES.count(), 0);
        if let Some(histogram) = memory.under_way() {
            ratio_lookup(histogram, whole, config.prior, largest)?;
        }
        let masses = whole.masses();
        let share = |lookup: &[u8]| -> f64 {
            masses.iter().zip(lookup).filter(|(_, p)| **p >= 128).map(|(mass, _)| mass).sum()
        };
        let won = share(largest);
        let weight = |unseen_frames: u64| {
            let age = unseen_frames as f64 / config.stale_frames.max(1e-9);
            config.stale_weight + (1.0 - config.stale_weight) / (1.0 + age)
        };
        let others = memory.known().map(|(histogram, unseen_frames)| (histogram, weight(unseen_frames)));
        for (histogram, weight) in others.chain((!recent.is_empty()).then_some((&*mean, 1.0))) {
            let gain = config.prior * weight;
            if gain > 0.0 {
                ratio_lookup(histogram, whole, gain, of_one)?;
                largest.iter_mut().zip(&*of_one).for_each(|(largest, p)| *largest = (*largest).max(*p));
            }
        }
        let road = share(largest);
        Ok((road, if road > 0.0 { won / road } else { 0.0 }))
    }
}

impl RoadDetector for Bank {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let (mut bank, sample_use) = self.memory.consider(&input)?;
        let (width, height) = input.picture.bin.size();
        self.memory.measure_all(&input, &mut self.whole)?;
        if !matches!(sample_use, SampleUse::LeftOut | SampleUse::Unseen) {
            if bank.founded {
                self.recent.clear();
            }
            self.roll()?;
        }
        (bank.road_share, bank.won_share) = self.tabulate()?;
        if probability.size() != (width, height) {
            probability.reset(width, height, 0);
        }
        self.projector.project(self.memory.tones(), input.validity, &self.largest, probability)?;
        let sample = self.memory.sample().masses().iter();
        let sample_probability =
            sample.zip(&self.largest).map(|(mass, &p)| mass * f64::from(p) / 255.0).sum();
        Ok(RoadEvidence {
            detector: "bank",
            uninformed_log_odds: UNINFORMED_LOG_ODDS_BY_COLOUR,
            sample: input.sample,
            sample_use,
            sample_probability,
            histograms: self.recent.len(),
            bank: Some(bank),
            ..RoadEvidence::default()
        })
    }

    fn know(&mut self, surfaces: &SurfaceFile) -> Result<(), RoadError> {
        self.memory.know(surfaces)
    }

    fn known_surfaces(&self) -> Option<SurfaceFile> {
        Some(self.memory.file())
    }

    fn reset(&mut self) {
        self.memory.forget();
        self.recent.clear();
    }
}
