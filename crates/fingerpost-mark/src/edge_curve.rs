//! The curve through an edge's points.

use fingerpost_geometry::Pchip;

/// Rows between the points of a curve that is handed out: a lane's edge bends by far less than a pixel over them.
const CURVE_STEP_PX: f64 = 4.0;
/// Points in rows closer together than this are one point: no hand tells them apart.
const SAME_ROW_PX: f64 = 0.5;
/// Rows over which the direction at a curve's end is taken.
const END_PX: f64 = 1.0;

/// A lane's edge as a column for every row: a shape-preserving cubic through points, straight on beyond its ends.
///
/// A lane's edge crosses each row once, so that its column is a function of the row.
#[derive(Debug, Clone, PartialEq)]
pub struct EdgeCurve {
    /// Column over row.
    spline: Pchip,
    far_row: f64,
    near_row: f64,
}

impl EdgeCurve {
    /// The curve through points `[u, v]`, in any order; none without a point.
    pub fn new(points: &[[f64; 2]]) -> Option<Self> {
        let mut by_row: Vec<[f64; 2]> = tidy(points).into_iter().map(|[u, v]| [v, u]).collect();
        by_row.reverse();
        let (far_row, near_row) = (by_row.first()?[0], by_row.last()?[0]);
        let mut spline = Pchip::default();
        spline.fit(&by_row);
        Some(Self { spline, far_row, near_row })
    }

    /// The rows between which it has points: the uppermost and the lowest.
    pub fn rows(&self) -> (f64, f64) {
        (self.far_row, self.near_row)
    }

    /// Column at a row; beyond the points the curve goes straight on.
    pub fn column(&self, row: f64) -> f64 {
        let at = |row: f64| self.spline.at(row).unwrap_or_default();
        let step = END_PX.min(self.near_row - self.far_row);
        let straight_on = |end: f64, inside: f64| {
            let rise = end - inside;
            let slope = if rise.abs() > 0.0 { (at(end) - at(inside)) / rise } else { 0.0 };
            at(end) + slope * (row - end)
        };
        if row < self.far_row {
            straight_on(self.far_row, self.far_row + step)
        } else if row > self.near_row {
            straight_on(self.near_row, self.near_row - step)
        } else {
            at(row)
        }
    }
}

/// Points from near to far, one a row; those that are no numbers are left out.
pub(crate) fn tidy(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> =
        points.iter().copied().filter(|point| point.iter().all(|c| c.is_finite())).collect();
    kept.sort_by(|a, b| b[1].total_cmp(&a[1]));
    kept.dedup_by(|far, near| near[1] - far[1] < SAME_ROW_PX);
    kept
}

/// Points `[u, v]` of a column that is known at every row, from the near row to the far one.
pub(crate) fn traced(far_row: f64, near_row: f64, column: impl Fn(f64) -> f64) -> Vec<[f64; 2]> {
    let steps = ((near_row - far_row) / CURVE_STEP_PX).ceil().max(1.0) as usize;
    let row = |k: usize| near_row + (far_row - near_row) * k as f64 / steps as f64;
    let last = if near_row > far_row { steps } else { 0 };
    (0..=last).map(|k| [column(row(k)), row(k)]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_goes_through_its_points_and_straight_on() {
        let curve = EdgeCurve::new(&[[100.0, 400.0], [60.0, 500.0], [80.0, 450.0]]).unwrap();
        assert_eq!(curve.rows(), (400.0, 500.0));
        for (row, column) in
            [(400.0, 100.0), (450.0, 80.0), (500.0, 60.0), (425.0, 90.0), (510.0, 56.0), (390.0, 104.0)]
        {
            assert!((curve.column(row) - column).abs() < 1e-9, "{row}: {}", curve.column(row));
        }
    }

    #[test]
    fn one_point_is_an_edge_of_one_row() {
        let curve = EdgeCurve::new(&[[7.0, 3.0]]).unwrap();
        assert_eq!(curve.rows(), (3.0, 3.0));
        assert!((curve.column(9.0) - 7.0).abs() < 1e-12);
        assert_eq!(traced(3.0, 3.0, |row| curve.column(row)), [[7.0, 3.0]]);
        assert_eq!(EdgeCurve::new(&[[f64::NAN, 3.0]]), None);
    }

    #[test]
    fn points_come_from_near_to_far_one_a_row() {
        let points = [[1.0, 10.0], [2.0, 30.0], [3.0, 30.2], [4.0, f64::INFINITY]];
        assert_eq!(tidy(&points), [[3.0, 30.2], [1.0, 10.0]]);
    }

    #[test]
    fn a_trace_reaches_both_ends() {
        let trace = traced(10.0, 19.0, |row| 2.0 * row);
        assert_eq!((trace.first(), trace.last()), (Some(&[38.0, 19.0]), Some(&[20.0, 10.0])));
        assert_eq!(trace.len(), 4);
    }
}
