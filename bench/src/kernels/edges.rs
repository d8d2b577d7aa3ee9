//! Filters and edges of 8-bit pictures.

use anyhow::Result;
use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::smoothing::{BoxBlur, GaussianBlur};
use fingerpost_vision::sobel::Sobel;
use serde_json::json;

use super::{Bench, Kernel, Promise, SIDE_PX, agreement, array_of_plane, grey_square, rust_crates, size_of};
use crate::results::Row;

/// Thresholds of the edges.
const CANNY: CannyParams = CannyParams { low: 80.0, high: 160.0, norm: GradientNorm::L1 };
/// Share of the pixels on which edges must be the same.
const SAME_EDGES: f64 = 0.995;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let grey = grey_square(&bench.frames[0], SIDE_PX)?;
    let mut rows = gaussian(bench, &grey)?;
    rows.extend(box_blur(bench, &grey, 5)?);
    rows.extend(box_blur(bench, &grey, 15)?);
    rows.extend(sobel(bench, &grey)?);
    rows.extend(canny(bench, &grey)?);
    Ok(rows)
}

/// The edges of the middle of a frame: what shapes and lines are looked for in.
pub fn edge_picture(frame: &RgbImage) -> Result<Plane<u8>> {
    let grey = grey_square(frame, SIDE_PX)?;
    let mut edges = Plane::new(SIDE_PX, SIDE_PX, 0);
    Canny::new(CANNY)?.apply(grey.view(), &mut edges)?;
    Ok(edges)
}

fn gaussian(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Vec<Row>> {
    let (side, sigma_px) = (5, 1.1);
    let parameters = json!({"side": side, "sigma": sigma_px});
    let theirs = bench.opencv_gives("gaussian", &parameters, &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: "Gaussian 5 x 5, 8 bit",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (GaussianBlur::new(side, sigma_px)?, Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(filter, smooth)| Ok(filter.apply(grey.view(), smooth)?),
        compare: &|(_, smooth)| Ok(agreement::within(smooth.as_slice(), theirs[0].u8s(), 1, 1.0)),
    };
    bench.rows(&kernel, rust_crates::gaussians(grey, side, sigma_px as f32))
}

fn box_blur(bench: &mut Bench<'_>, grey: &Plane<u8>, side: usize) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("box_mean", &json!({"side": side}), &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: &format!("box blur {side} x {side}, 8 bit"),
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (BoxBlur::new(side)?, Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(filter, smooth)| Ok(filter.apply(grey.view(), smooth)?),
        compare: &|(_, smooth)| Ok(agreement::within(smooth.as_slice(), theirs[0].u8s(), 1, 1.0)),
    };
    bench.rows(&kernel, rust_crates::box_means(grey, side))
}

fn sobel(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("sobel", &json!({}), &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: "Sobel 3 x 3",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (Sobel::new(), Plane::new(SIDE_PX, SIDE_PX, 0_i16)),
        work: &|(filter, slope)| Ok(filter.horizontal(grey.view(), slope)?),
        compare: &|(_, slope)| Ok(agreement::identical(slope.as_slice(), &theirs[0].i16s())),
    };
    bench.rows(&kernel, rust_crates::sobels(grey))
}

fn canny(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Vec<Row>> {
    let parameters = json!({"low": CANNY.low, "high": CANNY.high, "l2": false});
    let theirs = bench.opencv_gives("canny", &parameters, &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: "Canny",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (Canny::new(CANNY)?, Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(detector, edges)| Ok(detector.apply(grey.view(), edges)?),
        compare: &|(_, edges)| Ok(agreement::same(edges.as_slice(), theirs[0].u8s(), SAME_EDGES)),
    };
    bench.rows(&kernel, rust_crates::cannys(grey, CANNY.low, CANNY.high))
}
