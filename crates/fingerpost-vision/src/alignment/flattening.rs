//! A picture without the brightness that varies slowly over it.
//!
//! What the lens, dirt on it and the vehicle's own lights do to a picture stays with the camera while the road goes by, and
//! would speak for a vehicle that stands, the more the darker it is. So each place is held against the mean of what is seen
//! about it, or, where that lies to one side of it, against the plane through it. Both are taken over blocks and laid between
//! them linearly: rounded to grey levels, their contours would stay with the camera as well.

mod moments;

use self::moments::{ColumnMoments, Moments};
use crate::elementary::whole_part;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Grey of a place in a flattened picture that is as bright as what lies about it.
pub const FLAT: u8 = 128;
/// How many times stronger differences are in a flattened picture, of which a road has few.
const GAIN: f32 = 2.0;

/// Flattens pictures of one size; its memory is reused from picture to picture.
#[derive(Debug, Clone)]
pub struct Flattening {
    block_px: usize,
    reach_blocks: usize,
    /// Sum of the grey of the seen pixels, and their number, of each block.
    sums: Plane<u32>,
    counts: Plane<u32>,
    /// Sums of each column of blocks over the window's rows.
    window: Vec<ColumnMoments>,
    /// Mean of what is seen in the window about each block, for its place.
    means: Plane<f32>,
    /// Means of the blocks at the height of a row of pixels.
    across: Vec<f32>,
    /// Neighbouring columns of pixels that lie between the same blocks.
    runs: Vec<ColumnRun>,
    /// How far each column of pixels lies towards the second of its blocks.
    shares: Vec<f32>,
    /// Of each column of pixels, over the rows of a block: the sum of the grey, and the number of seen pixels.
    column_sums: Vec<u32>,
    column_counts: Vec<u32>,
    /// The mean at each pixel of a row.
    row: Vec<f32>,
}

/// So many neighbouring columns of pixels lie between these blocks.
#[derive(Debug, Clone, Copy)]
struct ColumnRun {
    left: usize,
    right: usize,
    count: usize,
}

impl Flattening {
    /// For means over windows of about `window_px` pixels a side, made of blocks of `block_px`.
    #[must_use]
    pub fn new(block_px: usize, window_px: usize) -> Self {
        let block_px = block_px.max(1);
        Self {
            block_px,
            reach_blocks: (window_px / 2).div_ceil(block_px),
            sums: Plane::default(),
            counts: Plane::default(),
            window: Vec::new(),
            means: Plane::default(),
            across: Vec::new(),
            runs: Vec::new(),
            shares: Vec::new(),
            column_sums: Vec::new(),
            column_counts: Vec::new(),
            row: Vec::new(),
        }
    }

    /// Fills `flat` with twice the difference of each seen pixel of `grey` (not 0) from the mean about it, beyond [`FLAT`],
    /// and with 0 where nothing is seen.
    pub fn apply(&mut self, grey: &Plane<u8>, flat: &mut Plane<u8>) {
        self.apply_on(CodePath::fastest(), grey, flat);
    }

    pub(super) fn apply_on(&mut self, path: CodePath, grey: &Plane<u8>, flat: &mut Plane<u8>) {
        let (width, height) = grey.size();
        if flat.size() != grey.size() {
            flat.reset(width, height, 0);
        }
        if width == 0 || height == 0 {
            return;
        }
        self.add_up(path, grey);
        self.take_means();
        let (columns, rows) = self.means.size();
        self.across.resize(columns, 0.0);
        self.row.resize(width, 0.0);
        if self.shares.len() != width {
            self.take_columns(width, columns);
        }
        for y in 0..height {
            let (above, below, share) = between(y, self.block_px, rows);
            let (above, below) = (self.means.row(above), self.means.row(below));
            for (out, (&above, &below)) in self.across.iter_mut().zip(above.iter().zip(below)) {
                *out = above + (below - above) * share;
            }
            lay_between(path, &self.across, &self.runs, &self.shares, &mut self.row);
            take_off(path, &self.row, grey.row(y), flat.row_mut(y));
        }
    }

    /// Notes between which blocks the columns of pixels lie.
    fn take_columns(&mut self, width: usize, columns: usize) {
        self.runs.clear();
        self.shares.clear();
        for x in 0..width {
            let (left, right, share) = between(x, self.block_px, columns);
            self.shares.push(share);
            match self.runs.last_mut() {
                Some(run) if (run.left, run.right) == (left, right) => run.count += 1,
                _ => self.runs.push(ColumnRun { left, right, count: 1 }),
            }
        }
    }

    fn add_up(&mut self, path: CodePath, grey: &Plane<u8>) {
        let (width, height) = grey.size();
        let (columns, rows) = (width.div_ceil(self.block_px), height.div_ceil(self.block_px));
        self.sums.reset(columns, rows, 0);
        self.counts.reset(columns, rows, 0);
        for row in 0..rows {
            // Down the columns first: these sums are made for many columns at once.
            for of_column in [&mut self.column_sums, &mut self.column_counts] {
                of_column.clear();
                of_column.resize(width, 0);
            }
            for y in row * self.block_px..((row + 1) * self.block_px).min(height) {
                add_row(path, grey.row(y), &mut self.column_sums, &mut self.column_counts);
            }
            for (of_column, of_block) in
                [(&self.column_sums, self.sums.row_mut(row)), (&self.column_counts, self.counts.row_mut(row))]
            {
                add_across(path, self.block_px, of_column, of_block);
            }
        }
    }

    fn take_means(&mut self) {
        let (columns, rows) = self.sums.size();
        self.means.reset(columns, rows, f32::from(FLAT));
        let reach = self.reach_blocks;
        self.window.clear();
        self.window.resize(columns, ColumnMoments::default());
        for row in 0..rows.min(reach) {
            self.enter(row);
        }
        for row in 0..rows {
            if row + reach < rows {
                self.enter(row + reach);
            }
            if let Some(left) = row.checked_sub(reach + 1) {
                self.leave(left);
            }
            let mut moments = Moments::default();
            for (column, of_column) in self.window.iter().enumerate().take(reach) {
                moments.add(column, of_column);
            }
            for (column, mean) in self.means.row_mut(row).iter_mut().enumerate() {
                if let Some(entered) = self.window.get(column + reach) {
                    moments.add(column + reach, entered);
                }
                if let Some(left) = column.checked_sub(reach + 1) {
                    moments.take_off(left, &self.window[left]);
                }
                if let Some(grey) = moments.grey_at(column, row) {
                    *mean = grey;
                }
            }
        }
    }

    /// Adds a row of blocks to the window.
    fn enter(&mut self, row: usize) {
        let blocks = self.counts.row(row).iter().zip(self.sums.row(row));
        for (sum, (&count, &grey)) in self.window.iter_mut().zip(blocks) {
            *sum += ColumnMoments::of_block(row, count, grey);
        }
    }

    /// Takes a row of blocks off the window.
    fn leave(&mut self, row: usize) {
        let blocks = self.counts.row(row).iter().zip(self.sums.row(row));
        for (sum, (&count, &grey)) in self.window.iter_mut().zip(blocks) {
            *sum -= ColumnMoments::of_block(row, count, grey);
        }
    }
}

/// The blocks between whose middles a pixel lies, and how far it is towards the second.
#[inline(always)]
fn between(pixel: usize, block_px: usize, blocks: usize) -> (usize, usize, f32) {
    let at = ((pixel as f32 + 0.5) / block_px as f32 - 0.5).clamp(0.0, (blocks - 1) as f32);
    let first = at as usize;
    (first, (first + 1).min(blocks - 1), at - first as f32)
}

simd_kernel! {
    fn add_row(grey: &[u8], sums: &mut [u32], counts: &mut [u32]) {
        for ((&grey, sum), count) in grey.iter().zip(sums).zip(counts) {
            *sum += u32::from(grey);
            *count += u32::from(grey != 0);
        }
    }
}

simd_kernel! {
    fn add_across(block_px: usize, of_column: &[u32], of_block: &mut [u32]) {
        for (columns, sum) in of_column.chunks(block_px).zip(of_block) {
            // Blocks of a known width are added in registers.
            *sum = match columns {
                [a, b, c, d] => a + b + c + d,
                _ => columns.iter().sum(),
            };
        }
    }
}

simd_kernel! {
    /// Lays what is given at the blocks' middles between them, along a row.
    fn lay_between(at_blocks: &[f32], runs: &[ColumnRun], shares: &[f32], row: &mut [f32]) {
        let (mut shares, mut row) = (shares, row);
        for run in runs {
            let (from, to) = (at_blocks[run.left], at_blocks[run.right]);
            let step = to - from;
            let Some((of_run, others)) = shares.split_at_checked(run.count) else { return };
            let Some((out, rest)) = row.split_at_mut_checked(run.count) else { return };
            // Runs of a known length need no loop.
            if let (Ok(shares), Ok(out)) = (<&[f32; 4]>::try_from(of_run), <&mut [f32; 4]>::try_from(&mut *out)) {
                *out = shares.map(|share| from + step * share);
            } else {
                out.iter_mut().zip(of_run).for_each(|(out, share)| *out = from + step * share);
            }
            (shares, row) = (others, rest);
        }
    }
}

simd_kernel! {
    fn take_off(means: &[f32], grey: &[u8], flat: &mut [u8]) {
        for ((out, &grey), &mean) in flat.iter_mut().zip(grey).zip(means) {
            let flat = f32::from(FLAT) + GAIN * (f32::from(grey) - mean);
            *out = if grey != 0 { whole_part((flat + 0.5).clamp(1.0, 255.0)) as u8 } else { 0 };
        }
    }
}
