//! Brightness evened out along the columns.

use crate::elementary::whole_part;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Largest departure from the mean that counts, in steps: sums of products over windows of 2000 cells then fit 32 bits.
const MOST_DEPARTURE: f32 = 1000.0;

/// Takes off, at each place, the mean of what is seen up to `half` rows above and below it; 0 where nothing is seen.
#[derive(Debug, Default)]
pub struct Detrending {
    sums: Vec<i32>,
    counts: Vec<i32>,
}

impl Detrending {
    /// Into `out`, whose memory is reused.
    pub fn detrend(&mut self, view: &Plane<i16>, half: usize, out: &mut Plane<i16>) {
        let (width, height) = view.size();
        if out.size() != view.size() {
            out.reset(width, height, 0);
        }
        for sums in [&mut self.sums, &mut self.counts] {
            sums.clear();
            sums.resize(width, 0);
        }
        let path = CodePath::fastest();
        for row in 0..half.min(height) {
            add_row(path, view.row(row), 1, &mut self.sums, &mut self.counts);
        }
        for row in 0..height {
            if row + half < height {
                add_row(path, view.row(row + half), 1, &mut self.sums, &mut self.counts);
            }
            if row > half {
                add_row(path, view.row(row - half - 1), -1, &mut self.sums, &mut self.counts);
            }
            departures(path, view.row(row), &self.sums, &self.counts, out.row_mut(row));
        }
    }
}

simd_kernel! {
    fn add_row(row: &[i16], sign: i32, sums: &mut [i32], counts: &mut [i32]) {
        for ((value, sum), count) in row.iter().zip(sums).zip(counts) {
            let is_seen = i32::from(*value >= 0);
            *sum += sign * is_seen * i32::from(*value);
            *count += sign * is_seen;
        }
    }
}

simd_kernel! {
    pub(super) fn departures(row: &[i16], sums: &[i32], counts: &[i32], out: &mut [i16]) {
        for (((value, sum), count), out) in row.iter().zip(sums).zip(counts).zip(out) {
            let departure = f32::from(*value) - *sum as f32 / (*count).max(1) as f32;
            let size = whole_part(departure.abs().min(MOST_DEPARTURE)) as i16;
            let departure = if departure < 0.0 { -size } else { size };
            *out = if *value >= 0 { departure } else { 0 };
        }
    }
}
