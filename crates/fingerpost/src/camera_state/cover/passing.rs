//! How fast what a block shows goes by while the vehicle drives ahead.

use fingerpost_geometry::{Camera, Pixel, View};
use nalgebra::Point3;

use super::BLOCK;

/// A way so short that the picture moves in proportion to it, metres.
const SHORT_WAY_M: f64 = 0.01;
/// Height up to which things stand beside the road, metres: the eaves of three storeys, roadside trees.
const RAISED_M: f64 = 10.0;

/// By how many samples level road goes by at least in a block per metre driven, which is at its upper edge; zero above the horizon.
pub(super) fn least_samples_per_m(camera: &Camera, nth: usize, place: (usize, usize)) -> f32 {
    let pixel = pixel_of_block(nth, place, 0.0);
    let moved = camera.ground_of_pixel(pixel).filter(|ahead| ahead.x > 0.0).and_then(|mut p_in_vehicle| {
        p_in_vehicle.x -= SHORT_WAY_M;
        camera.pixel_of_ground(p_in_vehicle)
    });
    samples_per_m(nth, pixel, moved)
}

/// The same above the horizon of what stands beside the road, at its lower edge; zero below it, and for a camera known by points.
pub(super) fn raised_samples_per_m(camera: &Camera, nth: usize, place: (usize, usize)) -> f32 {
    let pixel = pixel_of_block(nth, place, BLOCK as f64 - 1.0);
    let View::Calibrated { .. } = camera.view() else { return 0.0 };
    let moved = camera.ray(pixel).and_then(|(origin, direction)| {
        let along = (RAISED_M - origin.z) / direction.z;
        let p_in_vehicle = origin + along * direction.into_inner();
        let behind = Point3::new(p_in_vehicle.x - SHORT_WAY_M, p_in_vehicle.y, p_in_vehicle.z);
        if along.is_finite() && along > 0.0 { camera.project(behind) } else { None }
    });
    samples_per_m(nth, pixel, moved)
}

/// The pixel in the middle of a block's width, so many samples below its upper edge.
fn pixel_of_block(nth: usize, (column, row): (usize, usize), below: f64) -> Pixel {
    let middle = 0.5 * (BLOCK as f64 - 1.0);
    let [u, v] = [(column * BLOCK) as f64 + middle, (row * BLOCK) as f64 + below].map(|at| at * nth as f64);
    Pixel::new(u, v)
}

fn samples_per_m(nth: usize, from: Pixel, to: Option<Pixel>) -> f32 {
    to.map_or(0.0, |to| (libm::hypot(to.u - from.u, to.v - from.v) / (nth as f64 * SHORT_WAY_M)) as f32)
}
