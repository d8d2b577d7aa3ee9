//! A closed-loop drive from above, and what was advised over time: an SVG picture of its own.

mod over_time;

use fingerpost_format::{LoopDrive, LoopFrame};
use maud::{Markup, html};
use nalgebra::Point2;

use crate::html::{Fit, Sheet, px};

/// What is drawn.
#[derive(Debug, Clone, Copy)]
pub struct PlanView<'a> {
    /// The drive in numbers.
    pub drive: &'a LoopDrive,
    /// Its frames.
    pub frames: &'a [LoopFrame],
    /// The middle of the lane along the route, map frame, metres.
    pub lane_middle: &'a [Point2<f64>],
    /// The roads: ends of an axis, map frame, and half of the width, metres.
    pub roads: &'a [([Point2<f64>; 2], f64)],
}

/// Room for the plan.
const SHEET: Sheet = Sheet { width: 960.0, max_height: 620.0, margin: 34.0 };
/// Above the plan.
const TITLE: f64 = 46.0;
/// A mark every so many seconds.
const MARK_EVERY_S: f64 = 10.0;

/// Colour of what is steered along, by its name; the last one is that of nothing.
pub(super) const LINES: [(&str, &str, &str); 4] = [
    ("driving_line", "driving line", "#1a9850"),
    ("lane", "lane", "#7b3fb5"),
    ("centreline", "road's middle", "#d95f02"),
    ("", "nothing", "#d7191c"),
];

pub(super) fn colour(frame: &LoopFrame) -> &'static str {
    let name = if frame.has_line { frame.line.as_str() } else { "" };
    LINES.iter().find(|(line, ..)| *line == name).unwrap_or(&LINES[3]).2
}

/// The picture as a whole SVG file.
pub fn plan_view_svg(plan: &PlanView<'_>) -> String {
    let PlanView { drive, frames, .. } = *plan;
    let driven = frames.iter().map(|frame| Point2::new(frame.x_m, frame.y_m));
    let fit = Fit::new(SHEET, plan.lane_middle.iter().copied().chain(driven));
    let charts_at = TITLE + fit.height() + 24.0;
    let height = charts_at + over_time::HEIGHT;
    let title = format!("{} {}, {}: {}", drive.conditions, drive.seed, drive.controller, drive.end.words());
    let markup = html! {
        svg xmlns="http://www.w3.org/2000/svg" viewBox={ "0 0 " (SHEET.width) " " (px(height)) }
            width=(SHEET.width) height=(px(height)) font-family="sans-serif" font-size="12" fill="#222" {
            rect width="100%" height="100%" fill="#fff" {}
            text x="34" y="20" font-size="15" { (title) }
            text x="34" y="38" fill="#666" { (drive.because) }
            g transform={ "translate(0 " (TITLE) ")" } { (from_above(plan, &fit)) }
            g transform={ "translate(0 " (px(charts_at)) ")" } { (over_time::charts(frames)) }
        }
    };
    markup.into_string()
}

fn from_above(plan: &PlanView<'_>, fit: &Fit) -> Markup {
    let px_per_m = fit.px_per_m();
    let inside = |axis: &[Point2<f64>; 2]| fit.shows(fit.at(axis[0]), fit.at(axis[1]));
    let at = |frame: &LoopFrame| fit.at(Point2::new(frame.x_m, frame.y_m));
    html! {
        svg x="0" y="0" width=(SHEET.width) height=(px(fit.height())) {
            g stroke="#d4d6da" stroke-linecap="round" fill="none" {
                @for (axis, half_width_m) in plan.roads.iter().filter(|(axis, _)| inside(axis)) {
                    @let ([x1, y1], [x2, y2]) = (fit.at(axis[0]), fit.at(axis[1]));
                    line x1=(px(x1)) y1=(px(y1)) x2=(px(x2)) y2=(px(y2))
                        stroke-width=(px(2.0 * half_width_m * px_per_m)) {}
                }
            }
            polyline points=(fit.path(plan.lane_middle.iter().copied())) fill="none" stroke="#8a8f98"
                stroke-width="1" stroke-dasharray="5 4" {}
            @for (colour, points) in stretches(plan.frames, fit) {
                polyline points=(points) fill="none" stroke=(colour) stroke-width="2" {}
            }
            @for frame in plan.frames.iter().filter(|frame| frame.wheel_off_m > 0.0) {
                @let [x, y] = at(frame);
                circle cx=(px(x)) cy=(px(y)) r="3" fill="none" stroke="#d7191c" {}
            }
            @for (s, frame) in marks(plan.frames) {
                @let [x, y] = at(frame);
                circle cx=(px(x)) cy=(px(y)) r="2.5" fill="#222" {}
                text x=(px(x + 5.0)) y=(px(y - 4.0)) fill="#555" font-size="10" { (s) " s" }
            }
        }
    }
}

/// The path in pieces that were steered along one line each, with their colours; each begins where the one before ended.
fn stretches(frames: &[LoopFrame], fit: &Fit) -> Vec<(&'static str, String)> {
    let mut pieces = Vec::new();
    let mut from = 0;
    for i in 1..=frames.len() {
        if i == frames.len() || colour(&frames[i]) != colour(&frames[from]) {
            let piece = &frames[from..frames.len().min(i + 1)];
            let points = piece.iter().map(|frame| Point2::new(frame.x_m, frame.y_m));
            pieces.push((colour(&frames[from]), fit.path(points)));
            from = i;
        }
    }
    pieces
}

/// The first frame of every ten seconds.
fn marks(frames: &[LoopFrame]) -> Vec<(f64, &LoopFrame)> {
    let mut next_s = 0.0;
    let mut marks = Vec::new();
    for frame in frames {
        if frame.t_s >= next_s {
            marks.push((next_s, frame));
            next_s += MARK_EVERY_S;
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_changes_its_colour_with_what_is_steered_along_and_stays_in_one_piece() {
        let frames: Vec<LoopFrame> = (0..300)
            .map(|i| LoopFrame {
                t_s: 0.1 * f64::from(i),
                x_m: 0.5 * f64::from(i),
                line: (if i < 100 { "lane" } else { "driving_line" }).to_owned(),
                has_line: i < 250,
                wheel_off_m: if i == 200 { 0.2 } else { -1.0 },
                ..LoopFrame::default()
            })
            .collect();
        let middle = [Point2::new(0.0, 0.0), Point2::new(150.0, 0.0)];
        let roads = [(middle, 2.75)];
        let drive = LoopDrive { because: "stop: lost".to_owned(), ..LoopDrive::default() };
        let plan = PlanView { drive: &drive, frames: &frames, lane_middle: &middle, roads: &roads };
        let svg = plan_view_svg(&plan);
        for (line, _, colour) in LINES {
            let drawn = svg.contains(&format!("fill=\"none\" stroke=\"{colour}\" stroke-width=\"2\""));
            assert_eq!(drawn, line != "centreline", "{line}");
        }
        assert!(svg.contains("stop: lost") && svg.contains("20 s"));
        let fit = Fit::new(SHEET, middle);
        let pieces = stretches(&frames, &fit);
        assert_eq!(pieces.len(), 3);
        for pair in pieces.windows(2) {
            assert_eq!(pair[0].1.rsplit(' ').next(), pair[1].1.split(' ').next());
        }
    }
}
