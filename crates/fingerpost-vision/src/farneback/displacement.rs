//! Displacements from pairs of polynomials.

use super::FlowField;
use super::expansion::{Expansion, Quadratic};
use crate::error::PictureError;
use crate::filter::BoxMean;
use crate::picture::Plane;

/// Weights of pixels near the edge by their distance from it: polynomials there rest on continued pixels. The values are
/// those of OpenCV's implementation.
const EDGE_WEIGHTS: [f32; 5] = [0.14, 0.14, 0.4472, 0.4472, 0.4472];
/// Added to the determinant of each window's equations, in their units (grey levels per square pixel, to the fourth power),
/// so that a window without texture gives no displacement instead of any. The value is that of OpenCV's implementation.
const DETERMINANT_FLOOR: f32 = 1e-3;

/// Refines a flow by one step of windowed least squares (Farneback 2003).
#[derive(Debug, Clone)]
pub(super) struct DisplacementSolver {
    window: BoxMean,
    /// `A^T A` (xx, xy, yy) and `A^T b` (x, y) of each pixel.
    equations: [Plane<f32>; 5],
    /// The same, averaged over the window.
    averaged: [Plane<f32>; 5],
}

impl DisplacementSolver {
    pub(super) fn new(window_radius_px: usize) -> Self {
        Self {
            window: BoxMean::new(window_radius_px),
            equations: Default::default(),
            averaged: Default::default(),
        }
    }

    /// Replaces `flow` by the displacements that its own values, as a first guess, lead to.
    pub(super) fn refine(
        &mut self,
        from: &Expansion,
        to: &Expansion,
        flow: &mut FlowField,
    ) -> Result<(), PictureError> {
        self.set_up(from, to, flow);
        for (equation, averaged) in self.equations.iter().zip(&mut self.averaged) {
            self.window.apply(equation, averaged)?;
        }
        let [xx, xy, yy, bx, by] = self.averaged.each_ref().map(Plane::as_slice);
        let outs = flow.dx.as_mut_slice().iter_mut().zip(flow.dy.as_mut_slice());
        for (i, (dx, dy)) in outs.enumerate() {
            let inverse = 1.0 / (xx[i] * yy[i] - xy[i] * xy[i] + DETERMINANT_FLOOR);
            *dx = (yy[i] * bx[i] - xy[i] * by[i]) * inverse;
            *dy = (xx[i] * by[i] - xy[i] * bx[i]) * inverse;
        }
        Ok(())
    }

    fn set_up(&mut self, from: &Expansion, to: &Expansion, flow: &FlowField) {
        let (width, height) = (from.width, from.height);
        if self.equations[0].size() != (width, height) {
            let planes = self.equations.iter_mut().chain(&mut self.averaged);
            planes.for_each(|plane| plane.reset(width, height, 0.0));
        }
        let [xx, xy, yy, bx, by] = &mut self.equations;
        for y in 0..height {
            let (xx, xy, yy) = (xx.row_mut(y), xy.row_mut(y), yy.row_mut(y));
            let (bx, by) = (bx.row_mut(y), by.row_mut(y));
            let (dx, dy) = (flow.dx.row(y), flow.dy.row(y));
            let row_weight = edge_weight(y, height);
            for (x, here) in from.quadratics[y * width..(y + 1) * width].iter().enumerate() {
                let there = sample(to, x as f32 + dx[x], y as f32 + dy[x]);
                // A is the mean of both, b half the difference of the slopes, plus what the
                // displacement so far accounts for. Where the other picture shows nothing, this one's A stands alone.
                let [a_xx, a_yy, a_xy] = match there {
                    Some(q) => [0.5 * (here.xx + q.xx), 0.5 * (here.yy + q.yy), 0.25 * (here.xy + q.xy)],
                    None => [here.xx, here.yy, 0.5 * here.xy],
                };
                let slope = there.unwrap_or_default();
                let b_x = 0.5 * (here.x - slope.x) + a_xx * dx[x] + a_xy * dy[x];
                let b_y = 0.5 * (here.y - slope.y) + a_xy * dx[x] + a_yy * dy[x];
                let weight = row_weight * edge_weight(x, width);
                let [a_xx, a_yy, a_xy, b_x, b_y] = [a_xx, a_yy, a_xy, b_x, b_y].map(|value| value * weight);
                xx[x] = a_xx * a_xx + a_xy * a_xy;
                xy[x] = (a_xx + a_yy) * a_xy;
                yy[x] = a_yy * a_yy + a_xy * a_xy;
                bx[x] = a_xx * b_x + a_xy * b_y;
                by[x] = a_xy * b_x + a_yy * b_y;
            }
        }
    }
}

fn edge_weight(index: usize, length: usize) -> f32 {
    let from = |distance: usize| EDGE_WEIGHTS.get(distance).copied().unwrap_or(1.0);
    from(index) * from(length - 1 - index)
}

/// The polynomial at a place between pixels, bilinearly; `None` unless all four pixels around it exist.
fn sample(expansion: &Expansion, u: f32, v: f32) -> Option<Quadratic> {
    let (width, height) = (expansion.width, expansion.height);
    if !(u >= 0.0 && v >= 0.0) {
        return None;
    }
    // Not negative, so the conversion rounds down.
    let (x, y) = (u as usize, v as usize);
    if x >= width - 1 || y >= height - 1 {
        return None;
    }
    let (right, below) = (u - x as f32, v - y as f32);
    let index = y * width + x;
    let upper = &expansion.quadratics[index..index + 2];
    let lower = &expansion.quadratics[index + width..index + width + 2];
    let weights =
        [(1.0 - right) * (1.0 - below), right * (1.0 - below), (1.0 - right) * below, right * below];
    let mix = |part: fn(&Quadratic) -> f32| {
        weights[0] * part(&upper[0])
            + weights[1] * part(&upper[1])
            + weights[2] * part(&lower[0])
            + weights[3] * part(&lower[1])
    };
    Some(Quadratic {
        x: mix(|q| q.x),
        y: mix(|q| q.y),
        xx: mix(|q| q.xx),
        yy: mix(|q| q.yy),
        xy: mix(|q| q.xy),
    })
}
