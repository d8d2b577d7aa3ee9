//! A bank of known surfaces: the road is what looks like any of them.
//!
//! Paper 2, section 7.4. A rolling mean of the road just ahead loses the road for a moment where its surface changes. So every
//! surface that the road has had is kept as a histogram of brightness and tint (`bank/tones.rs`), learned on the drive or read from
//! a file; each is back-projected as in the papers, and a pixel's probability is the largest of all, that of the rolling mean
//! among them. The surface under way has a name.
//!
//! A sample that is like none of them founds a new surface when that lasts some frames of straight driving: in a turn the
//! region straight ahead may lie on the verge. The bank is bounded; the surface that has not been met for longest gives way.
//!
//! Limits: the more surfaces are known, the more of what lies beside the road looks like one; those long not met count less.
//! Brightness depends on the camera's exposure: a surface in another light is another surface.

mod known;
mod surface_memory;
mod tones;

use std::collections::VecDeque;
use std::sync::Arc;

use fingerpost_vision::backprojection::{BackProjector, ratio_lookup};
use fingerpost_vision::histogram::Histogram;
use fingerpost_vision::picture::{Plane, Rect};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::region::Region;
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput, SampleUse};
use known::KnownSurface;
use tones::TONES;

pub use known::{SurfaceFile, SurfaceRecord, SurfacesError};
pub(super) use surface_memory::SurfaceMemory;

/// Settings of the bank of known surfaces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BankConfig {
    /// Surfaces that are kept at the most.
    #[schemars(range(min = 1, max = 64))]
    pub surfaces: usize,
    /// Likeness (Bhattacharyya coefficient) from which a sample is of a known surface.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub min_likeness: f64,
    /// Frames of straight driving over which a sample must be like no known surface before it founds a new one.
    #[schemars(range(min = 1, max = 1000))]
    pub patience_frames: usize,
    /// Curvature of the vehicle's way from which it counts as turning, 1/m.
    #[schemars(range(min = 0.0, max = 1000.0))]
    pub turning_per_m: f64,
    /// Frames in the rolling mean (paper 1, IV-B).
    #[schemars(range(min = 1, max = 1000))]
    pub frames: usize,
    /// Share of the picture expected to be road.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub prior: f64,
    /// What a surface counts that has not been met for long.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub stale_weight: f64,
    /// Frames since a surface was met after which it has come half way to that.
    #[schemars(range(min = 1.0, max = 1000000000.0))]
    pub stale_frames: f64,
    /// Radius of the disc of the back-projection, pixels; 0 for none.
    #[schemars(range(min = 0, max = 32))]
    pub disc_radius_px: u16,
}

impl Default for BankConfig {
    fn default() -> Self {
        Self {
            surfaces: 8,
            min_likeness: 0.6,
            patience_frames: 4,
            // A radius of 25 m.
            turning_per_m: 0.04,
            frames: 5,
            prior: 0.8,
            stale_weight: 0.7,
            stale_frames: 100.0,
            disc_radius_px: 2,
        }
    }
}

/// Which surface is under way, by the bank.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BankEvidence {
    /// The known surface that the sample is most like; none where nothing is known or seen.
    pub surface: Option<Arc<str>>,
    /// How like it is, 0 to 1.
    pub likeness: f64,
    /// Surfaces known.
    pub surfaces: usize,
    /// Whether this frame founded a new one.
    pub founded: bool,
    /// Share of the picture that some surface gives a probability of at least a half, and the share of that at which the one
    /// under way gives the largest; 0 where the bank only names the surface.
    pub road_share: f64,
    /// See `road_share`.
    pub won_share: f64,
}

/// The detector by known surfaces.
#[derive(Debug)]
pub struct Bank {
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
            memory: SurfaceMemory::new(config)?,
            projector: BackProjector::new(config.disc_radius_px)?,
            recent: VecDeque::new(),
            mean: Histogram::new(TONES)?,
            whole: Region::new(TONES)?,
            of_one: Vec::new(),
            largest: Vec::new(),
        })
    }

    /// Takes the frame's sample into the rolling mean.
    fn roll(&mut self) -> Result<(), RoadError> {
        let full = self.recent.len() >= self.memory.config.frames.max(1);
        let mut recent = if full { self.recent.pop_front() } else { None }
            .unwrap_or_else(|| self.memory.sample.histogram.clone());
        recent.clone_from(&self.memory.sample.histogram);
        self.recent.push_back(recent);
        Ok(self.mean.set_to_mean(&self.recent)?)
    }

    /// Sets the largest probability of every tone; the share of the picture that is road by it, and the share of that at which
    /// the surface under way wins.
    fn tabulate(&mut self) -> Result<(f64, f64), RoadError> {
        let Self { memory, mean, whole: Region { histogram: whole, .. }, of_one, largest, recent, .. } = self;
        let config = &memory.config;
        largest.clear();
        largest.resize(TONES.count(), 0);
        let under_way =
            memory.under_way.and_then(|index| memory.known.get(index)).map(|known| &known.histogram);
        if let Some(histogram) = under_way {
            ratio_lookup(histogram, whole, config.prior, largest)?;
        }
        let masses = whole.masses();
        let share = |lookup: &[u8]| -> f64 {
            masses.iter().zip(lookup).filter(|(_, p)| **p >= 128).map(|(mass, _)| mass).sum()
        };
        let won = share(largest);
        let weight = |known: &KnownSurface| {
            let age = known.unseen_frames as f64 / config.stale_frames.max(1e-9);
            config.stale_weight + (1.0 - config.stale_weight) / (1.0 + age)
        };
        let others = memory.known.iter().map(|known| (&known.histogram, weight(known)));
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
        let everything = Rect { x: 0, y: 0, width, height };
        let SurfaceMemory { tones, tone, counter, smoothing, .. } = &mut self.memory;
        tones.make(input.picture, everything, tone);
        self.whole.measure(everything, tone.view(), input.validity, counter, smoothing)?;
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
        self.projector.project(&self.memory.tone, input.validity, &self.largest, probability)?;
        let sample = self.memory.sample.histogram.masses().iter();
        let sample_probability =
            sample.zip(&self.largest).map(|(mass, &p)| mass * f64::from(p) / 255.0).sum();
        Ok(RoadEvidence {
            detector: "bank",
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
