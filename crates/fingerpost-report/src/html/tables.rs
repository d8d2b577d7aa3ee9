//! A run in numbers: summary, features, stage times, losses.

use fingerpost_format::{
    DriveSummary, ErrorQuantiles, FeatureOutcome, FeatureSummary, SamplingRecord, Summary,
};
use maud::{Markup, html};

use super::chart::{number, px};
use crate::timeline::{Listed, Timeline};

/// The numbers of the run.
pub(crate) fn summary(summary: &Summary) -> Markup {
    let mut facts: Vec<(&str, String)> = Vec::new();
    facts.extend(summary.drive.iter().flat_map(drive));
    if !summary.features.is_empty() {
        facts.extend(features_found(&summary.features));
        facts.push(("frames lost", summary.lost_frames.to_string()));
    }
    facts.push(("frames", summary.frames.to_string()));
    facts.push(("frames worked through a second", format!("{:.1}", summary.fps)));
    if let Some(SamplingRecord { picture_px: [width, height], every, rate_hz }) = summary.sampling {
        facts.push(("pictures used at", format!("{width} x {height} px")));
        facts.extend(every.map(|nth| ("frames used", format!("one of {nth}"))));
        facts.extend(rate_hz.map(|hz| ("frames used", format!("{hz} a second at the most"))));
    }
    if summary.broken_frames > 0 {
        facts.push(("broken frames passed over", summary.broken_frames.to_string()));
    }
    if summary.damaged_frames > 0 {
        facts.push(("damaged frames used", summary.damaged_frames.to_string()));
    }
    if summary.dropped_frames > 0 {
        facts.push(("frames passed over for later ones", summary.dropped_frames.to_string()));
    }
    if let Some(truth) = &summary.truth {
        facts.push((
            "detected, of those passed",
            format!("{} of {}", truth.features_detected, truth.features_total),
        ));
        facts.push(("false detections", truth.false_detections.to_string()));
        facts.push(("arrivals", truth.arrivals.to_string()));
        facts.extend(truth.position_error_m.map(|error| ("position error", metres(error))));
        facts.extend(truth.motion_error_pct.map(|error| ("motion error", format!("{error:.2} %"))));
        facts.extend(truth.fix_error_m.map(|error| ("fix error", metres(error))));
        facts.extend(truth.bound_violations.map(|n| ("frames outside the bound", n.to_string())));
    }
    let remarks = summary.drive.iter().flat_map(|drive| &drive.remarks);
    html! {
        @for remark in remarks { p class="warning" { (sentence(remark)) } }
        (self::facts(&facts))
        @for (state, frames) in &summary.camera_frames {
            p class="warning" { "The camera " (state) " in " (frames) " frames." }
        }
        @for fault in &summary.mount_faults { p class="warning" { (fault.to_string()) "." } }
        @if summary.interrupted { p class="warning" { "The run was ended before its input was." } }
    }
}

/// How far and how long, and of how much of it anything is known.
fn drive(drive: &DriveSummary) -> Vec<(&'static str, String)> {
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let or_unknown = |value: Option<String>| value.unwrap_or_else(|| "not known".to_owned());
    let (unmeasured_s, duration_s) = (drive.unmeasured_s, drive.duration_s);
    let distance = |m: f64| {
        let without = format!(", without {unmeasured_s:.2} s in which it was not measured");
        format!("{m:.1} m{}", if unmeasured_s > 0.0 { without.as_str() } else { "" })
    };
    let mut facts = vec![
        ("distance driven", or_unknown(drive.distance_m.map(distance))),
        ("duration", format!("{duration_s:.1} s")),
        ("mean speed", or_unknown(drive.mean_speed_mps.map(|mps| format!("{mps:.1} m/s")))),
        ("frames with motion", percent(drive.motion_share)),
    ];
    facts.extend(drive.lane_share.map(|share| ("frames with a lane", percent(share))));
    facts.extend(drive.feature_share.map(|share| ("frames with a feature", percent(share))));
    facts
}

/// What became of the features that the drive came to, and how many it did not come to.
fn features_found(features: &[FeatureSummary]) -> Vec<(&'static str, String)> {
    let count = |of: &dyn Fn(&FeatureSummary) -> bool| features.iter().filter(|feature| of(feature)).count();
    let not_reached = count(&|feature| feature.outcome == Some(FeatureOutcome::NotReached));
    let reached = features.len() - not_reached;
    let mut facts = vec![
        ("features detected", format!("{} of {reached}", count(&|feature| feature.detected_frame.is_some()))),
        (
            "features arrived at",
            format!("{} of {reached}", count(&|feature| feature.arrived_frame.is_some())),
        ),
    ];
    if not_reached > 0 {
        facts.push(("features not reached", not_reached.to_string()));
    }
    facts
}

/// A remark as a sentence of its own.
fn sentence(remark: &str) -> String {
    let stop = if remark.ends_with(['.', '?', '!']) { "" } else { "." };
    let mut letters = remark.chars();
    letters
        .next()
        .map_or(String::new(), |first| first.to_uppercase().chain(letters).chain(stop.chars()).collect())
}

/// What the run was made from.
pub(crate) fn made_from(inputs: &[(&str, String)]) -> Markup {
    html! {
        @if !inputs.is_empty() {
            dl class="made-from" { @for (name, words) in inputs { dt { (name) } dd { (words) } } }
        }
    }
}

/// Names and what they are.
pub(crate) fn facts(facts: &[(&str, String)]) -> Markup {
    html! { dl class="facts" { @for (name, value) in facts { div { dt { (name) } dd { (value) } } } } }
}

pub(crate) fn metres(error: ErrorQuantiles) -> String {
    format!("{:.2} m median, {:.2} m p95, {:.2} m largest", error.p50, error.p95, error.max)
}

/// What became of every feature.
pub(crate) fn features(summary: &Summary) -> Markup {
    let or_dash = |value: Option<String>| value.unwrap_or_else(|| "-".to_owned());
    html! {
        div class="wide" { table {
            thead { tr {
                th { "" } th { "node" } th { "kind" } th { "name" } th class="n" { "along the route" }
                th { "what became of it" } th class="n" { "detected in frame" } th class="n" { "ahead by" }
                th class="n" { "arrived in frame" } th class="n" { "node ahead by" } th class="n" { "highest P(F)" }
            } }
            tbody {
                @for (i, feature) in summary.features.iter().enumerate() {
                    tr class=[(feature.outcome == Some(FeatureOutcome::Missed)).then_some("missed")] {
                        td class="n" { (i + 1) }
                        td class="n" { (feature.id) }
                        td { (feature.kind.replace('_', " ")) }
                        td { (feature.name) }
                        td class="n" { (or_dash(feature.at_m.map(|m| format!("{m:.0} m")))) }
                        td { (feature.outcome.map_or("not known", outcome)) }
                        td class="n" { (or_dash(feature.detected_frame.map(|n| n.to_string()))) }
                        td class="n" { (or_dash(feature.detected_forward_m.map(|m| format!("{m:.1} m")))) }
                        td class="n" { (or_dash(feature.arrived_frame.map(|n| n.to_string()))) }
                        td class="n" { (or_dash(feature.arrived_forward_m.map(|m| format!("{m:.1} m")))) }
                        td class="n" { (or_dash(feature.max_p.map(|p| format!("{p:.2}")))) }
                    }
                }
            }
        } }
    }
}

/// What became of a feature, in words.
pub(super) const fn outcome(outcome: FeatureOutcome) -> &'static str {
    match outcome {
        FeatureOutcome::Arrived => "arrived at",
        FeatureOutcome::Detected => "detected",
        FeatureOutcome::Missed => "missed",
        FeatureOutcome::NotReached => "not reached",
    }
}

/// Median and 95th percentile of every stage as bars.
pub(crate) fn stage_times(summary: &Summary) -> Markup {
    const BAR_LEFT: f64 = 150.0;
    const BAR_WIDTH: f64 = 640.0;
    const LINE: f64 = 24.0;
    let longest = summary.stage_ms.values().map(|time| time.p95.max(time.median)).fold(0.0, f64::max);
    let width = |ms: f64| px(if longest > 0.0 { ms / longest * BAR_WIDTH } else { 0.0 });
    let height = LINE * summary.stage_ms.len() as f64 + 4.0;
    html! {
        figure class="chart" {
            figcaption { "Milliseconds a frame: dark the median, light the 95th percentile" }
            svg viewBox={ "0 0 960 " (px(height)) } role="img" aria-label="stage times" {
                @for (i, (stage, time)) in summary.stage_ms.iter().enumerate() {
                    @let y = LINE * i as f64;
                    text x=(px(BAR_LEFT - 8.0)) y=(px(y + 16.0)) text-anchor="end" { (stage.replace('_', " ")) }
                    rect class="p95" x=(px(BAR_LEFT)) y=(px(y + 4.0)) width=(width(time.p95)) height="16" {}
                    rect class="median" x=(px(BAR_LEFT)) y=(px(y + 4.0)) width=(width(time.median)) height="16" {}
                    text x=(px(BAR_LEFT + BAR_WIDTH + 8.0)) y=(px(y + 16.0)) {
                        (number(time.median)) " / " (number(time.p95))
                    }
                }
            }
        }
    }
}

/// Every loss with its reason, and every frame that could not be used.
pub(crate) fn losses(timeline: &Timeline) -> Markup {
    html! {
        @if timeline.losses.count == 0 { p { "No feature was lost." } } @else { (list(&timeline.losses)) }
        @if timeline.broken.count > 0 {
            h3 { "Frames that could not be used" }
            (list(&timeline.broken))
        }
    }
}

/// Frames with a sentence each.
pub(super) fn list(listed: &Listed) -> Markup {
    let more = listed.count - listed.first.len();
    html! {
        ul {
            @for listed in &listed.first {
                li { b { "frame " (listed.frame) ", " (number(listed.t_s)) " s: " } (listed.text) }
            }
            @if more > 0 { li { "and " (more) " more" } }
        }
    }
}
