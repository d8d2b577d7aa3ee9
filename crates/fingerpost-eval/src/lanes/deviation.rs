//! The Lane Position Deviation of one edge in one frame (paper 3, equation 1).

use super::edge::column_at_row;
use super::measure::LpdDivisor;

/// The rows over which an edge is measured.
#[derive(Debug, Clone, Copy)]
pub(super) struct Region {
    /// Height of the picture, pixels.
    pub(super) height: u32,
    /// Its lowest rows, of the picture's at the most.
    pub(super) roi_rows: u32,
    pub(super) divisor: LpdDivisor,
}

/// What becomes of an edge that is evaluated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Deviation {
    /// Mean squared distance along the rows, squared pixels.
    Of { lpd_px2: f64 },
    /// A row that the truth reaches has no output.
    NoOutput,
}

/// Compares an edge with its truth over a region; none where the truth reaches none of them.
pub(super) fn deviation(
    truth: &[[f64; 2]],
    run: &[[f64; 2]],
    &Region { height, roi_rows, divisor }: &Region,
) -> Option<Deviation> {
    let (mut sum_px2, mut rows, mut all_found) = (0.0, 0_u32, true);
    for row in height.saturating_sub(roi_rows)..height {
        let row = f64::from(row);
        let Some(truth_u) = column_at_row(truth, row) else { continue };
        rows += 1;
        match column_at_row(run, row) {
            Some(u) => sum_px2 += (truth_u - u).powi(2),
            None => all_found = false,
        }
    }
    let divisor = match divisor {
        LpdDivisor::EvaluatedRows => rows,
        LpdDivisor::Region => roi_rows.min(height),
    };
    let lpd_px2 = sum_px2 / f64::from(divisor);
    (rows > 0).then_some(if all_found { Deviation::Of { lpd_px2 } } else { Deviation::NoOutput })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A region of a picture of ten rows.
    fn region(roi_rows: u32, divisor: LpdDivisor) -> Region {
        Region { height: 10, roi_rows, divisor }
    }

    fn measured(truth: &[[f64; 2]], run: &[[f64; 2]], roi_rows: u32) -> Option<Deviation> {
        deviation(truth, run, &region(roi_rows, LpdDivisor::EvaluatedRows))
    }

    #[test]
    fn the_mean_of_the_squares_over_the_rows_of_the_region() {
        let truth = [[10.0, 9.0], [10.0, 0.0]];
        // 0 px beside the truth in the lowest row, one more in every row above.
        let run = [[10.0, 9.0], [19.0, 0.0]];
        let lpd = |roi_rows| match measured(&truth, &run, roi_rows) {
            Some(Deviation::Of { lpd_px2 }) => lpd_px2,
            other => panic!("{other:?}"),
        };
        // (0 + 1 + 4 + 9) / 4
        assert!((lpd(4) - 3.5).abs() < 1e-12);
        // The picture has no more than ten rows: (0 + 1 + ... + 81) / 10
        assert!((lpd(150) - 28.5).abs() < 1e-12);
    }

    #[test]
    fn rows_that_only_the_truth_reaches_have_no_output() {
        let truth = [[10.0, 9.0], [10.0, 5.0]];
        assert_eq!(measured(&truth, &[], 5), Some(Deviation::NoOutput));
        let short = [[10.0, 8.0], [10.0, 5.0]];
        assert_eq!(measured(&truth, &short, 5), Some(Deviation::NoOutput));
        // Rows that the truth does not reach are not evaluated, whatever the output is there.
        let long = [[12.0, 9.0], [12.0, 0.0]];
        assert_eq!(measured(&truth, &long, 10), Some(Deviation::Of { lpd_px2: 4.0 }));
    }

    #[test]
    fn an_edge_beyond_the_region_is_not_evaluated() {
        let far = [[10.0, 4.0], [10.0, 0.0]];
        assert_eq!(measured(&far, &far, 5), None);
        assert_eq!(measured(&[], &far, 5), None);
    }

    #[test]
    fn as_printed_the_sum_is_divided_by_the_region() {
        // Four rows of truth, 2 px beside: 16 px² over 4 rows, or over the 8 of the region.
        let (truth, run) = ([[10.0, 9.0], [10.0, 6.0]], [[12.0, 9.0], [12.0, 0.0]]);
        let over = |divisor| deviation(&truth, &run, &region(8, divisor));
        assert_eq!(over(LpdDivisor::EvaluatedRows), Some(Deviation::Of { lpd_px2: 4.0 }));
        assert_eq!(over(LpdDivisor::Region), Some(Deviation::Of { lpd_px2: 2.0 }));
        // The picture has no more than ten rows.
        let all = deviation(&truth, &run, &region(150, LpdDivisor::Region));
        assert_eq!(all, Some(Deviation::Of { lpd_px2: 1.6 }));
    }
}
