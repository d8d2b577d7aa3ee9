//! P(F), distance and position error of a run over time.

use std::collections::BTreeMap;
use std::ops::RangeInclusive;

use fingerpost_format::{FrameRecord, TruthRecord};
use maud::{Markup, html};

use super::ReportInput;
use super::chart::{Band, Chart, Curve};
use crate::palette;
use crate::series::{MAX_POINTS, stretches};

/// The charts.
pub(crate) fn curves(input: &ReportInput<'_>) -> Markup {
    let records = input.records;
    let (Some(first), Some(last)) = (records.first(), records.last()) else {
        return html! { p { "No frame was processed." } };
    };
    let seconds = first.t_s..=last.t_s;
    let truth = truth_by_frame(input.truth);
    let p = probability(input, seconds.clone());
    let others = [
        distance(records, &truth, seconds.clone()),
        error(records, &truth, seconds.clone()),
        speed(records, &truth, seconds),
    ];
    html! {
        (states(records))
        @if p.has_values() {
            (p.figure())
            (arms(records))
        } @else {
            p { "No feature of the route came into view, so there is no P(F) to show." }
            (p.figure())
        }
        @for chart in others.iter().filter(|chart| chart.has_values()) { (chart.figure()) }
    }
}

/// What the bands' colours mean.
fn states(records: &[FrameRecord]) -> Markup {
    let mut shown = Vec::new();
    for record in records {
        if !shown.contains(&record.state) {
            shown.push(record.state);
        }
    }
    legend("state", shown.into_iter().map(palette::state).map(|(name, rgb)| (name.to_owned(), rgb)))
}

/// What the colours of the strip of weakest arms mean.
fn arms(records: &[FrameRecord]) -> Markup {
    let mut shown: Vec<&str> = records.iter().filter_map(weakest).collect();
    shown.sort_unstable();
    shown.dedup();
    legend("weakest", shown.into_iter().map(|label| (label.to_owned(), palette::sub_mask(label))))
}

fn legend(about: &str, entries: impl Iterator<Item = (String, palette::Rgb)>) -> Markup {
    html! {
        p class="legend" {
            (about) ": "
            @for (name, rgb) in entries {
                span class="chip" style={ "--chip:" (palette::css(rgb)) } { (name) }
            }
        }
    }
}

fn probability(input: &ReportInput<'_>, seconds: RangeInclusive<f64>) -> Chart {
    let records = input.records;
    let p = |record: &FrameRecord| {
        let sought = record.sought.as_ref().map(|sought| sought.p);
        record.feature.as_ref().map(|feature| feature.p).or(sought).flatten()
    };
    Chart {
        title: "P(F) of the feature followed or searched for; below, its weakest arm".to_owned(),
        unit: "P(F)",
        seconds,
        values: 0.0..=1.0,
        bands: bands(records, |record| {
            let (name, rgb) = palette::state(record.state);
            Some((name.to_owned(), palette::css(rgb)))
        }),
        strip: bands(records, |record| {
            weakest(record).map(|label| (format!("weakest: {label}"), palette::css(palette::sub_mask(label))))
        }),
        lines: vec![
            (input.thresholds.detect, format!("detected from {:.2}", input.thresholds.detect)),
            (input.thresholds.confirm, format!("confirmed from {:.2}", input.thresholds.confirm)),
        ],
        curves: vec![Curve { label: "P(F)", class: "one", points: series(records, p) }],
    }
}

fn distance(
    records: &[FrameRecord],
    truth: &BTreeMap<u64, &TruthRecord>,
    seconds: RangeInclusive<f64>,
) -> Chart {
    let reported = |record: &FrameRecord| record.feature.as_ref().map(|feature| feature.forward_m);
    let mut curves = vec![Curve { label: "reported", class: "one", points: by_feature(records, reported) }];
    if !truth.is_empty() {
        let real = |record: &FrameRecord| pair(record, truth).and_then(|(_, truth)| truth.feature_forward_m);
        curves.push(Curve { label: "truth", class: "two", points: by_feature(records, real) });
    }
    Chart {
        title: "Distance to the followed feature".to_owned(),
        unit: "metres ahead",
        seconds,
        values: 0.0..=10.0,
        bands: Vec::new(),
        strip: Vec::new(),
        lines: Vec::new(),
        curves,
    }
}

fn error(
    records: &[FrameRecord],
    truth: &BTreeMap<u64, &TruthRecord>,
    seconds: RangeInclusive<f64>,
) -> Chart {
    let error = |record: &FrameRecord| {
        let (feature, truth) = pair(record, truth)?;
        let (forward, left) = (truth.feature_forward_m?, truth.feature_left_m?);
        Some((feature.forward_m - forward).hypot(feature.left_m - left))
    };
    Chart {
        title: "Position error of the followed feature against truth".to_owned(),
        unit: "metres",
        seconds,
        values: 0.0..=0.5,
        bands: Vec::new(),
        strip: Vec::new(),
        lines: Vec::new(),
        curves: vec![Curve { label: "error", class: "three", points: by_feature(records, error) }],
    }
}

/// Speed by the motion of each frame; what a frame without motion hides is left out.
fn speed(
    records: &[FrameRecord],
    truth: &BTreeMap<u64, &TruthRecord>,
    seconds: RangeInclusive<f64>,
) -> Chart {
    let mut points = Vec::with_capacity(records.len());
    let mut before: Option<f64> = None;
    for record in records {
        let since = before.map(|before| record.t_s - before).filter(|since| *since > 0.0);
        let moved = record.motion.map(|motion| motion.forward_m);
        points.push((record.t_s, moved.zip(since).map(|(moved_m, since_s)| moved_m / since_s)));
        before = Some(record.t_s);
    }
    let mut curves = vec![Curve { label: "by ego-motion", class: "one", points }];
    if !truth.is_empty() {
        let real = |record: &FrameRecord| truth.get(&record.frame).map(|truth| truth.speed_mps);
        curves.push(Curve { label: "truth", class: "two", points: series(records, real) });
    }
    Chart {
        title: "Speed".to_owned(),
        unit: "metres a second",
        seconds,
        values: 0.0..=1.0,
        bands: Vec::new(),
        strip: Vec::new(),
        lines: Vec::new(),
        curves,
    }
}

fn truth_by_frame(truth: Option<&[TruthRecord]>) -> BTreeMap<u64, &TruthRecord> {
    truth.unwrap_or_default().iter().map(|truth| (truth.frame, truth)).collect()
}

/// A frame's feature and the truth about the same one.
fn pair<'a>(
    record: &'a FrameRecord,
    truth: &BTreeMap<u64, &'a TruthRecord>,
) -> Option<(&'a fingerpost_format::FeatureRecord, &'a TruthRecord)> {
    let feature = record.feature.as_ref()?;
    let truth = truth.get(&record.frame)?;
    (truth.feature_id == Some(feature.id)).then_some((feature, *truth))
}

/// The sub-mask with the least P(F_sub).
fn weakest(record: &FrameRecord) -> Option<&str> {
    let sub = &record.feature.as_ref()?.sub;
    sub.iter().min_by(|a, b| a.1.total_cmp(b.1)).map(|(label, _)| label.as_str())
}

pub(super) fn series(
    records: &[FrameRecord],
    value: impl Fn(&FrameRecord) -> Option<f64>,
) -> Vec<(f64, Option<f64>)> {
    records.iter().map(|record| (record.t_s, value(record))).collect()
}

/// As [`series`], cut where another feature is followed.
fn by_feature(
    records: &[FrameRecord],
    value: impl Fn(&FrameRecord) -> Option<f64>,
) -> Vec<(f64, Option<f64>)> {
    let mut points = Vec::with_capacity(records.len());
    let mut before = None;
    for record in records {
        let id = record.feature.as_ref().map(|feature| feature.id);
        if id != before {
            points.push((record.t_s, None));
        }
        before = id;
        points.push((record.t_s, value(record)));
    }
    points
}

/// Stretches of equal label and colour over time.
pub(super) fn bands(
    records: &[FrameRecord],
    band: impl Fn(&FrameRecord) -> Option<(String, String)>,
) -> Vec<Band> {
    let shortest = records.len().div_ceil(MAX_POINTS);
    stretches(records.iter().map(band), shortest)
        .into_iter()
        .filter_map(|(range, band)| {
            let (label, colour) = band?;
            let end = records.get(range.end).or(records.last())?.t_s;
            Some(Band { seconds: records.get(range.start)?.t_s..=end, label, colour })
        })
        .collect()
}
