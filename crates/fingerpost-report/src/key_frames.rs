//! The frames of a run that a person wants to see afterwards.
//!
//! [`KeyFrames::consider`] says from a frame's output and evidence alone whether the frame is wanted, so that nothing
//! is drawn in vain; [`KeyFrames::add`] draws it and keeps the pictures as JPEG. What is kept is bounded: of each
//! feature three frames, of losses the first few, and of the time in which nothing is followed an even spread that is
//! thinned as the run goes on.

use std::collections::BTreeMap;

use fingerpost::FrameOutput;
use fingerpost::track::{Decision, State, TrackEvidence};
use fingerpost_vision::picture::RgbImage;
use jpeg_encoder::{ColorType, Encoder, SamplingFactor};

use crate::ReportError;
use crate::panel::{StagePictures, compose};
use crate::scene::Scene;

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
    /// What was decided in it and what decided it.
    pub why: String,
    /// The composed picture first, then one a stage.
    pub pictures: Vec<KeyPicture>,
}

/// The key frames of a run.
#[derive(Debug, Clone)]
pub struct KeyFrames {
    kept: BTreeMap<(KeyReason, u64), KeyFrame>,
    lowest_p: BTreeMap<usize, f64>,
    losses: usize,
    spread_stride: u64,
    any_detection: bool,
    started: bool,
}

impl Default for KeyFrames {
    fn default() -> Self {
        Self::new()
    }
}

/// Losses whose pictures are kept; more of them look alike, and the page counts them all.
const MAX_LOSSES: usize = 12;
/// Spread frames that are kept while nothing has been detected: then they are all that the page can show.
const MAX_SPREAD: usize = 24;
/// Spread frames that are kept beside detections.
const MAX_SPREAD_WITH_DETECTIONS: usize = 6;
/// How much lower P(F) must be to count as weaker: smaller steps look the same and would be drawn frame after frame.
const WEAKER_BY: f64 = 0.02;
/// JPEG quality of the pictures, 1 to 100: lettering stays clean and a key frame takes about 250 kB.
const JPEG_QUALITY: u8 = 82;

impl KeyFrames {
    /// No frames yet.
    pub fn new() -> Self {
        Self {
            kept: BTreeMap::new(),
            lowest_p: BTreeMap::new(),
            losses: 0,
            spread_stride: 1,
            any_detection: false,
            started: false,
        }
    }

    /// Why the frame is wanted, if it is. To be asked once for every frame, in order.
    pub fn consider(
        &mut self,
        frame: u64,
        output: &FrameOutput,
        evidence: &TrackEvidence,
    ) -> Option<KeyReason> {
        let followed = output.track.followed.as_ref();
        let first = !std::mem::replace(&mut self.started, true);
        let reason = match (&evidence.decision, followed) {
            (Decision::Detected, Some(followed)) => {
                self.once(KeyReason::Detection { feature: followed.index })
            }
            (Decision::Arrived, Some(followed)) => self.once(KeyReason::Arrival { feature: followed.index }),
            (Decision::Lost { index }, _) => self.loss(*index),
            _ => None,
        };
        // What is detected is also the first match to be weaker than.
        let weaker = followed.filter(|_| output.track.state == State::Tracking).and_then(|followed| {
            let p = followed.matched.p?;
            let lowest = self.lowest_p.entry(followed.index).or_insert(f64::INFINITY);
            let weaker = p < *lowest - WEAKER_BY;
            *lowest = if weaker { p } else { *lowest };
            weaker.then_some(KeyReason::WeakestMatch { feature: followed.index })
        });
        self.any_detection |= matches!(reason, Some(KeyReason::Detection { .. }));
        let spread =
            (followed.is_none() && frame.is_multiple_of(self.spread_stride)).then_some(KeyReason::Spread);
        reason.or(weaker).or(first.then_some(KeyReason::FirstFrame)).or(spread)
    }

    /// Draws a wanted frame and keeps it; it takes the place of one that is no longer wanted.
    ///
    /// # Errors
    /// [`ReportError::Encode`] when a picture cannot be stored.
    pub fn add(&mut self, reason: KeyReason, scene: &Scene<'_>) -> Result<(), ReportError> {
        let mut pictures = vec![encoded(
            "composed",
            "All stages of the frame with the numbers that decided it.",
            &compose(scene),
        )?];
        for picture in StagePictures::draw(scene).pictures {
            pictures.push(encoded(picture.stage, picture.legend, &picture.picture)?);
        }
        let feature = match reason {
            KeyReason::Detection { feature }
            | KeyReason::Arrival { feature }
            | KeyReason::Loss { feature }
            | KeyReason::WeakestMatch { feature } => scene.setting.features.get(feature),
            KeyReason::FirstFrame | KeyReason::Spread => None,
        };
        let feature = feature.map_or_else(String::new, |model| {
            format!("{} {} {}", crate::palette::kind(model.kind), model.id, model.name).trim_end().to_owned()
        });
        let (frame, t_s, why) = (scene.frame, scene.t_s, scene.output.why.clone());
        self.keep(KeyFrame { frame, t_s, reason, feature, why, pictures });
        Ok(())
    }

    /// The frames that are kept, in the order of the run.
    pub fn frames(&self) -> Vec<&KeyFrame> {
        let mut frames: Vec<&KeyFrame> = self.kept.values().collect();
        frames.sort_by_key(|key| (key.frame, key.reason));
        frames
    }

    /// Losses in the run whose pictures are not kept.
    pub const fn losses_not_kept(&self) -> usize {
        self.losses.saturating_sub(MAX_LOSSES)
    }

    fn keep(&mut self, key: KeyFrame) {
        if let KeyReason::WeakestMatch { .. } = key.reason {
            self.kept.retain(|(reason, _), _| *reason != key.reason);
        }
        self.kept.insert((key.reason, key.frame), key);
        self.thin_spread();
    }

    fn once(&self, reason: KeyReason) -> Option<KeyReason> {
        (!self.kept.keys().any(|(kept, _)| *kept == reason)).then_some(reason)
    }

    fn loss(&mut self, feature: usize) -> Option<KeyReason> {
        self.losses += 1;
        (self.losses <= MAX_LOSSES).then_some(KeyReason::Loss { feature })
    }

    fn thin_spread(&mut self) {
        let limit = if self.any_detection { MAX_SPREAD_WITH_DETECTIONS } else { MAX_SPREAD };
        while self.kept.keys().filter(|(reason, _)| *reason == KeyReason::Spread).count() > limit {
            self.spread_stride *= 2;
            let stride = self.spread_stride;
            self.kept
                .retain(|&(reason, frame), _| reason != KeyReason::Spread || frame.is_multiple_of(stride));
        }
    }
}

fn encoded(stage: &'static str, legend: &'static str, picture: &RgbImage) -> Result<KeyPicture, ReportError> {
    let size_px = picture.size();
    let side = |px: usize| u16::try_from(px).unwrap_or(0);
    let mut jpeg = Vec::new();
    let mut encoder = Encoder::new(&mut jpeg, JPEG_QUALITY);
    // Halved chroma would smear coloured letters.
    encoder.set_sampling_factor(SamplingFactor::F_1_1);
    encoder
        .encode(picture.as_slice(), side(size_px.0), side(size_px.1), ColorType::Rgb)
        .map_err(|cause| ReportError::Encode { stage, cause })?;
    Ok(KeyPicture { stage, legend, jpeg, size_px })
}

#[cfg(test)]
mod tests {
    use fingerpost::matching::Match;
    use fingerpost::track::{Followed, TrackOutput};
    use nalgebra::{Isometry2, Matrix3};

    use super::*;

    fn output(state: State, p: Option<f64>) -> FrameOutput {
        let pose = Isometry2::translation(12.0, 0.0);
        let matched = |p| Match { vehicle_from_feature: pose, p: Some(p), ..Match::default() };
        let followed = p.map(|p| Followed {
            index: 2,
            vehicle_from_feature: pose,
            covariance: Matrix3::identity(),
            matched: matched(p),
        });
        FrameOutput { track: TrackOutput { state, followed, route_m: None }, ..FrameOutput::default() }
    }

    fn evidence(decision: Decision) -> TrackEvidence {
        TrackEvidence { decision, ..TrackEvidence::default() }
    }

    /// Considers a frame and keeps it without pictures where it is wanted.
    fn see(
        frames: &mut KeyFrames,
        frame: u64,
        decision: Decision,
        state: State,
        p: Option<f64>,
    ) -> Option<KeyReason> {
        let reason = frames.consider(frame, &output(state, p), &evidence(decision))?;
        let (feature, why, pictures) = (String::new(), String::new(), Vec::new());
        frames.keep(KeyFrame { frame, t_s: frame as f64, reason, feature, why, pictures });
        Some(reason)
    }

    #[test]
    fn a_feature_is_kept_when_detected_when_weakest_and_on_arrival() {
        let mut frames = KeyFrames::new();
        let not_found = || Decision::NotFound { index: 2 };
        assert_eq!(see(&mut frames, 0, not_found(), State::Searching, None), Some(KeyReason::FirstFrame));
        let tracking = [
            (Decision::Detected, 0.90, Some(KeyReason::Detection { feature: 2 })),
            (Decision::Confirmed, 0.95, None),
            (Decision::Confirmed, 0.80, Some(KeyReason::WeakestMatch { feature: 2 })),
            (Decision::Confirmed, 0.79, None),
            (Decision::Confirmed, 0.70, Some(KeyReason::WeakestMatch { feature: 2 })),
        ];
        for (frame, (decision, p, wanted)) in (1..).zip(tracking) {
            assert_eq!(see(&mut frames, frame, decision, State::Tracking, Some(p)), wanted, "frame {frame}");
        }
        let arrival = see(&mut frames, 6, Decision::Arrived, State::Arrived, Some(0.5));
        assert_eq!(arrival, Some(KeyReason::Arrival { feature: 2 }));
        let kept: Vec<u64> = frames.frames().iter().map(|key| key.frame).collect();
        assert_eq!(kept, [0, 1, 5, 6], "the weaker match took the place of the weak one");
    }

    #[test]
    fn a_run_without_detections_keeps_an_even_spread() {
        let mut frames = KeyFrames::new();
        for frame in 0..30_000 {
            see(&mut frames, frame, Decision::NotFound { index: 0 }, State::Searching, None);
        }
        let kept: Vec<u64> = frames.frames().iter().map(|key| key.frame).collect();
        assert!((MAX_SPREAD / 2..=MAX_SPREAD + 1).contains(&kept.len()), "{kept:?}");
        assert!(kept.windows(2).all(|w| w[1] - w[0] == kept[1] - kept[0]), "{kept:?}");
        assert!(kept.last().is_some_and(|&last| last > 27_000), "{kept:?}");
    }

    #[test]
    fn losses_are_kept_up_to_a_limit_and_the_rest_is_counted() {
        let mut frames = KeyFrames::new();
        let wanted = (0..20)
            .map(|frame| see(&mut frames, frame, Decision::Lost { index: 1 }, State::Lost, None))
            .filter(|reason| *reason == Some(KeyReason::Loss { feature: 1 }))
            .count();
        assert_eq!((wanted, frames.losses_not_kept()), (MAX_LOSSES, 20 - MAX_LOSSES));
    }
}
