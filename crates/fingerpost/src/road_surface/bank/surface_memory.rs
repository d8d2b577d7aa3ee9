//! The known surfaces, which of them is under way, and how a new one is founded.

use std::sync::Arc;

use fingerpost_vision::histogram::{BinCounter, Smoothing};
use fingerpost_vision::picture::Plane;

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
pub(in crate::road_surface) struct SurfaceMemory {
    pub(super) config: BankConfig,
    pub(super) tones: Tones,
    pub(super) tone: Plane<u16>,
    pub(super) counter: BinCounter,
    pub(super) smoothing: Smoothing,
    pub(super) sample: Region,
    pub(super) known: Vec<KnownSurface>,
    /// Index in `known`.
    pub(super) under_way: Option<usize>,
    unlike_frames: usize,
}

impl SurfaceMemory {
    pub(in crate::road_surface) fn new(config: &BankConfig) -> Result<Self, RoadError> {
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
    pub(in crate::road_surface) fn consider(
        &mut self,
        input: &RoadInput<'_>,
    ) -> Result<(BankEvidence, SampleUse), RoadError> {
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
    pub(in crate::road_surface) fn know(&mut self, file: &SurfaceFile) -> Result<(), RoadError> {
        self.known = file.surfaces()?;
        self.under_way = None;
        Ok(())
    }

    pub(in crate::road_surface) fn file(&self) -> SurfaceFile {
        SurfaceFile::of(&self.known)
    }

    pub(in crate::road_surface) fn forget(&mut self) {
        self.known.clear();
        (self.under_way, self.unlike_frames) = (None, 0);
    }
}
