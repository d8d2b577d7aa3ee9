//! What becomes of a developed picture: blur of the drive and of the lens, and the blocks of its compression.

use fingerpost_geometry::Camera;
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point3;

use crate::conditions::CameraLook;

/// The vanishing point is that of a place so far ahead, metres.
const FAR_M: f64 = 1e4;
/// Places along the way of a pixel that are averaged.
const PLACES: usize = 5;
/// Side of a block, pixels.
const BLOCK: usize = 8;
/// Steps of a block's coefficients at a compression of 1, grey levels: of the mean, and more for each step of frequency. Annex K of
/// ITU-T T.81, which is JPEG's quality 50, rises from 16 to 99 for grey, and to 99 within four frequencies for colour.
const GREY_STEPS: [f32; 2] = [12.0, 6.0];
const COLOUR_STEPS: [f32; 2] = [17.0, 20.0];
/// From red, green and blue to luma and two colour differences (ITU-T T.871), and back.
const FROM_RGB: [[f32; 3]; 3] = [[0.299, 0.587, 0.114], [-0.1687, -0.3313, 0.5], [0.5, -0.4187, -0.0813]];
const TO_RGB: [[f32; 3]; 3] = [[1.0, 0.0, 1.402], [1.0, -0.3441, -0.7141], [1.0, 1.772, 0.0]];

/// Blur and compression of a camera.
#[derive(Debug, Clone)]
pub(crate) struct Softening {
    /// Where the vehicle drives to, in the picture.
    vanishing_px: [f32; 2],
    motion: f32,
    defocus: f32,
    compression: f32,
    /// The cosine transform: a row for each frequency.
    cosines: [[f32; BLOCK]; BLOCK],
}

impl Softening {
    /// None for a camera without faults.
    pub(crate) fn new(camera: &Camera, look: &CameraLook) -> Option<Self> {
        let is_soft = look.motion_blur > 0.0 || look.defocus > 0.0 || look.compression > 0.0;
        let middle = [0.5 * camera.width() as f32, 0.5 * camera.height() as f32];
        let vanishing = camera.project(Point3::new(FAR_M, 0.0, 0.0));
        let cosine = |frequency: usize, at: usize| {
            let scale = if frequency == 0 { 0.125_f64 } else { 0.25 }.sqrt();
            (scale * libm::cos((at as f64 + 0.5) * frequency as f64 * std::f64::consts::PI / 8.0)) as f32
        };
        is_soft.then(|| Self {
            vanishing_px: vanishing.map_or(middle, |pixel| [pixel.u as f32, pixel.v as f32]),
            motion: look.motion_blur as f32,
            defocus: look.defocus as f32,
            compression: look.compression as f32,
            cosines: std::array::from_fn(|f| std::array::from_fn(|x| cosine(f, x))),
        })
    }

    /// The picture as it comes out of the camera.
    pub(crate) fn applied(&self, mut picture: RgbImage) -> RgbImage {
        if self.motion > 0.0 {
            picture = self.moved(&picture);
        }
        if self.defocus > 0.0 {
            let across = self.spread(&picture, [1, 0]);
            picture = self.spread(&across, [0, 1]);
        }
        if self.compression > 0.0 {
            self.compress(&mut picture);
        }
        picture
    }

    /// Each pixel as the mean of what passed it while it moved away from the vanishing point.
    fn moved(&self, picture: &RgbImage) -> RgbImage {
        let [u0, v0] = self.vanishing_px;
        let shares: [f32; PLACES] =
            std::array::from_fn(|i| 1.0 - self.motion * i as f32 / (PLACES - 1) as f32);
        mapped(picture, |u, v| {
            let mut sum = [0_u32; 3];
            for share in shares {
                let at = nearest(picture, u0 + share * (u as f32 - u0), v0 + share * (v as f32 - v0));
                sum = [0, 1, 2].map(|i| sum[i] + u32::from(at[i]));
            }
            sum.map(|total| ((total + PLACES as u32 / 2) / PLACES as u32) as u8)
        })
    }

    /// Each pixel with a share of its two neighbours in a direction.
    fn spread(&self, picture: &RgbImage, [du, dv]: [i32; 2]) -> RgbImage {
        mapped(picture, |u, v| {
            let at = |side: i32| nearest(picture, (u + side * du) as f32, (v + side * dv) as f32);
            let [before, here, after] = [-1, 0, 1].map(at);
            [0, 1, 2].map(|i| {
                let [a, b, c] = [before[i], here[i], after[i]].map(f32::from);
                (b + self.defocus * (a - 2.0 * b + c) + 0.5) as u8
            })
        })
    }

    /// Rounds each block's coefficients to their steps. What is left over at the right and lower edges stays as it is.
    fn compress(&self, picture: &mut RgbImage) {
        let (width, height) = picture.size();
        for top in (0..height.saturating_sub(BLOCK - 1)).step_by(BLOCK) {
            for left in (0..width.saturating_sub(BLOCK - 1)).step_by(BLOCK) {
                let mut block = [[[0.0_f32; BLOCK]; BLOCK]; 3];
                for y in 0..BLOCK {
                    for x in 0..BLOCK {
                        let rgb = picture.get(left + x, top + y).unwrap_or_default().map(f32::from);
                        for (plane, weights) in block.iter_mut().zip(FROM_RGB) {
                            plane[y][x] = weights[0] * rgb[0] + weights[1] * rgb[1] + weights[2] * rgb[2];
                        }
                    }
                }
                for (plane, steps) in block.iter_mut().zip([GREY_STEPS, COLOUR_STEPS, COLOUR_STEPS]) {
                    *plane = self.rounded(plane, steps);
                }
                for y in 0..BLOCK {
                    let row = &mut picture.row_mut(top + y)[3 * left..3 * (left + BLOCK)];
                    for (x, pixel) in row.chunks_exact_mut(3).enumerate() {
                        for (value, weights) in pixel.iter_mut().zip(TO_RGB) {
                            let level: f32 =
                                weights.iter().zip(&block).map(|(w, plane)| w * plane[y][x]).sum();
                            *value = (level + 0.5) as u8;
                        }
                    }
                }
            }
        }
    }

    fn rounded(&self, plane: &[[f32; BLOCK]; BLOCK], [mean, more]: [f32; 2]) -> [[f32; BLOCK]; BLOCK] {
        let c = &self.cosines;
        let product = |f: &dyn Fn(usize, usize, usize) -> f32| -> [[f32; BLOCK]; BLOCK] {
            std::array::from_fn(|i| std::array::from_fn(|j| (0..BLOCK).map(|k| f(i, j, k)).sum()))
        };
        let rows = product(&|i, j, k| c[j][k] * plane[i][k]);
        let mut coefficients = product(&|i, j, k| c[i][k] * rows[k][j]);
        for (i, row) in coefficients.iter_mut().enumerate() {
            for (j, value) in row.iter_mut().enumerate() {
                let step = self.compression * (mean + more * (i + j) as f32);
                *value = step * (*value / step).round();
            }
        }
        let rows = product(&|i, j, k| c[k][i] * coefficients[k][j]);
        product(&|i, j, k| c[k][j] * rows[i][k])
    }
}

/// The pixel nearest to a place, that of the edge beyond it.
fn nearest(picture: &RgbImage, u: f32, v: f32) -> [u8; 3] {
    let within = |value: f32, side: usize| ((value + 0.5).max(0.0) as usize).min(side.saturating_sub(1));
    picture.get(within(u, picture.width()), within(v, picture.height())).unwrap_or_default()
}

fn mapped(picture: &RgbImage, pixel: impl Fn(i32, i32) -> [u8; 3]) -> RgbImage {
    let mut out = RgbImage::new(picture.width(), picture.height());
    for v in 0..picture.height() {
        for (u, bytes) in out.row_mut(v).chunks_exact_mut(3).enumerate() {
            bytes.copy_from_slice(&pixel(u as i32, v as i32));
        }
    }
    out
}

#[cfg(test)]
mod tests;
