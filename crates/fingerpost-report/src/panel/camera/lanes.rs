//! The lane in the camera's picture: sections, lines considered, places read, edges given out.

use fingerpost::lanes::{LineVerdict, Side, Traced};

use super::Lens;
use crate::draw::{Canvas, Paint};
use crate::palette;
use crate::scene::Scene;

pub(super) fn draw(canvas: &mut Canvas, lens: &Lens<'_>, scene: &Scene<'_>) {
    let (Some(evidence), Some(lane)) = (scene.evidence.lanes, &scene.output.lane) else { return };
    for candidate in &evidence.candidates {
        let ends = [lens.of_pixel(candidate.lower_px), lens.of_pixel(candidate.upper_px)];
        match candidate.verdict {
            LineVerdict::Kept => canvas.dashed(&ends, 1.5, [4.0, 4.0], Paint::glaze(palette::PREDICTED, 0.6)),
            _ => canvas.dashed(&ends, 1.0, [2.0, 5.0], Paint::glaze(palette::REJECTED, 0.6)),
        }
    }
    for side in [Side::Left, Side::Right] {
        let Some(edge) = lane.edge(side) else { continue };
        let points: Vec<[f64; 2]> = edge.points_px.iter().map(|pixel| lens.of_pixel(*pixel)).collect();
        let opacity = if edge.kept_frames == 0 { 0.95 } else { 0.5 };
        canvas.polyline(&points, 2.0, Paint::glaze(palette::LANE, opacity));
    }
    for point in &evidence.traced {
        let [x, y] = lens.of_pixel(point.pixel);
        let colour = match point.found {
            Traced::Used => palette::ACCEPTED,
            Traced::Outlier => palette::REJECTED,
            Traced::Nothing => continue,
        };
        canvas.polyline(&[[x - 2.0, y], [x + 2.0, y]], 1.5, Paint::solid(colour));
    }
}
