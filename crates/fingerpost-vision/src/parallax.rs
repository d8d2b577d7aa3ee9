//! Parallax: how well two views of one place agree when one of them is shifted against the other.
//!
//! Two views of a plane are superimposed through the plane's projective map ([`register`]); what lies off the plane is
//! then displaced by its parallax, in one direction for all of it (Kumar, Anandan and Hanna, "Direct recovery of shape from
//! multiple views: a parallax based approach", 1994). So the correlation of the two, over small windows and at several shifts
//! ([`Correlation::at_shift`]), shows how far off the plane each place lies. What is even along the columns is taken off first
//! ([`Detrending`]): a shift along the columns cannot be seen in it.

mod correlation;
mod detrending;
mod likelihood;
pub mod rise_chain;
#[cfg(test)]
mod tests;

pub use self::correlation::{Correlation, HalfWindow, Rows};
pub use self::detrending::Detrending;
pub use self::likelihood::{LikelihoodLines, NOT_SEEN, log_likelihoods};

use crate::elementary::whole_part;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// A grey value of a [`coarse`] view where nothing is seen.
pub const UNSEEN: i16 = -1;
/// Steps of a [`coarse`] view in one of 8-bit grey.
pub const GREY_STEPS: i32 = 8;

/// A map of places in one view to those of another: a projective map behind a displacement along the columns,
/// (column, row) to M (column, row + s, 1), s = `row_shift[0] + row_shift[1] column` in row `row`.
pub trait Registration {
    /// Numerators of column and row and the denominator in the other view, at column 0 of a row, and what they grow by with each
    /// column.
    fn along_row(&self, row: usize) -> [[f32; 2]; 3];
}

/// The mean grey of squares of `ACROSS` columns and `down` rows of `grey`, up to 128 pixels, in [`GREY_STEPS`], or [`UNSEEN`] where
/// `seen` is 0 anywhere in one; rests at the right and lower edge are left out. `coarse` keeps its memory.
pub fn coarse<const ACROSS: usize>(grey: &Plane<u8>, seen: &Plane<u8>, down: usize, coarse: &mut Plane<i16>) {
    let down = down.max(1);
    let size = (grey.width() / ACROSS.max(1), grey.height() / down);
    if coarse.size() != size {
        coarse.reset(size.0, size.1, UNSEEN);
    }
    if grey.size() != seen.size() {
        coarse.as_mut_slice().fill(UNSEEN);
        return;
    }
    let path = CodePath::fastest();
    for row in 0..size.1 {
        let out = coarse.row_mut(row);
        out.fill(0);
        for line in row * down..(row + 1) * down {
            add_squares::<ACROSS>(path, grey.row(line), seen.row(line), out);
        }
        to_steps(path, (ACROSS * down) as f32, out);
    }
}

simd_kernel! {
    fn add_squares<const ACROSS: usize>(grey: &[u8], seen: &[u8], sums: &mut [i16]) {
        let (grey, seen) = (grey.as_chunks::<ACROSS>().0, seen.as_chunks::<ACROSS>().0);
        for ((grey, seen), sum) in grey.iter().zip(seen).zip(sums) {
            let (mut added, mut all) = (0, true);
            for (grey, seen) in grey.iter().zip(seen) {
                added += i16::from(*grey);
                all &= *seen != 0;
            }
            *sum = if all && *sum >= 0 { *sum + added } else { UNSEEN };
        }
    }
}

simd_kernel! {
    fn to_steps(pixels: f32, sums: &mut [i16]) {
        let steps = GREY_STEPS as f32 / pixels;
        for sum in sums {
            let seen = if *sum >= 0 { *sum } else { 0 };
            let mean = whole_part(f32::from(seen) * steps) as i16;
            *sum = if *sum >= 0 { mean } else { UNSEEN };
        }
    }
}

/// Lays `other` over a view: each place of `registered` (whose size is kept) gets the value of `other`, between pixels, where
/// `registration` leads, or [`UNSEEN`].
pub fn register(other: &Plane<i16>, registration: &impl Registration, registered: &mut Plane<i16>) {
    let path = CodePath::fastest();
    for row in 0..registered.height() {
        let [column, line, below] = registration.along_row(row);
        register_row(
            path,
            other.as_slice(),
            other.width(),
            other.height(),
            column,
            line,
            below,
            registered.row_mut(row),
        );
    }
}

/// Places of a row that are led to the other view together.
const LANES: usize = 16;

simd_kernel! {
    fn register_row(
        other: &[i16], width: usize, height: usize,
        column: [f32; 2], line: [f32; 2], below: [f32; 2], out: &mut [i16],
    ) {
        let (last_x, last_y) = (width as f32 - 1.0, height as f32 - 1.0);
        for (block, out) in out.chunks_mut(LANES).enumerate() {
            let (mut dx, mut dy) = ([0.0_f32; LANES], [0.0_f32; LANES]);
            let (mut start, mut is_inside) = ([0_u32; LANES], [false; LANES]);
            for lane in 0..LANES {
                let at = (block * LANES + lane) as f32;
                let w = below[0] + below[1] * at;
                let (x, y) = ((column[0] + column[1] * at) / w, (line[0] + line[1] * at) / w);
                let inside = (x >= 0.0) & (y >= 0.0) & (x < last_x) & (y < last_y);
                let (x, y) = if inside { (x, y) } else { (0.0, 0.0) };
                let (left, top) = (whole_part(x), whole_part(y));
                start[lane] = top * width as u32 + left;
                is_inside[lane] = inside;
                (dx[lane], dy[lane]) = (x - left as i32 as f32, y - top as i32 as f32);
            }
            let (mut upper, mut lower) = ([[0_i16; 2]; LANES], [[UNSEEN; 2]; LANES]);
            for lane in 0..LANES {
                let from = other.get(start[lane] as usize..).and_then(|from| from.get(..width + 2));
                if let Some(from) = from.filter(|_| is_inside[lane]) {
                    upper[lane] = [from[0], from[1]];
                    lower[lane] = [from[width], from[width + 1]];
                }
            }
            let mut registered = [0_i16; LANES];
            for lane in 0..LANES {
                let ([a, b], [c, d]) = (upper[lane], lower[lane]);
                let is_seen = (a | b | c | d) >= 0;
                let [a, b, c, d] = [a, b, c, d].map(|corner| i32::from(corner) as f32);
                let (upper, lower) = (a + dx[lane] * (b - a), c + dx[lane] * (d - c));
                let between = upper + dy[lane] * (lower - upper);
                // What is not seen is below zero.
                let whole = whole_part(if is_seen { between + 0.5 } else { 0.0 }) as i16;
                registered[lane] = if is_seen { whole } else { UNSEEN };
            }
            out.copy_from_slice(&registered[..out.len()]);
        }
    }
}
