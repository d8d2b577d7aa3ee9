//! The road surface: the probability of road as a heat map, and where the road was assumed.

use fingerpost::road_surface::Knowledge;
use fingerpost_vision::picture::Rect;

use super::ground_plot::GroundPlot;
use crate::draw::{Canvas, Paint, TextSize};
use crate::palette::{self, Rgb};
use crate::scene::Scene;

pub(crate) const LEGEND: &str = "Probability of road, from dark (0) to yellow (1); in violet (0 to 1: dark to light) where it is \
    not seen but remembered. Dashed: the region ahead that is assumed to be road and sampled. Hatched: not known.";

/// Width and height of the scale of colours, pixels.
const SCALE_PX: (usize, usize) = (80, 8);

/// Draws the heat map.
pub(crate) fn draw(canvas: &mut Canvas, plot: &GroundPlot<'_>, scene: &Scene<'_>) {
    let (surface, seen) = (scene.evidence.surface, scene.evidence.validity);
    let heat: [Rgb; 256] = std::array::from_fn(|p| palette::heat(p as u8));
    let remembered: [Rgb; 256] = std::array::from_fn(|p| palette::remembered(p as u8));
    // A surface that was never summed up is known where it is seen.
    let known = if surface.known().size() == seen.size() { surface.known().plane() } else { seen };
    plot.raster(canvas, known, |column, row| {
        let p = usize::from(surface.probability.get(column, row).unwrap_or(0));
        match surface.knowledge(seen, column, row) {
            Knowledge::Remembered => remembered[p],
            Knowledge::Seen | Knowledge::Unknown => heat[p],
        }
    });
    plot.metre_lines(canvas);
    canvas.clipped(plot.area, |canvas| {
        let sample = scene.evidence.road.sample;
        if sample.width > 0 && sample.height > 0 {
            let outline = plot.outline(sample);
            canvas.polyline(&outline, 3.0, Paint::glaze(palette::SHADE, 0.5));
            canvas.dashed(&outline, 1.5, [5.0, 4.0], Paint::solid(palette::SAMPLE));
        }
        scale(canvas, plot.area);
    });
}

/// The colours from 0 to 1 in the top right corner.
fn scale(canvas: &mut Canvas, area: Rect) {
    let (width, height) = SCALE_PX;
    let x = (area.x + area.width).saturating_sub(width + 20).max(area.x);
    let bar = Rect { x, y: area.y + 8, width, height };
    let plate = Rect { x: x.saturating_sub(16), y: area.y + 2, width: width + 34, height: height + 12 };
    canvas.fill(plate, Paint::glaze(palette::SHADE, 0.62));
    canvas.picture(bar, (width, 1), |column, _| palette::heat((column * 255 / (width - 1)) as u8));
    canvas.text([x as f64 - 11.0, area.y as f64 + 4.0], TextSize::Small, palette::TEXT, "0");
    canvas.text([(x + width + 4) as f64, area.y as f64 + 4.0], TextSize::Small, palette::TEXT, "1");
}
