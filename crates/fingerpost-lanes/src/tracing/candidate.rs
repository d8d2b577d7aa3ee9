//! Paint along a line that may become an edge.

use fingerpost_geometry::Pixel;
use fingerpost_vision::picture::RgbImage;

use super::{LEAST_REACH_PX, Tracer};
use crate::paint::PaintSearch;
use crate::road_view::RoadView;
use crate::sections::LineCandidate;

/// Rows in which a candidate is looked at.
const CANDIDATE_ROWS: usize = 10;

/// Paint that a candidate bounds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct PaintAlong {
    /// Sum of the steps of the rows that show some, levels.
    pub(crate) sum: f64,
    /// Those rows.
    pub(crate) rows: usize,
}

impl PaintAlong {
    /// How much brighter than the road it is, levels.
    pub(crate) fn step(self) -> f64 {
        self.sum / self.rows.max(1) as f64
    }
}

impl Tracer {
    /// How much paint a candidate bounds in its own section.
    pub(crate) fn paint_along(
        &mut self,
        view: &RoadView<'_>,
        frame: &RgbImage,
        candidate: &LineCandidate,
    ) -> PaintAlong {
        let mut along = PaintAlong::default();
        for index in 0..CANDIDATE_ROWS {
            let share = (index as f64 + 0.5) / CANDIDATE_ROWS as f64;
            let rows = candidate.upper_px.v - candidate.lower_px.v;
            let row = (candidate.lower_px.v + share * rows).round();
            let on_line = Pixel::new(candidate.column_at(row), row);
            let beside = Pixel::new(on_line.u + 1.0, row);
            let (Some(place), Some(next)) = (view.ground_of_pixel(on_line), view.ground_of_pixel(beside))
            else {
                continue;
            };
            let px_per_m = 1.0 / (place.y - next.y).max(1e-4);
            let search = PaintSearch {
                side: candidate.side,
                expected_u: on_line.u,
                reach_px: LEAST_REACH_PX,
                px_per_m,
            };
            if (0.0..frame.height() as f64).contains(&row)
                && let Some(paint) = self.paint.find(frame.row(row as usize), &search)
            {
                along.sum += paint.step;
                along.rows += 1;
            }
        }
        along
    }
}
