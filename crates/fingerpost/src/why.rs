//! The sentence that says what was decided in a frame and what decided it: of the route's feature, then of the lane.

use std::fmt::{self, Display, Formatter, Write};

use fingerpost_map::FeatureKind;

use crate::feature_masks::SubMaskKind;
use crate::lanes::departure::{DepartureOutput, Silence};
use crate::lanes::{Lane, LaneEvidence, Side};
use crate::matching::{Match, Participation};
use crate::mount::{MountAngle, MountEstimate, MountFault};
use crate::track::{Decision, Missing, RouteStop, State, TrackConfig, TrackEvidence, TrackOutput};

/// Name of a kind of feature as a sentence has it.
fn kind_name(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Junction => "junction",
        FeatureKind::SideRoad => "side road",
        FeatureKind::Bend => "bend",
    }
}

/// What was decided in a frame and what decided it, as one sentence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Why<'a> {
    /// What the tracker says.
    pub(crate) track: &'a TrackOutput,
    /// How it came to that.
    pub(crate) evidence: &'a TrackEvidence,
    /// The features of the route.
    pub(crate) stops: &'a [RouteStop],
    /// The thresholds.
    pub(crate) config: &'a TrackConfig,
    /// The camera's mount, where it is estimated.
    pub(crate) mount: Option<&'a MountEstimate>,
    /// The lane and how it was found, where it is looked for.
    pub(crate) lane: Option<(&'a Lane, &'a LaneEvidence)>,
    /// Whether no lane is looked for because the vehicle turns through a junction.
    pub(crate) turns_through: bool,
    /// How the vehicle moves towards the lane's edges, where that is known.
    pub(crate) departure: Option<&'a DepartureOutput>,
}

impl Why<'_> {
    /// Writes the sentence in place of what `text` was, reusing its memory.
    pub(crate) fn write_to(self, text: &mut String) {
        text.clear();
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
    }
}

impl Display for Why<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(fault) = self.mount.and_then(|mount| mount.fault.as_ref()) {
            write!(f, "{}; ", MountFaultWords(fault))?;
        }
        self.write_feature(f)?;
        if self.turns_through {
            f.write_str("; no lane is claimed while the vehicle turns through the junction")?;
        }
        let Some((lane, evidence)) = self.lane else { return Ok(()) };
        let kept_frames = Side::BOTH.map(|side| lane.edge(side).map(|edge| edge.kept_frames));
        write!(f, "; {}", LaneWords { kept_frames, followed: evidence.followed })?;
        self.departure.map_or(Ok(()), |departure| write!(f, "{}", DepartureWords(departure)))
    }
}

impl Why<'_> {
    fn write_feature(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { track, evidence, stops, config, .. } = *self;
        let name = |index: &usize| FeatureName(stops.get(*index));
        let needed_p = evidence.needed_p;
        match (&evidence.decision, &track.followed) {
            (Decision::NoRoute, _) => {
                f.write_str("no route: nothing is looked for but the road, its lanes and the motion")
            }
            (Decision::RouteDone, _) => f.write_str(ROUTE_DONE),
            (Decision::NotInReach { index, ahead_m }, _) => {
                write!(f, "{} is believed {}, out of the view's reach", name(index), Along(*ahead_m))
            }
            (Decision::NotFound { index }, _) if evidence.tried == 0 => {
                write!(f, "{} is not in reach of the view", name(index))
            }
            (Decision::NotFound { index }, _) => {
                write!(f, "{} not seen: ", name(index))?;
                match &evidence.sought {
                    Some(sought) => write!(f, "at the best place {}", MatchWords(&sought.matched, needed_p))?,
                    None => f.write_str("no arm that would tell it is in view")?,
                }
                write!(f, ", {} places tried", evidence.tried)
            }
            (Decision::Candidate { index, frames, p, missing }, _) => write!(
                f,
                "{} may be ahead: P(F) {p:.2} in {}, {}",
                name(index),
                Frames(*frames),
                MissingWords(missing)
            ),
            (Decision::Dropped { index, frames, most_frames }, _) => write!(
                f,
                "{} given up as a candidate: {} without a sure place, at most {most_frames} are waited for",
                name(index),
                Frames(*frames)
            ),
            (Decision::NoVergeInView { index, p, needed_p }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2}, {needed_p:.2} is needed where no verge is in view",
                name(index)
            ),
            (Decision::NotExpected { index, p, surprise, most }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2}, but it is expected elsewhere by a loss of {surprise:.2}, less than {most:.2} is needed \
                 where no verge is in view",
                name(index)
            ),
            (Decision::OffApproach { index, p, beside_m, most_m }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2} at the best place, but the vehicle would be {beside_m:.1} m beside its approach, at most \
                 {most_m:.1} m are possible",
                name(index)
            ),
            (Decision::Unbounded { index, p }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2}, but no arm that tells it shows an edge of its road or a verge",
                name(index)
            ),
            (Decision::NoVerge { index, p, contrast, surprise }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2}, but its contrast with the verge is {}, {:.2} is needed: {}",
                name(index),
                Hundredths(*contrast),
                0.5 * config.detect_contrast + surprise,
                if *contrast > 0.5 * config.detect_contrast {
                    "it is expected elsewhere"
                } else {
                    "a paved area would look alike"
                }
            ),
            (Decision::EdgesDisagree { index, p, aligned_p, needed_p }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2} at the best place, but {aligned_p:.2} where the edges of its arms put it, {needed_p:.2} \
                 is needed",
                name(index)
            ),
            (Decision::EdgesElsewhere { index, p, gated }, _) => write!(
                f,
                "{} not taken: P(F) {p:.2} at the best place, but {gated} edges of its arms lie too far from there",
                name(index)
            ),
            (Decision::Lost { index }, _) => write!(
                f,
                "{} lost: not confirmed in {}, bracketing found nothing better{}",
                name(index),
                Frames(config.lost_frames),
                Threshold(needed_p)
            ),
            (Decision::Skipped { index }, _) => {
                write!(f, "{} lies behind by all that is known and was never seen", name(index))
            }
            (decision, Some(followed)) => {
                let forward_m = followed.vehicle_from_feature.translation.x;
                write!(f, "{} {:.1}", name(&followed.index), Along(forward_m))?;
                let words = MatchWords(&followed.matched, needed_p);
                match decision {
                    Decision::Detected => write!(f, ", detected: {words}"),
                    Decision::FoundByBracketing => write!(f, ", found again by bracketing: {words}"),
                    Decision::NotConfirmed { frames } => write!(
                        f,
                        " by dead reckoning, not confirmed for {frames} of {}: {words}",
                        Frames(config.lost_frames)
                    ),
                    Decision::Arrived => {
                        f.write_str(": the driving line's start reached the bottom of the view")
                    }
                    Decision::Passing => f.write_str(": on the driving line through it"),
                    _ => write!(f, ": {words}"),
                }
            }
            (_, None) => {
                f.write_str(if track.state == State::RouteDone { ROUTE_DONE } else { "nothing is followed" })
            }
        }
    }
}

const ROUTE_DONE: &str = "every feature of the route has been passed";

/// A camera that has been moved as a sentence has it.
struct MountFaultWords<'a>(&'a MountFault);

impl Display for MountFaultWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let MountFault { angle, by_rad, frames_since } = self.0;
        let degrees = by_rad.abs().to_degrees();
        let way = match (angle, *by_rad > 0.0) {
            (MountAngle::Pitch, true) => "down",
            (MountAngle::Pitch, false) => "up",
            (MountAngle::Yaw, true) => "to the left",
            (MountAngle::Yaw, false) => "to the right",
            (MountAngle::Roll, true) => "about its axis, left side up",
            (MountAngle::Roll, false) => "about its axis, right side up",
        };
        write!(f, "the camera was turned by {degrees:.1} degrees {way}")?;
        write!(f, " {} ago, calibrate its mount anew", Frames(*frames_since))
    }
}

/// A feature as a sentence has it.
struct FeatureName<'a>(Option<&'a RouteStop>);

impl Display for FeatureName<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(stop) => write!(f, "{} {}", kind_name(stop.model.kind), stop.model.id),
            None => f.write_str("no feature"),
        }
    }
}

/// A distance along the way, metres, as a sentence has it; with the digits that are asked for, else whole metres.
struct Along(f64);

impl Display for Along {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let side = if self.0 >= 0.0 { "ahead" } else { "behind" };
        write!(f, "{:.*} m {side}", f.precision().unwrap_or(0), self.0.abs())
    }
}

/// A number that may be negative, to hundredths; what rounds to zero has no sign.
struct Hundredths(f64);

impl Display for Hundredths {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rounded = (100.0 * self.0).round() / 100.0;
        // Negative zero plus zero is zero.
        write!(f, "{:.2}", rounded + 0.0)
    }
}

/// A number of frames.
struct Frames(usize);

impl Display for Frames {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            1 => f.write_str("1 frame"),
            frames => write!(f, "{frames} frames"),
        }
    }
}

/// The bound that P(F) was held against, where it was.
struct Threshold(Option<f64>);

impl Display for Threshold {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |needed_p| write!(f, ", threshold {needed_p:.2}"))
    }
}

/// What a candidate lacks.
struct MissingWords<'a>(&'a Missing);

impl Display for MissingWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Missing::Frames { needed } => write!(f, "{needed} are needed"),
            Missing::Contrast { sum, needed } => {
                write!(f, "a contrast with the verge that sums up to {sum:.2}, {needed:.2} is needed")
            }
            Missing::Distance { sigma_m, most_m } => {
                write!(f, "a distance known to {sigma_m:.2} m, {most_m:.2} m is needed")
            }
        }
    }
}

/// The weakest sub-mask against the threshold, and those that took no part.
struct MatchWords<'a>(&'a Match, Option<f64>);

impl Display for MatchWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(matched, needed_p) = self;
        match matched.weakest.and_then(|i| matched.subs.get(i)) {
            Some(sub) => {
                let what = if sub.kind == SubMaskKind::DrivingLine { "weakest" } else { "weakest arm" };
                let p = sub.p.unwrap_or(0.0);
                write!(f, "{what} {} {p:.2}{}", sub.label, Threshold(*needed_p))?;
            }
            None => f.write_str("no arm is seen")?,
        }
        if let Some(contrast) = matched.contrast() {
            write!(f, "; contrast with the verge {}", Hundredths(contrast))?;
        }
        let mut separator = ";";
        for sub in &matched.subs {
            let where_it_is = match sub.participation {
                Participation::TakesPart => continue,
                Participation::CutByValidity => "outside the picture",
                Participation::TooShort => "out of view",
            };
            write!(f, "{separator} {} {where_it_is}", sub.label)?;
            separator = ",";
        }
        Ok(())
    }
}

/// The lane's edges, left and right, as a sentence has them.
struct LaneWords {
    /// For how many frames each has been kept without being seen; none where it is not given out.
    kept_frames: [Option<u32>; 2],
    /// Whether each is followed, given out or not.
    followed: [bool; 2],
}

impl Display for LaneWords {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (self.kept_frames, self.followed) {
            ([Some(0), Some(0)], _) => return f.write_str("both edges of the lane are seen"),
            ([None, None], [false, false]) => return f.write_str("no edge of a lane is seen"),
            _ => {}
        }
        let edges = self.kept_frames.into_iter().zip(self.followed);
        for (subject, (kept_frames, followed)) in
            ["the lane's left edge ", ", its right edge "].into_iter().zip(edges)
        {
            f.write_str(subject)?;
            match kept_frames {
                Some(0) => f.write_str("is seen")?,
                Some(1) => f.write_str("is not seen and kept")?,
                Some(frames) => write!(f, "has not been seen for {frames} frames and is kept")?,
                None if followed => f.write_str("is not sure yet")?,
                None => f.write_str("is not seen")?,
            }
        }
        Ok(())
    }
}

/// How the lane is left, as the end of a sentence has it; nothing while it is not.
struct DepartureWords<'a>(&'a DepartureOutput);

impl Display for DepartureWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let because = match (self.0.warning, self.0.silence) {
            (Some(Side::Left), _) => {
                return f.write_str("; warning: the vehicle leaves the lane to the left");
            }
            (Some(Side::Right), _) => {
                return f.write_str("; warning: the vehicle leaves the lane to the right");
            }
            (None, None) => return Ok(()),
            (None, Some(Silence::TurnSignal)) => "the driver signals",
            (None, Some(Silence::Slow)) => "the vehicle is slow",
            (None, Some(Silence::LaneChange)) => "the lane is being changed",
            (None, Some(Silence::CoolDown)) => "there has just been a warning",
        };
        write!(f, "; a wheel is at an edge, no warning because {because}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lanes_edges_are_seen_kept_or_none() {
        let words = |kept_frames, followed| LaneWords { kept_frames, followed }.to_string();
        assert_eq!(words([Some(0), Some(0)], [true, true]), "both edges of the lane are seen");
        assert_eq!(words([None, None], [false, false]), "no edge of a lane is seen");
        assert_eq!(
            words([Some(0), Some(4)], [true, true]),
            "the lane's left edge is seen, its right edge has not been seen for 4 frames and is kept"
        );
        assert_eq!(
            words([None, None], [true, false]),
            "the lane's left edge is not sure yet, its right edge is not seen"
        );
    }

    #[test]
    fn a_departure_is_warned_of_or_its_silence_explained() {
        let words = |warning, silence| {
            let departure = DepartureOutput { warning, silence, ..DepartureOutput::default() };
            DepartureWords(&departure).to_string()
        };
        assert_eq!(words(None, None), "");
        assert_eq!(words(Some(Side::Right), None), "; warning: the vehicle leaves the lane to the right");
        assert_eq!(
            words(None, Some(Silence::TurnSignal)),
            "; a wheel is at an edge, no warning because the driver signals"
        );
    }

    fn feature_words(decision: Decision) -> String {
        let (track, config) = (TrackOutput::default(), TrackConfig::default());
        let evidence = TrackEvidence { decision, ..TrackEvidence::default() };
        let why = Why {
            track: &track,
            evidence: &evidence,
            stops: &[],
            config: &config,
            mount: None,
            lane: None,
            turns_through: false,
            departure: None,
        };
        why.to_string()
    }

    /// Numbers of every size that a decision may hold.
    const NUMBERS: [f64; 9] = [0.0, 1e-9, 0.004, 0.25, 0.5, 0.999, 1.0, 37.25, 3_523_697.8];

    #[test]
    fn every_refusal_says_its_value_and_the_bound_that_it_missed() {
        let (index, p) = (0, 0.875);
        for value in NUMBERS {
            for bound in NUMBERS {
                let two = |number: f64| format!("{number:.2}");
                let one = |number: f64| format!("{number:.1} m");
                let (shown, needed) = (two(value), format!("{} is needed", two(bound)));
                let edges = Decision::EdgesDisagree { index, p, aligned_p: value, needed_p: bound };
                let verge = Decision::NoVergeInView { index, p: value, needed_p: bound };
                let elsewhere = Decision::NotExpected { index, p, surprise: value, most: bound };
                let beside = Decision::OffApproach { index, p, beside_m: value, most_m: bound };
                let sum = Missing::Contrast { sum: value, needed: bound };
                let distance = Missing::Distance { sigma_m: value, most_m: bound };
                let candidate = |missing| Decision::Candidate { index, frames: 1, p, missing };
                for (decision, words) in [
                    (edges, [shown.clone(), needed.clone()]),
                    (verge, [shown.clone(), needed.clone()]),
                    (elsewhere, [shown.clone(), format!("less than {}", two(bound))]),
                    (beside, [one(value), format!("at most {}", one(bound))]),
                    (candidate(sum), [shown.clone(), needed.clone()]),
                    (candidate(distance), [shown.clone(), format!("{} m is needed", two(bound))]),
                ] {
                    let text = feature_words(decision);
                    assert!(words.iter().all(|words| text.contains(words)), "{words:?} in {text}");
                    assert!(!text.contains('-'), "{text}");
                }
            }
        }
        for frames in [1, 2, 31] {
            let dropped = feature_words(Decision::Dropped { index, frames, most_frames: 30 });
            let count =
                if frames == 1 { "1 frame without".to_owned() } else { format!("{frames} frames without") };
            assert!(dropped.contains(&count) && dropped.contains("at most 30"), "{dropped}");
        }
    }

    #[test]
    fn what_lies_behind_is_not_said_to_be_ahead() {
        for ahead_m in [-3_523_697.8, -12.0, -0.6, -1e-9, 0.0, 0.4, 7.0, 440.0] {
            let text = feature_words(Decision::NotInReach { index: 0, ahead_m });
            let side = if ahead_m < 0.0 { "behind" } else { "ahead" };
            assert!(text.contains(&format!("{:.0} m {side}", ahead_m.abs())), "{text}");
            assert!(!text.contains('-'), "{text}");
        }
    }

    #[test]
    fn a_feature_that_is_not_taken_says_what_speaks_against_it() {
        let half = 0.5 * TrackConfig::default().detect_contrast;
        let paved = Decision::NoVerge { index: 0, p: 0.9, contrast: half - 0.02, surprise: 0.0 };
        assert!(feature_words(paved).contains("a paved area would look alike"));
        let elsewhere = Decision::NoVerge { index: 0, p: 0.9, contrast: half + 0.05, surprise: 0.2 };
        let words = feature_words(elsewhere);
        assert!(words.contains(&format!("{:.2} is needed", half + 0.2)), "{words}");
        assert!(words.contains("it is expected elsewhere"), "{words}");
        let words = feature_words(Decision::EdgesElsewhere { index: 0, p: 0.9, gated: 3 });
        assert!(words.contains("P(F) 0.90 at the best place, but 3 edges of its arms"), "{words}");
    }
}
