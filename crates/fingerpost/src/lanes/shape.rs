//! The edge as it is given out: a spline through its points in the picture.
//!
//! Paper 3, III-C: the selected points of all sections are joined by a shape-preserving interpolation. The points are those
//! of the lane on the road, moved to where the sections' own paint lies; a section that shows too little of it keeps the
//! lane's. Far sections whose place is not known well enough are left out (the paper's indicator).

use fingerpost_geometry::{Camera, Pchip, Pixel};
use nalgebra::Point2;

use super::lane_filter::{EdgePoint, LaneFilter};
use super::region::LaneRegion;
use super::road_view::RoadView;
use super::tracing::USED_WEIGHT;
use super::{LaneEdge, Side};

/// Spline points a section.
const KNOTS_A_SECTION: usize = 3;
/// So many points of a section must agree for its own place to count half.
const HALF_TRUST_POINTS: f64 = 2.0;
/// Rows between two points given out, share of the picture's height.
const POINT_ROWS_SHARE: f64 = 0.0125;
/// An edge ends where its place is less sure than this, metres.
const MOST_SIGMA_M: f64 = 0.4;

/// Makes edges' curves, with the buffers that it needs.
#[derive(Debug, Default)]
pub(super) struct EdgeShape {
    /// Of either side: row and how far outside the lane's curve the paint lies there, pixels.
    residuals: [Vec<[f64; 2]>; 2],
    sorted: Vec<f64>,
    corrections: Vec<[f64; 2]>,
    correction: Pchip,
    knots: Vec<[f64; 2]>,
    spline: Pchip,
}

impl EdgeShape {
    pub(super) fn clear(&mut self) {
        self.residuals.iter_mut().for_each(Vec::clear);
    }

    /// Notes where a side's paint lies against the lane's curve.
    pub(super) fn note(&mut self, camera: &Camera, filter: &LaneFilter, side: Side, points: &[EdgePoint]) {
        let view = RoadView::new(camera, filter.pitch_rad());
        let residuals = &mut self.residuals[side.index()];
        residuals.clear();
        for point in points.iter().filter(|point| point.side == side && point.weight >= USED_WEIGHT) {
            if let Some(u) = column_at(&view, filter, side, point.pixel) {
                residuals.push([point.pixel.v, point.pixel.u - u]);
            }
        }
    }

    /// Sets an edge's curve and its points.
    pub(super) fn give_out(
        &mut self,
        camera: &Camera,
        filter: &LaneFilter,
        region: &LaneRegion,
        side: Side,
        edge: &mut LaneEdge,
    ) {
        edge.offset_m = filter.offset_m(side);
        edge.offset_sigma_m = filter.offset_sigma_m(side);
        edge.heading_rad = filter.heading_rad();
        edge.curvature_per_m = filter.curvature_per_m();
        self.correct(region, side);
        let view = RoadView::new(camera, filter.pitch_rad());
        self.knots.clear();
        let base = region.base_row as f64 - 1.0;
        let middle = (camera.width() - 1) as f64 / 2.0;
        // From the far end down, because a spline's abscissae rise.
        'sections: for &[upper, lower] in region.sections.iter().rev() {
            for knot in 0..KNOTS_A_SECTION {
                let row = upper as f64 + (lower - upper) as f64 * knot as f64 / KNOTS_A_SECTION as f64;
                let Some(below) = view.ground_of_pixel(Pixel::new(middle, row)) else { continue 'sections };
                if filter.left_sigma_m(side, below.x) > MOST_SIGMA_M {
                    continue;
                }
                self.push_knot(&view, filter, side, Pixel::new(middle, row));
            }
        }
        self.push_knot(&view, filter, side, Pixel::new(middle, base));
        self.spline.fit(&self.knots);
        edge.points_px.clear();
        let Some(first) = self.spline.points().first().map(|knot| knot[0]) else { return };
        let step = (POINT_ROWS_SHARE * camera.height() as f64).max(2.0);
        let mut row = base;
        while row > first {
            edge.points_px.extend(self.spline.at(row).map(|u| Pixel::new(u, row)));
            row -= step;
        }
        edge.points_px.extend(self.spline.at(first).map(|u| Pixel::new(u, first)));
    }

    fn push_knot(&mut self, view: &RoadView<'_>, filter: &LaneFilter, side: Side, near: Pixel) {
        let Some(u) = column_at(view, filter, side, near) else { return };
        let points = self.correction.points();
        let nearest = points.first().zip(points.last()).map(|(first, last)| near.v.clamp(first[0], last[0]));
        let moved = nearest.and_then(|row| self.correction.at(row)).unwrap_or(0.0);
        self.knots.push([near.v, u + moved]);
    }

    /// The sections' own places against the lane's curve, by the medians of their points.
    fn correct(&mut self, region: &LaneRegion, side: Side) {
        self.corrections.clear();
        for &[upper, lower] in region.sections.iter().rev() {
            self.sorted.clear();
            let (mut rows, mut count) = (0.0, 0.0);
            for &[row, off_px] in &self.residuals[side.index()] {
                if (upper as f64..lower as f64).contains(&row) {
                    self.sorted.push(off_px);
                    rows += row;
                    count += 1.0;
                }
            }
            if self.sorted.is_empty() {
                continue;
            }
            let middle = self.sorted.len() / 2;
            let (_, median, _) = self.sorted.select_nth_unstable_by(middle, f64::total_cmp);
            self.corrections.push([rows / count, *median * count / (count + HALF_TRUST_POINTS)]);
        }
        self.correction.fit(&self.corrections);
    }
}

/// The column of the lane's curve in the row of `near`.
fn column_at(view: &RoadView<'_>, filter: &LaneFilter, side: Side, near: Pixel) -> Option<f64> {
    let mut ahead_m = view.ground_of_pixel(near)?.x;
    let mut pixel = view.pixel_of_ground(Point2::new(ahead_m, filter.left_at(side, ahead_m)))?;
    // A rolled camera or a bent lens shows the place in another row: two corrections along the curve.
    for _ in 0..2 {
        if (pixel.v - near.v).abs() < 0.05 {
            break;
        }
        ahead_m = view.ground_of_pixel(Pixel::new(pixel.u, near.v))?.x;
        pixel = view.pixel_of_ground(Point2::new(ahead_m, filter.left_at(side, ahead_m)))?;
    }
    Some(pixel.u)
}
