//! Sums over a window of blocks, of which a plane of grey is fitted (local linear regression).
//!
//! Where a window is cut off by the end of what is seen, a mean lies to one side of the place and would leave a slope of the
//! light standing there; a plane does not (Fan and Gijbels, Local Polynomial Modelling and Its Applications, 1996, 3.2.5).

use std::ops::{AddAssign, SubAssign};

/// Added to the spread of what is seen in each direction, blocks squared: few blocks in a row show no slope across it.
const SPREAD: f64 = 1.0;

/// Sums of one column of blocks over the rows of the window: number of seen pixels and their grey, and both times the row.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ColumnMoments {
    count: i64,
    row: i64,
    row_row: i64,
    grey: i64,
    grey_row: i64,
}

impl ColumnMoments {
    /// Of one block.
    pub(super) fn of_block(row: usize, count: u32, grey: u32) -> Self {
        let (row, count, grey) = (row as i64, i64::from(count), i64::from(grey));
        Self { count, row: count * row, row_row: count * row * row, grey, grey_row: grey * row }
    }
}

impl AddAssign for ColumnMoments {
    fn add_assign(&mut self, other: Self) {
        self.count += other.count;
        self.row += other.row;
        self.row_row += other.row_row;
        self.grey += other.grey;
        self.grey_row += other.grey_row;
    }
}

impl SubAssign for ColumnMoments {
    fn sub_assign(&mut self, other: Self) {
        self.count -= other.count;
        self.row -= other.row;
        self.row_row -= other.row_row;
        self.grey -= other.grey;
        self.grey_row -= other.grey_row;
    }
}

/// Sums over the whole window, as far as they have been added up.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Moments {
    rows: ColumnMoments,
    column: i64,
    column_column: i64,
    column_row: i64,
    grey_column: i64,
}

impl Moments {
    pub(super) fn add(&mut self, column: usize, of_column: &ColumnMoments) {
        let column = column as i64;
        self.rows += *of_column;
        self.column += column * of_column.count;
        self.column_column += column * column * of_column.count;
        self.column_row += column * of_column.row;
        self.grey_column += column * of_column.grey;
    }

    pub(super) fn take_off(&mut self, column: usize, of_column: &ColumnMoments) {
        let column = column as i64;
        self.rows -= *of_column;
        self.column -= column * of_column.count;
        self.column_column -= column * column * of_column.count;
        self.column_row -= column * of_column.row;
        self.grey_column -= column * of_column.grey;
    }

    /// Grey of the plane at a block; none where nothing is seen in the window.
    pub(super) fn grey_at(&self, column: usize, row: usize) -> Option<f32> {
        if self.rows.count == 0 {
            return None;
        }
        // One division for all means: they take most of the time.
        let share = 1.0 / self.rows.count as f64;
        let mean = |sum: i64| sum as f64 * share;
        let (across, down, grey) = (mean(self.column), mean(self.rows.row), mean(self.rows.grey));
        let spread_across = mean(self.column_column) - across * across + SPREAD;
        let spread_down = mean(self.rows.row_row) - down * down + SPREAD;
        let together = mean(self.column_row) - across * down;
        let with_across = mean(self.grey_column) - across * grey;
        let with_down = mean(self.rows.grey_row) - down * grey;
        // The spread added keeps it away from zero.
        let inverse = 1.0 / (spread_across * spread_down - together * together);
        let slope_across = (spread_down * with_across - together * with_down) * inverse;
        let slope_down = (spread_across * with_down - together * with_across) * inverse;
        Some((grey + slope_across * (column as f64 - across) + slope_down * (row as f64 - down)) as f32)
    }
}
