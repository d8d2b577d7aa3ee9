//! The edge as it is given out: a spline through its points in the picture.
//!
//! Paper 3, III-C: the selected points of all sections are joined by a shape-preserving interpolation. The points are those
//! of the lane on the road, moved to where the edge's own paint lies (`unevenness`). Far sections whose place is not known
//! well enough are left out (the paper's indicator).

mod unevenness;

use fingerpost_geometry::{Camera, Pchip, Pixel};
use nalgebra::Point2;

use self::unevenness::Unevenness;
use super::lane_filter::{EdgePoint, LaneFilter};
use super::region::LaneRegion;
use super::road_view::RoadView;
use super::tracing::USED_WEIGHT;
use super::{LaneEdge, Side};

/// Spline points a section.
const KNOTS_A_SECTION: usize = 3;
/// Rows between two points given out, share of the picture's height.
const POINT_ROWS_SHARE: f64 = 0.0125;
/// An edge ends where its place is less sure than this, metres.
const MOST_SIGMA_M: f64 = 0.4;

/// Makes edges' curves, with the buffers that it needs.
#[derive(Debug, Default)]
pub(super) struct EdgeShape {
    /// Of either side: where the paint lies against the lane's curve.
    unevenness: [Unevenness; 2],
    knots: Vec<[f64; 2]>,
    spline: Pchip,
}

impl EdgeShape {
    /// Forgets the paint of the frame before; up to `rows` places of it may come.
    pub(super) fn clear(&mut self, rows: usize) {
        for unevenness in &mut self.unevenness {
            unevenness.clear();
            unevenness.make_room(rows);
        }
    }

    /// Notes where a side's paint lies against the lane's curve.
    pub(super) fn note(&mut self, camera: &Camera, filter: &LaneFilter, side: Side, points: &[EdgePoint]) {
        let view = RoadView::new(camera, filter.pitch_rad());
        let unevenness = &mut self.unevenness[side.index()];
        unevenness.clear();
        for point in points.iter().filter(|point| point.side == side && point.weight >= USED_WEIGHT) {
            let beside = Pixel::new(point.pixel.u + 1.0, point.pixel.v);
            let places = view.ground_of_pixel(point.pixel).zip(view.ground_of_pixel(beside));
            if let Some((place, beside)) = places {
                let sigma_m = point.column_sigma_px * (place.y - beside.y).abs() / point.weight.sqrt();
                unevenness.note(place.x, place.y - filter.left_at(side, place.x), sigma_m);
            }
        }
        unevenness.fit();
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
        let view = RoadView::new(camera, filter.pitch_rad());
        self.knots.clear();
        let base = region.base_row as f64 - 1.0;
        let middle = (camera.width() - 1) as f64 / 2.0;
        // From the far end down, because a spline's abscissae rise.
        'sections: for &[upper, lower] in region.read_sections.iter().rev() {
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
        lay_points(&self.spline, base, camera.height(), &mut edge.points_px);
    }

    fn push_knot(&mut self, view: &RoadView<'_>, filter: &LaneFilter, side: Side, near: Pixel) {
        let unevenness = &self.unevenness[side.index()];
        let left_m = |ahead_m: f64| filter.left_at(side, ahead_m) + unevenness.left_m(ahead_m);
        self.knots.extend(column_at(view, left_m, near).map(|u| [near.v, u]));
    }
}

/// Sets `points_px` to places along a spline of columns over rows, from row `base` up to the spline's first row; none where the
/// spline has no point.
pub fn lay_points(spline: &Pchip, base: f64, picture_height: usize, points_px: &mut Vec<Pixel>) {
    points_px.clear();
    let Some(first) = spline.points().first().map(|knot| knot[0]) else { return };
    let step = (POINT_ROWS_SHARE * picture_height as f64).max(2.0);
    let mut row = base;
    while row > first {
        points_px.extend(spline.at(row).map(|u| Pixel::new(u, row)));
        row -= step;
    }
    points_px.extend(spline.at(first).map(|u| Pixel::new(u, first)));
}

/// The column in the row of `near` of a curve that lies so far left so far ahead, metres.
fn column_at(view: &RoadView<'_>, left_m: impl Fn(f64) -> f64, near: Pixel) -> Option<f64> {
    let mut ahead_m = view.ground_of_pixel(near)?.x;
    let mut pixel = view.pixel_of_ground(Point2::new(ahead_m, left_m(ahead_m)))?;
    // A rolled camera or a bent lens shows the place in another row: two corrections along the curve.
    for _ in 0..2 {
        if (pixel.v - near.v).abs() < 0.05 {
            break;
        }
        ahead_m = view.ground_of_pixel(Pixel::new(pixel.u, near.v))?.x;
        pixel = view.pixel_of_ground(Point2::new(ahead_m, left_m(ahead_m)))?;
    }
    Some(pixel.u)
}
