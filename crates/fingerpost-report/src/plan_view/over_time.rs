//! Steering, speed and the distance from the lane's middle over time.

use fingerpost_format::LoopFrame;
use maud::{Markup, html};

use super::{LINES, colour};
use crate::html::{joined, number, px, ticks};
use crate::series::thinned_path;

/// Size of a curve's field and what is between two of them, picture units.
const FIELD: [f64; 2] = [878.0, 110.0];
const LEFT: f64 = 52.0;
const GAP: f64 = 30.0;
const STRIP: f64 = 8.0;
/// Height of all of them with the legend.
pub(super) const HEIGHT: f64 = 3.0 * (FIELD[1] + GAP) + 40.0;

/// A value of a frame.
type Value = fn(&LoopFrame) -> f64;

/// Curves in one field: their title, and of each its name, its colour and its values.
struct Curves {
    title: &'static str,
    least: [f64; 2],
    curves: &'static [(&'static str, &'static str, Value)],
}

const FIELDS: [Curves; 3] = [
    Curves {
        title: "angle of the front wheels, degrees, left is up",
        least: [-5.0, 5.0],
        curves: &[
            ("advised", "#1f78b4", |frame| frame.advised_steer_rad.to_degrees()),
            ("driven", "#333", |frame| frame.steer_rad.to_degrees()),
        ],
    },
    Curves {
        title: "speed, m/s",
        least: [0.0, 5.0],
        curves: &[
            ("advised", "#1f78b4", |frame| frame.advised_speed_mps),
            ("driven", "#333", |frame| frame.speed_mps),
        ],
    },
    Curves {
        title: "left of the lane's middle, metres",
        least: [-1.0, 1.0],
        curves: &[("driven", "#333", |frame| frame.left_m)],
    },
];

/// The fields below each other, over a strip of what is steered along.
pub(super) fn charts(frames: &[LoopFrame]) -> Markup {
    let end_s = frames.last().map_or(1.0, |frame| frame.t_s.max(1.0));
    let x = |t_s: f64| LEFT + FIELD[0] * t_s / end_s;
    html! {
        @for (i, field) in FIELDS.iter().enumerate() {
            g transform={ "translate(0 " (px(i as f64 * (FIELD[1] + GAP))) ")" } {
                (curves(frames, field, &x))
                (strip(frames, &x))
                @for t_s in ticks(0.0, end_s, 12) {
                    text x=(px(x(t_s))) y=(px(FIELD[1] + STRIP + 14.0)) text-anchor="middle" font-size="10"
                        fill="#666" { (number(t_s)) " s" }
                }
            }
        }
        g transform={ "translate(0 " (px(3.0 * (FIELD[1] + GAP) + 16.0)) ")" } {
            text x=(LEFT) y="0" { "Steered along:" }
            @for (i, (_, name, colour)) in LINES.iter().enumerate() {
                @let left = LEFT + 110.0 + 140.0 * i as f64;
                rect x=(left) y="-9" width="18" height="9" fill=(colour) {}
                text x=(left + 24.0) y="0" { (name) }
            }
            text x=(LEFT + 680.0) y="0" fill="#666" { "rings: a wheel off the road" }
        }
    }
}

fn curves(frames: &[LoopFrame], field: &Curves, x: &dyn Fn(f64) -> f64) -> Markup {
    let values = field.curves.iter().flat_map(|(.., value)| frames.iter().map(*value));
    let [low, high] = values
        .filter(|value| value.is_finite())
        .fold(field.least, |[low, high], value| [low.min(value), high.max(value)]);
    let y = |value: f64| FIELD[1] * (high - value) / (high - low);
    html! {
        text x=(LEFT) y="-6" fill="#444" {
            (field.title)
            @for (name, colour, _) in field.curves { tspan dx="14" fill=(colour) { (name) } }
        }
        @for tick in ticks(low, high, 4) {
            line x1=(LEFT) x2=(LEFT + FIELD[0]) y1=(px(y(tick))) y2=(px(y(tick))) stroke="#e3e5e8" {}
            text x=(LEFT - 6.0) y=(px(y(tick) + 4.0)) text-anchor="end" font-size="10" fill="#666" { (number(tick)) }
        }
        @for (_, colour, value) in field.curves {
            @let points = frames.iter().map(|frame| [x(frame.t_s), y(value(frame))]);
            polyline points=(joined(thinned_path(points, 0.5).into_iter())) fill="none" stroke=(colour)
                stroke-width="1.3" {}
        }
    }
}

fn strip(frames: &[LoopFrame], x: &dyn Fn(f64) -> f64) -> Markup {
    let mut pieces: Vec<(&str, f64, f64)> = Vec::new();
    for pair in frames.windows(2) {
        let (colour, from_s, to_s) = (colour(&pair[0]), pair[0].t_s, pair[1].t_s);
        match pieces.last_mut() {
            Some(last) if last.0 == colour => last.2 = to_s,
            _ => pieces.push((colour, from_s, to_s)),
        }
    }
    html! {
        @for (colour, from_s, to_s) in pieces {
            rect x=(px(x(from_s))) y=(px(FIELD[1] + 1.0)) width=(px((x(to_s) - x(from_s)).max(0.5))) height=(STRIP)
                fill=(colour) {}
        }
    }
}
