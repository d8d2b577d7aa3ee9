//! Places of corners at fractions of a pixel.
//!
//! Förstner and Gülch 1987: the gradient at every pixel about a corner is across an edge that leads through it, so the
//! corner is the place `q` with the least sum of `w (g . (q - p))^2` over the pixels `p` with gradients `g`.

use crate::picture::PlaneView;

const ITERATIONS: usize = 40;
/// A step below which the place stays, pixels.
const STILL_PX: f64 = 1e-3;
/// Least ratio of the gradients' second moments across two directions: below, all edges run one way.
const LEAST_RATIO: f64 = 0.01;

/// Brightness between pixels' centres, grey levels; none outside the picture.
pub(super) fn brightness(grey: PlaneView<'_, u8>, [u, v]: [f64; 2]) -> Option<f64> {
    let (width, height) = grey.size();
    if !(u >= 0.0 && v >= 0.0 && u <= width as f64 - 1.0 && v <= height as f64 - 1.0) {
        return None;
    }
    let (x, y) = (u as usize, v as usize);
    let (right, below) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
    let (along, down) = (u - x as f64, v - y as f64);
    let mix = |row: &[u8]| f64::from(row[x]) * (1.0 - along) + f64::from(row[right]) * along;
    Some(mix(grey.row(y)) * (1.0 - down) + mix(grey.row(below)) * down)
}

/// The corner near `start` by the pixels up to `reach` to either side of it; none where the picture ends, where there is no
/// corner, or where it lies farther than `reach` away.
pub(super) fn refined(grey: PlaneView<'_, u8>, start: [f64; 2], reach: usize) -> Option<[f64; 2]> {
    let mut corner = start;
    for _ in 0..ITERATIONS {
        let step = step_to_corner(grey, corner, reach as isize)?;
        corner = [corner[0] + step[0], corner[1] + step[1]];
        if libm::hypot(corner[0] - start[0], corner[1] - start[1]) > reach as f64 {
            return None;
        }
        if libm::hypot(step[0], step[1]) < STILL_PX {
            break;
        }
    }
    Some(corner)
}

/// From the window's middle to the corner that its gradients point to.
fn step_to_corner(grey: PlaneView<'_, u8>, [u, v]: [f64; 2], reach: isize) -> Option<[f64; 2]> {
    let side = (2 * reach + 3) as usize;
    let mut patch = Vec::with_capacity(side * side);
    for y in -reach - 1..=reach + 1 {
        for x in -reach - 1..=reach + 1 {
            patch.push(brightness(grey, [u + x as f64, v + y as f64])?);
        }
    }
    let (mut xx, mut xy, mut yy, mut across_x, mut across_y) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for row in 1..side - 1 {
        for column in 1..side - 1 {
            let at = row * side + column;
            let (x, y) = ((column as isize - 1 - reach) as f64, (row as isize - 1 - reach) as f64);
            // Pixels at the window's edge count e^-2 as much as one at the corner.
            let weight = libm::exp(-(x * x + y * y) / (reach * reach) as f64);
            let (gx, gy) = (patch[at + 1] - patch[at - 1], patch[at + side] - patch[at - side]);
            let (wxx, wxy, wyy) = (weight * gx * gx, weight * gx * gy, weight * gy * gy);
            xx += wxx;
            xy += wxy;
            yy += wyy;
            across_x += wxx * x + wxy * y;
            across_y += wxy * x + wyy * y;
        }
    }
    let determinant = xx * yy - xy * xy;
    let mean = 0.5 * (xx + yy);
    // The determinant is the product of both moments, the trace their sum.
    (determinant > LEAST_RATIO * mean * mean).then(|| {
        [(yy * across_x - xy * across_y) / determinant, (xx * across_y - xy * across_x) / determinant]
    })
}
