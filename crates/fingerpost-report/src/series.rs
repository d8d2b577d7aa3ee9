//! Curves over a run, made short enough for a page.

use std::ops::Range;

/// Points that a curve on a page has at most, about: two for every pixel of a laptop's width.
pub(crate) const MAX_POINTS: usize = 2000;

/// Thins a curve to about `max_points`, keeping its extremes, and cuts it where it has no value.
///
/// Long curves are cut into equal stretches of which the lowest and the highest point are kept; gaps shorter than such
/// a stretch are passed over.
pub(crate) fn thinned(points: &[(f64, Option<f64>)], max_points: usize) -> Vec<Vec<(f64, f64)>> {
    let stretch = (2 * points.len()).div_ceil(max_points.max(2)).max(1);
    let mut curves: Vec<Vec<(f64, f64)>> = Vec::new();
    let mut last_seen = None;
    for (i, &(x, y)) in points.iter().enumerate() {
        let Some(y) = y.filter(|y| y.is_finite()) else { continue };
        let gap = last_seen.is_none_or(|last| i - last > stretch);
        last_seen = Some(i);
        match curves.last_mut() {
            Some(curve) if !gap => curve.push((x, y)),
            _ => curves.push(vec![(x, y)]),
        }
    }
    if points.len() > max_points {
        curves.iter_mut().for_each(|curve| *curve = extremes(curve, stretch));
    }
    curves
}

/// The first and last point, and of every `stretch` points the lowest and the highest, in their order.
fn extremes(curve: &[(f64, f64)], stretch: usize) -> Vec<(f64, f64)> {
    let mut kept = Vec::new();
    for (i, piece) in curve.chunks(stretch).enumerate() {
        let by_value = |a: &(usize, f64), b: &(usize, f64)| a.1.total_cmp(&b.1);
        let values = || piece.iter().map(|(_, y)| *y).enumerate();
        let (low, high) = (values().min_by(by_value), values().max_by(by_value));
        let mut wanted: Vec<usize> = [low, high].into_iter().flatten().map(|(k, _)| k).collect();
        if i == 0 {
            wanted.push(0);
        }
        if (i + 1) * stretch >= curve.len() {
            wanted.push(piece.len() - 1);
        }
        wanted.sort_unstable();
        wanted.dedup();
        kept.extend(wanted.into_iter().map(|k| piece[k]));
    }
    kept
}

/// The points of a path that lie at least `step` from the one kept before, and its last.
pub(crate) fn thinned_path(points: impl Iterator<Item = [f64; 2]>, step: f64) -> Vec<[f64; 2]> {
    let mut kept: Vec<[f64; 2]> = Vec::new();
    let mut skipped = None;
    for point in points.filter(|p| p[0].is_finite() && p[1].is_finite()) {
        let near = kept.last().is_some_and(|last| (point[0] - last[0]).hypot(point[1] - last[1]) < step);
        if near {
            skipped = Some(point);
        } else {
            kept.push(point);
            skipped = None;
        }
    }
    kept.extend(skipped);
    kept
}

/// Stretches of equal values, as ranges of indices; stretches shorter than `shortest` join the one before.
pub(crate) fn stretches<T: PartialEq>(
    values: impl Iterator<Item = T>,
    shortest: usize,
) -> Vec<(Range<usize>, T)> {
    let mut found: Vec<(Range<usize>, T)> = Vec::new();
    for (i, value) in values.enumerate() {
        match found.last_mut() {
            Some((range, same)) if *same == value => range.end = i + 1,
            _ => {
                if found.len() > 1 && found.last().is_some_and(|(range, _)| range.len() < shortest) {
                    found.pop();
                    if let Some((range, _)) = found.last_mut() {
                        range.end = i;
                    }
                }
                match found.last_mut() {
                    Some((range, same)) if *same == value => range.end = i + 1,
                    _ => found.push((i..i + 1, value)),
                }
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_the_extremes_and_the_ends() {
        let mut points: Vec<(f64, Option<f64>)> = (0..30_000).map(|i| (f64::from(i), Some(0.5))).collect();
        points[12_345].1 = Some(0.01);
        points[23_456].1 = Some(0.99);
        let curves = thinned(&points, MAX_POINTS);
        assert_eq!(curves.len(), 1);
        assert!(curves[0].len() <= MAX_POINTS + 4, "{}", curves[0].len());
        assert!(curves[0].contains(&(12_345.0, 0.01)) && curves[0].contains(&(23_456.0, 0.99)));
        assert_eq!(curves[0].first(), Some(&(0.0, 0.5)));
        assert_eq!(curves[0].last(), Some(&(29_999.0, 0.5)));
        assert!(curves[0].windows(2).all(|w| w[0].0 < w[1].0), "in order");
    }

    #[test]
    fn short_curves_are_kept_whole_and_cut_at_gaps() {
        let points =
            [(0.0, Some(1.0)), (1.0, Some(2.0)), (2.0, None), (3.0, Some(f64::NAN)), (4.0, Some(3.0))];
        assert_eq!(thinned(&points, 100), vec![vec![(0.0, 1.0), (1.0, 2.0)], vec![(4.0, 3.0)]]);
        assert!(thinned(&[], 100).is_empty());
    }

    #[test]
    fn paths_keep_their_ends() {
        let path = (0..=100).map(|i| [0.1 * f64::from(i), 0.0]);
        let kept = thinned_path(path, 3.0);
        assert_eq!(kept.first(), Some(&[0.0, 0.0]));
        assert_eq!(kept.last(), Some(&[10.0, 0.0]));
        assert!((4..=5).contains(&kept.len()));
    }

    #[test]
    fn stretches_join_flicker() {
        let found = stretches("aaabaacc".chars(), 2);
        assert_eq!(found, [(0..6, 'a'), (6..8, 'c')]);
        assert_eq!(stretches("ab".chars(), 1), [(0..1, 'a'), (1..2, 'b')]);
    }
}
