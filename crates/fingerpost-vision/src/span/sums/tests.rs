//! Covers against one another, path by path and at places where numbers could overflow.

use super::*;
use crate::picture::{Plane, Rect};

#[test]
fn every_path_covers_alike() {
    let (width, height) = (600, 40);
    let values = (0..width * height).map(|index| (index * index % 251) as u8).collect();
    let probability = Plane::from_vec(width, height, values).unwrap();
    let mut seen = Plane::new(width, height, 1);
    (0..height).for_each(|y| seen.row_mut(y)[300 - 7 * y..310 + 3 * y].fill(0));
    let validity = ValidityMask::from_plane(seen);
    let mask = SpanMask::stroke(&[[-900.0, -3.0], [0.0, 4.0], [20.0, 60.0]], 11.0).unwrap();
    for path in CodePath::available() {
        let mut sums = RowSums::default();
        sums.rebuild_on(path, probability.view(), &validity).unwrap();
        let mut covers = [Cover::default(); 150];
        sums.covers_on(path, &mask, 400, 10, &mut covers);
        for (index, &cover) in covers.iter().enumerate() {
            assert_eq!(cover, sums.cover(&mask, 400 + index as i32, 10), "{path:?}, place {index}");
        }
        assert!(covers.iter().all(|cover| cover.seen < cover.in_view && cover.in_view < cover.area));
    }
}

#[test]
fn a_mask_whose_sum_exceeds_32_bits_is_covered_whole() {
    let side = 4200;
    let probability = Plane::new(side, side, u8::MAX);
    let mut sums = RowSums::default();
    sums.rebuild(probability.view(), &ValidityMask::all_seen(side, side)).unwrap();
    let mask = SpanMask::from_rect(Rect { x: 0, y: 0, width: side, height: side });
    let mut covers = [Cover::default(); 3];
    sums.covers(&mask, -1, 0, &mut covers);
    let pixels = [side - 1, side, side - 1].map(|columns| (columns * side) as u64);
    assert_eq!(covers.map(|cover| cover.seen), pixels);
    assert_eq!(covers.map(|cover| cover.sum), pixels.map(|count| 255 * count));
}
