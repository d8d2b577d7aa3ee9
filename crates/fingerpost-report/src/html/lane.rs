//! The lane of a run over time: its edges, its width, the speed across it, and the warnings of leaving it.

use fingerpost_format::Side;
use maud::{Markup, html};

use super::chart::{Chart, Curve};
use super::curves::bands;
use super::tables::list;
use crate::palette;
use crate::series::Series;
use crate::timeline::Timeline;

/// The charts; none where the run has no lane on the road.
pub(crate) fn lane(timeline: &Timeline) -> Option<Markup> {
    let seconds = timeline.seconds.clone()?;
    let lane = &timeline.lane;
    let chart = |title: &str, unit, values, curves| Chart {
        curves,
        ..Chart::over(seconds.clone(), title, unit, values)
    };
    let edges = vec![curve("left", "one", &lane.left_m), curve("right", "three", &lane.right_m)];
    let edges = Chart {
        bands: bands(&seconds, &lane.warnings, |warning| warning.map(warning_band)),
        strip: bands(&seconds, &lane.silences, |because| because.as_deref().map(silence_band)),
        ..chart(
            "Edges of the lane beside the rear axle; coloured where the lane is left, below where that is passed over",
            "metres to the left",
            -2.0..=2.0,
            edges,
        )
    };
    let width = vec![curve("width", "one", &lane.width_m)];
    let speed = vec![curve("to the left", "one", &lane.lateral_speed_mps)];
    let charts = [
        edges,
        chart("Width of the lane", "metres", 2.5..=4.5, width),
        chart("Speed across the lane", "metres a second", -0.5..=0.5, speed),
    ];
    charts[0].has_values().then(|| {
        html! {
            @for chart in charts.iter().filter(|chart| chart.has_values()) { (chart.figure()) }
            @if lane.warnings_begun.count == 0 { p { "There was no warning of leaving the lane." } } @else {
                h3 { "Warnings of leaving the lane" }
                (list(&lane.warnings_begun))
            }
        }
    })
}

fn curve<'a>(label: &'static str, class: &'static str, values: &'a Series) -> Curve<'a> {
    Curve { label, class, values }
}

fn warning_band(side: Side) -> (String, String) {
    let side = match side {
        Side::Left => "left",
        Side::Right => "right",
    };
    (format!("warning: {side}"), palette::css(palette::REJECTED))
}

fn silence_band(because: &str) -> (String, String) {
    (format!("no warning: {}", because.replace('_', " ")), palette::css(palette::LANE))
}
