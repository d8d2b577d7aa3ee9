//! Squares, registration, detrending and correlation of painted views.

use super::correlation::{add_products, correlate_row, scale_row, sum_across};
use super::detrending::departures;
use super::likelihood::likelihood_row;
use super::rise_chain::{LANES, RiseChain, RiseSteps};
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
    coarse::<2>(&grey, &seen, 2, &mut out);
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
        correlation.at_shift((&view, &scales), (&other, &other_scales), shift, (window, Rows::ALL), &mut out);
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
fn a_height_is_as_likely_as_its_line_says_between_two_shifts() {
    let lines = LikelihoodLines { offset: &[-3.0, -3.0, -3.0, -3.0], slope: &[20.0, 20.0, 2000.0, 20.0] };
    let mut out = [0; 4];
    log_likelihoods([&[0.4, 0.0, 0.9, -0.5], &[0.8, 0.0, 0.9, -0.5]], 0.25, lines, &mut out);
    assert_eq!(out, [7, NOT_SEEN, 127, -3], "20 times 0.5 less 3; unseen; at most; below 0 counts as 0");
}

/// Likelihoods of five heights at so many places: 1 at the height `of` a place, 0.01 elsewhere, in every row.
fn heights(places: usize, of: impl Fn(usize) -> usize) -> Vec<[[f32; LANES]; 5]> {
    let at = |place| std::array::from_fn(|height| [if height == of(place) { 1.0 } else { 0.01 }; LANES]);
    (0..places).map(at).collect()
}

#[test]
fn a_rise_lies_before_the_places_behind_it_and_a_drift_is_none() {
    let steps = RiseSteps { rise: 0.01, drift: 0.05 };
    let mut chain = RiseChain::<5, 2, 3>::default();
    let risen = chain.odds(&steps, &heights(20, |place| if place < 10 { 1 } else { 3 })).to_vec();
    assert!(risen[..10].iter().all(|odds| odds[0] < 0.1 && odds[LANES - 1] < 0.1), "{risen:?}");
    assert!(risen[10..].iter().all(|odds| odds[0] > 10.0 && odds[LANES - 1] > 10.0), "{risen:?}");
    let drifted = chain.odds(&steps, &heights(20, |place| place / 5));
    assert!(drifted.iter().all(|odds| odds[0] < 1.0), "{drifted:?}");
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
        let mut likelihoods = vec![0; 121];
        likelihood_row(path, &correlated, &scales, 0.3, &scales, &correlated, &mut likelihoods);
        let seen = heights(30, |place| texture(place, 7) as usize % 5);
        let mut chain = RiseChain::<5, 2, 3>::default();
        let odds = chain.odds_with(path, &RiseSteps { rise: 0.01, drift: 0.05 }, &seen).to_vec();
        (across, scales, correlated, departed, laid, likelihoods, odds)
    };
    let portable = of(CodePath::PORTABLE);
    CodePath::available().for_each(|path| assert_eq!(of(path), portable, "{path:?}"));
}
