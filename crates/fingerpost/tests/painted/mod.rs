//! A painted plane: grey textured roads on green textured ground, seen by a camera at a known place on it.
//!
//! Independent of the simulator: no objects, no suspension, no noise, so that every place is known exactly.

#![allow(unreachable_pub, dead_code, reason = "shared by several test programs, each of which uses a part")]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use fingerpost::config::Config;
use fingerpost::road_surface::RememberedMethod;
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, Pixel, Polyline};
use fingerpost_map::{Arm, ArmRole, FeatureKind, LatLon, Route, RouteFeature, RoutePoint, TangentPlane};
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Point2, Vector2};

/// Metres east and north of the junction that all scenes are built around.
pub type Place = (f64, f64);

/// Camera of all scenes: about 75 degrees wide, 1.5 m high, 8 degrees nose down, 1.5 m ahead of the rear axle.
pub fn camera() -> Camera {
    camera_of_width(640)
}

/// The same camera with pictures of another width, pixels.
pub fn camera_of_width(width: usize) -> Camera {
    calibrated(width, 8_f64.to_radians(), 1.0)
}

/// The same camera as a calibration has it that errs: by an angle of pitch, and by a factor of the focal length.
pub fn camera_calibrated_wrong(pitch_off_rad: f64, focal_factor: f64) -> Camera {
    calibrated(640, 8_f64.to_radians() + pitch_off_rad, focal_factor)
}

fn calibrated(width: usize, pitch_rad: f64, focal_factor: f64) -> Camera {
    let mount = Mount { pitch_rad, x_m: 1.5, ..Mount::level(1.5) };
    let (height, f) = (width * 3 / 4, 420.0 / 640.0 * width as f64 * focal_factor);
    let (cx, cy) = (0.5 * (width as f64 - 1.0), 0.5 * (height as f64 - 1.0));
    let intrinsics = Intrinsics { fx: f, fy: f, cx, cy };
    Camera::calibrated(width, height, intrinsics, Distortion::None, mount).unwrap()
}

/// The default settings, with road by its colours alone: a plane without a world is nothing that the network was trained on.
pub fn config() -> Config {
    let mut config = Config::default();
    config.road_surface.memory.of = RememberedMethod::Backprojection;
    config
}

/// Roads painted on the plane.
pub struct World {
    roads: Vec<(Polyline, f64)>,
}

impl World {
    /// Roads given by their lines (map frame, metres) and widths.
    pub fn new(roads: &[(&[Place], f64)]) -> Self {
        let line = |points: &[Place]| Polyline::new(points.iter().map(|&(x, y)| Point2::new(x, y))).unwrap();
        Self { roads: roads.iter().map(|(points, width)| (line(points), *width)).collect() }
    }

    fn colour(&self, p: Point2<f64>) -> [f64; 3] {
        let road = self.roads.iter().any(|(line, width)| line.nearest(p).left_m.abs() < 0.5 * width);
        let texture = 0.5 * noise(p / 0.25) + 0.3 * noise(p / 0.7) + 0.2 * noise(p / 2.3);
        let base = if road { [112.0, 108.0, 104.0] } else { [92.0, 118.0, 58.0] };
        base.map(|c| c * (0.75 + 0.5 * texture))
    }

    /// What the camera of a vehicle at `map_from_vehicle` sees; sky above the horizon.
    pub fn picture(&self, camera: &Camera, map_from_vehicle: &Isometry2<f64>) -> RgbImage {
        let mut picture = RgbImage::new(camera.width(), camera.height());
        for v in 0..camera.height() {
            for (u, out) in picture.row_mut(v).chunks_exact_mut(3).enumerate() {
                let ground = camera.ground_of_pixel(Pixel::new(u as f64, v as f64));
                let colour = match ground.filter(|p| p.x < 60.0) {
                    Some(p_in_vehicle) => self.colour(map_from_vehicle * p_in_vehicle),
                    None => [150.0, 190.0, 230.0],
                };
                out.copy_from_slice(&colour.map(|c| c.round().clamp(0.0, 255.0) as u8));
            }
        }
        picture
    }
}

/// Smooth value noise, 0 to 1.
fn noise(p: Point2<f64>) -> f64 {
    let (x0, y0) = (p.x.floor(), p.y.floor());
    let value = |dx: f64, dy: f64| {
        let mut h = ((x0 + dx) as i64 as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ ((y0 + dy) as i64 as u64).wrapping_mul(0xC2B2_AE3D_27D4_EB4F);
        h = (h ^ (h >> 29)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        ((h ^ (h >> 32)) & 0xFFFF) as f64 / 65535.0
    };
    let ease = |t: f64| t * t * (3.0 - 2.0 * t);
    let (tx, ty) = (ease(p.x - x0), ease(p.y - y0));
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    mix(mix(value(0.0, 0.0), value(1.0, 0.0), tx), mix(value(0.0, 1.0), value(1.0, 1.0), tx), ty)
}

/// One feature at the origin of the map, approached from `approach`, left by `exit`.
pub struct Junction<'a> {
    pub kind: FeatureKind,
    pub approach: &'a [Place],
    pub exit: &'a [Place],
    pub sides: &'a [&'a [Place]],
    pub width_m: f64,
}

/// A route over one feature. The route's first node is the far end of the approach; the returned vector takes places
/// given around the junction to the map frame, whose origin that node is.
pub fn route(junction: &Junction<'_>) -> (Route, Vector2<f64>) {
    let plane = TangentPlane::new(LatLon { lat_deg: 47.1, lon_deg: 9.5 });
    let at = |&(x, y): &Place| plane.wgs84_from_map(Point2::new(x, y));
    let arm = |role: ArmRole, points: &[Place]| Arm {
        role,
        bearing_rad: libm::atan2(points[1].1, points[1].0),
        points: points.iter().map(at).collect(),
        width_m: junction.width_m,
        surface: None,
        beside: Default::default(),
    };
    let mut arms = vec![arm(ArmRole::Approach, junction.approach), arm(ArmRole::Exit, junction.exit)];
    arms.extend(junction.sides.iter().map(|points| arm(ArmRole::Side, points)));
    let line: Vec<Place> =
        junction.approach.iter().rev().copied().chain(junction.exit.iter().skip(1).copied()).collect();
    let approach = Polyline::new(junction.approach.iter().map(|&(x, y)| Point2::new(x, y))).unwrap();
    let feature = RouteFeature {
        id: 7,
        at: at(&(0.0, 0.0)),
        name: "A x B".to_owned(),
        kind: junction.kind,
        turn_rad: 0.0,
        arms,
        route_m: approach.length_m(),
    };
    let points = line.iter().map(|place| RoutePoint { node: None, at: at(place) }).collect();
    let route = Route { name: "test".to_owned(), line: points, features: vec![feature] };
    let (x, y) = line[0];
    (route, Vector2::new(-x, -y))
}

/// A route straight north from `start` to `end`, with side roads at places along it: metres north, and where each side road
/// leads from its node.
pub fn route_past(sides: &[(f64, Place)], [start, end]: [f64; 2], width_m: f64) -> Route {
    let plane = TangentPlane::new(LatLon { lat_deg: 47.1, lon_deg: 9.5 });
    let at = |x: f64, y: f64| plane.wgs84_from_map(Point2::new(x, y));
    let feature = |i: usize| {
        let (north, side) = sides[i];
        let arm = |role: ArmRole, (x, y): Place| Arm {
            role,
            bearing_rad: libm::atan2(y - north, x),
            points: vec![at(0.0, north), at(x, y)],
            width_m,
            surface: None,
            beside: Default::default(),
        };
        RouteFeature {
            id: i as i64 + 1,
            at: at(0.0, north),
            name: "A x B".to_owned(),
            kind: FeatureKind::SideRoad,
            turn_rad: 0.0,
            arms: vec![
                arm(ArmRole::Approach, (0.0, start)),
                arm(ArmRole::Exit, (0.0, end)),
                arm(ArmRole::Side, (side.0, north + side.1)),
            ],
            route_m: north - start,
        }
    };
    let line = [start, end].map(|north| RoutePoint { node: None, at: at(0.0, north) });
    Route { name: "test".to_owned(), line: line.to_vec(), features: (0..sides.len()).map(feature).collect() }
}
