//! The vehicle's motion and the camera's turning as warps of the ground view's pixels.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::alignment::{Corridor, ProjectiveMap, QuadraticField, UNKNOWNS};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use crate::ground_view::{CameraTurn, Viewpoint};

/// Coefficients of 1, u, v, u^2, u v, v^2.
type Quadratic = [f64; 6];
/// Coefficients of 1, u, v.
type Affine = [f64; 3];

/// Half the width of the road that a vehicle is about to drive over and that counts with all its texture, metres: half a
/// lane.
const CORRIDOR_HALF_WIDTH_M: f64 = 2.0;
/// Curvature of a path from which the camera looks past the road, 1/m: at a radius of a dozen metres, as in a turn at a
/// junction, the path leaves the view a few metres ahead, and what lies straight ahead is the pavement and its houses.
const LOOKS_ASIDE_PER_M: f64 = 0.08;
/// Trust that is left for what lies beside the path then: without any, a turn over a bare road would not be seen at all.
const LEAST_OUTSIDE: f64 = 0.05;

/// What is estimated.
#[derive(Debug, Clone, Copy)]
pub(super) struct Displacement {
    pub(super) current_from_previous: Isometry2<f64>,
    /// How the camera was turned against its configured mount when the older picture was taken: pitch and roll, radians.
    pub(super) turn_before_rad: [f64; 2],
    /// How much it turned until the newer one: pitch and roll, radians.
    pub(super) turn_change_rad: [f64; 2],
}

/// The directions of the camera for which the older and the newer ground view were made.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Views {
    pub(super) before: CameraTurn,
    pub(super) after: CameraTurn,
}

impl Displacement {
    /// A motion with a camera that stays turned.
    pub(super) fn of(current_from_previous: Isometry2<f64>, turn_before_rad: [f64; 2]) -> Self {
        Self { current_from_previous, turn_before_rad, turn_change_rad: [0.0; 2] }
    }
}

/// The pixels of one level of the pyramid as places on the road.
#[derive(Debug, Clone, Copy)]
pub(super) struct Raster {
    /// Place of pixel (0, 0), metres forward and left.
    corner: Point2<f64>,
    /// Scale, metres per pixel.
    pub(super) metres_per_pixel: f64,
    viewpoint: Viewpoint,
}

impl Raster {
    /// The raster of the part of the ground view that begins at `origin` (column and row), halved `level` times.
    pub(super) fn new(grid: &GroundGrid, viewpoint: Viewpoint, origin: [usize; 2], level: usize) -> Self {
        let pixels = (1_u64 << level) as f64;
        // The first pixel of a halved picture covers the first 2 x 2, and so on.
        let [column, row] = origin.map(|start| start as f64 + 0.5 * (pixels - 1.0));
        let corner = grid.vehicle_from_ground(GroundPixel { column, row });
        Self { corner, metres_per_pixel: grid.metres_per_pixel() * pixels, viewpoint }
    }

    /// The warp by which places of the older picture move.
    pub(super) fn warp(&self, displacement: &Displacement, views: &Views) -> ProjectiveMap {
        let [pitch_rad, roll_rad] = displacement.turn_before_rad;
        let [pitch_change, roll_change] = displacement.turn_change_rad;
        // The view's own yaw is taken for the camera's: the road does not tell it from the direction of driving.
        let before = CameraTurn { pitch_rad, roll_rad, yaw_rad: views.before.yaw_rad };
        let after = CameraTurn {
            pitch_rad: pitch_rad + pitch_change,
            roll_rad: roll_rad + roll_change,
            yaw_rad: views.after.yaw_rad,
        };
        let seen_from = self.viewpoint;
        let road_from_older = before.road_from_shown(seen_from) * views.before.shown_from_road(seen_from);
        let newer_from_road = views.after.road_from_shown(seen_from) * after.shown_from_road(seen_from);
        let road_from_road = displacement.current_from_previous.to_homogeneous();
        let places_from_pixels = self.places_from_pixels();
        let pixels_from_places = self.pixels_from_places();
        let warp =
            pixels_from_places * newer_from_road * road_from_road * road_from_older * places_from_pixels;
        let row = |i: usize| [2, 0, 1].map(|column| (warp[(i, column)] / warp[(2, 2)]) as f32);
        ProjectiveMap { right: row(0), down: row(1), scale: row(2) }
    }

    /// The homogeneous map from pixels (u, v) to places.
    fn places_from_pixels(&self) -> Matrix3<f64> {
        let scale = self.metres_per_pixel;
        Matrix3::new(0.0, -scale, self.corner.x, -scale, 0.0, self.corner.y, 0.0, 0.0, 1.0)
    }

    fn pixels_from_places(&self) -> Matrix3<f64> {
        let scale = 1.0 / self.metres_per_pixel;
        Matrix3::new(0.0, -scale, scale * self.corner.y, -scale, 0.0, scale * self.corner.x, 0.0, 0.0, 1.0)
    }

    /// How far a place of the older picture moves for a unit of each unknown: forward, left, yaw, change of pitch and of
    /// roll, pitch and roll before, about the displacement `about`, turned back into the older picture.
    pub(super) fn directions(&self, about: &Displacement) -> [QuadraticField; UNKNOWNS] {
        let before = self.place();
        let [x, y] = before;
        let motion = &about.current_from_previous;
        let (pitch_after, roll_after) = self.sway_fields(moved(motion, before));
        let (pitch_before, roll_before) = self.sway_fields(before);
        let back = motion.rotation.inverse();
        let (cosine, sine) = (back.re, back.im);
        let turned_back = |[x, y]: [Quadratic; 2]| -> [Quadratic; 2] {
            [
                std::array::from_fn(|i| cosine * x[i] - sine * y[i]),
                std::array::from_fn(|i| sine * x[i] + cosine * y[i]),
            ]
        };
        let (pitch_after, roll_after) = (turned_back(pitch_after), turned_back(roll_after));
        let stretch = |after: [Quadratic; 2], before: [Quadratic; 2]| -> [Quadratic; 2] {
            std::array::from_fn(|axis| std::array::from_fn(|i| after[axis][i] - before[axis][i]))
        };
        let (one, none) = (widen([1.0, 0.0, 0.0]), [0.0; 6]);
        [
            [one, none],
            [none, one],
            [widen(y.map(|c| -c)), widen(x)],
            pitch_after,
            roll_after,
            stretch(pitch_after, pitch_before),
            stretch(roll_after, roll_before),
        ]
        .map(|[x, y]| {
            let pixels = |field: Quadratic| field.map(|c| (-c / self.metres_per_pixel) as f32);
            QuadraticField { u: pixels(y), v: pixels(x) }
        })
    }

    /// The road that a vehicle is about to drive over when its path bends with `curvature_per_m`.
    pub(super) fn corridor(&self, curvature_per_m: f64) -> Corridor {
        let (scale, ahead) = (self.metres_per_pixel, self.corner.x);
        // Left of the vehicle's axis by c x^2 / 2, with x = ahead - scale v.
        let bend = 0.5 * curvature_per_m;
        let left = [bend * ahead * ahead - self.corner.y, -2.0 * bend * ahead * scale, bend * scale * scale];
        let straightness = libm::exp(-(curvature_per_m / LOOKS_ASIDE_PER_M).powi(2));
        Corridor {
            middle: left.map(|coefficient| (-coefficient / scale) as f32),
            half_width: (CORRIDOR_HALF_WIDTH_M / scale) as f32,
            outside: straightness.max(LEAST_OUTSIDE) as f32,
        }
    }

    /// The place that a pixel shows, metres.
    pub(super) fn vehicle_from_pixel(&self, [u, v]: [f32; 2]) -> Point2<f64> {
        self.corner - self.metres_per_pixel * Vector2::new(f64::from(v), f64::from(u))
    }

    /// The place (x, y) of a pixel (u, v).
    fn place(&self) -> [Affine; 2] {
        [[self.corner.x, 0.0, -self.metres_per_pixel], [self.corner.y, -self.metres_per_pixel, 0.0]]
    }

    /// How places move for a unit of pitch and of roll, as polynomials: seen from height h by a camera turned by a small pitch p
    /// and roll r, the place (X, Y) from its foot is shown at (X + p (X^2 + h^2)/h - r XY/h, Y + p XY/h - r (Y^2 + h^2)/h).
    fn sway_fields(&self, [x, y]: [Affine; 2]) -> ([Quadratic; 2], [Quadratic; 2]) {
        let height = self.viewpoint.height_m;
        let from_foot = |mut place: Affine, foot: f64| {
            place[0] -= foot;
            place
        };
        let (x, y) = (from_foot(x, self.viewpoint.foot.x), from_foot(y, self.viewpoint.foot.y));
        let along = |a: Affine| {
            let mut square = product(a, a).map(|c| c / height);
            square[0] += height;
            square
        };
        let across = product(x, y).map(|c| c / height);
        ([along(x), across], [across.map(|c| -c), along(y).map(|c| -c)])
    }
}

fn moved(motion: &Isometry2<f64>, [x, y]: [Affine; 2]) -> [Affine; 2] {
    let (cosine, sine) = (motion.rotation.re, motion.rotation.im);
    let step: Vector2<f64> = motion.translation.vector;
    let mut turned: [Affine; 2] = [
        std::array::from_fn(|i| cosine * x[i] - sine * y[i]),
        std::array::from_fn(|i| sine * x[i] + cosine * y[i]),
    ];
    turned[0][0] += step.x;
    turned[1][0] += step.y;
    turned
}

fn widen([c, u, v]: Affine) -> Quadratic {
    [c, u, v, 0.0, 0.0, 0.0]
}

fn product(a: Affine, b: Affine) -> Quadratic {
    [
        a[0] * b[0],
        a[0] * b[1] + a[1] * b[0],
        a[0] * b[2] + a[2] * b[0],
        a[1] * b[1],
        a[1] * b[2] + a[2] * b[1],
        a[2] * b[2],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWPOINT: Viewpoint = Viewpoint { foot: Point2::new(1.5, 0.1), height_m: 1.5 };
    const VIEWS: Views = Views {
        before: CameraTurn { pitch_rad: 0.01, roll_rad: 0.002, yaw_rad: 0.0 },
        after: CameraTurn { pitch_rad: 0.013, roll_rad: -0.001, yaw_rad: 0.004 },
    };

    fn raster() -> (GroundGrid, Raster) {
        let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        (grid, Raster::new(&grid, VIEWPOINT, [40, 8], 1))
    }

    fn mapped(map: Matrix3<f64>, place: Point2<f64>) -> Point2<f64> {
        Point2::from_homogeneous(map * place.to_homogeneous()).unwrap()
    }

    /// Where a place of the older view is seen in the newer one.
    fn seen(place: Point2<f64>, displacement: &Displacement, views: &Views) -> Point2<f64> {
        let [pitch_rad, roll_rad] = displacement.turn_before_rad;
        let [pitch_change, roll_change] = displacement.turn_change_rad;
        let before = CameraTurn { pitch_rad, roll_rad, yaw_rad: views.before.yaw_rad };
        let after = CameraTurn {
            pitch_rad: pitch_rad + pitch_change,
            roll_rad: roll_rad + roll_change,
            yaw_rad: views.after.yaw_rad,
        };
        let configured = mapped(views.before.shown_from_road(VIEWPOINT), place);
        let road = mapped(before.road_from_shown(VIEWPOINT), configured);
        let moved = displacement.current_from_previous * road;
        mapped(views.after.road_from_shown(VIEWPOINT), mapped(after.shown_from_road(VIEWPOINT), moved))
    }

    /// Pixel (u, v) of the once halved part as a place.
    fn place_of(grid: &GroundGrid, u: f64, v: f64) -> Point2<f64> {
        grid.vehicle_from_ground(GroundPixel { column: 40.0 + 2.0 * u + 0.5, row: 8.0 + 2.0 * v + 0.5 })
    }

    #[test]
    fn the_warp_is_the_motion_seen_by_turned_cameras() {
        let (grid, raster) = raster();
        let displacement = Displacement {
            current_from_previous: Isometry2::new(Vector2::new(-0.9, 0.04), -0.05),
            turn_before_rad: [0.02, -0.003],
            turn_change_rad: [0.004, 0.008],
        };
        let warp = raster.warp(&displacement, &VIEWS);
        for (u, v) in [(0.0, 0.0), (100.0, 40.0), (17.0, 150.0), (199.0, 159.0)] {
            let [to_u, to_v] = warp.at(u as f32, v as f32).map(f64::from);
            let wanted = seen(place_of(&grid, u, v), &displacement, &VIEWS);
            assert!((place_of(&grid, to_u, to_v) - wanted).norm() < 1e-4, "{u} {v}");
        }
    }

    #[test]
    fn the_directions_are_the_derivatives_of_the_warp() {
        let (grid, raster) = raster();
        let about = Displacement::of(Isometry2::new(Vector2::new(-0.9, 0.04), -0.05), [0.0; 2]);
        let views = Views::default();
        let step = 1e-6;
        for (unknown, direction) in raster.directions(&about).iter().enumerate() {
            for (u, v) in [(100.0, 40.0), (17.0, 150.0)] {
                let place = place_of(&grid, u, v);
                let mut changed = about;
                match unknown {
                    0 => changed.current_from_previous *= Isometry2::translation(step, 0.0),
                    1 => changed.current_from_previous *= Isometry2::translation(0.0, step),
                    2 => changed.current_from_previous *= Isometry2::rotation(step),
                    3 | 4 => changed.turn_change_rad[unknown - 3] += step,
                    _ => changed.turn_before_rad[unknown - 5] += step,
                }
                let difference = (seen(place, &changed, &views) - seen(place, &about, &views)) / step;
                let derivative = about.current_from_previous.rotation.inverse() * difference;
                let [right, down] = direction.at(u as f32, v as f32).map(f64::from);
                let expected = Vector2::new(-derivative.y, -derivative.x) / raster.metres_per_pixel;
                assert!((Vector2::new(right, down) - expected).norm() < 2e-2, "{unknown} at {u} {v}");
            }
        }
    }
}
