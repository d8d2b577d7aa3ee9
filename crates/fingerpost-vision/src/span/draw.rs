//! Scan conversion of polygons and strokes by the pixel-centre rule.

use super::Span;

/// Where an outline crosses a row: the column, and 1 where it goes down, -1 where it goes up.
type Crossing = (f64, i32);

/// Appends the runs of a closed polygon's pixels, by the non-zero winding rule.
pub(super) fn polygon(corners_px: &[[f64; 2]], spans: &mut Vec<Span>) {
    if corners_px.len() >= 3 {
        fill(corners_px, &mut vec![(0.0, 0); corners_px.len()], spans);
    }
}

/// Appends the runs of a polygon's pixels; `crossings` has room for one a corner.
fn fill(corners_px: &[[f64; 2]], crossings: &mut [Crossing], spans: &mut Vec<Span>) {
    let rows = corners_px.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), corner| {
        (low.min(corner[1]), high.max(corner[1]))
    });
    for row in pixels_between(rows.0, rows.1) {
        let v = f64::from(row);
        let mut count = 0;
        for (index, from) in corners_px.iter().enumerate() {
            let to = &corners_px[(index + 1) % corners_px.len()];
            // Half open, so that a corner on the row counts for exactly one of its two edges where it must.
            if (from[1] <= v) != (to[1] <= v) {
                let u = from[0] + (v - from[1]) / (to[1] - from[1]) * (to[0] - from[0]);
                crossings[count] = (u, if from[1] <= v { 1 } else { -1 });
                count += 1;
            }
        }
        let crossings = &mut crossings[..count];
        crossings.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
        let mut winding = 0;
        for pair in crossings.windows(2) {
            winding += pair[0].1;
            if winding != 0 {
                let columns = pixels_between(pair[0].0, pair[1].0);
                spans.push(Span { row, start: columns.start, end: columns.end });
            }
        }
    }
}

/// Appends the runs of a stroke's pixels: a rectangle for each segment, a disc at each inner point.
pub(super) fn stroke(polyline_px: &[[f64; 2]], width_px: f64, spans: &mut Vec<Span>) {
    let half = 0.5 * width_px;
    let mut is_inner = false;
    for ends in polyline_px.windows(2) {
        let [from, to] = [ends[0], ends[1]];
        let along = [to[0] - from[0], to[1] - from[1]];
        let length = libm::hypot(along[0], along[1]);
        if length <= 0.0 {
            continue;
        }
        let across = [-along[1] / length * half, along[0] / length * half];
        let corner = |end: [f64; 2], side: f64| [end[0] + side * across[0], end[1] + side * across[1]];
        let rectangle = [corner(from, 1.0), corner(to, 1.0), corner(to, -1.0), corner(from, -1.0)];
        fill(&rectangle, &mut [(0.0, 0); 4], spans);
        if is_inner {
            disc(from, half, spans);
        }
        is_inner = true;
    }
}

fn disc(centre_px: [f64; 2], radius_px: f64, spans: &mut Vec<Span>) {
    for row in pixels_between(centre_px[1] - radius_px, centre_px[1] + radius_px) {
        let rise = f64::from(row) - centre_px[1];
        let reach = (radius_px * radius_px - rise * rise).max(0.0).sqrt();
        let columns = pixels_between(centre_px[0] - reach, centre_px[0] + reach);
        spans.push(Span { row, start: columns.start, end: columns.end });
    }
}

/// The pixels whose centres lie at `from` or above it and below `to`. Coordinates are within reach, so they fit `i32`.
fn pixels_between(from_px: f64, to_px: f64) -> std::ops::Range<i32> {
    from_px.ceil() as i32..to_px.ceil() as i32
}

#[cfg(test)]
mod tests {
    use crate::span::{Span, SpanMask};

    #[test]
    fn a_square_covers_the_pixels_whose_centres_it_holds() {
        let mask = SpanMask::from_polygon(&[[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [0.0, 2.0]]).unwrap();
        assert_eq!(mask.spans(), &[Span { row: 0, start: 0, end: 3 }, Span { row: 1, start: 0, end: 3 }]);
        let turned = SpanMask::from_polygon(&[[0.0, 2.0], [3.0, 2.0], [3.0, 0.0], [0.0, 0.0]]).unwrap();
        assert_eq!(turned, mask);
    }

    #[test]
    fn a_concave_shape_has_two_runs_in_a_row_and_a_crossed_one_is_filled() {
        let notch =
            [[0.0, 0.0], [2.0, 0.0], [2.0, 3.0], [4.0, 3.0], [4.0, 0.0], [6.0, 0.0], [6.0, 5.0], [0.0, 5.0]];
        let mask = SpanMask::from_polygon(&notch).unwrap();
        assert_eq!(mask.area(), 3 * 4 + 2 * 6);
        assert_eq!(mask.spans()[1], Span { row: 0, start: 4, end: 6 });
        let twice_round = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].repeat(2);
        assert_eq!(SpanMask::from_polygon(&twice_round).unwrap().area(), 16);
    }

    #[test]
    fn a_stroke_has_its_width_butt_ends_and_round_joins() {
        let straight = SpanMask::stroke(&[[0.5, 10.5], [0.5, 0.5]], 4.0).unwrap();
        assert_eq!(straight.area(), 40);
        // Points that repeat make no join and no end.
        let repeated = SpanMask::stroke(&[[0.5, 10.5], [0.5, 10.5], [0.5, 0.5], [0.5, 0.5]], 4.0).unwrap();
        assert_eq!(repeated, straight);
        // The outer side of a right angle is a quarter disc, not a square: (10, -10) is the joint.
        let bent = SpanMask::stroke(&[[0.0, -10.0], [10.0, -10.0], [10.0, 0.0]], 8.0).unwrap();
        let has =
            |col: i32, row: i32| bent.spans().iter().any(|s| s.row == row && (s.start..s.end).contains(&col));
        assert!(has(12, -12));
        assert!(!has(13, -13));
        assert!(!has(-1, -10) && !has(10, 1));
        assert!(SpanMask::stroke(&[[3.0, 3.0]], 8.0).unwrap().is_empty());
    }

    #[test]
    fn shapes_that_share_an_edge_share_no_pixel() {
        let left = SpanMask::from_polygon(&[[0.0, 0.0], [7.3, 0.0], [4.1, 9.0], [0.0, 9.0]]).unwrap();
        let right = SpanMask::from_polygon(&[[7.3, 0.0], [12.0, 0.0], [12.0, 9.0], [4.1, 9.0]]).unwrap();
        assert_eq!(left.area() + right.area(), 12 * 9);
        assert_eq!(left.union(&right).area(), 12 * 9);
    }
}
