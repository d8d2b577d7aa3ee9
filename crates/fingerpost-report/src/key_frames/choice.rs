//! Which frames are wanted.

use std::collections::{BTreeMap, BTreeSet};

use fingerpost::FrameOutput;
use fingerpost::track::{Decision, State, TrackEvidence};

use super::KeyReason;

/// Losses whose pictures are kept; more of them look alike, and the page counts them all.
pub(crate) const MAX_LOSSES: usize = 12;
/// Spread frames that are kept while nothing has been detected: then they are all that the page can show.
const MAX_SPREAD: usize = 12;
/// Spread frames that are kept beside detections.
const MAX_SPREAD_WITH_DETECTIONS: usize = 6;
/// How much lower P(F) must be to count as weaker: smaller steps look the same and would be drawn frame after frame.
const WEAKER_BY: f64 = 0.02;

/// Chooses the frames that are kept, knowing what it chose before.
#[derive(Debug, Clone)]
pub struct KeyFrameChoice {
    once: BTreeSet<KeyReason>,
    lowest_p: BTreeMap<usize, f64>,
    losses: usize,
    spread: Vec<u64>,
    spread_stride: u64,
    any_detection: bool,
    started: bool,
}

/// A frame that is wanted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ChosenFrame {
    /// Why.
    pub reason: KeyReason,
    /// Spread frames that are no multiple of it are no longer wanted.
    pub(super) spread_stride: u64,
}

impl KeyFrameChoice {
    /// Nothing chosen yet, for a run of about `frames` frames. Where that is not known, frames are chosen that the spread
    /// of a longer run has no use for.
    pub fn new(frames: Option<u64>) -> Self {
        let stride = frames.unwrap_or(0).div_ceil(MAX_SPREAD as u64).next_power_of_two();
        Self {
            once: BTreeSet::new(),
            lowest_p: BTreeMap::new(),
            losses: 0,
            spread: Vec::new(),
            spread_stride: stride,
            any_detection: false,
            started: false,
        }
    }

    /// Whether and why the frame is wanted. To be asked once for every frame, in order.
    pub fn consider(
        &mut self,
        frame: u64,
        output: &FrameOutput,
        evidence: &TrackEvidence,
    ) -> Option<ChosenFrame> {
        let followed = output.track.followed.as_ref();
        let first = !std::mem::replace(&mut self.started, true);
        let reason = match (&evidence.decision, followed) {
            (Decision::Detected, Some(followed)) => {
                self.once(KeyReason::Detection { feature: followed.index })
            }
            (Decision::Arrived, Some(followed)) => self.once(KeyReason::Arrival { feature: followed.index }),
            (Decision::NoLongerSure { index, .. }, _) => self.loss(*index),
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
        let reason = reason.or(weaker).or(first.then_some(KeyReason::FirstFrame)).or(spread)?;
        if reason == KeyReason::Spread {
            self.spread.push(frame);
        }
        self.thin_spread();
        Some(ChosenFrame { reason, spread_stride: self.spread_stride })
    }

    fn once(&mut self, reason: KeyReason) -> Option<KeyReason> {
        self.once.insert(reason).then_some(reason)
    }

    fn loss(&mut self, feature: usize) -> Option<KeyReason> {
        self.losses += 1;
        (self.losses <= MAX_LOSSES).then_some(KeyReason::Loss { feature })
    }

    fn thin_spread(&mut self) {
        let limit = if self.any_detection { MAX_SPREAD_WITH_DETECTIONS } else { MAX_SPREAD };
        while self.spread.len() > limit {
            self.spread_stride *= 2;
            let stride = self.spread_stride;
            self.spread.retain(|frame| frame.is_multiple_of(stride));
        }
    }
}

#[cfg(test)]
mod tests {
    use fingerpost::matching::Match;
    use fingerpost::track::{Followed, Lack, TrackOutput};
    use nalgebra::{Isometry2, Matrix3};

    use super::super::{KeyFrame, KeyFrames, KeyPicture, MAX_PICTURE_BYTES};
    use super::*;

    fn output(index: usize, state: State, p: Option<f64>) -> FrameOutput {
        let pose = Isometry2::translation(12.0, 0.0);
        let matched = |p| Match { vehicle_from_feature: pose, p: Some(p), ..Match::default() };
        let followed = p.map(|p| Followed {
            index,
            vehicle_from_feature: pose,
            covariance: Matrix3::identity(),
            present: 0.9,
            present_by_sight: 0.9,
            matched: matched(p),
        });
        FrameOutput {
            track: TrackOutput { state, followed, ..TrackOutput::default() },
            ..FrameOutput::default()
        }
    }

    fn evidence(decision: Decision) -> TrackEvidence {
        TrackEvidence { decision, ..TrackEvidence::default() }
    }

    /// Pictures that there is room for.
    const PICTURES: usize = 20;

    /// A choice and what is kept of it.
    struct Chosen(KeyFrameChoice, KeyFrames);

    impl Chosen {
        fn of(frames: Option<u64>) -> Self {
            Self(KeyFrameChoice::new(frames), KeyFrames::default())
        }

        fn see(&mut self, frame: u64, decision: Decision, state: State, p: Option<f64>) -> Option<KeyReason> {
            self.see_feature(frame, 2, decision, state, p)
        }

        fn see_feature(
            &mut self,
            frame: u64,
            index: usize,
            decision: Decision,
            state: State,
            p: Option<f64>,
        ) -> Option<KeyReason> {
            let chosen = self.0.consider(frame, &output(index, state, p), &evidence(decision))?;
            let (reason, t_s) = (chosen.reason, frame as f64);
            let (feature, why) = (String::new(), String::new());
            let jpeg = vec![0; MAX_PICTURE_BYTES / PICTURES];
            let pictures = vec![KeyPicture { stage: "", legend: "", jpeg, size_px: (1, 1) }];
            let key = KeyFrame { frame, t_s, reason, feature, match_p: p, why, pictures };
            self.1.keep(key, chosen.spread_stride);
            Some(reason)
        }

        fn kept(&self) -> Vec<u64> {
            self.1.frames().iter().map(|key| key.frame).collect()
        }
    }

    #[test]
    fn a_feature_is_kept_when_detected_when_weakest_and_on_arrival() {
        let mut frames = Chosen::of(None);
        let not_found = || Decision::NotFound { index: 2, places: 33 };
        assert_eq!(frames.see(0, not_found(), State::Searching, None), Some(KeyReason::FirstFrame));
        let tracking = [
            (Decision::Detected, 0.90, Some(KeyReason::Detection { feature: 2 })),
            (Decision::Confirmed, 0.95, None),
            (Decision::Confirmed, 0.80, Some(KeyReason::WeakestMatch { feature: 2 })),
            (Decision::Confirmed, 0.79, None),
            (Decision::Confirmed, 0.70, Some(KeyReason::WeakestMatch { feature: 2 })),
        ];
        for (frame, (decision, p, wanted)) in (1..).zip(tracking) {
            assert_eq!(frames.see(frame, decision, State::Tracking, Some(p)), wanted, "frame {frame}");
        }
        let arrival = frames.see(6, Decision::Arrived, State::Arrived, Some(0.5));
        assert_eq!(arrival, Some(KeyReason::Arrival { feature: 2 }));
        assert_eq!(frames.kept(), [0, 1, 5, 6], "the weaker match took the place of the weak one");
    }

    #[test]
    fn a_run_without_detections_keeps_an_even_spread() {
        let mut frames = Chosen::of(None);
        for frame in 0..30_000 {
            frames.see(frame, Decision::NotFound { index: 0, places: 33 }, State::Searching, None);
        }
        let kept = frames.kept();
        assert!((MAX_SPREAD / 2..=MAX_SPREAD + 1).contains(&kept.len()), "{kept:?}");
        assert!(kept.windows(2).all(|w| w[1] - w[0] == kept[1] - kept[0]), "{kept:?}");
        assert!(kept.last().is_some_and(|&last| last > 27_000), "{kept:?}");
    }

    #[test]
    fn losses_are_kept_up_to_a_limit() {
        let mut frames = Chosen::of(None);
        let lack = Lack::Presence { present: 0.3, needed: 0.5 };
        let lost = Decision::NoLongerSure { index: 1, lack };
        let wanted = (0..20)
            .map(|frame| frames.see(frame, lost.clone(), State::Lost, None))
            .filter(|reason| *reason == Some(KeyReason::Loss { feature: 1 }))
            .count();
        assert_eq!(wanted, MAX_LOSSES);
    }

    #[test]
    fn a_run_of_known_length_draws_no_frame_in_vain() {
        let mut frames = Chosen::of(Some(30_000));
        let drawn = (0..30_000)
            .filter(|&frame| {
                frames
                    .see(frame, Decision::NotFound { index: 0, places: 33 }, State::Searching, None)
                    .is_some()
            })
            .count();
        assert_eq!(drawn, frames.kept().len());
        assert!((MAX_SPREAD / 2..=MAX_SPREAD + 1).contains(&drawn), "{drawn}");
    }

    #[test]
    fn of_many_features_those_with_the_weakest_matches_are_kept() {
        let mut frames = Chosen::of(None);
        let features = 60;
        // Every tenth is matched worse.
        let match_p = |feature: usize| if feature.is_multiple_of(10) { 0.6 } else { 0.9 };
        for feature in 0..features {
            let p = Some(match_p(feature));
            let first = 2 * feature as u64;
            frames.see_feature(first, feature, Decision::Detected, State::Tracking, p);
            frames.see_feature(first + 1, feature, Decision::Arrived, State::Arrived, p);
        }
        let kept: BTreeSet<usize> = frames.1.frames().iter().filter_map(|key| key.reason.feature()).collect();
        assert!((0..features).step_by(10).all(|weak| kept.contains(&weak)), "{kept:?}");
        assert!(kept.contains(&(features - 1)), "the last one may still become weaker: {kept:?}");
        assert_eq!(kept.len() + frames.1.features_left_out(), features);
        assert!(frames.1.picture_bytes() <= MAX_PICTURE_BYTES);
    }
}
