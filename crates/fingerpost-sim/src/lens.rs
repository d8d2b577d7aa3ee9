//! The rays of a camera's pixels, taken through its lens once.

use fingerpost_geometry::{Camera, Pixel, View};
use rayon::prelude::*;

use crate::SimError;
use crate::object::dot;

/// Side of a tile of the picture, pixels.
pub(crate) const TILE_PX: usize = 16;

/// Directions of the pixels in the camera frame, and the cones around the tiles' directions.
#[derive(Debug, Clone)]
pub(crate) struct Lens {
    /// Unit vectors, row by row, zero where the lens sees nothing; beside each the square of the pixel's distance from
    /// the picture's middle, 1 in the corners.
    pub(crate) pixels: Vec<([f32; 3], f32)>,
    /// For each tile the unit vector in its middle, and cosine and sine of the angle to its farthest pixel.
    pub(crate) cones: Vec<([f32; 3], f32, f32)>,
    /// Angle between neighbouring pixels, radians.
    pub(crate) pixel_rad: f32,
}

impl Lens {
    /// The rays of a camera with a calibrated lens.
    pub(crate) fn new(camera: &Camera) -> Result<Self, SimError> {
        let View::Calibrated { intrinsics, distortion, .. } = camera.view() else {
            return Err(SimError::CameraWithoutLens);
        };
        let (width, height) = (camera.width(), camera.height());
        let direction = |u: usize, v: usize| {
            let pixel = Pixel::new(u as f64, v as f64);
            let x = (pixel.u - intrinsics.cx) / intrinsics.fx;
            let y = (pixel.v - intrinsics.cy) / intrinsics.fy;
            distortion
                .undistort(nalgebra::Vector2::new(x, y))
                .map_or([0.0; 3], |d| [d.x as f32, d.y as f32, d.z as f32])
        };
        let directions: Vec<[f32; 3]> =
            (0..width * height).into_par_iter().map(|i| direction(i % width, i / width)).collect();
        let mut cones = Vec::new();
        for top in (0..height).step_by(TILE_PX) {
            for left in (0..width).step_by(TILE_PX) {
                let pixels: Vec<[f32; 3]> = (top..(top + TILE_PX).min(height))
                    .flat_map(|v| (left..(left + TILE_PX).min(width)).map(move |u| v * width + u))
                    .map(|i| directions[i])
                    .collect();
                cones.push(cone_around(&pixels));
            }
        }
        let pixel_rad = (1.0 / (intrinsics.fx * intrinsics.fy).sqrt()) as f32;
        let (half_u, half_v) = (0.5 * width as f32, 0.5 * height as f32);
        let off_centre = |i: usize| {
            let (x, y) = ((i % width) as f32 - half_u, (i / width) as f32 - half_v);
            (x * x + y * y) / (half_u * half_u + half_v * half_v)
        };
        let pixels =
            directions.iter().enumerate().map(|(i, &direction)| (direction, off_centre(i))).collect();
        Ok(Self { pixels, cones, pixel_rad })
    }
}

fn cone_around(directions: &[[f32; 3]]) -> ([f32; 3], f32, f32) {
    let sum = directions.iter().fold([0.0; 3], |sum, d| [sum[0] + d[0], sum[1] + d[1], sum[2] + d[2]]);
    let length = dot(sum, sum).sqrt();
    if length < 1e-6 {
        return ([0.0, 0.0, 1.0], 1.0, 0.0);
    }
    let axis = sum.map(|x| x / length);
    let seen = directions.iter().filter(|d| dot(**d, **d) > 0.5);
    let cos = seen.map(|d| dot(*d, axis)).fold(1.0_f32, f32::min).clamp(-1.0, 1.0);
    (axis, cos, (1.0 - cos * cos).max(0.0).sqrt())
}
