//! Probability that the feature is there, P(F), distance and position error of a run over time.

use std::ops::RangeInclusive;

use maud::{Markup, html};

use super::chart::{Band, Chart, Curve};
use super::{ReportInput, Thresholds};
use crate::palette;
use crate::series::{Series, Stretches};
use crate::timeline::Compared;

/// The charts.
pub(crate) fn curves(input: &ReportInput<'_>) -> Markup {
    let timeline = input.timeline;
    let Some(seconds) = &timeline.seconds else {
        return html! { p { "No frame was processed." } };
    };
    let p = probability(input);
    let chart = |title: &str, unit, values, curves| Chart {
        curves,
        ..Chart::over(seconds.clone(), title, unit, values)
    };
    let error = Curve { label: "error", class: "three", values: &timeline.error_m };
    let others = [
        chart(
            "Distance to the followed feature",
            "metres ahead",
            0.0..=10.0,
            compared("reported", &timeline.distance_m),
        ),
        chart("Position error of the followed feature against truth", "metres", 0.0..=0.5, vec![error]),
        chart("Speed", "metres a second", 0.0..=1.0, compared("by ego-motion", &timeline.speed_mps)),
    ];
    let states = timeline.states_seen.iter().map(|&state| palette::state(state));
    let states = states.map(|(name, rgb)| (name.to_owned(), rgb));
    let weakest = timeline.weakest_seen.iter().map(|label| (label.clone(), palette::sub_mask(label)));
    html! {
        (legend("state", states))
        @if p.has_values() {
            (p.figure())
            (legend("weakest", weakest))
        } @else {
            p { "No feature of the route came into view, so there is no probability to show." }
            (p.figure())
        }
        @for chart in others.iter().filter(|chart| chart.has_values()) { (chart.figure()) }
    }
}

/// What the colours mean.
pub(crate) fn legend(about: &str, entries: impl Iterator<Item = (String, palette::Rgb)>) -> Markup {
    html! {
        p class="legend" {
            (about) ": "
            @for (name, rgb) in entries {
                span class="chip" style={ "--chip:" (palette::css(rgb)) } { (name) }
            }
        }
    }
}

fn probability<'a>(input: &ReportInput<'a>) -> Chart<'a> {
    let timeline = input.timeline;
    let seconds = timeline.seconds.clone().unwrap_or(0.0..=0.0);
    let title = "Probability that the feature followed or searched for is there, and P(F) of its masks; below, its weakest arm";
    let there = Curve { label: "there", class: "two", values: &timeline.present };
    let by_match = Curve { label: "P(F)", class: "one", values: &timeline.match_p };
    let Thresholds { detect, lost } = input.thresholds;
    Chart {
        bands: bands(&seconds, &timeline.states, |&state| {
            let (name, rgb) = palette::state(state);
            Some((name.to_owned(), palette::css(rgb)))
        }),
        strip: bands(&seconds, &timeline.weakest, |label| {
            let label = label.as_ref()?;
            Some((format!("weakest: {label}"), palette::css(palette::sub_mask(label))))
        }),
        lines: vec![(detect, format!("tracked from {detect:.2}")), (lost, format!("lost below {lost:.2}"))],
        curves: vec![there, by_match],
        ..Chart::over(seconds, title, "probability", 0.0..=1.0)
    }
}

/// A value and, where there is one, its truth.
fn compared<'a>(label: &'static str, values: &'a Compared) -> Vec<Curve<'a>> {
    let curve = |label, class, values: &'a Series| Curve { label, class, values };
    let mut curves = vec![curve(label, "one", &values.reported)];
    if !values.truth.is_empty() {
        curves.push(curve("truth", "two", &values.truth));
    }
    curves
}

/// Stretches of equal label and colour over time.
pub(crate) fn bands<T: PartialEq + Clone>(
    seconds: &RangeInclusive<f64>,
    stretches: &Stretches<T>,
    band: impl Fn(&T) -> Option<(String, String)>,
) -> Vec<Band> {
    let stretches = stretches.joined();
    let ends = stretches.iter().skip(1).map(|next| next.start).chain([*seconds.end()]);
    let bands = stretches.iter().zip(ends).filter_map(|(stretch, end)| {
        let (label, colour) = band(&stretch.value)?;
        Some(Band { seconds: stretch.start..=end, label, colour })
    });
    bands.collect()
}
