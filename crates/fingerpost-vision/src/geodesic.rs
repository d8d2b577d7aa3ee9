//! Geodesic distance: how hard it is to come from the seeds to each pixel, over whatever way is easiest.
//!
//! P. J. Toivanen, "New geodesic distance transforms for gray-scale images", 1996: distances are carried along by sweeps
//! over the rows. Steps go to the eight neighbours; a step costs the mean of its two pixels, a diagonal one 1.414 times as
//! much. Limits: a way that turns up and down more often than there are sweeps is not found at its true cost, only at a
//! higher one.

use crate::elementary::whole_part;
use crate::error::{PictureError, check_size};
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Distance of a pixel that no way leads to.
pub const UNREACHED: u32 = 1 << 30;
/// Largest cost of a pixel: a way through 8000 of them still counts below [`UNREACHED`].
pub const MAX_COST: u32 = 1 << 16;
/// The square root of 2 as a fraction: 181 / 128.
const DIAGONAL: (u32, u32) = (181, 7);

/// Sweeps distances over a picture, with the buffers that it needs.
#[derive(Debug, Clone, Default)]
pub struct GeodesicSweeps {
    /// Distances and costs of the row that the sweep comes from, with one pixel beyond either end.
    from: Vec<u32>,
    from_costs: Vec<u32>,
    /// Costs of the steps from each pixel's left neighbour.
    steps: Vec<u32>,
    rightwards: Vec<u32>,
}

impl GeodesicSweeps {
    /// Lowers `distance`, which holds 0 on the seeds and [`UNREACHED`] elsewhere, to the distance over `cost` (half the
    /// price of crossing a pixel, 1 to [`MAX_COST`]): by `sweeps` sweeps, the first one upwards, the second downwards, and so on. Rows above `first_row` are
    /// left as they are.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn spread(
        &mut self,
        cost: &Plane<u32>,
        first_row: usize,
        sweeps: usize,
        distance: &mut Plane<u32>,
    ) -> Result<(), PictureError> {
        self.spread_on(CodePath::fastest(), cost, first_row, sweeps, distance)
    }

    fn spread_on(
        &mut self,
        path: CodePath,
        cost: &Plane<u32>,
        first_row: usize,
        sweeps: usize,
        distance: &mut Plane<u32>,
    ) -> Result<(), PictureError> {
        check_size("geodesic distance", cost.size(), distance.size())?;
        let (width, height) = cost.size();
        if width == 0 {
            return Ok(());
        }
        self.from.clear();
        self.from.resize(width + 2, UNREACHED);
        self.from_costs.clear();
        self.from_costs.resize(width + 2, 0);
        self.steps.resize(width, 0);
        self.rightwards.resize(width, 0);
        for sweep in 0..sweeps {
            for step in 0..height.saturating_sub(first_row) {
                let is_upwards = sweep % 2 == 0;
                let y = if is_upwards { height - 1 - step } else { first_row + step };
                if step > 0 {
                    let from = if is_upwards { y + 1 } else { y - 1 };
                    self.from[1..=width].copy_from_slice(distance.row(from));
                    self.from_costs[1..=width].copy_from_slice(cost.row(from));
                    across_rows(path, &self.from, &self.from_costs, cost.row(y), distance.row_mut(y));
                }
                steps_of_row(path, cost.row(y), &mut self.steps);
                along_row(&self.steps, &mut self.rightwards, distance.row_mut(y));
                lesser(path, &self.rightwards, distance.row_mut(y));
            }
        }
        Ok(())
    }
}

simd_kernel! {
    fn across_rows(from: &[u32], from_costs: &[u32], costs: &[u32], out: &mut [u32]) {
        let width = out.len();
        let costs = &costs[..width];
        let (left, middle, right) = (&from[..width], &from[1..][..width], &from[2..][..width]);
        let (left_cost, middle_cost, right_cost) =
            (&from_costs[..width], &from_costs[1..][..width], &from_costs[2..][..width]);
        let (times, shift) = DIAGONAL;
        for x in 0..width {
            let straight = middle[x] + middle_cost[x] + costs[x];
            let from_left = left[x] + (((left_cost[x] + costs[x]) * times) >> shift);
            let from_right = right[x] + (((right_cost[x] + costs[x]) * times) >> shift);
            out[x] = out[x].min(straight).min(from_left).min(from_right);
        }
    }
}

simd_kernel! {
    fn steps_of_row(costs: &[u32], steps: &mut [u32]) {
        let width = steps.len();
        let (left, right) = (&costs[..width - 1], &costs[1..width]);
        steps[0] = 0;
        for ((step, left), right) in steps[1..].iter_mut().zip(left).zip(right) {
            *step = left + right;
        }
    }
}

simd_kernel! {
    fn lesser(other: &[u32], out: &mut [u32]) {
        for (out, &other) in out.iter_mut().zip(other) {
            *out = other.min(*out);
        }
    }
}

/// Carries distances to the right, into `rightwards`, and to the left, in place. Neither needs the other: the cheapest way
/// along a row never turns. Two chains of dependent sums run side by side so.
fn along_row(steps: &[u32], rightwards: &mut [u32], row: &mut [u32]) {
    let width = row.len();
    let (steps, rightwards) = (&steps[..width], &mut rightwards[..width]);
    let (mut right, mut left) = (UNREACHED, UNREACHED);
    let mut step_left = 0;
    // The right-going chain must read a pixel before the left-going one overwrites it, and in the second half it reads
    // what has been overwritten: that is itself a true distance, so the result is the same or a shorter true one.
    for x in 0..width {
        right = row[x].min(right + steps[x]);
        rightwards[x] = right;
        let mirrored = width - 1 - x;
        left = row[mirrored].min(left + step_left);
        row[mirrored] = left;
        step_left = steps[mirrored];
    }
}

/// Fills `target` with 255 / (1 + (distance / half)^3): nearness, 255 on the seeds, half of that at the distance `half`,
/// which must be at least 1.
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the two differ in size.
pub fn nearness(distance: &Plane<u32>, half: u32, target: &mut Plane<u8>) -> Result<(), PictureError> {
    check_size("nearness", distance.size(), target.size())?;
    nearness_of(CodePath::fastest(), distance.as_slice(), 1.0 / half.max(1) as f32, target.as_mut_slice());
    Ok(())
}

simd_kernel! {
    fn nearness_of(distances: &[u32], scale: f32, out: &mut [u8]) {
        for (out, &distance) in out.iter_mut().zip(distances) {
            let relative = distance as i32 as f32 * scale;
            *out = whole_part(255.0 / (1.0 + relative * relative * relative) + 0.5) as u8;
        }
    }
}

#[cfg(test)]
mod tests;
