use proptest::prelude::*;

use super::*;
use crate::picture::Plane;
use crate::test_pictures::{config, grey_pictures};

/// Strength by the formula, none too near the edge.
fn plain_strength(grey: PlaneView<'_, u8>, x: usize, y: usize) -> Option<f32> {
    let (width, height) = grey.size();
    if x < EDGE || y < EDGE || x + EDGE >= width || y + EDGE >= height {
        return None;
    }
    let (mut xx, mut yy, mut xy) = (0, 0, 0);
    for v in y - REACH..=y + REACH {
        for u in x - REACH..=x + REACH {
            let dx = i32::from(grey.row(v)[u + 1]) - i32::from(grey.row(v)[u - 1]);
            let dy = i32::from(grey.row(v + 1)[u]) - i32::from(grey.row(v - 1)[u]);
            xx += dx * dx;
            yy += dy * dy;
            xy += dx * dy;
        }
    }
    Some(smaller_eigenvalue(xx as f32, xy as f32, yy as f32))
}

fn plain(grey: PlaneView<'_, u8>, cell: usize, least: f32) -> Vec<Corner> {
    let (width, height) = grey.size();
    let mut corners = Vec::new();
    for top in (EDGE..height).step_by(cell) {
        for left in (EDGE..width).step_by(cell) {
            let mut best: Option<Corner> = None;
            for y in top..top + cell {
                for x in left..left + cell {
                    let Some(strength) = plain_strength(grey, x, y) else { continue };
                    if strength > 0.0 && strength >= least && best.is_none_or(|best| strength > best.strength)
                    {
                        best = Some(Corner { x, y, strength });
                    }
                }
            }
            corners.extend(best);
        }
    }
    corners
}

proptest! {
    #![proptest_config(config(60))]

    #[test]
    fn every_path_finds_the_corners_of_the_formula(
        picture in grey_pictures(), cell in 1..40_usize, least in 0.0..50.0_f32,
    ) {
        let expected = plain(picture.view(), cell, least);
        for path in CodePath::available() {
            let (mut finder, mut corners) = (CornerFinder::default(), Vec::new());
            finder.find_on(path, picture.view(), cell, least, &mut corners);
            prop_assert_eq!(&corners, &expected, "{:?}", path);
            finder.find_on(path, picture.view(), cell, least, &mut corners);
            prop_assert_eq!(&corners, &expected, "a second time, {:?}", path);
        }
    }
}

#[test]
fn edges_and_flat_parts_have_no_corner() {
    let mut picture = Plane::new(40, 40, 90_u8);
    for y in 0..40 {
        picture.row_mut(y)[20..].fill(180);
    }
    let mut corners = vec![Corner { x: 1, y: 1, strength: 1.0 }];
    CornerFinder::default().find(picture.view(), 10, 0.5, &mut corners);
    assert_eq!(corners, []);
    CornerFinder::default().find(picture.view(), 0, 0.5, &mut corners);
    assert_eq!(corners, []);
}
