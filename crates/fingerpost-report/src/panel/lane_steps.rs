//! The steps from the region of interest to the lines of its sections, as figures 4 to 12 of paper 3 show them.

use std::ops::Range;

use fingerpost::lanes::{EdgeSteps, LaneEvidence, LineVerdict};
use fingerpost_vision::components::{ConnectedComponents, Connectivity};
use fingerpost_vision::picture::{Plane, Rect};

use super::fitted;
use crate::draw::{Canvas, Paint, TextSize};
use crate::palette::{self, Rgb};
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "From the region of interest to the lane's lines: grey, the mean of the last frames; its edges; \
    those with a direction that a marking can have; the same joined and labelled, pieces that are too small in red; what is left of \
    it; thinned, with the sections and their straight lines, white where kept and red where not.";

/// Steps that are shown.
const STEPS: usize = 6;
const GAP_PX: usize = 6;
const TITLE_PX: usize = 16;

/// What the lane finder made of the frame; none where it did not look at the picture.
pub(crate) fn shown<'a>(scene: &Scene<'a>) -> Option<&'a LaneEvidence> {
    scene.evidence.lanes.filter(|evidence| !evidence.steps.thin.as_slice().is_empty())
}

/// Height of the steps in two columns of a width, pixels.
pub(crate) fn height_px(evidence: &LaneEvidence, width: usize) -> usize {
    let (columns, rows) = evidence.steps.thin.size();
    let tile = (width - GAP_PX) / 2;
    let height = (tile as f64 * rows as f64 / columns as f64).ceil() as usize;
    STEPS / 2 * (height + TITLE_PX) + (STEPS / 2 - 1) * GAP_PX
}

/// Draws the steps beside and below each other, as large as `room` allows.
pub(crate) fn draw(canvas: &mut Canvas, room: Rect, evidence: &LaneEvidence) {
    let size = evidence.steps.thin.size();
    let tile = |columns: usize| {
        let lines = STEPS.div_ceil(columns);
        let width = (room.width.saturating_sub((columns - 1) * GAP_PX)) / columns;
        let height = (room.height.saturating_sub((lines - 1) * GAP_PX)) / lines;
        fitted(size, Rect { width, height: height.saturating_sub(TITLE_PX), ..room })
    };
    let columns = (1..=3).max_by_key(|columns| tile(*columns).width).unwrap_or(1);
    let labels = Labels::of(&evidence.steps);
    for step in 0..STEPS {
        let tile = tile(columns);
        let corner = [
            room.x + step % columns * (tile.width + GAP_PX),
            room.y + step / columns * (tile.height + TITLE_PX + GAP_PX),
        ];
        let area = Rect { x: corner[0], y: corner[1] + TITLE_PX, ..tile };
        let title = draw_step(canvas, area, evidence, &labels, step);
        canvas.clipped(Rect { x: corner[0], y: corner[1], width: tile.width, height: TITLE_PX }, |canvas| {
            canvas.text(corner.map(|c| c as f64), TextSize::Small, palette::TEXT_DIM, title);
        });
    }
}

/// Draws a step and says what it is.
fn draw_step(
    canvas: &mut Canvas,
    area: Rect,
    evidence: &LaneEvidence,
    labels: &Labels,
    step: usize,
) -> &'static str {
    let steps = &evidence.steps;
    let white = |plane: &Plane<u8>, u: usize, v: usize| {
        plane.get(u, v).filter(|level| *level != 0).map(|_| palette::TEXT)
    };
    let mut marked = |plane: &Plane<u8>| dots(canvas, area, plane.size(), |u, v| white(plane, u, v));
    match step {
        0 => {
            let mean = &steps.mean;
            canvas.picture(area, mean.size(), |u, v| [mean.get(u, v).unwrap_or(0); 3]);
            "grey, buffered"
        }
        1 => {
            marked(&steps.edges);
            "edges"
        }
        2 => {
            marked(&steps.oriented);
            "by orientation"
        }
        3 => {
            dots(canvas, area, steps.dilated.size(), |u, v| labels.colour(steps, u, v));
            "dilated, labelled"
        }
        4 => {
            marked(&steps.labelled);
            "large enough"
        }
        _ => {
            marked(&steps.thin);
            canvas.clipped(area, |canvas| lines(canvas, area, evidence));
            "thinned, lines"
        }
    }
}

/// Fills an area with a dot wherever any of the pixels beneath has a colour, so that thin lines stay whole when made smaller.
fn dots(
    canvas: &mut Canvas,
    area: Rect,
    source: (usize, usize),
    colour_at: impl Fn(usize, usize) -> Option<Rgb>,
) {
    let beneath = |at: usize, length: usize, source: usize| {
        let [from, to] = [at, at + 1].map(|at| at * source / length);
        from..to.max(from + 1).min(source)
    };
    let columns: Vec<Range<usize>> = (0..area.width).map(|x| beneath(x, area.width, source.0)).collect();
    let rows: Vec<Range<usize>> = (0..area.height).map(|y| beneath(y, area.height, source.1)).collect();
    let mut dots = Plane::new(area.width, area.height, palette::SHADE);
    for (y, rows) in rows.into_iter().enumerate() {
        for (dot, columns) in dots.row_mut(y).iter_mut().zip(&columns) {
            let mut places = rows.clone().flat_map(|v| columns.clone().map(move |u| (u, v)));
            if let Some(colour) = places.find_map(|(u, v)| colour_at(u, v)) {
                *dot = colour;
            }
        }
    }
    canvas.picture(area, dots.size(), |x, y| dots.get(x, y).unwrap_or(palette::SHADE));
}

/// The sections and the straight lines of the frame.
fn lines(canvas: &mut Canvas, area: Rect, evidence: &LaneEvidence) {
    let scale = area.width as f64 / evidence.steps.thin.width() as f64;
    let top_row = evidence.steps.top_row as f64;
    let at = |u: f64, v: f64| [area.x as f64 + u * scale, area.y as f64 + (v - top_row) * scale];
    let right = evidence.steps.thin.width() as f64;
    for &[upper, _] in &evidence.region.sections {
        let ends = [at(0.0, upper as f64), at(right, upper as f64)];
        canvas.dashed(&ends, 1.0, [4.0, 4.0], Paint::glaze(palette::ACCEPTED, 0.5));
    }
    for candidate in &evidence.candidates {
        let ends = [candidate.lower_px, candidate.upper_px].map(|end| at(end.u, end.v));
        let (width, colour) = match candidate.verdict {
            LineVerdict::Kept => (2.0, palette::UPDATED),
            _ => (1.0, palette::REJECTED),
        };
        canvas.polyline(&ends, width, Paint::glaze(colour, 0.8));
    }
}

/// The pieces of the dilated picture.
struct Labels(Plane<u32>);

impl Labels {
    fn of(steps: &EdgeSteps) -> Self {
        let mut pieces = ConnectedComponents::new(Connectivity::Eight);
        pieces.find(steps.dilated.view());
        let (width, height) = steps.dilated.size();
        let mut labels = Plane::new(width, height, 0);
        // The sizes are the same.
        let _ = pieces.write_labels(&mut labels);
        Self(labels)
    }

    fn colour(&self, steps: &EdgeSteps, u: usize, v: usize) -> Option<Rgb> {
        let label = self.0.get(u, v).filter(|label| *label != 0)?;
        let is_kept = steps.labelled.get(u, v).is_some_and(|level| level != 0);
        Some(if is_kept { palette::piece(label) } else { palette::REJECTED })
    }
}
