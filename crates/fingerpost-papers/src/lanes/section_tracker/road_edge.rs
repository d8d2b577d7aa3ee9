//! An edge of the picture as a curve on the road, for the departure warning and the record; the paper knows pixels alone.

use fingerpost_geometry::Pixel;
use fingerpost_lanes::{LaneEdge, RoadView};
use nalgebra::{Matrix3, Vector3};

/// How well a Hough line's ends lie, pixels: a line may run from one edge of a marking to the other, which is 3 to 8 pixels in the
/// upper sections of a picture 640 wide.
const COLUMN_SIGMA_PX: f64 = 4.0;
/// Before anything is seen: where the edge passes, metres, its direction, radians, and its curvature, 1/m; marked roads bend
/// with radii of some hundred metres.
const PRIOR_SIGMAS: [f64; 3] = [10.0, 0.3, 0.004];

/// y(x) = offset + slope x + curvature x² / 2, fitted to places on the road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RoadEdge {
    offset_m: f64,
    offset_sigma_m: f64,
    slope: f64,
    curvature_per_m: f64,
}

impl RoadEdge {
    /// The curve through `[row, column]` points of the picture, by least squares about the prior.
    pub(super) fn through(view: &RoadView<'_>, points: &[[f64; 2]]) -> Option<Self> {
        let mut information = Matrix3::from_diagonal(&Vector3::from(PRIOR_SIGMAS.map(|s| 1.0 / (s * s))));
        let mut sum = Vector3::zeros();
        for &[row, column] in points {
            let places = [0.0, 1.0].map(|du| view.ground_of_pixel(Pixel::new(column + du, row)));
            let [Some(place), Some(beside)] = places else { continue };
            let sigma_m = COLUMN_SIGMA_PX * (place.y - beside.y).abs();
            let weight = 1.0 / (sigma_m * sigma_m);
            if !weight.is_finite() {
                continue;
            }
            let along = Vector3::new(1.0, place.x, 0.5 * place.x * place.x);
            information += weight * along * along.transpose();
            sum += weight * place.y * along;
        }
        let covariance = information.try_inverse()?;
        let fitted = covariance * sum;
        let (offset_m, slope, curvature_per_m) = (fitted.x, fitted.y, fitted.z);
        Some(Self { offset_m, offset_sigma_m: covariance[(0, 0)].sqrt(), slope, curvature_per_m })
    }

    /// Writes the curve into an edge.
    pub(super) fn write(&self, edge: &mut LaneEdge) {
        edge.offset_m = self.offset_m;
        edge.offset_sigma_m = self.offset_sigma_m;
        edge.heading_rad = libm::atan(self.slope);
        edge.curvature_per_m = self.curvature_per_m;
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
    use nalgebra::Point2;

    use super::*;

    #[test]
    fn points_of_a_known_curve_give_it_back_with_its_signs() {
        let intrinsics = Intrinsics { fx: 580.0, fy: 580.0, cx: 319.5, cy: 239.5 };
        let mount = Mount { pitch_rad: 0.05, x_m: 1.7, ..Mount::level(1.3) };
        let camera = Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let view = RoadView::new(&camera, 0.0);
        for (offset_m, slope, curvature_per_m) in [(1.7, 0.03, 0.002), (-1.5, -0.02, -0.004)] {
            let points = [30.0, 20.0, 13.0, 8.0, 5.0].map(|x| {
                let left_m = offset_m + slope * x + 0.5 * curvature_per_m * x * x;
                let pixel = view.pixel_of_ground(Point2::new(x, left_m)).unwrap();
                [pixel.v, pixel.u]
            });
            let found = RoadEdge::through(&view, &points).unwrap();
            // What was believed before draws it towards straight on by a tenth.
            assert!((found.offset_m - offset_m).abs() < 0.03, "{found:?}");
            assert!((found.slope - slope).abs() < 0.006, "{found:?}");
            assert!((found.curvature_per_m - curvature_per_m).abs() < 5e-4, "{found:?}");
            // Fewer places, less sure.
            let two = RoadEdge::through(&view, &points[3..]).unwrap();
            assert!(found.offset_sigma_m > 0.0 && two.offset_sigma_m > found.offset_sigma_m, "{two:?}");
        }
        let none = RoadEdge::through(&view, &[]).unwrap();
        assert!(none.offset_sigma_m > 5.0, "{none:?}");
    }
}
