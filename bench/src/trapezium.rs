//! The ground view that the peer's loop makes: a trapezium of road in the picture becomes a strip of a square.

use anyhow::Result;
use fingerpost::ground_view::GroundViewConfig;
use fingerpost_geometry::{Camera, GroundGrid, GroundPixel, Pixel};

use crate::peer::Array;

/// Corners of the trapezium as shares of the picture's width and height: upper left, upper right, lower right, lower left.
const IN_PICTURE: [[f64; 2]; 4] = [[0.42, 0.66], [0.58, 0.66], [1.1, 0.97], [-0.1, 0.97]];
/// The same corners as shares of the square's side.
const IN_SQUARE: [[f64; 2]; 4] = [[0.35, 0.0], [0.65, 0.0], [0.65, 1.0], [0.35, 1.0]];
/// Scale that the square is taken to have, metres a pixel.
const METRES_PER_PIXEL: f64 = 0.05;
/// Distance at which its lower edge is taken to lie, metres.
const NEAR_M: f64 = 4.0;

/// A square ground view of `side_px` pixels of pictures of `width` x `height`.
#[derive(Debug)]
pub struct Trapezium {
    pub config: GroundViewConfig,
    pub camera: Camera,
    pub side_px: usize,
}

impl Trapezium {
    pub fn new((width, height): (usize, usize), side_px: usize) -> Result<Self> {
        let side_m = side_px as f64 * METRES_PER_PIXEL;
        let config = GroundViewConfig {
            near_m: NEAR_M,
            far_m: NEAR_M + side_m,
            half_width_m: 0.5 * side_m,
            metres_per_pixel: METRES_PER_PIXEL,
        };
        let grid =
            GroundGrid::new(config.near_m, config.far_m, config.half_width_m, config.metres_per_pixel)?;
        let road_m = IN_SQUARE.map(|[x, y]| {
            let pixel = GroundPixel { column: x * side_px as f64, row: y * side_px as f64 };
            grid.vehicle_from_ground(pixel)
        });
        let image = IN_PICTURE.map(|[x, y]| Pixel { u: x * width as f64, v: y * height as f64 });
        let camera = Camera::from_points(width, height, image, road_m)?;
        Ok(Self { config, camera, side_px })
    }

    /// Length of the square's side, metres.
    pub fn side_m(&self) -> f64 {
        self.side_px as f64 * METRES_PER_PIXEL
    }

    /// Where each pixel of the square lies in the picture.
    pub fn place(&self, column: usize, row: usize) -> Option<[f64; 2]> {
        let c = &self.config;
        let grid = GroundGrid::new(c.near_m, c.far_m, c.half_width_m, c.metres_per_pixel).ok()?;
        let pixel = GroundPixel { column: column as f64, row: row as f64 };
        self.camera.pixel_of_ground(grid.vehicle_from_ground(pixel)).map(|p| [p.u, p.v])
    }

    /// The places as OpenCV takes them, columns and rows, and 255 where they lie in the picture.
    pub fn maps(&self) -> [Array; 3] {
        let n = self.side_px;
        let (mut us, mut vs, mut seen) = (Vec::new(), Vec::new(), Vec::new());
        for row in 0..n {
            for column in 0..n {
                // Far outside where there is no place at all.
                let [u, v] = self.place(column, row).unwrap_or([-1e4, -1e4]);
                let (last_u, last_v) = (self.camera.width() as f64 - 1.0, self.camera.height() as f64 - 1.0);
                let inside = (0.0..=last_u).contains(&u) && (0.0..=last_v).contains(&v);
                us.push(u as f32);
                vs.push(v as f32);
                seen.push(if inside { 255 } else { 0 });
            }
        }
        [Array::of_f32(&[n, n], &us), Array::of_f32(&[n, n], &vs), Array::of_u8(&[n, n], &seen)]
    }
}
