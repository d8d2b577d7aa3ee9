//! The lane of a run over time: its edges, its width, the speed across it, and the warnings of leaving it.

use fingerpost_format::{DepartureRecord, FrameRecord, LanesRecord, Side};
use maud::{Markup, html};

use super::chart::{Chart, Curve};
use super::curves::{bands, series};
use super::tables::list;
use crate::palette;

/// The charts; none where the run has no lane on the road.
pub(crate) fn lane(records: &[FrameRecord]) -> Option<Markup> {
    let (first, last) = records.first().zip(records.last())?;
    let seconds = first.t_s..=last.t_s;
    let chart = |title: &str, unit, values, curves| Chart {
        title: title.to_owned(),
        unit,
        seconds: seconds.clone(),
        values,
        bands: Vec::new(),
        strip: Vec::new(),
        lines: Vec::new(),
        curves,
    };
    let curve = |label, class, value: fn(&LanesRecord) -> Option<f64>| Curve {
        label,
        class,
        points: series(records, |record| value(record.lanes.as_ref()?)),
    };
    let edges = vec![
        curve("left", "one", |lanes| Some(lanes.left?.offset_m)),
        curve("right", "three", |lanes| Some(lanes.right?.offset_m)),
    ];
    let edges = Chart {
        bands: bands(records, warning),
        strip: bands(records, silence),
        ..chart(
            "Edges of the lane beside the rear axle; coloured where the lane is left, below where that is passed over",
            "metres to the left",
            -2.0..=2.0,
            edges,
        )
    };
    let width = vec![curve("width", "one", |lanes| lanes.width_m)];
    let speed = vec![curve("to the left", "one", |lanes| lanes.departure.as_ref()?.lateral_speed_mps)];
    let charts = [
        edges,
        chart("Width of the lane", "metres", 2.5..=4.5, width),
        chart("Speed across the lane", "metres a second", -0.5..=0.5, speed),
    ];
    let begun: Vec<&FrameRecord> = warnings_begun(records).collect();
    charts[0].has_values().then(|| {
        html! {
            @for chart in charts.iter().filter(|chart| chart.has_values()) { (chart.figure()) }
            @if begun.is_empty() { p { "There was no warning of leaving the lane." } } @else {
                h3 { "Warnings of leaving the lane" }
                (list(&begun, |record| &record.why))
            }
        }
    })
}

fn departure(record: &FrameRecord) -> Option<&DepartureRecord> {
    record.lanes.as_ref()?.departure.as_ref()
}

fn warned(record: &FrameRecord) -> Option<Side> {
    departure(record)?.warning
}

fn warning(record: &FrameRecord) -> Option<(String, String)> {
    let side = match warned(record)? {
        Side::Left => "left",
        Side::Right => "right",
    };
    Some((format!("warning: {side}"), palette::css(palette::REJECTED)))
}

fn silence(record: &FrameRecord) -> Option<(String, String)> {
    let because = departure(record)?.silent_because.as_ref()?;
    Some((format!("no warning: {}", because.replace('_', " ")), palette::css(palette::LANE)))
}

/// The frames in which a warning begins.
fn warnings_begun(records: &[FrameRecord]) -> impl Iterator<Item = &FrameRecord> {
    let mut before = None;
    records.iter().filter(move |record| {
        let warned = warned(record);
        std::mem::replace(&mut before, warned) != warned && warned.is_some()
    })
}
