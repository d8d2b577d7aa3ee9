//! The known surfaces, which of them is under way, and how a new one is founded.

use std::sync::Arc;

use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::histogram::{BinCounter, Histogram, Smoothing};
use fingerpost_vision::picture::{Plane, Rect};

use super::known::{KnownSurface, likeness, name_of};
use super::tones::{TONES, Tones};
use super::{BankConfig, BankEvidence, SurfaceFile};
use crate::road_surface::region::Region;
use crate::road_surface::{RoadError, RoadInput, SampleUse};

/// Standard deviation of the histograms' smoothing along brightness, bins of 8 grey levels: the noise of a camera.
const SMOOTHING_BINS: f64 = 1.2;
/// Share of a new sample in a surface's histogram once it has been learned from many frames.
const LEAST_SHARE: f64 = 0.05;

/// The known surfaces and which of them is under way.
#[derive(Debug)]
pub struct SurfaceMemory {
    config: BankConfig,
    tones: Tones,
    tone: Plane<u16>,
    counter: BinCounter,
    smoothing: Smoothing,
    sample: Region,
    known: Vec<KnownSurface>,
    /// Index in `known`.
    under_way: Option<usize>,
    unlike_frames: usize,
}

impl SurfaceMemory {
    /// Bins of the surfaces' histograms: brightness in the place of hue, tint in that of saturation.
    pub const TONES: HueSaturationBins = TONES;

    /// No surface is known yet.
    ///
    /// # Errors
    /// [`RoadError::Histogram`] when the histograms cannot be made.
    pub fn new(config: &BankConfig) -> Result<Self, RoadError> {
        Ok(Self {
            config: config.clone(),
            tones: Tones::new(),
            tone: Plane::default(),
            counter: BinCounter::default(),
            smoothing: Smoothing::new(TONES, SMOOTHING_BINS, 0.0)?,
            sample: Region::new(TONES)?,
            known: Vec::new(),
            under_way: None,
            unlike_frames: 0,
        })
    }

    /// Looks at the sample: names its surface, learns from it, or founds a new one.
    ///
    /// # Errors
    /// [`RoadError`] when picture and validity do not fit together.
    pub fn consider(&mut self, input: &RoadInput<'_>) -> Result<(BankEvidence, SampleUse), RoadError> {
        self.known.iter_mut().for_each(|known| known.unseen_frames = known.unseen_frames.saturating_add(1));
        self.tones.make(input.picture, input.sample, &mut self.tone);
        let tone = self.tone.view();
        self.sample.measure(input.sample, tone, input.validity, &mut self.counter, &mut self.smoothing)?;
        let mut founded = false;
        let mut sample_use = SampleUse::Unseen;
        if self.sample.is_seen() {
            let best = self.most_alike();
            sample_use = match best.filter(|(_, likeness)| *likeness >= self.config.min_likeness) {
                Some((index, _)) => {
                    self.unlike_frames = 0;
                    self.learn(index);
                    SampleUse::Learned
                }
                None => {
                    // What a turning vehicle has straight ahead of it may be the verge.
                    self.unlike_frames = if self.is_turning(input) { 0 } else { self.unlike_frames + 1 };
                    founded = self.known.is_empty() || self.unlike_frames >= self.config.patience_frames;
                    if founded {
                        self.found();
                        SampleUse::SurfaceChanged
                    } else {
                        SampleUse::LeftOut
                    }
                }
            };
        }
        let surface = self.under_way.and_then(|index| self.known.get(index));
        let evidence = BankEvidence {
            surface: surface.map(|surface| Arc::clone(&surface.name)),
            likeness: surface.map_or(0.0, |surface| likeness(&surface.histogram, &self.sample.histogram)),
            surfaces: self.known.len(),
            founded,
            ..BankEvidence::default()
        };
        Ok((evidence, sample_use))
    }

    /// Makes tones of the whole picture and measures what is seen of them into `whole`.
    ///
    /// # Errors
    /// [`RoadError`] when picture and validity do not fit together.
    pub fn measure_all(&mut self, input: &RoadInput<'_>, whole: &mut Region) -> Result<(), RoadError> {
        let (width, height) = input.picture.bin.size();
        let everything = Rect { x: 0, y: 0, width, height };
        self.tones.make(input.picture, everything, &mut self.tone);
        let tone = self.tone.view();
        whole.measure(everything, tone, input.validity, &mut self.counter, &mut self.smoothing)
    }

    /// Tone of every pixel, as far as it was made: of the sample, or of the whole picture.
    pub const fn tones(&self) -> &Plane<u16> {
        &self.tone
    }

    /// Histogram of the last sample, of mass 1; empty where nothing of it was seen.
    pub const fn sample(&self) -> &Histogram {
        &self.sample.histogram
    }

    /// Histogram of the surface under way, of mass 1.
    pub fn under_way(&self) -> Option<&Histogram> {
        self.under_way.and_then(|index| self.known.get(index)).map(|known| &known.histogram)
    }

    /// The known surfaces: histogram, of mass 1, and frames since each was last under way.
    pub fn known(&self) -> impl Iterator<Item = (&Histogram, u64)> {
        self.known.iter().map(|known| (&known.histogram, known.unseen_frames))
    }

    fn most_alike(&self) -> Option<(usize, f64)> {
        let alike =
            self.known.iter().map(|known| likeness(&known.histogram, &self.sample.histogram)).enumerate();
        alike.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    fn is_turning(&self, input: &RoadInput<'_>) -> bool {
        input.motion.is_some_and(|motion| {
            let moved = &motion.previous_from_current;
            let turned_rad = moved.rotation.angle().abs();
            turned_rad > self.config.turning_per_m * moved.translation.vector.norm()
        })
    }

    fn learn(&mut self, index: usize) {
        self.under_way = Some(index);
        if let Some(known) = self.known.get_mut(index) {
            known.frames = known.frames.saturating_add(1);
            known.unseen_frames = 0;
            known.histogram.blend(&self.sample.histogram, (1.0 / known.frames as f64).max(LEAST_SHARE));
        }
    }

    fn found(&mut self) {
        self.unlike_frames = 0;
        let longest = self
            .known
            .iter()
            .enumerate()
            .max_by_key(|(_, known)| known.unseen_frames)
            .map(|(index, _)| index);
        if let Some(longest) = longest.filter(|_| self.known.len() >= self.config.surfaces.max(1)) {
            self.known.remove(longest);
        }
        let kind = name_of(&self.sample.histogram);
        let named = |name: &str| self.known.iter().any(|known| &*known.name == name);
        let numbered = (2..).map(|number| format!("{kind} {number}")).find(|name| !named(name));
        let name = if named(kind) { numbered.unwrap_or_default() } else { kind.to_owned() };
        let histogram = self.sample.histogram.clone();
        self.known.push(KnownSurface { name: name.into(), histogram, frames: 1, unseen_frames: 0 });
        self.under_way = Some(self.known.len() - 1);
    }

    /// Takes surfaces over from a file, in place of what was learned.
    ///
    /// # Errors
    /// [`RoadError::Surfaces`] when they cannot be used.
    pub fn know(&mut self, file: &SurfaceFile) -> Result<(), RoadError> {
        self.known = file.surfaces()?;
        self.under_way = None;
        Ok(())
    }

    /// The known surfaces as a file has them.
    pub fn file(&self) -> SurfaceFile {
        SurfaceFile::of(&self.known)
    }

    /// Forgets all surfaces, as at the start of a drive.
    pub fn forget(&mut self) {
        self.known.clear();
        (self.under_way, self.unlike_frames) = (None, 0);
    }
}
