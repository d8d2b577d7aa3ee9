//! Masks and their cover against plain twins that go pixel by pixel.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use fingerpost_vision::span::{Cover, RowSums, Span, SpanMask};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

fn config() -> ProptestConfig {
    ProptestConfig {
        cases: 300,
        rng_seed: RngSeed::Fixed(20),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

fn has(mask: &SpanMask, col: i32, row: i32) -> bool {
    mask.spans().iter().any(|span| span.row == row && (span.start..span.end).contains(&col))
}

/// The cover summed pixel by pixel.
fn plain_cover(probability: &Plane<u8>, validity: &Plane<u8>, mask: &SpanMask, shift: [i32; 2]) -> Cover {
    let mut cover = Cover { area: mask.area(), ..Cover::default() };
    for (y, x) in (0..probability.height()).flat_map(|y| (0..probability.width()).map(move |x| (y, x))) {
        if !has(mask, x as i32 - shift[0], y as i32 - shift[1]) {
            continue;
        }
        cover.in_view += 1;
        if validity.row(y)[x] != 0 {
            cover.seen += 1;
            cover.sum += u64::from(probability.row(y)[x]);
        }
    }
    cover
}

fn masks() -> impl Strategy<Value = SpanMask> {
    let span = (-20..20_i32, -30..30_i32, 0..25_i32).prop_map(|(row, start, length)| Span {
        row,
        start,
        end: start + length,
    });
    prop::collection::vec(span, 0..40).prop_map(SpanMask::from_spans)
}

fn planes() -> impl Strategy<Value = (Plane<u8>, Plane<u8>)> {
    (0..23_usize, 0..17_usize).prop_flat_map(|(width, height)| {
        let count = width * height;
        let validity = prop::collection::vec(prop_oneof![Just(0_u8), Just(1), Just(255)], count);
        (prop::collection::vec(any::<u8>(), count), validity).prop_map(move |(probability, validity)| {
            let plane = |values| Plane::from_vec(width, height, values).unwrap();
            (plane(probability), plane(validity))
        })
    })
}

proptest! {
    #![proptest_config(config())]

    #[test]
    fn cover_equals_the_sum_over_pixels(
        (probability, validity) in planes(),
        mask in masks(),
        shift in [-40..40_i32, -40..40_i32],
    ) {
        let mut sums = RowSums::default();
        // Sums of another picture first: a rebuild leaves nothing of them.
        let earlier = Plane::new(probability.width(), 29, 200);
        sums.rebuild(earlier.view(), &ValidityMask::from_plane(earlier.clone())).unwrap();
        sums.rebuild(probability.view(), &ValidityMask::from_plane(validity.clone())).unwrap();
        let cover = sums.cover(&mask, shift[0], shift[1]);
        prop_assert_eq!(cover, plain_cover(&probability, &validity, &mask, shift));
        prop_assert_eq!(cover, sums.cover(&mask.translated(shift[0], shift[1]), 0, 0));
        let inside = mask.translated(shift[0], shift[1]).intersect_rect(Rect {
            x: 0, y: 0, width: probability.width(), height: probability.height(),
        });
        prop_assert_eq!(cover.in_view, inside.area());
    }

    #[test]
    fn covers_are_those_of_the_places_one_by_one(
        (width, height) in (0..700_usize, 1..5_usize),
        seen_from in 0..150_usize,
        gap in 0..400_usize,
        spans in prop::collection::vec((-3..6_i32, -400..700_i32, 0..900_i32), 0..12),
        shift in [-500..500_i32, -4..4_i32],
        count in 0..150_usize,
    ) {
        let mut validity = Plane::new(width, height, 1_u8);
        for y in 0..height {
            let row = validity.row_mut(y);
            row[..(seen_from * y).min(width)].fill(0);
            row[gap.min(width)..(gap + 20 * y).min(width)].fill(0);
        }
        let values = (0..width * height).map(|index| 255 - (index * 31 % 67) as u8).collect();
        let probability = Plane::from_vec(width, height, values).unwrap();
        let mut sums = RowSums::default();
        sums.rebuild(probability.view(), &ValidityMask::from_plane(validity.clone())).unwrap();
        let spans = spans.iter().map(|&(row, start, length)| Span { row, start, end: start + length });
        let mask = SpanMask::from_spans(spans.collect());
        let mut covers = vec![Cover::default(); count];
        sums.covers(&mask, shift[0], shift[1], &mut covers);
        for (index, &cover) in covers.iter().enumerate() {
            let d_col = shift[0] + index as i32;
            prop_assert_eq!(cover, sums.cover(&mask, d_col, shift[1]), "{}", d_col);
            if index % 16 == 0 {
                prop_assert_eq!(cover, plain_cover(&probability, &validity, &mask, [d_col, shift[1]]));
            }
        }
    }

    #[test]
    fn a_polygon_holds_the_pixels_with_a_winding_number(
        corners in prop::collection::vec([-12.0..12.0_f64, -12.0..12.0_f64], 0..8),
    ) {
        let mask = SpanMask::from_polygon(&corners).unwrap();
        for (row, col) in (-14..14).flat_map(|row| (-14..14).map(move |col| (row, col))) {
            prop_assert_eq!(has(&mask, col, row), winding_angle(&corners, [f64::from(col), f64::from(row)]) != 0);
        }
    }

    #[test]
    fn a_stroke_holds_the_pixels_near_its_line(
        points in prop::collection::vec([-15.0..15.0_f64, -15.0..15.0_f64], 2..6),
        width_px in 0.5..9.0_f64,
    ) {
        let mask = SpanMask::stroke(&points, width_px).unwrap();
        for (row, col) in (-22..22).flat_map(|row| (-22..22).map(move |col| (row, col))) {
            let at = [f64::from(col), f64::from(row)];
            let is_near = is_on_stroke(&points, at, 0.5 * width_px);
            prop_assert_eq!(has(&mask, col, row), is_near, "({}, {})", col, row);
        }
    }

    #[test]
    fn the_centroid_is_the_mean_of_the_pixels(mask in masks()) {
        let pixels: Vec<[f64; 2]> = mask.spans().iter()
            .flat_map(|span| (span.start..span.end).map(|col| [f64::from(col), f64::from(span.row)]))
            .collect();
        prop_assert_eq!(pixels.len() as u64, mask.area());
        match mask.centroid() {
            None => prop_assert!(pixels.is_empty()),
            Some(centroid) => for axis in 0..2 {
                let mean = pixels.iter().map(|pixel| pixel[axis]).sum::<f64>() / pixels.len() as f64;
                prop_assert!((mean - centroid[axis]).abs() < 1e-9);
            },
        }
    }
}

/// How often the outline goes round a point, from the angles under which its edges are seen.
fn winding_angle(corners: &[[f64; 2]], at: [f64; 2]) -> i64 {
    let direction = |corner: &[f64; 2]| libm::atan2(corner[1] - at[1], corner[0] - at[0]);
    let turn: f64 = corners
        .iter()
        .zip(corners.iter().cycle().skip(1))
        .map(|(from, to)| {
            let angle = direction(to) - direction(from);
            angle - std::f64::consts::TAU * (angle / std::f64::consts::TAU).round()
        })
        .sum();
    (turn / std::f64::consts::TAU).round() as i64
}

fn is_on_stroke(points: &[[f64; 2]], at: [f64; 2], half_px: f64) -> bool {
    let beside_a_segment = points.windows(2).any(|ends| {
        let along = [ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]];
        let offset = [at[0] - ends[0][0], at[1] - ends[0][1]];
        let length = libm::hypot(along[0], along[1]);
        let forward = (offset[0] * along[0] + offset[1] * along[1]) / length;
        let aside = (offset[0] * along[1] - offset[1] * along[0]) / length;
        (0.0..=length).contains(&forward) && aside.abs() <= half_px
    });
    let inner = &points[1..points.len() - 1];
    beside_a_segment || inner.iter().any(|point| libm::hypot(at[0] - point[0], at[1] - point[1]) <= half_px)
}

#[test]
fn a_mask_far_away_covers_nothing_and_has_no_probability() {
    let plane = Plane::new(9, 9, 255);
    let mut sums = RowSums::default();
    sums.rebuild(plane.view(), &ValidityMask::all_seen(9, 9)).unwrap();
    let mask = SpanMask::from_rect(Rect { x: 0, y: 0, width: 3, height: 3 });
    for (d_col, d_row) in [(i32::MAX, 0), (i32::MIN, 0), (0, i32::MAX), (0, i32::MIN), (9, 0), (0, -3)] {
        let cover = sums.cover(&mask, d_col, d_row);
        assert_eq!(cover, Cover { area: 9, ..Cover::default() });
        let mut covers = [Cover::default(); 1];
        sums.covers(&mask, d_col, d_row, &mut covers);
        assert_eq!(covers, [cover]);
        assert_eq!(cover.probability(), None);
    }
    assert_eq!(sums.cover(&mask, 7, 8).probability(), Some(1.0));
    assert!((sums.cover(&mask, 7, 8).seen_share() - 2.0 / 9.0).abs() < 1e-12);
}

#[test]
fn planes_of_different_sizes_are_an_error() {
    let mut sums = RowSums::default();
    assert!(sums.rebuild(Plane::new(4, 3, 0).view(), &ValidityMask::all_seen(3, 4)).is_err());
    assert_eq!(RowSums::default().cover(&SpanMask::default(), 0, 0), Cover::default());
    let mask = SpanMask::from_rect(Rect { x: 0, y: 0, width: 1, height: 1 });
    let mut covers = [Cover::default(); 2];
    RowSums::default().covers(&mask, 0, 0, &mut covers);
    assert_eq!(covers, [Cover { area: 1, ..Cover::default() }; 2]);
}
