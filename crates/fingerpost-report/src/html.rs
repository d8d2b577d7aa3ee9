//! `report.html`: a run on one self-contained page.

mod advice;
mod chart;
mod curves;
mod fit;
mod fixes;
mod key_frames;
mod lane;
mod map;
mod tables;

use fingerpost_format::{Summary, TruthRecord};
use fingerpost_map::{RoadGraph, Route};
use maud::{DOCTYPE, Markup, PreEscaped, html};

pub(crate) use self::chart::{Chart, Curve, Scale, joined, number, px, ticks};
pub(crate) use self::curves::{bands, legend};
pub(crate) use self::fit::{Fit, Sheet};
pub(crate) use self::tables::{facts, metres};
use crate::key_frames::KeyFrames;
use crate::timeline::Timeline;

/// Probabilities that a feature is there, by which it is followed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thresholds {
    /// From which it is tracked.
    pub detect: f64,
    /// Below which it is lost.
    pub lost: f64,
}

/// What a report is made of.
#[derive(Debug, Clone, Copy)]
pub struct ReportInput<'a> {
    /// Title of the page: what was run on.
    pub title: &'a str,
    /// What the run was made from, name and words: the command line, camera, map, route.
    pub made_from: &'a [(&'static str, String)],
    /// The run over time.
    pub timeline: &'a Timeline,
    /// The run in numbers.
    pub summary: &'a Summary,
    /// Truth of the frames, where there is one.
    pub truth: Option<&'a [TruthRecord]>,
    /// The route, where there is one.
    pub route: Option<&'a Route>,
    /// The roads, where the vehicle was located on a map.
    pub roads: Option<&'a RoadGraph>,
    /// Thresholds in force.
    pub thresholds: Thresholds,
    /// Texts of the rules that steered, in their order; none of controllers without rules.
    pub rules: &'a [String],
    /// The effective configuration.
    pub config_toml: &'a str,
    /// The frames to be shown.
    pub key_frames: &'a KeyFrames,
}

/// Whose the map is.
pub(crate) const MAP_DATA: &str = "Map data © OpenStreetMap contributors, ODbL.";
/// Look of the page, light and dark.
const STYLE: &str = include_str!("html/style.css");

/// The report as one HTML page that needs nothing from outside: no script, no font, pictures inside.
pub fn report_html(input: &ReportInput<'_>) -> String {
    let body = html! {
        header {
            h1 { (input.title) }
            p class="dim" { "What Fingerpost saw on this run and why it decided." }
        }
        (tables::summary(input.summary))
        (tables::made_from(input.made_from))
        @if !input.summary.features.is_empty() {
            h2 { "Features of the route" }
            (tables::features(input.summary))
        }
        @if let Some(map) = map::map(input) { h2 { "Map" } (map) }
        h2 { "Over time" }
        (curves::curves(input))
        @if let Some(fixes) = fixes::fixes(input) { h2 { "Place on the map" } (fixes) }
        @if let Some(lane) = lane::lane(input.timeline) { h2 { "Lane" } (lane) }
        @if let Some(advice) = advice::advice(input) { h2 { "Advice" } (advice) }
        h2 { "Losses" }
        (tables::losses(input.timeline))
        @if !input.summary.stage_ms.is_empty() {
            h2 { "Time a stage takes" }
            (tables::stage_times(input.summary))
        }
        h2 { "Key frames" }
        (key_frames::key_frames(input))
        h2 { "Configuration" }
        details {
            summary { "The effective configuration of the run" }
            pre { (input.config_toml) }
        }
        footer {
            @if input.route.is_some() || input.roads.is_some() { p { (MAP_DATA) } }
            @if let Some(written_by) = &input.summary.written_by { p { "Written by " (written_by) "." } }
        }
    };
    page(input.title, &body)
}

/// A whole page with everything that it needs inside.
pub(crate) fn page(title: &str, body: &Markup) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                title { (title) " - Fingerpost" }
                style { (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    };
    page.into_string()
}
