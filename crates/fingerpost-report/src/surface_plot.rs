//! A table of percentages over two variables as a surface seen from the front, an SVG picture of its own.

use maud::{Markup, html};

use crate::html::{joined, number, px};
use crate::palette::{css, heat};

/// What is drawn: a percentage for every pair of `xs` and `ys`.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePlot {
    /// Above it.
    pub title: String,
    /// What runs along the front.
    pub x_label: String,
    /// Its values, two or more.
    pub xs: Vec<f64>,
    /// What runs into the depth.
    pub y_label: String,
    /// Its values, two or more.
    pub ys: Vec<f64>,
    /// What runs upwards.
    pub z_label: String,
    /// Percentages: for every one of `ys` those of all `xs`.
    pub percent: Vec<Vec<f64>>,
}

/// The box around the surface: its foremost lower corner, and where one step along each axis leads, picture units.
const ORIGIN: [f64; 2] = [96.0, 372.0];
const ALONG_X: [f64; 2] = [300.0, 76.0];
const ALONG_Y: [f64; 2] = [246.0, -104.0];
const UP: f64 = -220.0;
const SIZE: [f64; 2] = [720.0, 500.0];
/// The scale starts at the next lower multiple of this, and is at least so long.
const SCALE_STEP_PCT: f64 = 5.0;

/// What the file says of itself, so that it is told from a user's.
const WRITTEN_BY: &str = "a surface of percentages by fingerpost";

/// A place in the box, each coordinate 0 to 1.
fn at(x: f64, y: f64, z: f64) -> [f64; 2] {
    [ORIGIN[0] + x * ALONG_X[0] + y * ALONG_Y[0], ORIGIN[1] + x * ALONG_X[1] + y * ALONG_Y[1] + z * UP]
}

/// Whether a text is one of [`surface_svg`].
pub fn is_surface_svg(text: &str) -> bool {
    text.starts_with("<svg") && text.contains(&format!("<metadata>{WRITTEN_BY}</metadata>"))
}

/// The surface as a whole SVG file. Values that are missing or no numbers are drawn at the scale's lower end.
///
/// ```
/// use fingerpost_report::{SurfacePlot, surface_svg};
/// let svg = surface_svg(&SurfacePlot {
///     title: "mean accuracy".into(),
///     x_label: "threshold".into(),
///     xs: vec![10.0, 20.0],
///     y_label: "rows".into(),
///     ys: vec![100.0, 150.0],
///     z_label: "%".into(),
///     percent: vec![vec![90.0, 95.0], vec![91.0, 97.5]],
/// });
/// assert!(svg.starts_with("<svg") && svg.contains("97.5") && fingerpost_report::is_surface_svg(&svg));
/// ```
pub fn surface_svg(plot: &SurfacePlot) -> String {
    let lowest = plot.percent.iter().flatten().copied().filter(|p| p.is_finite()).fold(100.0, f64::min);
    let low = ((lowest / SCALE_STEP_PCT).floor() * SCALE_STEP_PCT).clamp(0.0, 100.0 - SCALE_STEP_PCT);
    let share = |values: &[f64], index: usize| {
        let (first, last) = (values.first().copied(), values.last().copied());
        let (first, last) = (first.unwrap_or_default(), last.unwrap_or_default());
        let length = if last > first { last - first } else { 1.0 };
        values.get(index).map_or(0.0, |value| (value - first) / length)
    };
    let value = |j: usize, i: usize| {
        plot.percent.get(j).and_then(|row| row.get(i)).copied().filter(|p| p.is_finite()).unwrap_or(low)
    };
    let up = |percent: f64| ((percent - low) / (100.0 - low)).clamp(0.0, 1.0);
    let corner = |j: usize, i: usize| at(share(&plot.xs, i), share(&plot.ys, j), up(value(j, i)));
    let steps = if 100.0 - low > 5.0 * SCALE_STEP_PCT { 10.0 } else { SCALE_STEP_PCT };
    let steps = if 100.0 - low > SCALE_STEP_PCT { steps } else { 1.0 };
    let ticks = (0_u32..).map(|k| low + f64::from(k) * steps).take_while(|tick| *tick <= 100.0);
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (SIZE[0]) " " (SIZE[1]) } width=(SIZE[0])
            height=(SIZE[1]) font-family="sans-serif" font-size="13" fill="#222" {
            metadata { (WRITTEN_BY) }
            rect width="100%" height="100%" fill="#fff" {}
            text x=(SIZE[0] / 2.0) y="24" font-size="16" text-anchor="middle" { (plot.title) }
            @for tick in ticks {
                (line(&[at(0.0, 0.0, up(tick)), at(0.0, 1.0, up(tick)), at(1.0, 1.0, up(tick))], "#c8ccd2"))
                (label(at(0.0, 0.0, up(tick)), [-8.0, 4.0], "end", &number(tick)))
            }
            (line(&[at(0.0, 0.0, 1.0), at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.0), at(1.0, 1.0, 0.0), at(1.0, 1.0, 1.0)], "#555"))
            @for i in 0..plot.xs.len() {
                (label(at(share(&plot.xs, i), 0.0, 0.0), [-4.0, 20.0], "middle", &number(plot.xs[i])))
            }
            @for j in 0..plot.ys.len() {
                (label(at(1.0, share(&plot.ys, j), 0.0), [10.0, 14.0], "start", &number(plot.ys[j])))
            }
            (label(at(0.5, 0.0, 0.0), [-40.0, 46.0], "middle", &plot.x_label))
            (label(at(1.0, 0.5, 0.0), [44.0, 36.0], "start", &plot.y_label))
            (label(at(0.0, 0.0, 1.0), [-8.0, -16.0], "middle", &plot.z_label))
            // Far pieces first, so that near ones cover them.
            @for j in (1..plot.ys.len()).rev() {
                @for i in 1..plot.xs.len() {
                    (piece(
                        [corner(j - 1, i - 1), corner(j - 1, i), corner(j, i), corner(j, i - 1)],
                        (value(j - 1, i - 1) + value(j - 1, i) + value(j, i) + value(j, i - 1)) / 4.0,
                        low,
                    ))
                }
            }
            @for j in 0..plot.ys.len() {
                @for i in 0..plot.xs.len() {
                    (label(corner(j, i), [0.0, -7.0], "middle", &format!("{:.1}", value(j, i))))
                }
            }
        }
    };
    markup.into_string()
}

fn piece(corners: [[f64; 2]; 4], percent: f64, low: f64) -> Markup {
    let share = ((percent - low) / (100.0 - low)).clamp(0.0, 1.0);
    let fill = css(heat((255.0 * share).round() as u8));
    html! {
        polygon points=(joined(corners.into_iter())) fill=(fill) fill-opacity="0.85" stroke="#222" stroke-width="0.8" {}
    }
}

fn line(points: &[[f64; 2]], colour: &str) -> Markup {
    html! { polyline points=(joined(points.iter().copied())) fill="none" stroke=(colour) {} }
}

fn label([x, y]: [f64; 2], [right, down]: [f64; 2], anchor: &str, text: &str) -> Markup {
    // A white rim keeps numbers readable on dark pieces.
    html! {
        text x=(px(x + right)) y=(px(y + down)) text-anchor=(anchor) stroke="#fff" stroke-width="3"
            paint-order="stroke" { (text) }
    }
}
