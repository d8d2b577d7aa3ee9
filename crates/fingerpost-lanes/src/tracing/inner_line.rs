//! The line inside an edge that makes its marking a double one.

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point2;

use super::{INNER_M, INNER_ROWS, Tracer, WEAK_SHARE};
use crate::Side;
use crate::lane_filter::LaneFilter;
use crate::paint::PaintSearch;
use crate::road_view::RoadView;

/// Every so many rows are looked at for it.
const INNER_STEP: usize = 2;
/// The length that it must show, and how far its rows may lie apart, metres.
const INNER_LENGTH_M: f64 = 1.5;
const INNER_SPREAD_M: f64 = 0.05;

impl Tracer {
    /// How far inside a side's edge another line runs, metres; none where no such line is seen. The inner line of a double
    /// marking may have gaps, so that the outer one was taken for it.
    pub(crate) fn inner_line_m(
        &mut self,
        camera: &Camera,
        filter: &LaneFilter,
        frame: &RgbImage,
        side: Side,
        strength: f64,
    ) -> Option<f64> {
        let view = RoadView::new(camera, filter.pitch_rad());
        self.inner.clear();
        let readings = &self.readings[side.index()];
        for (index, reading) in readings.iter().enumerate().step_by(INNER_STEP) {
            let inward_m = 0.5 * (INNER_M[0] + INNER_M[1]);
            let left_m = filter.left_at(side, reading.ahead_m) + side.outward() * inward_m;
            let place = Point2::new(reading.ahead_m, left_m);
            let Some(expected) = view.pixel_of_ground(place) else { continue };
            let search = PaintSearch {
                side,
                expected_u: expected.u,
                reach_px: 0.5 * (INNER_M[1] - INNER_M[0]) * reading.px_per_m,
                px_per_m: reading.px_per_m,
            };
            let row = frame.row(reading.row as usize);
            let found = self.paint.find(row, &search).filter(|paint| paint.step >= WEAK_SHARE * strength);
            let Some(paint) = found else { continue };
            let inside_m = side.outward() * (reading.expected_u - paint.u) / reading.px_per_m;
            let next = readings.get(index + INNER_STEP).map_or(reading.ahead_m, |next| next.ahead_m);
            self.inner.push([inside_m, (next - reading.ahead_m).max(0.0)]);
        }
        if self.inner.is_empty() {
            return None;
        }
        let middle = self.inner.len() / 2;
        let (_, &mut [median_m, _], _) =
            self.inner.select_nth_unstable_by(middle, |a, b| a[0].total_cmp(&b[0]));
        let agreeing = self.inner.iter().filter(|found| (found[0] - median_m).abs() < INNER_SPREAD_M);
        let (count, length_m) = agreeing.fold((0, 0.0), |(count, sum), found| (count + 1, sum + found[1]));
        let most_agree = 2 * count > self.inner.len();
        (count >= INNER_ROWS && length_m >= INNER_LENGTH_M && most_agree && INNER_M[0] < median_m)
            .then_some(median_m)
    }
}
