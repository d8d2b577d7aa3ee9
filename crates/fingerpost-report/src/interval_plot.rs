//! Figures over settings, each a mean with its interval and the values behind it, an SVG picture of its own.

use maud::{Markup, html};

use crate::html::{joined, number, px, ticks};

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalPlot {
    /// Above it.
    pub title: String,
    /// What runs along the bottom.
    pub x_label: String,
    /// Its settings, one or more, side by side at even distances.
    pub xs: Vec<String>,
    /// What runs upwards, with its unit.
    pub y_label: String,
    /// The lines.
    pub series: Vec<IntervalSeries>,
}

/// A line of an [`IntervalPlot`].
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalSeries {
    /// Its name.
    pub label: String,
    /// For every setting what is known there.
    pub points: Vec<Option<IntervalPoint>>,
}

/// A mean, its interval and the values that it is the mean of.
#[derive(Debug, Clone, PartialEq)]
pub struct IntervalPoint {
    /// The mean.
    pub mean: f64,
    /// Lower and upper end of its interval; infinite ones are not drawn.
    pub interval: [f64; 2],
    /// The values.
    pub values: Vec<f64>,
}

const SIZE: [f64; 2] = [640.0, 330.0];
const LEFT: f64 = 56.0;
const RIGHT: f64 = 16.0;
const TOP: f64 = 64.0;
const BOTTOM: f64 = 48.0;
/// Distance of neighbouring lines at the same setting, so that their intervals can be told apart.
const APART: f64 = 12.0;
/// Half the width of an interval's ends.
const CAP: f64 = 4.0;
/// Room above and below the outermost values, as a share of what they span.
const ROOM: f64 = 0.05;
/// Colours that are told apart by people who see few colours too (M. Okabe and K. Ito, "Color universal design", 2008).
const COLOURS: [&str; 5] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"];

/// The plot as a whole SVG file. What is no number is left out.
///
/// ```
/// use fingerpost_report::{IntervalPlot, IntervalPoint, IntervalSeries, interval_svg};
/// let point = |mean| Some(IntervalPoint { mean, interval: [mean - 1.0, mean + 1.0], values: vec![mean] });
/// let svg = interval_svg(&IntervalPlot {
///     title: "Small pictures".into(),
///     x_label: "width".into(),
///     xs: vec!["150".into(), "512".into()],
///     y_label: "followed, %".into(),
///     series: vec![IntervalSeries { label: "wet & dry".into(), points: vec![point(80.0), point(90.0)] }],
/// });
/// assert!(svg.starts_with("<svg") && svg.contains("wet &amp; dry"));
/// ```
pub fn interval_svg(plot: &IntervalPlot) -> String {
    let [width, height] = SIZE;
    let (low, high) = limits(plot);
    let count = plot.xs.len().max(1) as f64;
    let step = (width - LEFT - RIGHT) / count;
    let middle = |i: usize| LEFT + (i as f64 + 0.5) * step;
    let shift = |s: usize| (s as f64 - 0.5 * (plot.series.len().saturating_sub(1)) as f64) * APART;
    let y = |v: f64| TOP + (high - v) / (high - low) * (height - TOP - BOTTOM);
    let colour = |s: usize| COLOURS[s % COLOURS.len()];
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (width) " " (height) } width=(width) height=(height)
            font-family="sans-serif" font-size="12" fill="#222" {
            rect width="100%" height="100%" fill="#fff" {}
            text x=(width / 2.0) y="20" font-size="14" text-anchor="middle" { (plot.title) }
            @for (s, series) in plot.series.iter().enumerate() {
                (key(s, plot.series.len(), &series.label, colour(s)))
            }
            @for v in ticks(low, high, 5) {
                line x1=(px(LEFT)) x2=(px(width - RIGHT)) y1=(px(y(v))) y2=(px(y(v))) stroke="#dde0e4" {}
                text x=(px(LEFT - 6.0)) y=(px(y(v) + 4.0)) text-anchor="end" { (number(v)) }
            }
            @for (i, name) in plot.xs.iter().enumerate() {
                text x=(px(middle(i))) y=(px(height - BOTTOM + 17.0)) text-anchor="middle" { (name) }
            }
            text x=(px(width - RIGHT)) y=(px(height - 8.0)) text-anchor="end" fill="#666" { (plot.x_label) }
            text x="8" y=(px(TOP - 8.0)) fill="#666" { (plot.y_label) }
            @for (s, series) in plot.series.iter().enumerate() {
                (line(series, |i| middle(i) + shift(s), y, colour(s)))
            }
        }
    };
    markup.into_string()
}

/// Lower and upper end of the scale: all values and means, and a little room.
fn limits(plot: &IntervalPlot) -> (f64, f64) {
    let points = || plot.series.iter().flat_map(|series| series.points.iter().flatten());
    let all = || {
        points().flat_map(|point| point.values.iter().chain([&point.mean])).copied().filter(|v| v.is_finite())
    };
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    if low > high {
        return (0.0, 1.0);
    }
    let span = if high > low { high - low } else { low.abs().max(1.0) };
    (low - ROOM * span, high + ROOM * span)
}

fn key(index: usize, count: usize, label: &str, colour: &str) -> Markup {
    let x = LEFT + index as f64 * (SIZE[0] - LEFT - RIGHT) / count.max(1) as f64;
    html! {
        rect x=(px(x)) y="31" width="10" height="10" fill=(colour) {}
        text x=(px(x + 15.0)) y="40" font-size="11" { (label) }
    }
}

fn line(
    series: &IntervalSeries,
    x: impl Fn(usize) -> f64 + Copy,
    y: impl Fn(f64) -> f64 + Copy,
    colour: &str,
) -> Markup {
    let known: Vec<(usize, &IntervalPoint)> = series
        .points
        .iter()
        .enumerate()
        .filter_map(|(i, point)| Some((i, point.as_ref().filter(|point| point.mean.is_finite())?)))
        .collect();
    let (bottom, top) = (SIZE[1] - BOTTOM, TOP);
    html! {
        @for (i, point) in &known {
            @for value in point.values.iter().filter(|value| value.is_finite()) {
                circle cx=(px(x(*i))) cy=(px(y(*value))) r="2" fill=(colour) fill-opacity="0.35" {}
            }
        }
        polyline points=(joined(known.iter().map(|(i, point)| [x(*i), y(point.mean)]))) fill="none" stroke=(colour)
            stroke-width="1.5" {}
        @for (i, point) in &known {
            @if point.interval.iter().all(|end| end.is_finite()) {
                @let ends = point.interval.map(|end| y(end).clamp(top, bottom));
                line x1=(px(x(*i))) x2=(px(x(*i))) y1=(px(ends[0])) y2=(px(ends[1])) stroke=(colour) stroke-width="1.5" {}
                @for end in ends {
                    line x1=(px(x(*i) - CAP)) x2=(px(x(*i) + CAP)) y1=(px(end)) y2=(px(end)) stroke=(colour) stroke-width="1.5" {}
                }
            }
            circle cx=(px(x(*i))) cy=(px(y(point.mean))) r="4" fill=(colour) {}
        }
    }
}
