//! `report.html`: a run on one self-contained page.

use fingerpost_format::{FrameRecord, Summary, TruthRecord};
use fingerpost_map::Route;

use crate::key_frames::KeyFrames;

/// P(F) from which a feature counts as seen, and as confirmed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// For the detection.
    pub detect: f64,
    /// While it is tracked.
    pub confirm: f64,
}

/// What a report is made of.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Title of the page: what was run on.
    pub title: &'a str,
    /// Every frame of the run.
    pub records: &'a [FrameRecord],
    /// The run in numbers.
    pub summary: &'a Summary,
    /// Truth of the frames, where there is one.
    pub truth: Option<&'a [TruthRecord]>,
    /// The route, where there is one.
    pub route: Option<&'a Route>,
    /// Thresholds in force.
    pub thresholds: Thresholds,
    /// The effective configuration.
    pub config_toml: &'a str,
    /// The frames to be shown.
    pub key_frames: &'a KeyFrames,
}

/// The report as one HTML page without outside resources.
pub fn report_html(input: &ReportInput<'_>) -> String {
    maud::html! { (maud::DOCTYPE) html { head { title { (input.title) } } body {} } }.into_string()
}
