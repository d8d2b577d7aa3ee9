//! The flow's behaviour on motions that are known, and on input that is not usable.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use fingerpost_vision::farneback::{Farneback, FarnebackError, FarnebackParams, FlowField};
use fingerpost_vision::picture::{Plane, Rect};
use fingerpost_vision::simd::{CodePath, InstructionSet};

/// A smooth pattern without repetition in the picture, seen from a place moved by `shift` pixels.
fn textured(width: usize, height: usize, shift: [f64; 2]) -> Plane<u8> {
    let value = |index: usize| {
        let (x, y) = ((index % width) as f64 + shift[0], (index / width) as f64 + shift[1]);
        let waves = libm::sin(0.31 * x + 0.11 * y)
            + libm::sin(0.17 * y - 0.23 * x + 1.0)
            + libm::cos(0.37 * y + 0.05 * x);
        (128.0 + 35.0 * waves + 12.0 * libm::sin(0.9 * x) * libm::sin(0.8 * y)).clamp(0.0, 255.0) as u8
    };
    Plane::from_vec(width, height, (0..width * height).map(value).collect()).unwrap()
}

fn farneback() -> Farneback {
    Farneback::new(FarnebackParams::default()).unwrap()
}

fn mean_inside(flow: &FlowField, margin: usize) -> [f64; 2] {
    let mut sum = [0.0; 2];
    let (columns, rows) = (margin..flow.width() - margin, margin..flow.height() - margin);
    let count = (columns.len() * rows.len()) as f64;
    for (y, x) in rows.flat_map(|y| columns.clone().map(move |x| (y, x))) {
        let [dx, dy] = flow.get(x, y).unwrap();
        sum[0] += f64::from(dx) / count;
        sum[1] += f64::from(dy) / count;
    }
    sum
}

#[test]
fn what_moves_left_and_down_flows_left_and_down() {
    let (previous, next) = (textured(120, 90, [0.0, 0.0]), textured(120, 90, [3.5, -2.25]));
    let mut farneback = farneback();
    let [dx, dy] = mean_inside(farneback.flow(previous.view(), next.view(), None).unwrap(), 15);
    assert!((dx + 3.5).abs() < 0.05 && (dy - 2.25).abs() < 0.05, "({dx}, {dy})");
}

#[test]
fn what_stands_still_does_not_flow() {
    // Half of the window, 7 pixels, at the coarsest of three levels, four times smaller, and a little more.
    const EDGE_REACH_PX: usize = 30;
    let mut farneback = farneback();
    for picture in [textured(128, 128, [0.0; 2]), Plane::new(128, 128, 93)] {
        let flow = farneback.flow(picture.view(), picture.view(), None).unwrap();
        let [dx, dy] = mean_inside(flow, 0);
        assert!(dx.abs() < 5e-4 && dy.abs() < 5e-4, "mean ({dx}, {dy})");
        for (y, x) in (0..128).flat_map(|y| (0..128).map(move |x| (y, x))) {
            let [dx, dy] = flow.get(x, y).unwrap();
            let is_inner = [x, y].iter().all(|c| (EDGE_REACH_PX..128 - EDGE_REACH_PX).contains(c));
            // OpenCV's flow of the textured picture reaches 0.14 px at its edges.
            let allowed = if is_inner { 1e-4 } else { 0.2 };
            assert!(libm::hypotf(dx, dy) < allowed, "({dx}, {dy}) at ({x}, {y})");
        }
    }
}

#[test]
fn an_initial_flow_reaches_what_is_too_fast_without() {
    let (previous, next) = (textured(96, 96, [0.0; 2]), textured(96, 96, [-30.0, 0.0]));
    let params = FarnebackParams { levels: 0, ..FarnebackParams::default() };
    let mut farneback = Farneback::new(params).unwrap();
    let centre = |flow: &FlowField| flow.get(40, 48).unwrap();
    let lost = centre(farneback.flow(previous.view(), next.view(), None).unwrap());
    assert!((lost[0] - 30.0).abs() > 5.0, "{lost:?}");
    for mut farneback in [farneback, self::farneback()] {
        let guess = FlowField::uniform(96, 96, [27.5, 1.0]);
        let found = centre(farneback.flow(previous.view(), next.view(), Some(&guess)).unwrap());
        assert!((found[0] - 30.0).abs() < 0.2 && found[1].abs() < 0.2, "{found:?}");
    }
}

#[test]
fn a_region_gives_the_same_as_its_copy_and_used_buffers_the_same_as_new_ones() {
    let (previous, next) = (textured(150, 120, [0.0; 2]), textured(150, 120, [1.0, 4.0]));
    let rect = Rect { x: 21, y: 13, width: 77, height: 64 };
    let (previous, next) = (previous.view().crop(rect).unwrap(), next.view().crop(rect).unwrap());
    let copy = |view: fingerpost_vision::picture::PlaneView<'_, u8>| {
        let pixels = (0..view.height()).flat_map(|y| view.row(y).to_vec()).collect();
        Plane::from_vec(view.width(), view.height(), pixels).unwrap()
    };
    let mut used = farneback();
    let other = textured(64, 140, [0.0; 2]);
    used.flow(other.view(), other.view(), Some(&FlowField::uniform(64, 140, [5.0, 5.0]))).unwrap();
    let from_region = used.flow(previous, next, None).unwrap().clone();
    let mut fresh = farneback();
    assert_eq!(&from_region, fresh.flow(copy(previous).view(), copy(next).view(), None).unwrap());
}

#[test]
fn every_path_gives_the_same_bytes() {
    for (width, height, poly_n_px, window_px) in
        [(128, 96, 5, 15), (67, 131, 7, 9), (90, 41, 3, 21), (33, 35, 9, 1)]
    {
        let (previous, next) = (textured(width, height, [0.0; 2]), textured(width, height, [2.3, -1.1]));
        let mut farneback =
            Farneback::new(FarnebackParams { poly_n_px, window_px, ..FarnebackParams::default() }).unwrap();
        let guess = FlowField::uniform(width, height, [-200.0, 0.5]);
        for initial in [None, Some(&guess)] {
            let flows = InstructionSet::ALL.map(|set| {
                CodePath::limit(set);
                farneback.flow(previous.view(), next.view(), initial).unwrap().clone()
            });
            CodePath::limit(InstructionSet::Avx512);
            assert!(flows.iter().all(|flow| flow == &flows[0]), "{width} x {height}");
        }
    }
}

#[test]
fn the_smallest_pictures_do_no_harm() {
    for (width, height) in [(1, 1), (1, 40), (40, 1), (2, 3), (9, 9)] {
        let (previous, next) = (textured(width, height, [0.0; 2]), textured(width, height, [0.5, 0.0]));
        let mut farneback = farneback();
        let flow = farneback.flow(previous.view(), next.view(), None).unwrap();
        assert_eq!((flow.width(), flow.height()), (width, height));
        assert!(flow.dx.as_slice().iter().chain(flow.dy.as_slice()).all(|d| d.is_finite()));
    }
}

#[test]
fn pictures_that_do_not_fit_are_errors() {
    let (wide, high) = (textured(40, 30, [0.0; 2]), textured(30, 40, [0.0; 2]));
    let nothing = Plane::new(0, 7, 0);
    let mut farneback = farneback();
    let is_picture_error = |result| matches!(result, Err(FarnebackError::Picture(_)));
    assert!(is_picture_error(farneback.flow(wide.view(), high.view(), None).map(|_| ())));
    assert!(is_picture_error(farneback.flow(nothing.view(), nothing.view(), None).map(|_| ())));
    let mut guess = FlowField::uniform(30, 40, [0.0; 2]);
    assert!(is_picture_error(farneback.flow(wide.view(), wide.view(), Some(&guess)).map(|_| ())));
    guess.dy.row_mut(7)[3] = f32::NAN;
    let refused = farneback.flow(high.view(), high.view(), Some(&guess)).map(|_| ());
    assert_eq!(refused, Err(FarnebackError::InitialFlow { x: 3, y: 7 }));
    let absurd = FlowField::uniform(40, 30, [f32::MAX, -f32::MAX]);
    assert!(farneback.flow(wide.view(), wide.view(), Some(&absurd)).is_ok());
}

#[test]
fn parameters_outside_their_range_are_errors() {
    let usual = FarnebackParams::default();
    for params in [
        FarnebackParams { pyramid_scale: 1.0, ..usual },
        FarnebackParams { pyramid_scale: f64::NAN, ..usual },
        FarnebackParams { levels: 33, ..usual },
        FarnebackParams { window_px: 14, ..usual },
        FarnebackParams { window_px: 0, ..usual },
        FarnebackParams { iterations: 0, ..usual },
        FarnebackParams { poly_n_px: 0, ..usual },
        FarnebackParams { poly_sigma_px: 0.0, ..usual },
        FarnebackParams { poly_sigma_px: f64::NAN, ..usual },
    ] {
        assert!(matches!(Farneback::new(params), Err(FarnebackError::Parameter { .. })), "{params:?}");
    }
}
