//! Agreement with OpenCV on committed pictures; `tools/golden/opencv_golden.py` made the golden files.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{HEIGHT, WIDTH, end_point_difference, golden};
use fingerpost_vision::colour::{grey_of, hue_saturation_of};
use fingerpost_vision::farneback::{Farneback, FarnebackParams};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::warp::WarpTable;

/// Mean end-point difference allowed, pixels.
const FLOW_TOLERANCE_PX: f64 = 0.005;
/// One golden flow vector is kept at every so many pixels.
const STEP: usize = 4;

fn golden_picture(name: &str) -> Plane<u8> {
    Plane::from_vec(WIDTH, HEIGHT, golden(name)).unwrap()
}

#[test]
fn flow_agrees_on_five_synthetic_ground_views() {
    let mut farneback = Farneback::new(FarnebackParams::default()).unwrap();
    for number in 1..=5 {
        let previous = golden_picture(&format!("synthetic_{number}_previous.grey"));
        let next = golden_picture(&format!("synthetic_{number}_next.grey"));
        let flow = farneback.flow(previous.view(), next.view(), None).unwrap();
        let (mean, largest) = end_point_difference(flow, &format!("synthetic_{number}.flow"), STEP);
        assert!(mean <= FLOW_TOLERANCE_PX, "pair {number}: mean {mean} px, largest {largest} px");
    }
}

#[test]
fn colours_agree_within_one_level() {
    let expected = golden("colour.bin");
    let (expected, _) = expected.as_chunks::<3>();
    let levels: Vec<u8> = (0..=255).step_by(15).collect();
    let grid = levels.iter().flat_map(|&r| levels.iter().map(move |&g| (r, g)));
    let colours: Vec<[u8; 3]> = grid.flat_map(|(r, g)| levels.iter().map(move |&b| [r, g, b])).collect();
    assert_eq!(colours.len(), expected.len());
    for (&rgb, &[grey, hue, saturation]) in colours.iter().zip(expected) {
        let (found_hue, found_saturation) = hue_saturation_of(rgb);
        assert!(grey_of(rgb).abs_diff(grey) <= 1, "grey of {rgb:?}");
        assert!(found_saturation.abs_diff(saturation) <= 1, "saturation of {rgb:?}");
        let apart = found_hue.abs_diff(hue);
        assert!(apart.min(180 - apart) <= 1, "hue of {rgb:?}: {found_hue}, not {hue}");
    }
}

#[test]
fn resampling_agrees_within_one_level() {
    let table = WarpTable::new(WIDTH, HEIGHT, WIDTH, HEIGHT, |col, row| {
        let (col, row) = (col as f64, row as f64);
        Some([0.9 * col + 0.13 * row - 4.0, 1.1 * row - 0.07 * col - 2.5 + 0.002 * col * row])
    })
    .unwrap();
    let mut warped = Plane::new(WIDTH, HEIGHT, 0);
    table.warp_grey(&golden_picture("synthetic_1_previous.grey"), &mut warped).unwrap();
    let expected = golden_picture("warp.grey");
    let unseen = table.validity().plane().as_slice().iter().filter(|&&valid| valid == 0).count();
    assert!((1000..10_000).contains(&unseen), "{unseen} unseen pixels");
    for (index, (found, expected)) in warped.as_slice().iter().zip(expected.as_slice()).enumerate() {
        let (col, row) = (index % WIDTH, index / WIDTH);
        assert!(found.abs_diff(*expected) <= 1, "({col}, {row}): {found}, not {expected}");
    }
}
