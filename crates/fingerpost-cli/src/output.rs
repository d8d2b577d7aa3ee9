//! What the program says: data on standard output, everything else on standard error.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, Result};
use fingerpost_format::{DriveSummary, ErrorQuantiles, FeatureOutcome, StageTime, Summary};
use fingerpost_io::without_credentials;
use fingerpost_map::escaped;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use log::{Level, LevelFilter, log_enabled};
use serde::Serialize;

use crate::verbosity::MESSAGES;

/// A message of one line on standard error, unless it is to be quiet.
pub(crate) fn message(text: &str) {
    log::info!(target: MESSAGES, "{text}");
}

/// What the program fails of, on standard error.
pub(crate) fn error(text: &str) {
    log::error!(target: MESSAGES, "{text}");
}

/// A line on standard error. Where nobody can read it any more, the program goes on without saying it.
///
/// Much of what is said comes from files and arguments, whose names may hold line breaks and what steers a terminal; addresses are
/// without their users' passwords.
pub(crate) fn line(text: &str) {
    let _ = writeln!(io::stderr(), "{}", escaped(&without_credentials(text)));
}

/// Data on standard output, as one JSON object on a line.
pub(crate) fn print_json<T: Serialize>(data: &T) -> Result<()> {
    let text = serde_json::to_string(data).context("the result cannot be written as JSON")?;
    print_text(&text)
}

/// Data on standard output, as a line of text.
pub(crate) fn print_text(text: &str) -> Result<()> {
    writeln!(io::stdout(), "{text}").context("standard output cannot be written; check where it leads")
}

/// An error with everything that led to it on one line; causes that a message already holds are not said twice.
pub(crate) fn cause_chain(error: &anyhow::Error) -> String {
    // TOML's parser draws the place of an error below its message.
    let one_line = |text: String| text.trim_end().lines().map(str::trim).collect::<Vec<_>>().join(" ");
    error.chain().map(|cause| one_line(cause.to_string())).fold(String::new(), |chain, cause| match chain {
        chain if chain.is_empty() => cause,
        chain if chain.contains(&cause) => chain,
        chain => format!("{chain}: {cause}"),
    })
}

/// A bar on standard error, shown where that is a terminal, unless it is to be quiet or every frame is said; without a length it counts.
pub(crate) fn progress(length: Option<u64>, unit: &str) -> ProgressBar {
    let is_shown = log_enabled!(target: MESSAGES, Level::Info) && log::max_level() < LevelFilter::Debug;
    let target = if is_shown { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(length, target);
    let template = match length {
        Some(_) => format!("{{wide_bar}} {{pos}}/{{len}} {unit}, {{per_sec}}, {{eta}} left"),
        None => format!("{{spinner}} {{pos}} {unit}, {{per_sec}}"),
    };
    match ProgressStyle::with_template(&template) {
        Ok(style) => bar.with_style(style),
        Err(_) => bar,
    }
}

/// How far and how long a drive was, and of how much of it anything is known.
fn drive_line(drive: &DriveSummary) -> String {
    let DriveSummary { distance_m, duration_s, mean_speed_mps, unmeasured_s, motion_share, .. } = drive;
    let distance = distance_m.map_or("distance not known".to_owned(), |m| format!("{m:.1} m"));
    let speed = mean_speed_mps.map_or(String::new(), |mps| format!(", {mps:.1} m/s on average"));
    let unmeasured = distance_m
        .filter(|_| *unmeasured_s > 0.0)
        .map(|_| format!(" (without {unmeasured_s:.2} s in which it was not measured)"));
    let percent = |share: f64| format!("{:.0} %", 100.0 * share);
    let lane = drive.lane_share.map(|share| format!(", a lane in {}", percent(share)));
    let feature = drive.feature_share.map(|share| format!(", a feature in {}", percent(share)));
    format!(
        "{distance} in {duration_s:.1} s{}{speed}; motion in {} of the frames{}{}",
        unmeasured.unwrap_or_default(),
        percent(*motion_share),
        lane.unwrap_or_default(),
        feature.unwrap_or_default()
    )
}

/// A run in a few lines on standard error, and where to look; without those of its remarks that were said before its first frame.
pub(crate) fn print_summary(summary: &Summary, said: &[String], out: &Path) {
    if let Some(drive) = &summary.drive {
        message(&drive_line(drive));
        drive.remarks.iter().filter(|remark| !said.contains(remark)).for_each(|remark| message(remark));
    }
    if !summary.features.is_empty() {
        message("kind       detected        arrived        max P(F)  place");
    }
    for feature in &summary.features {
        let ahead = |m: Option<f64>| m.map(|m| format!("{m:.1} m ahead"));
        let unfound = match feature.outcome {
            Some(FeatureOutcome::Missed) => "missed",
            Some(FeatureOutcome::NotReached) => "not reached",
            Some(FeatureOutcome::Arrived | FeatureOutcome::Detected) | None => "-",
        };
        let detected = ahead(feature.detected_forward_m).unwrap_or_else(|| unfound.to_owned());
        let arrived = ahead(feature.arrived_forward_m).unwrap_or_else(|| "-".to_owned());
        let max_p = feature.max_p.map_or("-".to_owned(), |p| format!("{p:.2}"));
        message(&format!("{:<9}  {detected:<14}  {arrived:<13}  {max_p:<8}  {}", feature.kind, feature.name));
    }
    if let Some(truth) = &summary.truth {
        message(&format!(
            "against truth: {} of {} features detected, {} falsely, {} arrived at",
            truth.features_detected, truth.features_total, truth.false_detections, truth.arrivals
        ));
        if let Some(ErrorQuantiles { p50, p95, max }) = truth.position_error_m {
            message(&format!("position error: median {p50:.2} m, p95 {p95:.2} m, largest {max:.2} m"));
        }
        if let Some(percent) = truth.motion_error_pct {
            message(&format!("distance driven: {percent:.1} % off"));
        }
        if let Some(ErrorQuantiles { p50, p95, max }) = truth.fix_error_m {
            let outside = truth.bound_violations.unwrap_or_default();
            message(&format!(
                "place on the map: median {p50:.1} m off, p95 {p95:.1} m, largest {max:.1} m, outside its bound in {outside} frames"
            ));
        }
    }
    for (state, frames) in &summary.camera_frames {
        message(&format!("the camera {state} in {frames} frames"));
    }
    for fault in &summary.mount_faults {
        message(&fault.to_string());
    }
    let Summary { frames, broken_frames, lost_frames, fps, .. } = summary;
    for (stage, StageTime { median, p95 }) in &summary.stage_ms {
        log::info!("{stage}: {median:.3} ms a frame in the median, {p95:.3} ms at the 95th percentile");
    }
    message(&format!("{frames} frames ({broken_frames} broken, {lost_frames} lost) at {fps:.1} a second"));
    message(&format!("results in {}; look at {}", out.display(), out.join("report.html").display()));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_is_said_is_not_said_again() {
        let error = anyhow::anyhow!("disk full").context("a.txt cannot be written (disk full)");
        assert_eq!(cause_chain(&error), "a.txt cannot be written (disk full)");
        let error = anyhow::anyhow!("disk full").context("the run ended");
        assert_eq!(cause_chain(&error), "the run ended: disk full");
    }

    #[test]
    fn an_error_is_one_line_whatever_it_is_of() {
        let torn: toml::de::Error = "a = [".parse::<toml::Table>().unwrap_err();
        assert!(torn.to_string().contains('\n'));
        for error in [
            anyhow::Error::new(torn).context("camera.toml is none"),
            anyhow::anyhow!("a\nfingerpost: results in b cannot be read"),
        ] {
            let chain = cause_chain(&error);
            assert!(!chain.contains('\n') && escaped(&chain) == chain, "{chain}");
        }
    }
}
