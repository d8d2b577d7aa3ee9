//! Agreement with OpenCV on committed pictures; `tools/golden/opencv_golden.py` made the golden files.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod common;

use common::{HEIGHT, WIDTH, end_point_difference, golden};
use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
use fingerpost_vision::colour::{grey_of, hue_saturation_of};
use fingerpost_vision::components::{ConnectedComponents, Connectivity};
use fingerpost_vision::farneback::{Farneback, FarnebackParams};
use fingerpost_vision::hough::{HoughLines, HoughParams};
use fingerpost_vision::morphology::{Dilation, StructuringElement};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::smoothing::{BoxBlur, GaussianBlur};
use fingerpost_vision::sobel::Sobel;
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

/// Every [`STEP`]-th pixel of every such row.
fn sampled<T: Copy>(plane: &Plane<T>) -> Vec<T> {
    let rows = (0..plane.height()).step_by(STEP);
    rows.flat_map(|y| plane.row(y).iter().copied().step_by(STEP)).collect()
}

fn smoothed() -> Plane<u8> {
    let mut smoothed = Plane::new(WIDTH, HEIGHT, 0);
    let picture = golden_picture("synthetic_1_previous.grey");
    GaussianBlur::new(5, 1.1).unwrap().apply(picture.view(), &mut smoothed).unwrap();
    smoothed
}

fn edges(norm: GradientNorm) -> Plane<u8> {
    let mut edges = Plane::new(WIDTH, HEIGHT, 0);
    let params = CannyParams { low: 80.0, high: 160.0, norm };
    Canny::new(params).unwrap().apply(smoothed().view(), &mut edges).unwrap();
    edges
}

#[test]
fn smoothing_and_dilation_agree_to_the_level() {
    let picture = golden_picture("synthetic_1_previous.grey");
    assert_eq!(sampled(&smoothed()), golden("gaussian_5.grey"));
    let mut target = Plane::new(WIDTH, HEIGHT, 0);
    BoxBlur::new(15).unwrap().apply(picture.view(), &mut target).unwrap();
    assert_eq!(sampled(&target), golden("box_15.grey"));
    Dilation::new(StructuringElement::ellipse(5, 5).unwrap()).apply(picture.view(), &mut target).unwrap();
    assert_eq!(sampled(&target), golden("dilated_5.grey"));
}

#[test]
fn slopes_agree_exactly() {
    let (mut dx, mut dy) = (Plane::new(WIDTH, HEIGHT, 0), Plane::new(WIDTH, HEIGHT, 0));
    let picture = golden_picture("synthetic_1_previous.grey");
    Sobel::new().gradient(picture.view(), &mut dx, &mut dy).unwrap();
    let slopes = sampled(&dx).into_iter().zip(sampled(&dy));
    let found: Vec<u8> = slopes.flat_map(|(dx, dy)| [dx.to_le_bytes(), dy.to_le_bytes()].concat()).collect();
    assert_eq!(found, golden("sobel.i16"));
}

#[test]
fn edges_agree_pixel_by_pixel() {
    for (norm, name) in [(GradientNorm::L1, "canny_l1.bits"), (GradientNorm::L2, "canny_l2.bits")] {
        let edges = edges(norm);
        let packed = |eight: &[u8]| eight.iter().fold(0, |bits, &edge| bits << 1 | u8::from(edge != 0));
        let found: Vec<u8> = edges.as_slice().chunks(8).map(packed).collect();
        assert_eq!(found, golden(name), "{name}");
    }
}

#[test]
fn components_agree_in_place_and_area() {
    let mut finder = ConnectedComponents::new(Connectivity::Eight);
    let components = finder.find(edges(GradientNorm::L1).view());
    let numbers = components.iter().flat_map(|component| {
        let bounds = component.bounds;
        [bounds.x, bounds.y, bounds.width, bounds.height, component.area_px]
    });
    let found: Vec<u8> = numbers.flat_map(|number| (number as i32).to_le_bytes()).collect();
    assert!(found.len() > 5 * 4 * 10);
    assert_eq!(found, golden("components.i32"));
}

#[test]
fn the_strongest_lines_agree_within_a_bin() {
    let step_rad = 1_f64.to_radians();
    let params = HoughParams { rho_step_px: 1.0, theta_step_rad: step_rad, votes: 20 };
    let mut finder = HoughLines::new(params).unwrap();
    let found = finder.find(edges(GradientNorm::L1).view());
    let bytes = golden("lines.f32");
    let (values, _) = bytes.as_chunks::<4>();
    let values: Vec<f64> = values.iter().map(|&value| f64::from(f32::from_le_bytes(value))).collect();
    let (expected, _) = values.as_chunks::<3>();
    assert_eq!(expected.len(), 12);
    for &[rho_px, theta_rad, votes] in expected {
        let agrees = found[..2 * expected.len()].iter().any(|line| {
            (line.rho_px - rho_px).abs() <= 1.001
                && (line.theta_rad - theta_rad).abs() <= 1.001 * step_rad
                && (f64::from(line.votes) - votes).abs() <= 2.0
        });
        assert!(agrees, "({rho_px}, {theta_rad}, {votes}) not in {found:#?}");
    }
}
