//! The flow of the road from which the motion was found.

use std::collections::BTreeSet;

use super::facts::signed;
use super::ground_plot::GroundPlot;
use crate::draw::{Canvas, Paint, TextSize};
use crate::palette;
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "Flow of the road since the frame before: cyan vectors were used, the fainter the less \
    weight; red ones were rejected (one of each in a small square). Dashed: the region that was measured.";

/// Weight below which a vector counts as rejected.
pub(crate) const REJECTED_WEIGHT: f64 = 0.05;

/// Side of the squares of which each shows one used and one rejected vector, pixels: more would run into one another.
const CELL_PX: f64 = 13.0;

/// Draws the flow on the grey ground view.
pub(crate) fn draw(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    let grey = &scene.evidence.ground.grey;
    plot.raster(canvas, scene.evidence.validity, |column, row| {
        [(f64::from(grey.get(column, row).unwrap_or(0)) * 0.7) as u8; 3]
    });
    plot.metre_lines(canvas);
    canvas.clipped(plot.area, |canvas| {
        let Some(motion) = &scene.evidence.motion else {
            let corner = [plot.area.x as f64 + 8.0, plot.area.y as f64 + 6.0];
            canvas.label(corner, TextSize::Small, palette::TEXT_DIM, "no frame before this one");
            return;
        };
        canvas.dashed(&plot.outline(motion.region), 1.5, [5.0, 4.0], Paint::glaze(palette::SAMPLE, 0.8));
        let mut drawn = BTreeSet::new();
        // Squares about the first sample take one of each row and column of them alike.
        let corner = motion.samples.first().map_or([0.0; 2], |first| plot.at_pixel(first.from_px));
        for sample in &motion.samples {
            let ends = [sample.from_px, sample.to_px].map(|p| plot.at_pixel(p));
            let rejected = sample.weight < REJECTED_WEIGHT;
            let cell = [0, 1].map(|axis| ((ends[0][axis] - corner[axis]) / CELL_PX).round() as i64);
            if !drawn.insert((cell, rejected)) {
                continue;
            }
            let paint = if rejected {
                Paint::glaze(palette::REJECTED, 0.9)
            } else {
                Paint::glaze(palette::ACCEPTED, 0.35 + 0.6 * sample.weight.min(1.0))
            };
            canvas.arrow(ends[0], ends[1], 1.3, paint);
            canvas.disc(ends[1], 1.4, paint);
        }
        if let Some(moved) = &scene.output.motion {
            let step = moved.previous_from_current.translation.vector;
            let text = format!("moved {:.2} m, {} m left", step.x, signed(step.y, 2));
            let corner = [plot.area.x as f64 + 8.0, plot.area.y as f64 + 6.0];
            canvas.label(corner, TextSize::Small, palette::TEXT, &text);
        }
    });
}
