//! What the drive itself shows of its road: colours where they tell it, and elsewhere the way that leads from the vehicle.
//!
//! Back-projection tells road from verge to the pixel where their colours differ, and knows nothing where both are grey. How
//! much it knows it says itself: the odds that it gives to the road just ahead, over those of any place of the view. Where
//! these are high, in the mean of the last frames, it decides. Elsewhere the classifier that is trained as the drive goes
//! does: it knows where the road leads, but works on a reduced picture and lets go of the road slowly, so that edges seen
//! from above are soft; the colours of what it found to be road, and of what it did not, sharpen them ([`RoadColours`]). In a
//! camera picture, where nothing is enlarged, the classifier stands alone.

use fingerpost_vision::fusion::fuse;
use fingerpost_vision::picture::Plane;

use super::colours::RoadColours;
use super::perspective::clear_unseen;
use super::{
    Backprojection, BackprojectionConfig, Online, Perspective, RoadDetector, RoadError, RoadEvidence,
    RoadInput, SampleUse,
};

/// Doubt about the classifier, of 255: a quarter of what it is sure of may be wrong, so that clear colours outvote it.
const DOUBT: u8 = 64;

/// Logarithm of the odds above which colours alone decide: 4 to 1 over any place of the view.
const COLOURS_TELL: f64 = 1.39;
/// Weight of a frame in the mean of the odds: about a second of a camera at ten frames a second.
const FRAME_SHARE: f64 = 0.1;
/// While colours decide the classifier is trained in every so many-th frame, to be ready when they no longer do.
const TRAINED_EVERY: u64 = 5;

/// Back-projection, and the classifier with the colours of what it finds.
pub(super) struct Appearance {
    by_sample: Backprojection,
    prior: f64,
    /// Running mean of the logarithm of the odds of the road just ahead over those of any place; none before the first frame.
    sample_log_odds: Option<f64>,
    frames: u64,
    classifier: Online,
    colours: RoadColours,
    by_way: Plane<u8>,
    by_colour: Vec<u8>,
}

impl Appearance {
    pub(super) fn new(classifier: Online, config: &BackprojectionConfig) -> Result<Self, RoadError> {
        Ok(Self {
            by_sample: Backprojection::new(config)?,
            prior: config.prior,
            sample_log_odds: None,
            frames: 0,
            classifier,
            colours: RoadColours::new(config.bins()),
            by_way: Plane::default(),
            by_colour: Vec::new(),
        })
    }

    /// Whether colours tell the road, by what back-projection says of the sample.
    fn colours_tell(&mut self, evidence: &RoadEvidence) -> bool {
        if evidence.sample_use == SampleUse::Unseen {
            return self.sample_log_odds.is_some_and(|mean| mean >= COLOURS_TELL);
        }
        let log_odds = |p: f64| libm::log(p / (1.0 - p));
        // A probability of 8 bits is never quite 1.
        let now = log_odds(evidence.sample_probability.clamp(0.002, 0.998))
            - log_odds(self.prior.clamp(0.002, 0.998));
        let mean = self.sample_log_odds.map_or(now, |mean| mean + FRAME_SHARE * (now - mean));
        self.sample_log_odds = Some(mean);
        mean >= COLOURS_TELL
    }

    /// Writes the classifier's surface, sharpened by the colours of what it found.
    fn sharpen(&mut self, input: RoadInput<'_>, probability: &mut Plane<u8>) -> Result<(), RoadError> {
        self.colours.learn(input.picture, input.validity, &self.by_way);
        let (width, height) = self.by_way.size();
        if probability.size() != (width, height) {
            probability.reset(width, height, 0);
        }
        clear_unseen(input.validity, probability);
        for row in 0..height {
            let (bins, greys) = (input.picture.bin.row(row), input.picture.grey.row(row));
            let (way, fused) = (self.by_way.row(row), probability.row_mut(row));
            for run in input.validity.runs(row) {
                let pixels = run.start..run.end;
                let by_colour = &mut self.by_colour[pixels.clone()];
                self.colours.read(&bins[pixels.clone()], &greys[pixels.clone()], by_colour);
                fuse(&way[pixels.clone()], by_colour, DOUBT, &mut fused[pixels])?;
            }
        }
        Ok(())
    }
}

impl RoadDetector for Appearance {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let Perspective::Ground { .. } = input.perspective else {
            return self.classifier.estimate(input, probability);
        };
        if self.by_way.size() != input.validity.size() {
            let (width, height) = input.validity.size();
            self.by_way.reset(width, height, 0);
            self.by_colour.resize(width, 0);
        }
        let by_sample = self.by_sample.learn_from(input)?;
        let tell = self.colours_tell(&by_sample);
        let trains = self.frames.is_multiple_of(TRAINED_EVERY);
        self.frames += 1;
        if tell {
            self.by_sample.project(input, probability)?;
            let online = if trains { self.classifier.learn_from(input)?.online } else { None };
            return Ok(RoadEvidence { online, ..by_sample });
        }
        let by_way = self.classifier.estimate(input, &mut self.by_way)?;
        self.sharpen(input, probability)?;
        Ok(RoadEvidence { histograms: by_sample.histograms, ..by_way })
    }

    fn reset(&mut self) {
        self.by_sample.reset();
        self.sample_log_odds = None;
        self.frames = 0;
        self.classifier.reset();
        self.colours.forget();
    }
}
