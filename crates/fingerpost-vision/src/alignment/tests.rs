//! Kernels against plain twins, and what they are for: a displaced picture is found again.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::sums::{Brightness, Residuals};
use super::target::{mark, neighbours};
use super::template::Template;
use super::*;
use crate::picture::{Plane, Rect};
use crate::simd::CodePath;

/// A smooth picture of seen pixels.
fn hills(width: usize, height: usize, at: impl Fn(f32, f32) -> [f32; 2]) -> Plane<u8> {
    let mut picture = Plane::new(width, height, 0);
    for y in 0..height {
        for (x, out) in picture.row_mut(y).iter_mut().enumerate() {
            let [u, v] = at(x as f32, y as f32);
            *out = (120.0 + 50.0 * libm::sinf(0.31 * u + 0.1 * v) + 50.0 * libm::cosf(0.23 * v - 0.05 * u))
                as u8;
        }
    }
    picture
}

/// A picture with holes, from proptest's bytes.
fn holey(width: usize, height: usize, bytes: &[u8]) -> Plane<u8> {
    let holes = |byte: u8| if byte.is_multiple_of(17) { 0 } else { byte };
    let data = (0..width * height).map(|i| holes(bytes[(i * 7 + i / 5) % bytes.len()])).collect();
    Plane::from_vec(width, height, data).unwrap()
}

fn target(path: CodePath, grey: &Plane<u8>) -> Target {
    let mut target = Target { cells: Plane::new(grey.width(), grey.height(), 0) };
    neighbours(path, grey, &mut target.cells);
    target
}

/// Residual and weight of a point by the formulas, one look-up a pixel.
fn plain_residual(
    grey: &Plane<u8>,
    [u, v]: [f32; 2],
    point: f32,
    brightness: Brightness,
    scale: f32,
) -> Option<(f32, f32)> {
    let (right, bottom) = (grey.width() as f32 - 1.0, grey.height() as f32 - 1.0);
    if !(0.0..right).contains(&u) || !(0.0..bottom).contains(&v) {
        return None;
    }
    let (column, row) = (u.floor(), v.floor());
    let at = |dx: usize, dy: usize| grey.get(column as usize + dx, row as usize + dy).map(f32::from);
    let corners = [at(0, 0)?, at(1, 0)?, at(0, 1)?, at(1, 1)?];
    if corners.contains(&0.0) {
        return None;
    }
    let [a, b, c, d] = corners;
    let (upper, lower) = (a + (b - a) * (u - column), c + (d - c) * (u - column));
    let residual = upper + (lower - upper) * (v - row) - brightness.gain * point - brightness.offset;
    let share = 5.0 / (5.0 + (residual / scale).powi(2));
    Some((residual, share.powi(4)))
}

/// The grey at [0, 0] of the plane that fits places and their grey best, steep ones at a price; by the normal equations.
fn plain_plane(seen: &[[f64; 3]]) -> Option<f32> {
    let mut equations = [[0.0; 4]; 3];
    for &[across, down, grey] in seen {
        let row = [across, down, 1.0, grey];
        for (i, equation) in equations.iter_mut().enumerate() {
            for (sum, term) in equation.iter_mut().zip(row) {
                *sum += row[i] * term;
            }
        }
    }
    let count = equations[2][2];
    for i in 0..2 {
        equations[i][i] += count;
        for below in i + 1..3 {
            let share = equations[below][i] / equations[i][i];
            let above = equations[i];
            for (term, of_above) in equations[below].iter_mut().zip(above) {
                *term -= share * of_above;
            }
        }
    }
    (count > 0.0).then(|| (equations[2][3] / equations[2][2]) as f32)
}

/// How far a point is believed, by the angle of its gradient.
fn plain_trust(corridor: &Corridor, [u, v]: [f32; 2], [right, down]: [f32; 2]) -> f32 {
    let middle = corridor.middle[0] + corridor.middle[1] * v + corridor.middle[2] * v * v;
    if (u - middle).abs() <= corridor.half_width {
        1.0
    } else if libm::hypotf(right, down) > 0.0 {
        corridor.outside * libm::cosf(libm::atan2f(down, right)).powi(8)
    } else {
        0.0
    }
}

fn close(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance * (1.0 + a.abs().max(b.abs()))
}

fn fields(seed: &[f32]) -> [QuadraticField; UNKNOWNS] {
    std::array::from_fn(|i| QuadraticField {
        u: std::array::from_fn(|k| {
            seed[(i * 5 + k) % seed.len()] / 30_f32.powi(i32::from(k > 0) + i32::from(k > 2))
        }),
        v: std::array::from_fn(|k| {
            seed[(i * 3 + k + 1) % seed.len()] / 30_f32.powi(i32::from(k > 0) + i32::from(k > 2))
        }),
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, rng_seed: RngSeed::Fixed(9), failure_persistence: None, ..Default::default() })]

    #[test]
    fn points_are_the_strongest_seen_pixels_of_their_cells(
        width in 1_usize..60, height in 1_usize..40, cell in 1_usize..6,
        x in 0_usize..8, y in 0_usize..8, bytes in prop::collection::vec(any::<u8>(), 50..99),
    ) {
        let grey = holey(width, height, &bytes);
        let region = Rect { x, y, width: width.saturating_sub(x), height: height.saturating_sub(y) };
        let strength = |x: usize, y: usize| -> Option<u16> {
            let around = [(1, 1), (0, 1), (2, 1), (1, 0), (1, 2)].map(|(dx, dy)| {
                let (x, y) = ((x + dx).checked_sub(1)?, (y + dy).checked_sub(1)?);
                grey.get(x, y).filter(|&grey| grey > 0)
            });
            let [_, left, right, above, below] = around;
            around[0]?;
            Some(u16::from(left?.abs_diff(right?)) + u16::from(above?.abs_diff(below?)))
        };
        let (left, top) = (x.max(1), y.max(1));
        let (right, bottom) = (width.saturating_sub(1), height.saturating_sub(1));
        let mut expected = Vec::new();
        for row in 0..bottom.saturating_sub(top) / cell {
            for column in 0..right.saturating_sub(left) / cell {
                let mut best: Option<(u16, [f32; 2])> = None;
                for i in 0..cell * cell {
                    let (x, y) = (left + column * cell + i % cell, top + row * cell + i / cell);
                    if let Some(strength) = strength(x, y) && best.is_none_or(|(most, _)| strength > most) {
                        best = Some((strength, [x as f32, y as f32]));
                    }
                }
                expected.extend(best.map(|(_, place)| place));
            }
        }
        for path in CodePath::available() {
            let mut template = Template::default();
            template.choose_with(path, &grey, region, cell, &Corridor::EVERYWHERE);
            let places: Vec<[f32; 2]> = (0..template.len()).filter_map(|point| template.place(point)).collect();
            prop_assert_eq!(&places, &expected);
        }
    }

    #[test]
    fn residuals_and_sums_are_those_of_the_formulas_on_every_path(
        width in 2_usize..70, height in 2_usize..50, cell in 1_usize..4,
        bytes in prop::collection::vec(any::<u8>(), 50..99),
        shift in [-3.0_f32..3.0, -3.0_f32..3.0], bend in -0.02_f32..0.02,
        seed in prop::collection::vec(-1.0_f32..1.0, 7..9),
        gain in 0.8_f32..1.2, offset in -9.0_f32..9.0, scale in 1.0_f32..20.0,
        outside in 0.0_f32..1.0,
    ) {
        let (older, newer) = (holey(width, height, &bytes), holey(width, height, &bytes[3..]));
        let warp = ProjectiveMap {
            right: [shift[0], 1.0, bend],
            down: [shift[1], -bend, 1.0],
            scale: [1.0, 0.05 * bend, -0.1 * bend],
        };
        let (brightness, fields) = (Brightness { gain, offset }, fields(&seed));
        let corridor = Corridor { middle: [0.5 * width as f32, bend, -0.1 * bend], half_width: 4.5, outside };
        let mut results = Vec::new();
        for path in CodePath::available() {
            let mut template = Template::default();
            template.choose_with(path, &older, Rect { x: 0, y: 0, width, height }, cell, &corridor);
            template.set_directions_with(path, &fields);
            let mut residuals = Residuals::default();
            residuals.measure_with(path, &template, &target(path, &newer), &warp, brightness, scale);
            let sums = residuals.sums_with(path, &template);
            results.push((template, residuals, sums));
        }
        let (template, residuals, sums) = &results[0];
        for other in &results[1..] {
            prop_assert_eq!(&other.1, residuals, "the same on every path");
            prop_assert_eq!(&other.2, sums, "the same on every path");
        }
        let mut seen = 0.0;
        let mut hessian = [[0.0_f64; UNKNOWNS]; UNKNOWNS];
        let mut gradient = [0.0_f64; UNKNOWNS];
        for point in 0..template.len() {
            let [u, v] = template.place(point).unwrap();
            let at = |dx: usize, dy: usize| f32::from(older.get(u as usize + dx - 1, v as usize + dy - 1).unwrap());
            let plain = plain_residual(&newer, warp.at(u, v), at(1, 1), brightness, scale);
            let (residual, weight) = plain.unwrap_or((0.0, 0.0));
            let weight = weight * plain_trust(&corridor, [u, v], [at(2, 1) - at(0, 1), at(1, 2) - at(1, 0)]);
            prop_assert!(close(residuals.residual(point).unwrap(), residual, 1e-3));
            prop_assert!(close(residuals.weight(point).unwrap(), weight, 1e-3));
            seen += if plain.is_some() { 1.0 } else { 0.0 };
            let slopes = fields.map(|field| {
                let [right, down] = field.at(u, v);
                f64::from(0.5 * ((at(2, 1) - at(0, 1)) * right + (at(1, 2) - at(1, 0)) * down))
            });
            for i in 0..UNKNOWNS {
                gradient[i] += f64::from(weight * residual) * slopes[i];
                for (sum, slope) in hessian[i].iter_mut().zip(slopes) {
                    *sum += f64::from(weight) * slopes[i] * slope;
                }
            }
        }
        prop_assert!(close(residuals.seen, seen, 1e-6));
        let most = (0..UNKNOWNS).map(|i| hessian[i][i]).fold(1.0, f64::max);
        for i in 0..UNKNOWNS {
            for (&found, &expected) in sums.hessian[i].iter().zip(&hessian[i]) {
                prop_assert!((f64::from(found) - expected).abs() < 2e-3 * most, "{found} for {expected}");
            }
            prop_assert!((f64::from(sums.gradient[i]) - gradient[i]).abs() < 2e-3 * most * f64::from(scale));
        }
    }

    #[test]
    fn flattening_takes_the_plane_about_each_block_off_on_every_path(
        width in 1_usize..70, height in 1_usize..40, block in 1_usize..9, window in 1_usize..30,
        bytes in prop::collection::vec(any::<u8>(), 50..99),
    ) {
        let grey = holey(width, height, &bytes);
        let reach = (window / 2).div_ceil(block);
        let (columns, rows) = (width.div_ceil(block), height.div_ceil(block));
        let mean = |column: usize, row: usize| {
            let inside = |at: usize, middle: usize| (at / block).abs_diff(middle) <= reach;
            let from = |at: usize, middle: usize| (at / block) as f64 - middle as f64;
            let seen: Vec<[f64; 3]> = (0..height * width)
                .filter(|i| inside(i % width, column) && inside(i / width, row))
                .map(|i| [from(i % width, column), from(i / width, row), f64::from(grey.as_slice()[i])])
                .filter(|seen| seen[2] > 0.0)
                .collect();
            plain_plane(&seen).unwrap_or(128.0)
        };
        let between = |at: usize, blocks: usize| {
            let at = ((at as f32 + 0.5) / block as f32 - 0.5).clamp(0.0, (blocks - 1) as f32);
            (at as usize, (at as usize + 1).min(blocks - 1), at.fract())
        };
        for path in CodePath::available() {
            let mut flat = Plane::default();
            Flattening::new(block, window).apply_on(path, &grey, &mut flat);
            for (x, y) in [(0, 0), (width - 1, height - 1), (width / 2, height / 2), (width / 3, 0)] {
                let ((left, right, u), (above, below, v)) = (between(x, columns), between(y, rows));
                let upper = mean(left, above) * (1.0 - u) + mean(right, above) * u;
                let lower = mean(left, below) * (1.0 - u) + mean(right, below) * u;
                let expected = 128.0 + 2.0 * (f32::from(grey.row(y)[x]) - (upper * (1.0 - v) + lower * v));
                let (found, seen) = (flat.row(y)[x], grey.row(y)[x] != 0);
                let off = (f32::from(found) - expected.clamp(1.0, 255.0)).abs();
                prop_assert!(if seen { off <= 0.51 } else { found == 0 }, "{found} for {expected}");
            }
        }
    }

    #[test]
    fn marking_and_neighbours_are_the_same_on_every_path(
        width in 1_usize..70, height in 1_usize..9, bytes in prop::collection::vec(any::<u8>(), 50..99),
    ) {
        let (source, seen) = (holey(width, height, &bytes), holey(width, height, &bytes[9..]));
        for path in CodePath::available() {
            let mut grey = Plane::new(width, height, 7);
            mark(path, source.view(), &seen, &mut grey);
            let cells = target(path, &grey).cells;
            for y in 0..height {
                for x in 0..width {
                    let marked = seen.get(x, y).filter(|&seen| seen != 0).map_or(0, |_| source.row(y)[x].max(1));
                    prop_assert_eq!(grey.get(x, y), Some(marked));
                    let pixel = |dx: usize, dy: usize| u32::from(grey.get(x + dx, y + dy).unwrap_or(0));
                    let cell = pixel(0, 0) | pixel(1, 0) << 8 | pixel(0, 1) << 16 | pixel(1, 1) << 24;
                    let inside = x + 1 < width && y + 1 < height;
                    prop_assert_eq!(cells.get(x, y), Some(if inside { cell } else { 0 }));
                }
            }
        }
    }
}

#[test]
fn a_displaced_picture_is_found_again() {
    let (older, newer) = (hills(80, 60, |u, v| [u, v]), hills(80, 60, |u, v| [u - 0.8, v + 0.6]));
    let mut template = Template::default();
    template.choose(&older, Rect { x: 4, y: 4, width: 70, height: 50 }, 2, &Corridor::EVERYWHERE);
    let mut fields = [QuadraticField::default(); UNKNOWNS];
    fields[0].u[0] = 1.0;
    fields[1].v[0] = 1.0;
    template.set_directions(&fields);
    let mut target = Target::default();
    target.fill(&newer);
    let (mut warp, mut residuals, mut agreeing) = (ProjectiveMap::IDENTITY, Residuals::default(), 0.0);
    for _ in 0..6 {
        residuals.measure(&template, &target, &warp, Brightness::default(), 5.0);
        let Sums { hessian: h, gradient: g, unweighted } = residuals.sums(&template);
        agreeing = h[0][0] / unweighted;
        let determinant = h[0][0] * h[1][1] - h[0][1] * h[0][1];
        warp.right[0] -= (h[1][1] * g[0] - h[0][1] * g[1]) / determinant;
        warp.down[0] -= (h[0][0] * g[1] - h[0][1] * g[0]) / determinant;
    }
    assert!((warp.right[0] - 0.8).abs() < 0.02 && (warp.down[0] + 0.6).abs() < 0.02, "{warp:?}");
    assert!(agreeing > 0.9, "all of the picture agrees: {agreeing}");
}

/// Light that falls off to one side is taken off up to the ends of what is seen, where a mean lies to one side of the place.
#[test]
fn a_slope_of_light_leaves_nothing_at_the_ends() {
    let (width, height) = (60, 40);
    let mut grey = Plane::new(width, height, 0);
    for y in 0..height {
        for (x, out) in grey.row_mut(y).iter_mut().enumerate() {
            // The nearest corners of a ground view are not seen.
            let hidden = x + 2 * (height - y) < 25 || (width - x) + 2 * (height - y) < 25;
            *out = if hidden { 0 } else { (40 + x + 2 * y) as u8 };
        }
    }
    let mut flat = Plane::default();
    Flattening::new(4, 40).apply(&grey, &mut flat);
    let seen = flat.as_slice().iter().filter(|&&flat| flat != 0);
    let (least, most) = (seen.clone().min(), seen.max());
    // The mean of the window would leave 50 levels.
    assert!(least >= Some(&102) && most <= Some(&154), "{least:?} to {most:?}");
}

#[test]
fn nothing_seen_is_no_residual_and_nothing_panics() {
    for (width, height) in [(0, 0), (0, 3), (3, 0), (1, 1), (1, 40), (40, 1), (3, 3)] {
        let grey = Plane::new(width, height, 0);
        let mut template = Template::default();
        template.choose(
            &grey,
            Rect { x: 1, y: 1, width: usize::MAX, height: usize::MAX },
            2,
            &Corridor::EVERYWHERE,
        );
        assert!(template.is_empty());
        let mut target = Target::default();
        target.fill(&grey);
        let mut residuals = Residuals::default();
        residuals.measure(&template, &target, &ProjectiveMap::IDENTITY, Brightness::default(), 1.0);
        assert!(residuals.seen < 0.5);
    }
    let mut template = Template::default();
    template.choose(
        &hills(20, 20, |u, v| [u, v]),
        Rect { x: 0, y: 0, width: 20, height: 20 },
        1,
        &Corridor::EVERYWHERE,
    );
    let mut residuals = Residuals::default();
    let lost = ProjectiveMap { right: [f32::NAN; 3], down: [f32::INFINITY; 3], scale: [0.0; 3] };
    residuals.measure(&template, &Target::default(), &lost, Brightness::default(), 0.0);
    assert!(residuals.seen < 0.5 && residuals.sums(&template).hessian[0][0].abs() < 1e-9);
}

#[test]
fn a_thinned_template_has_every_other_group_of_points() {
    let grey = hills(90, 60, |u, v| [u, v]);
    for (width, step) in [(90, 2), (71, 2), (52, 2), (40, 3), (90, 1)] {
        let (mut all, mut some) = (Template::default(), Template::default());
        all.choose(&grey, Rect { x: 0, y: 0, width, height: 41 }, 4, &Corridor::EVERYWHERE);
        some.thin(&all, step);
        let kept: Vec<[f32; 2]> = (0..all.len())
            .filter(|point| (point / LANES).is_multiple_of(step))
            .filter_map(|p| all.place(p))
            .collect();
        assert_eq!(some.len(), kept.len(), "{width} {step}");
        assert!(kept.iter().enumerate().all(|(point, place)| some.place(point) == Some(*place)));
    }
    let mut some = Template::default();
    some.thin(&Template::default(), 2);
    assert!(some.is_empty());
}
