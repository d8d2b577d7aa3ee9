//! Filters and edges of 8-bit pictures.

use anyhow::Result;
use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::smoothing::GaussianBlur;
use fingerpost_vision::sobel::Sobel;
use serde_json::json;

use super::{Bench, PROMISED, SIDE_PX, agreement, array_of_plane, grey_square, rust_crates, size_of};
use crate::results::Row;

/// Thresholds of the edges.
const CANNY: CannyParams = CannyParams { low: 80.0, high: 160.0, norm: GradientNorm::L1 };
/// Share of the pixels on which edges must be the same.
const SAME_EDGES: f64 = 0.995;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let grey = grey_square(&bench.frames[0], SIDE_PX)?;
    Ok(vec![gaussian(bench, &grey)?, sobel(bench, &grey)?, canny(bench, &grey)?])
}

fn gaussian(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Row> {
    let (side, sigma_px) = (5, 1.1);
    let mut filter = GaussianBlur::new(side, sigma_px)?;
    let mut smooth = Plane::new(SIDE_PX, SIDE_PX, 0);
    filter.apply(grey.view(), &mut smooth)?;
    let parameters = json!({"side": side, "sigma": sigma_px});
    let theirs = bench.opencv_gives("gaussian", &parameters, &[array_of_plane(grey)])?;
    let agreement = agreement::within(smooth.as_slice(), theirs[0].u8s(), 1, 1.0);
    let work = || {
        let _ = filter.apply(grey.view(), &mut smooth);
    };
    let others = rust_crates::gaussians(grey, side, sigma_px as f32);
    bench.row(("Gaussian 5 x 5, 8 bit", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, others)
}

fn sobel(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Row> {
    let mut filter = Sobel::new();
    let mut slope = Plane::new(SIDE_PX, SIDE_PX, 0_i16);
    filter.horizontal(grey.view(), &mut slope)?;
    let theirs = bench.opencv_gives("sobel", &json!({}), &[array_of_plane(grey)])?;
    let agreement = agreement::identical(slope.as_slice(), &theirs[0].i16s());
    let work = || {
        let _ = filter.horizontal(grey.view(), &mut slope);
    };
    bench.row(("Sobel 3 x 3", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, rust_crates::sobels(grey))
}

fn canny(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Row> {
    let mut detector = Canny::new(CANNY)?;
    let mut edges = Plane::new(SIDE_PX, SIDE_PX, 0);
    detector.apply(grey.view(), &mut edges)?;
    let parameters = json!({"low": CANNY.low, "high": CANNY.high, "l2": false});
    let theirs = bench.opencv_gives("canny", &parameters, &[array_of_plane(grey)])?;
    let same = edges.as_slice().iter().zip(theirs[0].u8s()).filter(|(ours, theirs)| ours == theirs).count();
    let agreement = agreement::share_of(same, SIDE_PX * SIDE_PX, SAME_EDGES, "the same");
    let work = || {
        let _ = detector.apply(grey.view(), &mut edges);
    };
    let others = rust_crates::cannys(grey, CANNY.low, CANNY.high);
    bench.row(("Canny", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, others)
}
