//! The frames of a run that a person wants to see afterwards.
//!
//! [`KeyFrameChoice::consider`] says from a frame's output and evidence alone whether the frame is wanted, so that nothing
//! is drawn in vain; [`ChosenFrame::draw`] draws it while its evidence is there, and [`KeyFrames::add`] keeps the pictures
//! as JPEG, later and elsewhere if need be. What is kept is bounded: of each feature three frames, of losses the first
//! few, and of the time in which nothing is followed an even spread that is thinned as the run goes on. Where the pictures
//! of many features take too much, those of the features with the strongest matches give way.

mod choice;

use std::collections::{BTreeMap, BTreeSet};

use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};

use crate::ReportError;
use crate::panel::{StagePicture, StagePictures, compose};
use crate::scene::Scene;

pub use choice::{ChosenFrame, KeyFrameChoice};

/// Why a frame is kept; in this order where one frame has several reasons.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum KeyReason {
    /// A feature was detected for the first time.
    Detection {
        /// Index of the feature in the route.
        feature: usize,
    },
    /// The vehicle arrived at it.
    Arrival {
        /// Index of the feature in the route.
        feature: usize,
    },
    /// A followed feature was lost.
    Loss {
        /// Index of the feature in the route.
        feature: usize,
    },
    /// P(F) was the lowest so far while the feature was tracked.
    WeakestMatch {
        /// Index of the feature in the route.
        feature: usize,
    },
    /// The first frame of the run.
    FirstFrame,
    /// One of a few frames spread over the time in which nothing was followed.
    Spread,
}

impl KeyReason {
    /// Index in the route of the feature that it is about.
    fn feature(self) -> Option<usize> {
        match self {
            Self::Detection { feature }
            | Self::Arrival { feature }
            | Self::Loss { feature }
            | Self::WeakestMatch { feature } => Some(feature),
            Self::FirstFrame | Self::Spread => None,
        }
    }
}

/// One picture of a key frame.
#[derive(Debug, Clone)]
pub struct KeyPicture {
    /// Name of the stage.
    pub stage: &'static str,
    /// What is to be seen in it.
    pub legend: &'static str,
    /// The picture as JPEG.
    pub jpeg: Vec<u8>,
    /// Width and height, pixels.
    pub size_px: (usize, usize),
}

/// A frame that is kept.
#[derive(Debug, Clone)]
pub struct KeyFrame {
    /// Index of the frame in the input.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// Why it is kept.
    pub reason: KeyReason,
    /// The feature it is about: kind, number and name; empty where it is about none.
    pub feature: String,
    /// P(F) of the followed feature; none where nothing was followed or seen.
    pub match_p: Option<f64>,
    /// What was decided in it and what decided it.
    pub why: String,
    /// The composed picture first, then one a stage.
    pub pictures: Vec<KeyPicture>,
}

/// A wanted frame with its pictures, not yet made small enough to be kept.
#[derive(Debug)]
pub struct DrawnFrame {
    key: KeyFrame,
    spread_stride: u64,
    drawn: Vec<StagePicture>,
}

impl ChosenFrame {
    /// Draws the frame.
    pub fn draw(self, scene: &Scene<'_>) -> DrawnFrame {
        let Self { reason, spread_stride } = self;
        let mut drawn = vec![StagePicture {
            stage: "composed",
            legend: "All stages of the frame with the numbers that decided it.",
            picture: compose(scene),
        }];
        drawn.extend(StagePictures::draw(scene).pictures);
        let feature = reason.feature().and_then(|feature| scene.setting.features.get(feature));
        let feature = feature.map_or_else(String::new, |model| {
            format!("{} {} {}", crate::palette::kind(model.kind), model.id, model.name).trim_end().to_owned()
        });
        let match_p = scene.output.track.followed.as_ref().and_then(|followed| followed.matched.p);
        let (frame, t_s, why) = (scene.frame, scene.t_s, scene.output.why.clone());
        let key = KeyFrame { frame, t_s, reason, feature, match_p, why, pictures: Vec::new() };
        DrawnFrame { key, spread_stride, drawn }
    }
}

/// The key frames of a run.
#[derive(Debug, Clone, Default)]
pub struct KeyFrames {
    kept: BTreeMap<(KeyReason, u64), KeyFrame>,
    features_left_out: BTreeSet<usize>,
}

/// Bytes that all pictures together may take: as text in a page a third more, which browsers still open at once and mail
/// still takes.
const MAX_PICTURE_BYTES: usize = 12 << 20;

/// JPEG quality of the pictures, 1 to 100: lettering stays clean and a key frame takes about 250 kB.
const JPEG_QUALITY: u8 = 82;

impl KeyFrames {
    /// Keeps a frame; it takes the place of those that are no longer wanted. To be given in the order of the run.
    ///
    /// # Errors
    /// [`ReportError::Encode`] when a picture cannot be stored.
    pub fn add(&mut self, frame: DrawnFrame) -> Result<(), ReportError> {
        let DrawnFrame { mut key, spread_stride, drawn } = frame;
        key.pictures = drawn.iter().map(encoded).collect::<Result<_, _>>()?;
        self.keep(key, spread_stride);
        Ok(())
    }

    /// The frames that are kept, in the order of the run.
    pub fn frames(&self) -> Vec<&KeyFrame> {
        let mut frames: Vec<&KeyFrame> = self.kept.values().collect();
        frames.sort_by_key(|key| (key.frame, key.reason));
        frames
    }

    /// Number of features whose frames gave way to those of others.
    pub(crate) fn features_left_out(&self) -> usize {
        self.features_left_out.len()
    }

    fn keep(&mut self, key: KeyFrame, spread_stride: u64) {
        let newest = key.reason.feature();
        if let KeyReason::WeakestMatch { .. } = key.reason {
            self.kept.retain(|(reason, _), _| *reason != key.reason);
        }
        self.kept.insert((key.reason, key.frame), key);
        self.kept
            .retain(|&(reason, frame), _| reason != KeyReason::Spread || frame.is_multiple_of(spread_stride));
        self.features_left_out.retain(|feature| Some(*feature) != newest);
        while self.picture_bytes() > MAX_PICTURE_BYTES {
            let Some(strongest) = self.strongest_match(newest) else { break };
            // Losses are few and say most.
            let stays = |reason: KeyReason| {
                matches!(reason, KeyReason::Loss { .. }) || reason.feature() != Some(strongest)
            };
            self.kept.retain(|&(reason, _), _| stays(reason));
            self.features_left_out.insert(strongest);
        }
    }

    fn picture_bytes(&self) -> usize {
        self.kept.values().flat_map(|key| &key.pictures).map(|picture| picture.jpeg.len()).sum()
    }

    /// The feature whose weakest match in the kept frames is the strongest of all; `newest` is still followed.
    fn strongest_match(&self, newest: Option<usize>) -> Option<usize> {
        let mut weakest: BTreeMap<usize, f64> = BTreeMap::new();
        for (&(reason, _), key) in &self.kept {
            let feature = reason.feature().filter(|_| !matches!(reason, KeyReason::Loss { .. }));
            if let Some(feature) = feature.filter(|feature| Some(*feature) != newest) {
                let weakest = weakest.entry(feature).or_insert(f64::INFINITY);
                *weakest = key.match_p.map_or(*weakest, |p| weakest.min(p));
            }
        }
        weakest.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(feature, _)| feature)
    }
}

fn encoded(drawn: &StagePicture) -> Result<KeyPicture, ReportError> {
    let StagePicture { stage, legend, ref picture } = *drawn;
    // Halved chroma would smear coloured letters.
    let jpeg = jpeg_file(picture, JPEG_QUALITY, ChromaSampling::Full)
        .map_err(|cause| ReportError::Encode { stage, cause })?;
    Ok(KeyPicture { stage, legend, jpeg, size_px: picture.size() })
}
