use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::picture::Plane;
use crate::simd::CodePath;
use crate::test_pictures::{Framed, binary_pictures, config};

fn params(rho_step_px: f64, theta_step_deg: f64, votes: u32) -> HoughParams {
    HoughParams { rho_step_px, theta_step_rad: theta_step_deg.to_radians(), votes }
}

/// Votes of all lines, as (number of the angle, number of the distance).
fn plain_votes(picture: &Framed, params: HoughParams) -> BTreeMap<(usize, i64), u32> {
    let mut votes = BTreeMap::new();
    let (width, height) = picture.view().size();
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        if picture.view().row(y)[x] == 0 {
            continue;
        }
        for (number, angle) in params.angles().enumerate() {
            let [cos, sin] =
                [libm::cos(angle), libm::sin(angle)].map(|part| (part / params.rho_step_px) as f32);
            let rho = (x as f32 * cos + y as f32 * sin).round_ties_even();
            *votes.entry((number, rho as i64)).or_insert(0) += 1;
        }
    }
    votes
}

fn plain_lines(picture: &Framed, params: HoughParams) -> Vec<HoughLine> {
    let votes = plain_votes(picture, params);
    let at = |angle: Option<usize>, rho: i64| {
        angle.and_then(|angle| votes.get(&(angle, rho))).copied().unwrap_or(0)
    };
    let mut found: Vec<((usize, i64), u32)> = votes
        .iter()
        .map(|(&place, &own)| (place, own))
        .filter(|&((angle, rho), own)| {
            own > params.votes
                && own > at(Some(angle), rho - 1)
                && own >= at(Some(angle), rho + 1)
                && own > at(angle.checked_sub(1), rho)
                && own >= at(Some(angle + 1), rho)
        })
        .collect();
    found.sort_by_key(|&(place, own)| (std::cmp::Reverse(own), place));
    let line = |((angle, rho), votes)| HoughLine {
        rho_px: rho as f64 * params.rho_step_px,
        theta_rad: angle as f64 * params.theta_step_rad,
        votes,
    };
    found.into_iter().map(line).collect()
}

proptest! {
    #![proptest_config(config(40))]

    #[test]
    fn lines_are_the_local_maxima_of_all_votes_on_every_path(
        picture in binary_pictures(),
        rho_step_px in prop_oneof![Just(1.0), Just(0.5), 0.7..4.0_f64],
        theta_step_deg in prop_oneof![Just(1.0), 2.0..50.0_f64],
        votes in 0..20_u32,
    ) {
        let params = params(rho_step_px, theta_step_deg, votes);
        let expected = plain_lines(&picture, params);
        let mut finder = HoughLines::new(params).unwrap();
        for path in CodePath::available() {
            let found = finder.find_on(path, picture.view());
            prop_assert_eq!(found, &expected[..], "{:?}", path);
        }
    }

    #[test]
    fn lines_that_lean_are_those_of_all_lines(
        pictures in prop::collection::vec(binary_pictures(), 1..4),
        theta_step_deg in prop_oneof![Just(1.0), 2.0..50.0_f64],
        votes in 0..20_u32,
        (from, width) in (-3.0..3.0_f64, 0.0..4.0_f64),
    ) {
        let params = params(1.0, theta_step_deg, votes);
        let (mut all, mut leaning) = (HoughLines::new(params).unwrap(), HoughLines::new(params).unwrap());
        let leans = from..=from + width;
        // One after the other: what is left of the picture before counts for nothing.
        for picture in &pictures {
            let lines = all.find(picture.view()).iter().copied();
            let expected: Vec<HoughLine> =
                lines.filter(|line| leans.contains(&-libm::tan(line.theta_rad))).collect();
            prop_assert_eq!(leaning.find_leaning(picture.view(), leans.clone()), &expected[..]);
        }
    }

    #[test]
    fn segments_keep_to_their_line_and_their_limits(
        picture in binary_pictures(),
        votes in 5..15_u32,
        (min_length_px, max_gap_px) in (5.0..20.0_f64, 0.0..4.0_f64),
    ) {
        let mut finder = HoughSegments::new(params(1.0, 2.0, votes), min_length_px, max_gap_px).unwrap();
        let segments = finder.find(picture.view()).to_vec();
        for segment in &segments {
            prop_assert!(segment.length_px() >= min_length_px - 1e-9);
            let (sin, cos) = libm::sincos(segment.line.theta_rad);
            for [u, v] in [segment.start_px, segment.end_px] {
                prop_assert!((u * cos + v * sin - segment.line.rho_px).abs() < 1e-9);
                let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
                let (x, y) = (u.round() as isize, v.round() as isize);
                prop_assert!(near.into_iter().any(|(dx, dy)| picture.get(x + dx, y + dy, 0) != 0));
            }
        }
        for path in CodePath::available() {
            prop_assert_eq!(finder.find_on(path, picture.view()), &segments[..], "{:?}", path);
        }
    }
}

/// Draws the pixels nearest to a straight line between two places.
fn draw(picture: &mut Plane<u8>, [from, to]: [[f64; 2]; 2]) {
    let steps = (to[0] - from[0]).abs().max((to[1] - from[1]).abs());
    for step in 0..=steps as usize {
        let part = step as f64 / steps;
        let [u, v] = [0, 1].map(|axis| (from[axis] + part * (to[axis] - from[axis])).round() as usize);
        picture.row_mut(v)[u] = 255;
    }
}

#[test]
fn drawn_segments_are_found_where_they_are_and_once_each() {
    let mut picture = Plane::new(200, 150, 0);
    let drawn = [
        [[10.0, 20.0], [150.0, 45.0]],
        [[30.0, 140.0], [60.0, 30.0]],
        [[100.0, 60.0], [100.0, 140.0]],
        [[110.0, 130.0], [190.0, 70.0]],
    ];
    for segment in drawn {
        draw(&mut picture, segment);
    }
    let mut finder = HoughSegments::new(params(1.0, 1.0, 40), 40.0, 3.0).unwrap();
    let found = finder.find(picture.view());
    assert_eq!(found.len(), drawn.len(), "{found:#?}");
    for ends in drawn {
        let apart = |one: [f64; 2], other: [f64; 2]| libm::hypot(one[0] - other[0], one[1] - other[1]);
        let same = |segment: &&Segment| {
            let there = apart(segment.start_px, ends[0]).max(apart(segment.end_px, ends[1]));
            let back = apart(segment.start_px, ends[1]).max(apart(segment.end_px, ends[0]));
            there.min(back) < 4.0
        };
        assert_eq!(found.iter().filter(same).count(), 1, "{ends:?} in {found:#?}");
    }
}

#[test]
fn a_gap_that_is_too_wide_ends_a_segment() {
    let mut picture = Plane::new(100, 20, 0);
    picture.row_mut(9)[5..45].fill(1);
    picture.row_mut(9)[50..95].fill(1);
    let ends = |max_gap_px| {
        let mut finder = HoughSegments::new(params(1.0, 1.0, 30), 20.0, max_gap_px).unwrap();
        let segments = finder.find(picture.view()).iter();
        segments.map(|segment| [segment.start_px[0] as usize, segment.end_px[0] as usize]).collect::<Vec<_>>()
    };
    assert_eq!(ends(5.0), [[5, 94]]);
    assert_eq!(ends(4.0), [[5, 44], [50, 94]]);
}

#[test]
fn an_empty_picture_has_no_lines() {
    let mut finder = HoughSegments::new(params(1.0, 1.0, 0), 0.0, 0.0).unwrap();
    for (width, height) in [(0, 0), (0, 4), (4, 0), (7, 5)] {
        assert!(finder.find(Plane::new(width, height, 0).view()).is_empty());
    }
    assert_eq!(finder.find(Plane::new(1, 1, 1).view()).len(), 1);
}

#[test]
fn steps_and_lengths_that_do_not_work_are_errors() {
    for step in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(HoughLines::new(params(step, 1.0, 9)), Err(HoughError::RhoStep { .. })));
        assert!(matches!(HoughLines::new(params(1.0, step, 9)), Err(HoughError::ThetaStep { .. })));
    }
    for length in [-1.0, f64::NAN, f64::INFINITY] {
        let good = params(1.0, 1.0, 9);
        assert!(matches!(HoughSegments::new(good, length, 1.0), Err(HoughError::Length { .. })));
        assert!(matches!(HoughSegments::new(good, 1.0, length), Err(HoughError::Length { .. })));
    }
}
