//! Where a lane's edge crosses a row of the picture.

/// How far from its centre a row of pixels reaches.
const HALF_ROW_PX: f64 = 0.5;

/// Column at which an edge, `[u, v]` pixels from near to far, crosses the middle of a row; none where it does not reach it.
///
/// Between points it is straight. An edge that ends inside the row's pixels, half a pixel above or below their middle,
/// reaches the row: it goes on straight for that half pixel. Where a slope of the road lets it cross a row more than once,
/// the crossing nearest to the vehicle counts.
pub fn column_at_row(edge: &[[f64; 2]], row: f64) -> Option<f64> {
    let crossed = edge.windows(2).find_map(|pair| {
        let ([u, v], [next_u, next_v]) = (pair[0], pair[1]);
        let within = v.min(next_v) <= row && row <= v.max(next_v);
        within.then(|| at([u, v], [next_u, next_v], row))
    });
    crossed.or_else(|| {
        let near = edge.first().zip(edge.get(1).or(edge.first()));
        let far = edge.last().zip(edge.iter().nth_back(1).or(edge.last()));
        let mut ends = [near, far].into_iter().flatten();
        let (end, next) = ends.find(|(end, _)| (end[1] - row).abs() <= HALF_ROW_PX)?;
        Some(at(*end, *next, row))
    })
}

/// Column of the line through two points at a row; of the first point where the line lies in a row itself.
fn at([u, v]: [f64; 2], [next_u, next_v]: [f64; 2], row: f64) -> f64 {
    // Below a billionth of a pixel the points stand in one row.
    const LEVEL_PX: f64 = 1e-9;
    let rise = next_v - v;
    if rise.abs() < LEVEL_PX { u } else { u + (next_u - u) * (row - v) / rise }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Option<f64>, expected: f64) {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-12), "{found:?} is not {expected}");
    }

    #[test]
    fn rows_between_points_are_on_the_line() {
        let edge = [[100.0, 479.0], [140.0, 459.0], [150.0, 449.0]];
        close(column_at_row(&edge, 479.0), 100.0);
        close(column_at_row(&edge, 469.0), 120.0);
        close(column_at_row(&edge, 459.0), 140.0);
        close(column_at_row(&edge, 454.0), 145.0);
    }

    #[test]
    fn an_edge_reaches_the_row_in_which_it_ends() {
        let edge = [[100.0, 478.6], [140.0, 458.6]];
        close(column_at_row(&edge, 479.0), 99.2);
        close(column_at_row(&edge, 458.4), 140.4);
        assert_eq!(column_at_row(&edge, 480.0), None);
        assert_eq!(column_at_row(&edge, 458.0), None);
        close(column_at_row(&[[7.0, 3.0]], 3.0), 7.0);
        close(column_at_row(&[[7.0, 3.0]], 3.5), 7.0);
    }

    #[test]
    fn nothing_reaches_nothing() {
        assert_eq!(column_at_row(&[], 1.0), None);
        assert_eq!(column_at_row(&[[f64::NAN, f64::NAN]; 3], 1.0), None);
        assert_eq!(column_at_row(&[[1.0, 1.0], [2.0, 2.0]], f64::NAN), None);
    }

    #[test]
    fn of_two_crossings_the_nearer_counts_and_a_level_piece_has_its_first_column() {
        let over_a_crest = [[100.0, 400.0], [120.0, 380.0], [130.0, 390.0]];
        close(column_at_row(&over_a_crest, 385.0), 115.0);
        close(column_at_row(&[[10.0, 5.0], [20.0, 5.0]], 5.0), 10.0);
    }
}
