//! A grey road with two lines, painted, and how far off an edge is there.

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, Pixel};
use fingerpost_lanes::{Lane, Side};
use fingerpost_vision::picture::RgbImage;

pub(crate) const WIDTH: usize = 640;
pub(crate) const HEIGHT: usize = 480;
const LINE_M: f64 = 0.15;

pub(crate) fn camera(pitch_deg: f64) -> Camera {
    let intrinsics = Intrinsics { fx: 580.0, fy: 580.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: pitch_deg.to_radians(), x_m: 1.7, ..Mount::level(1.3) };
    Camera::calibrated(WIDTH, HEIGHT, intrinsics, Distortion::None, mount).unwrap()
}

/// Lines of a road: inner edges beside the vehicle (metres, left positive), direction, curvature, and where paint is.
pub(crate) struct Road {
    pub(crate) edges_m: [f64; 2],
    pub(crate) heading_rad: f64,
    pub(crate) curvature_per_m: f64,
    pub(crate) painted: fn(f64) -> bool,
}

impl Road {
    pub(crate) fn left_m(&self, side: usize, ahead_m: f64) -> f64 {
        self.edges_m[side] + self.heading_rad * ahead_m + 0.5 * self.curvature_per_m * ahead_m * ahead_m
    }

    /// The picture of it on grey road, four rays a pixel.
    pub(crate) fn picture(&self, camera: &Camera) -> RgbImage {
        let mut picture = RgbImage::new(WIDTH, HEIGHT);
        for v in 0..HEIGHT {
            let row = picture.row_mut(v);
            for u in 0..WIDTH {
                let rays = [-0.375, -0.125, 0.125, 0.375];
                let white = rays.iter().filter(|&&du| self.is_paint(camera, u as f64 + du, v as f64)).count();
                // A little texture, so that there is something to be told from paint.
                let grain = ((u * 7919 + v * 104_729) % 7) as u8;
                let level = 90 + grain + 30 * white as u8;
                row[3 * u..3 * u + 3].fill(level);
            }
        }
        picture
    }

    fn is_paint(&self, camera: &Camera, u: f64, v: f64) -> bool {
        let Some(place) = camera.ground_of_pixel(Pixel::new(u, v)) else { return false };
        let outside_left = place.y - self.left_m(0, place.x);
        let outside_right = self.left_m(1, place.x) - place.y;
        place.x < 120.0
            && (self.painted)(place.x)
            && [outside_left, outside_right].iter().any(|m| (0.0..LINE_M).contains(m))
    }
}

/// Root mean square distance of an edge from the road's, pixels, over the lowest 150 rows.
pub(crate) fn deviation_px(camera: &Camera, road: &Road, lane: &Lane, side: Side) -> f64 {
    let edge = lane.edge(side).unwrap_or_else(|| panic!("no {side:?} edge"));
    let index = usize::from(side == Side::Right);
    let mut squares = Vec::new();
    for ahead_dm in 30..150 {
        let ahead_m = 0.1 * f64::from(ahead_dm);
        let place = nalgebra::Point2::new(ahead_m, road.left_m(index, ahead_m));
        let truth = camera.pixel_of_ground(place).unwrap();
        if truth.v > HEIGHT as f64 - 1.0 || truth.v < HEIGHT as f64 - 150.0 {
            continue;
        }
        let after = edge.points_px.iter().position(|p| p.v <= truth.v).expect("the edge covers the rows");
        let [a, b] = [edge.points_px[after.saturating_sub(1)], edge.points_px[after]];
        let share = if after == 0 { 0.0 } else { (truth.v - a.v) / (b.v - a.v) };
        squares.push((a.u + share * (b.u - a.u) - truth.u).powi(2));
    }
    assert!(squares.len() > 20, "rows are compared");
    (squares.iter().sum::<f64>() / squares.len() as f64).sqrt()
}
