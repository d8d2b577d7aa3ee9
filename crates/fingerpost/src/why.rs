//! The sentence that says what was decided in a frame and what decided it.

use fingerpost_map::FeatureKind;

use crate::matching::{Match, Participation};
use crate::track::{Decision, RouteStop, State, TrackConfig, TrackEvidence, TrackOutput};

/// Name of a kind of feature as a sentence has it.
fn kind_name(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Junction => "junction",
        FeatureKind::SideRoad => "side road",
        FeatureKind::Bend => "bend",
    }
}

fn feature_name(stops: &[RouteStop], index: usize) -> String {
    stops.get(index).map_or_else(
        || "no feature".to_owned(),
        |stop| format!("{} {}", kind_name(stop.model.kind), stop.model.id),
    )
}

/// The weakest sub-mask and those that took no part, in words.
fn match_words(matched: &Match, threshold: f64) -> String {
    let weakest = match matched.weakest.and_then(|i| matched.subs.get(i)) {
        Some(sub) => {
            let what = if sub.label == "driving_line" { "weakest" } else { "weakest arm" };
            format!("{what} {} {:.2}, threshold {threshold:.2}", sub.label, sub.p.unwrap_or(0.0))
        }
        None => "no arm is seen".to_owned(),
    };
    let left_out: Vec<String> = matched
        .subs
        .iter()
        .filter_map(|sub| match sub.participation {
            Participation::TakesPart => None,
            Participation::CutByValidity => Some(format!("{} outside the picture", sub.label)),
            Participation::TooShort => Some(format!("{} out of view", sub.label)),
        })
        .collect();
    if left_out.is_empty() { weakest } else { format!("{weakest}; {}", left_out.join(", ")) }
}

/// What was decided in this frame and what decided it.
pub(crate) fn why(
    output: &TrackOutput,
    evidence: &TrackEvidence,
    stops: &[RouteStop],
    config: &TrackConfig,
) -> String {
    let detect = config.detect_threshold;
    let followed = output.followed.as_ref().map(|followed| {
        let forward_m = followed.vehicle_from_feature.translation.x;
        let place = if forward_m >= 0.0 {
            format!("{forward_m:.1} m ahead")
        } else {
            format!("{:.1} m behind", -forward_m)
        };
        (format!("{} {place}", feature_name(stops, followed.index)), &followed.matched)
    });
    match (&evidence.decision, followed) {
        (Decision::NoRoute, _) => "no route: ground view, road surface and motion alone".to_owned(),
        (Decision::RouteDone, _) => "every feature of the route has been passed".to_owned(),
        (Decision::NotInReach { index, ahead_m }, _) => {
            format!(
                "{} is believed {ahead_m:.0} m ahead, out of the view's reach",
                feature_name(stops, *index)
            )
        }
        (Decision::NotFound { index }, _) if evidence.tried == 0 => {
            format!("{} is not in reach of the view", feature_name(stops, *index))
        }
        (Decision::NotFound { index }, _) => format!(
            "{} not seen: {}, {} places tried",
            feature_name(stops, *index),
            evidence.sought.as_ref().map_or_else(
                || "no arm that would tell it is in view".to_owned(),
                |sought| format!("at the best place {}", match_words(&sought.matched, detect)),
            ),
            evidence.tried
        ),
        (Decision::Candidate { index, frames, p }, _) => format!(
            "{} may be ahead: P(F) {p:.2} in {frames} frames, {} and a sure distance are needed",
            feature_name(stops, *index),
            config.detect_frames
        ),
        (Decision::Unbounded { index, p }, _) => format!(
            "{} not taken: P(F) {p:.2}, but no arm that tells it shows an edge of its road",
            feature_name(stops, *index)
        ),
        (Decision::EdgesDisagree { index, p, aligned_p }, _) => format!(
            "{} not taken: P(F) {p:.2} at the best place, but {aligned_p:.2} where the edges of its arms put it",
            feature_name(stops, *index)
        ),
        (Decision::Lost { index }, _) => format!(
            "{} lost: not confirmed in {} frames, bracketing found nothing above {:.2}",
            feature_name(stops, *index),
            config.lost_frames,
            config.confirm_threshold
        ),
        (Decision::Skipped { index }, _) => {
            format!("{} lies behind by all that is known and was never seen", feature_name(stops, *index))
        }
        (decision, Some((place, matched))) => {
            let words = match_words(matched, config.confirm_threshold);
            match decision {
                Decision::Detected => format!("{place}, detected: {}", match_words(matched, detect)),
                Decision::FoundByBracketing => format!("{place}, found again by bracketing: {words}"),
                Decision::NotConfirmed { frames } => format!(
                    "{place} by dead reckoning, not confirmed for {frames} of {} frames: {words}",
                    config.lost_frames
                ),
                Decision::Arrived => {
                    format!("{place}: the driving line's start reached the bottom of the view")
                }
                Decision::Passing => format!("{place}: on the driving line through it"),
                _ => format!("{place}: {words}"),
            }
        }
        (_, None) => match output.state {
            State::RouteDone => "every feature of the route has been passed".to_owned(),
            _ => "nothing is followed".to_owned(),
        },
    }
}
