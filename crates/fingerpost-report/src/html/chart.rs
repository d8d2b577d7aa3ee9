//! Curves over time as inline SVG.

use std::fmt::Write;
use std::ops::RangeInclusive;

use maud::{Markup, html};

use crate::series::Series;

/// A curve.
pub(crate) struct Curve<'a> {
    pub(crate) label: &'static str,
    /// CSS class that colours it.
    pub(crate) class: &'static str,
    /// The values over seconds.
    pub(crate) values: &'a Series,
}

/// A stretch of time in a colour.
pub(crate) struct Band {
    pub(crate) seconds: RangeInclusive<f64>,
    pub(crate) label: String,
    pub(crate) colour: String,
}

/// How values are laid out along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scale {
    Linear,
    /// Values below the axis, as zero is, lie at its lower end.
    Logarithmic,
}

impl Scale {
    /// Where a value lies between two others: 0 at the first, 1 at the second.
    pub(crate) fn share(self, value: f64, [low, high]: [f64; 2]) -> f64 {
        match self {
            Self::Linear => (value - low) / (high - low),
            Self::Logarithmic => libm::log(value.max(low) / low) / libm::log(high / low),
        }
    }

    /// Round numbers from `low` to `high`, at most about `count` of them, or the powers of ten.
    pub(crate) fn ticks(self, [low, high]: [f64; 2], count: usize) -> Vec<f64> {
        match self {
            Self::Linear => ticks(low, high, count),
            Self::Logarithmic => {
                let (first, last) = (libm::log10(low).ceil() as i32, libm::log10(high).floor() as i32);
                (first..=last).map(|power| 10_f64.powi(power)).collect()
            }
        }
    }
}

/// Curves over the same time.
pub(crate) struct Chart<'a> {
    pub(crate) title: String,
    pub(crate) unit: &'static str,
    pub(crate) scale: Scale,
    pub(crate) seconds: RangeInclusive<f64>,
    /// Values that are shown at least; where the scale is logarithmic, none below them is.
    pub(crate) values: RangeInclusive<f64>,
    /// Behind the curves.
    pub(crate) bands: Vec<Band>,
    /// In a strip of their own below the curves.
    pub(crate) strip: Vec<Band>,
    /// Values with a line across and their names.
    pub(crate) lines: Vec<(f64, String)>,
    pub(crate) curves: Vec<Curve<'a>>,
}

const WIDTH: f64 = 960.0;
const HEIGHT: f64 = 230.0;
const LEFT: f64 = 52.0;
const RIGHT: f64 = 14.0;
const TOP: f64 = 12.0;
const BOTTOM: f64 = 44.0;
const STRIP: f64 = 10.0;

impl Chart<'_> {
    /// A chart with nothing in it yet.
    pub(crate) fn over(
        seconds: RangeInclusive<f64>,
        title: &str,
        unit: &'static str,
        values: RangeInclusive<f64>,
    ) -> Self {
        let (bands, strip, lines, curves) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let scale = Scale::Linear;
        Self { title: title.to_owned(), unit, scale, seconds, values, bands, strip, lines, curves }
    }

    /// Whether there is anything to be seen in it.
    pub(crate) fn has_values(&self) -> bool {
        self.curves.iter().any(|curve| !curve.values.is_empty())
    }

    /// The chart as a figure.
    pub(crate) fn figure(&self) -> Markup {
        let (mut low, mut high) = (*self.values.start(), *self.values.end());
        for (least, greatest) in self.curves.iter().filter_map(|curve| curve.values.extent()) {
            low = if self.scale == Scale::Linear { low.min(least) } else { low };
            high = high.max(greatest);
        }
        let high = if high > low { high } else { low + 1.0 };
        let (t0, t1) = (*self.seconds.start(), self.seconds.end().max(self.seconds.start() + 1e-3));
        let x = |t: f64| LEFT + (t - t0) / (t1 - t0) * (WIDTH - LEFT - RIGHT);
        let y = |v: f64| TOP + (1.0 - self.scale.share(v, [low, high])) * (HEIGHT - TOP - BOTTOM);
        let floor = HEIGHT - BOTTOM;
        let band = |band: &Band, top: f64, height: f64, opacity: &str| {
            let (from, to) = (x(*band.seconds.start()), x(*band.seconds.end()));
            html! {
                rect x=(px(from)) y=(px(top)) width=(px(to - from)) height=(px(height)) fill=(band.colour)
                    fill-opacity=(opacity) { title { (band.label) } }
            }
        };
        html! {
            figure class="chart" {
                figcaption {
                    (self.title)
                    @for curve in &self.curves { span class={ "key " (curve.class) } { (curve.label) } }
                }
                svg viewBox={ "0 0 " (WIDTH) " " (HEIGHT) } role="img" aria-label=(self.title) {
                    @for b in &self.bands { (band(b, TOP, floor - TOP, "0.22")) }
                    @for b in &self.strip { (band(b, floor + 3.0, STRIP, "1")) }
                    @for v in self.scale.ticks([low, high], 5) {
                        line class="grid" x1=(px(LEFT)) x2=(px(WIDTH - RIGHT)) y1=(px(y(v))) y2=(px(y(v))) {}
                        text x=(px(LEFT - 6.0)) y=(px(y(v) + 4.0)) text-anchor="end" { (number(v)) }
                    }
                    @for t in ticks(t0, t1, 10) {
                        line class="tick" x1=(px(x(t))) x2=(px(x(t))) y1=(px(floor)) y2=(px(floor + 4.0)) {}
                        text x=(px(x(t))) y=(px(floor + 28.0)) text-anchor="middle" { (number(t)) }
                    }
                    text x=(px(WIDTH - RIGHT)) y=(px(HEIGHT - 3.0)) text-anchor="end" class="dim" { "seconds" }
                    text x="2" y=(px(HEIGHT - 3.0)) class="dim" { (self.unit) }
                    @for (value, label) in &self.lines {
                        line class="threshold" x1=(px(LEFT)) x2=(px(WIDTH - RIGHT)) y1=(px(y(*value)))
                            y2=(px(y(*value))) {}
                        text x=(px(WIDTH - RIGHT - 4.0)) y=(px(y(*value) - 4.0)) text-anchor="end" { (label) }
                    }
                    @for curve in &self.curves {
                        @for piece in curve.values.pieces() {
                            @if let [(t, v)] = piece[..] {
                                circle class=(curve.class) cx=(px(x(t))) cy=(px(y(v))) r="2" {}
                            } @else {
                                polyline class=(curve.class)
                                    points=(joined(piece.iter().map(|&(t, v)| [x(t), y(v)]))) {}
                            }
                        }
                    }
                }
            }
        }
    }
}

/// Points as SVG has them.
pub(crate) fn joined(points: impl Iterator<Item = [f64; 2]>) -> String {
    points.fold(String::new(), |mut text, [x, y]| {
        if !text.is_empty() {
            text.push(' ');
        }
        // Writing to a string cannot fail.
        let _ = write!(text, "{},{}", px(x), px(y));
        text
    })
}

/// A coordinate to a tenth of a pixel.
pub(crate) fn px(value: f64) -> String {
    let text = format!("{value:.1}");
    text.strip_suffix(".0").map_or_else(|| text.clone(), str::to_owned)
}

/// A number with as many digits as it needs.
pub(crate) fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Round numbers from `low` to `high`, at most about `count` of them: 1, 2 or 5 times a power of ten apart.
pub(crate) fn ticks(low: f64, high: f64, count: usize) -> Vec<f64> {
    let least = (high - low) / count.max(1) as f64;
    if !(least.is_finite() && least > 0.0) {
        return Vec::new();
    }
    let power = libm::pow(10_f64, libm::log10(least).floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|s| *s >= least).unwrap_or(least);
    let (first, last) = ((low / step).ceil() as i64, (high / step + 1e-9).floor() as i64);
    (first..=last).map(|k| k as f64 * step).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks(0.0, 1.0, 5).len(), 6);
        assert_eq!(ticks(0.0, 130.0, 10), [0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0]);
        assert!(ticks(1.0, 1.0, 5).is_empty() && ticks(0.0, f64::NAN, 5).is_empty());
    }

    #[test]
    fn a_logarithmic_axis_has_a_line_a_decade() {
        let axis = [0.1, 1000.0];
        assert_eq!(Scale::Logarithmic.ticks(axis, 5), [0.1, 1.0, 10.0, 100.0, 1000.0]);
        let shares = [0.0, 0.1, 10.0, 1000.0].map(|value| Scale::Logarithmic.share(value, axis));
        for (share, expected) in shares.into_iter().zip([0.0, 0.0, 0.5, 1.0]) {
            assert!((share - expected).abs() < 1e-12, "{shares:?}");
        }
    }

    #[test]
    fn numbers_are_short() {
        assert_eq!([number(0.5), number(20.0), px(3.04), px(-0.26)], ["0.5", "20", "3", "-0.3"]);
    }
}
