//! Parallax: how well two views of one place agree when one of them is shifted against the other.
//!
//! Two views of a plane are laid over each other through the plane's projective map ([`register`]); what lies off the plane is
//! then displaced by its parallax, in one direction for all of it (Kumar, Anandan and Hanna, "Direct recovery of shape from
//! multiple views: a parallax based approach", 1994). So the correlation of the two, over small windows and at several shifts
//! ([`Correlation::at_shift`]), shows how far off the plane each place lies. What is even along the columns is taken off first
//! ([`Detrending`]): a shift along the columns cannot be seen in it.

use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// A grey value of a [`coarse`] view where nothing is seen.
pub const UNSEEN: i16 = -1;
/// Steps of a [`coarse`] view in one of 8-bit grey.
pub const GREY_STEPS: i32 = 8;
/// Largest departure from the mean that counts, in steps: sums of products over windows of 2000 cells then fit 32 bits.
const MOST_DEPARTURE: f32 = 1000.0;

/// A map of places in one view to those of another: a projective map behind a displacement along the columns,
/// (column, row) to M (column, row + s, 1), s = `row_shift[0] + row_shift[1] column` in row `row`.
pub trait Registration {
    /// Numerators of column and row and the denominator in the other view, at column 0 of a row, and what they grow by with each
    /// column.
    fn along_row(&self, row: usize) -> [[f32; 2]; 3];
}

/// The mean grey of squares of `across` columns and `down` rows of `grey`, in [`GREY_STEPS`], or [`UNSEEN`] where `seen` is 0
/// anywhere in one; rests at the right and lower edge are left out. `coarse` keeps its memory.
pub fn coarse(grey: &Plane<u8>, seen: &Plane<u8>, (across, down): (usize, usize), coarse: &mut Plane<i16>) {
    let (across, down) = (across.max(1), down.max(1));
    let size = (grey.width() / across, grey.height() / down);
    if coarse.size() != size {
        coarse.reset(size.0, size.1, UNSEEN);
    }
    if grey.size() != seen.size() {
        coarse.as_mut_slice().fill(UNSEEN);
        return;
    }
    let pixels = (across * down) as i32;
    for row in 0..size.1 {
        let out = coarse.row_mut(row);
        for (column, out) in out.iter_mut().enumerate() {
            let (mut sum, mut all) = (0, true);
            for line in row * down..(row + 1) * down {
                let columns = column * across..(column + 1) * across;
                sum += grey.row(line)[columns.clone()].iter().map(|&value| i32::from(value)).sum::<i32>();
                all &= seen.row(line)[columns].iter().all(|&seen| seen != 0);
            }
            *out = if all { (GREY_STEPS * sum / pixels) as i16 } else { UNSEEN };
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

simd_kernel! {
    fn register_row(
        other: &[i16], width: usize, height: usize,
        column: [f32; 2], line: [f32; 2], below: [f32; 2], out: &mut [i16],
    ) {
        let (last_x, last_y) = (width as f32 - 1.0, height as f32 - 1.0);
        for (at, out) in out.iter_mut().enumerate() {
            let at = at as f32;
            let w = below[0] + below[1] * at;
            let (x, y) = ((column[0] + column[1] * at) / w, (line[0] + line[1] * at) / w);
            *out = UNSEEN;
            if !(x >= 0.0 && y >= 0.0 && x < last_x && y < last_y) {
                continue;
            }
            let (left, top) = (x as usize, y as usize);
            let start = top * width + left;
            let (Some(&[a, b]), Some(&[c, d])) = (
                other.get(start..start + 2).and_then(<[i16]>::as_array::<2>),
                other.get(start + width..start + width + 2).and_then(<[i16]>::as_array::<2>),
            ) else { continue };
            if a.min(b).min(c).min(d) < 0 {
                continue;
            }
            let (dx, dy) = (x - left as f32, y - top as f32);
            let upper = f32::from(a) + dx * (f32::from(b) - f32::from(a));
            let lower = f32::from(c) + dx * (f32::from(d) - f32::from(c));
            *out = (upper + dy * (lower - upper) + 0.5) as i16;
        }
    }
}

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
    fn departures(row: &[i16], sums: &[i32], counts: &[i32], out: &mut [i16]) {
        for (((value, sum), count), out) in row.iter().zip(sums).zip(counts).zip(out) {
            let departure = f32::from(*value) - *sum as f32 / (*count).max(1) as f32;
            let departure = departure.clamp(-MOST_DEPARTURE, MOST_DEPARTURE);
            *out = if *value >= 0 { departure as i16 } else { 0 };
        }
    }
}

/// Half the sides of a window, cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct HalfWindow {
    /// Columns to each side.
    pub columns: usize,
    /// Rows above and below.
    pub rows: usize,
}

impl HalfWindow {
    /// Cells of a whole window.
    #[must_use]
    pub const fn cells(self) -> usize {
        (2 * self.columns + 1) * (2 * self.rows + 1)
    }
}

/// Every so many rows, from one of them on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rows {
    /// The first.
    pub first: usize,
    /// How many rows on the next one is, at least 1.
    pub step: usize,
}

impl Rows {
    /// All rows.
    pub const ALL: Self = Self { first: 0, step: 1 };

    /// Those of them that a view of this height has.
    pub fn of(self, height: usize) -> impl Iterator<Item = usize> {
        (self.first..height).step_by(self.step.max(1))
    }

    fn contain(self, row: usize) -> bool {
        row.checked_sub(self.first).is_some_and(|rows| rows.is_multiple_of(self.step.max(1)))
    }
}

/// Sums over windows, with their memory.
#[derive(Debug, Default)]
pub struct Correlation {
    /// Sums along the columns, with a window's half at each side.
    columns: Vec<i32>,
    across: Vec<i32>,
}

impl Correlation {
    /// One over the root of the sum of squares in each window of `detrended`; 0 where its mean square is at most `noise` (square
    /// steps).
    pub fn scales(
        &mut self,
        detrended: &Plane<i16>,
        window: HalfWindow,
        noise: f32,
        scales: &mut Plane<f32>,
    ) {
        let (width, height) = detrended.size();
        if scales.size() != (width, height) {
            scales.reset(width, height, 0.0);
        }
        let least = noise * window.cells() as f32;
        self.sums(detrended, detrended, [0, 0], (window, Rows::ALL), |path, row, sums| {
            scale_row(path, sums, least, scales.row_mut(row));
        });
    }

    /// The correlation, -1 to 1, of each place's window in `view` with that in `other` `shift` rows farther up and columns farther
    /// left, both detrended and of one size; 0 where either has no scale. Only `rows` of `correlation` are written.
    pub fn at_shift(
        &mut self,
        (view, scales): (&Plane<i16>, &Plane<f32>),
        (other, other_scales): (&Plane<i16>, &Plane<f32>),
        [up, left]: [isize; 2],
        (window, rows): (HalfWindow, Rows),
        correlation: &mut Plane<f32>,
    ) {
        let (width, height) = view.size();
        if correlation.size() != (width, height) {
            correlation.reset(width, height, 0.0);
        }
        if [other.size(), scales.size(), other_scales.size()] != [view.size(); 3] {
            correlation.as_mut_slice().fill(0.0);
            return;
        }
        self.sums(view, other, [up, left], (window, rows), |path, row, sums| {
            let out = correlation.row_mut(row);
            out.fill(0.0);
            let Some(other_row) = row.checked_add_signed(-up).filter(|&row| row < height) else { return };
            let (to, from) = overlap(width, left);
            let count = width - to.max(from);
            correlate_row(
                path,
                &sums[to..to + count],
                &scales.row(row)[to..to + count],
                &other_scales.row(other_row)[from..from + count],
                &mut out[to..to + count],
            );
        });
    }

    /// Calls `finish` with the sums of products over the windows of each of `rows`.
    fn sums(
        &mut self,
        view: &Plane<i16>,
        other: &Plane<i16>,
        [up, left]: [isize; 2],
        (window, rows): (HalfWindow, Rows),
        mut finish: impl FnMut(CodePath, usize, &[i32]),
    ) {
        let (width, height) = view.size();
        let path = CodePath::fastest();
        self.columns.clear();
        self.columns.resize(width + 2 * window.columns, 0);
        self.across.clear();
        self.across.resize(width, 0);
        let (to, from) = overlap(width, left);
        let count = width - to.max(from);
        let products = |row: usize| {
            let other_row = row.checked_add_signed(-up).filter(|&row| row < height)?;
            Some((&view.row(row)[to..to + count], &other.row(other_row)[from..from + count]))
        };
        let first = window.columns + to;
        for row in 0..height + window.rows {
            if row < height
                && let Some((a, b)) = products(row)
            {
                add_products(path, a, b, 1, &mut self.columns[first..first + count]);
            }
            if row < window.rows {
                continue;
            }
            let middle = row - window.rows;
            if middle > window.rows
                && let Some((a, b)) = products(middle - window.rows - 1)
            {
                add_products(path, a, b, -1, &mut self.columns[first..first + count]);
            }
            if rows.contain(middle) {
                sum_across(path, &self.columns, window.columns, &mut self.across);
                finish(path, middle, &self.across);
            }
        }
    }
}

/// Where a row begins to have a partner `left` columns farther left, and where that one's row does.
const fn overlap(width: usize, left: isize) -> (usize, usize) {
    let by = left.unsigned_abs();
    let by = if by < width { by } else { width };
    if left >= 0 { (by, 0) } else { (0, by) }
}

simd_kernel! {
    fn add_products(a: &[i16], b: &[i16], sign: i32, sums: &mut [i32]) {
        for ((a, b), sum) in a.iter().zip(b).zip(sums) {
            *sum += sign * i32::from(*a) * i32::from(*b);
        }
    }
}

simd_kernel! {
    fn sum_across(columns: &[i32], half: usize, out: &mut [i32]) {
        let width = out.len();
        out.copy_from_slice(&columns[..width]);
        for start in 1..=2 * half {
            for (out, column) in out.iter_mut().zip(&columns[start..start + width]) {
                *out += *column;
            }
        }
    }
}

simd_kernel! {
    fn scale_row(sums: &[i32], least: f32, out: &mut [f32]) {
        for (sum, out) in sums.iter().zip(out) {
            let sum = *sum as f32;
            *out = if sum > least { 1.0 / sum.sqrt() } else { 0.0 };
        }
    }
}

simd_kernel! {
    fn correlate_row(sums: &[i32], scales: &[f32], other: &[f32], out: &mut [f32]) {
        for (((sum, scale), other), out) in sums.iter().zip(scales).zip(other).zip(out) {
            *out = *sum as f32 * *scale * *other;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(column: usize, row: usize) -> i16 {
        let mixed = (column as u32).wrapping_mul(2_654_435_761) ^ (row as u32).wrapping_mul(40_503_111);
        (mixed.wrapping_mul(0x9E37_79B1) >> 22) as i16
    }

    fn plane(width: usize, height: usize, of: impl Fn(usize, usize) -> i16) -> Plane<i16> {
        let values = (0..width * height).map(|i| of(i % width, i / width)).collect();
        Plane::from_vec(width, height, values).unwrap()
    }

    struct Shifted([f32; 2]);

    impl Registration for Shifted {
        fn along_row(&self, row: usize) -> [[f32; 2]; 3] {
            [[self.0[0], 1.0], [row as f32 + self.0[1], 0.0], [1.0, 0.0]]
        }
    }

    #[test]
    fn a_square_is_its_mean_and_unseen_where_any_of_it_is() {
        let grey = Plane::from_vec(5, 2, vec![10_u8, 20, 0, 0, 9, 30, 40, 0, 8, 9]).unwrap();
        let seen = Plane::from_vec(5, 2, vec![1_u8, 1, 1, 0, 1, 1, 1, 1, 1, 1]).unwrap();
        let mut out = Plane::default();
        coarse(&grey, &seen, (2, 2), &mut out);
        assert_eq!(out.as_slice(), &[25 * GREY_STEPS as i16, UNSEEN]);
    }

    #[test]
    fn a_view_is_laid_over_between_pixels_and_only_where_both_are_seen() {
        let mut other = plane(8, 6, |column, row| (100 * column + 10 * row) as i16);
        other.row_mut(4)[5] = UNSEEN;
        let mut registered = Plane::new(8, 6, 0);
        register(&other, &Shifted([1.5, 0.5]), &mut registered);
        assert_eq!(registered.get(2, 1), Some(365));
        assert_eq!(registered.get(3, 3), Some(UNSEEN), "beside what is not seen");
        assert_eq!(registered.get(6, 1), Some(UNSEEN), "beyond the picture");
    }

    #[test]
    fn what_runs_along_the_columns_is_taken_off() {
        let mut out = Plane::new(0, 0, 0);
        Detrending::default().detrend(&plane(30, 20, |column, _| (7 * column) as i16), 3, &mut out);
        assert!(out.as_slice().iter().all(|&value| value == 0));
        let step = plane(1, 9, |_, row| if row == 4 { 70 } else { UNSEEN.max(0) });
        Detrending::default().detrend(&step, 1, &mut out);
        assert_eq!(out.as_slice(), &[0, 0, 0, -23, 46, -23, 0, 0, 0]);
    }

    #[test]
    fn the_correlation_is_one_at_the_true_shift_and_small_elsewhere() {
        let window = HalfWindow { columns: 2, rows: 4 };
        let view = plane(40, 50, |column, row| texture(column + 10, row + 10) - 512);
        // What `view` shows in a row is two rows farther up and one column farther right in `other`.
        let other = plane(40, 50, |column, row| texture(column + 9, row + 12) - 512);
        let mut correlation = Correlation::default();
        let [mut scales, mut other_scales] = [Plane::default(), Plane::default()];
        correlation.scales(&view, window, 1.0, &mut scales);
        correlation.scales(&other, window, 1.0, &mut other_scales);
        let mut at = |shift| {
            let mut out = Plane::default();
            correlation.at_shift(
                (&view, &scales),
                (&other, &other_scales),
                shift,
                (window, Rows::ALL),
                &mut out,
            );
            out
        };
        let (right, wrong) = (at([2, -1]), at([-2, 1]));
        for (column, row) in [(8, 9), (20, 30), (30, 40)] {
            assert!((right.get(column, row).unwrap() - 1.0).abs() < 1e-4);
            assert!(wrong.get(column, row).unwrap().abs() < 0.6);
        }
        assert_eq!(right.get(20, 0), Some(0.0), "no partner");
    }

    #[test]
    fn every_path_gives_the_same_numbers() {
        let a: Vec<i16> = (0..131).map(|i| texture(i, 3) - 512).collect();
        let b: Vec<i16> = (0..131).map(|i| texture(i, 5) - 512).collect();
        let of = |path| {
            let mut sums = vec![0; 131];
            add_products(path, &a, &b, 1, &mut sums);
            let mut across = vec![0; 121];
            sum_across(path, &sums, 5, &mut across);
            let mut scales = vec![0.0; 121];
            scale_row(path, &across, 1.0, &mut scales);
            let mut correlated = vec![0.0; 121];
            correlate_row(path, &across, &scales, &scales, &mut correlated);
            let mut departed = vec![0; 131];
            departures(path, &a, &sums, &vec![7; 131], &mut departed);
            let mut laid = vec![0; 40];
            let other: Vec<i16> = (0..60 * 20).map(|i| texture(i % 60, i / 60)).collect();
            register_row(path, &other, 60, 20, [3.3, 1.1], [7.2, 0.13], [1.0, 0.002], &mut laid);
            (across, scales, correlated, departed, laid)
        };
        let portable = of(CodePath::PORTABLE);
        CodePath::available().for_each(|path| assert_eq!(of(path), portable, "{path:?}"));
    }
}
