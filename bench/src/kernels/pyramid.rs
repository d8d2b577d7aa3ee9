//! Reductions of pictures, and the filters of floating-point pictures that the flow is made with.

use anyhow::Result;
use fingerpost_vision::filter::{BoxMean, SeparableFilter, gaussian_taps};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::pyramid::{Resizer, halve, reduce};
use serde_json::json;

use super::{
    Bench, Kernel, Promise, SIDE_PX, agreement, array_of_floats, array_of_plane, grey_square, rust_crates,
    size_of,
};
use crate::results::Row;

/// Largest difference of a smoothed or resampled grey level that is allowed: that of adding up in another order.
const FLOAT_BOUND: f32 = 1e-3;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let grey = grey_square(&bench.frames[0], SIDE_PX)?;
    let values: Vec<f32> = grey.as_slice().iter().map(|&value| f32::from(value)).collect();
    let floats = Plane::from_vec(SIDE_PX, SIDE_PX, values)?;
    let mut rows = halving(bench, &grey)?;
    rows.extend(reduction(bench, &grey)?);
    rows.extend(resizing(bench, &floats)?);
    rows.extend(gaussian(bench, &floats)?);
    rows.extend(box_mean(bench, &floats)?);
    Ok(rows)
}

fn halving(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("resize_half", &json!({}), &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: "halving, 8 bit (resize)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0),
        work: &|half| Ok(halve(grey.view(), half)?),
        compare: &|half| Ok(agreement::identical(half.as_slice(), theirs[0].u8s())),
    };
    bench.rows(&kernel, rust_crates::halvings(grey))
}

fn reduction(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("pyramid_reduction", &json!({}), &[array_of_plane(grey)])?;
    let kernel = Kernel {
        what: "pyramid reduction, 8 bit (pyrDown)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0),
        work: &|half| Ok(reduce(grey.view(), half)?),
        compare: &|half| Ok(agreement::identical(half.as_slice(), theirs[0].u8s())),
    };
    bench.rows(&kernel, rust_crates::reductions(grey))
}

fn resizing(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("resize_half", &json!({}), &[array_of_floats(floats)])?;
    let kernel = Kernel {
        what: "resize to half, f32",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (Resizer::default(), Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0.0)),
        work: &|(resizer, half)| {
            resizer.resize(floats, half, 1.0);
            Ok(())
        },
        compare: &|(_, half)| Ok(agreement::floats_within(half.as_slice(), &theirs[0].f32s(), FLOAT_BOUND)),
    };
    bench.rows(&kernel, Vec::new())
}

fn gaussian(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Vec<Row>> {
    let (side, sigma_px) = (5, 1.1);
    let parameters = json!({"side": side, "sigma": sigma_px});
    let theirs = bench.opencv_gives("gaussian", &parameters, &[array_of_floats(floats)])?;
    let filter = SeparableFilter::new(&gaussian_taps(sigma_px, side / 2));
    let kernel = Kernel {
        what: "Gaussian 5 x 5, f32",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (filter, Plane::new(SIDE_PX, SIDE_PX, 0.0)),
        work: &|(filter, smooth)| Ok(filter.apply(floats, smooth)?),
        compare: &|(_, smooth)| {
            Ok(agreement::floats_within(smooth.as_slice(), &theirs[0].f32s(), FLOAT_BOUND))
        },
    };
    bench.rows(&kernel, Vec::new())
}

fn box_mean(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Vec<Row>> {
    let radius_px = 7;
    let parameters = json!({"side": 2 * radius_px + 1, "replicate": true});
    let theirs = bench.opencv_gives("box_mean", &parameters, &[array_of_floats(floats)])?;
    let kernel = Kernel {
        what: "box mean 15 x 15, f32",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (BoxMean::new(radius_px), Plane::new(SIDE_PX, SIDE_PX, 0.0)),
        work: &|(filter, smooth)| Ok(filter.apply(floats, smooth)?),
        compare: &|(_, smooth)| {
            Ok(agreement::floats_within(smooth.as_slice(), &theirs[0].f32s(), FLOAT_BOUND))
        },
    };
    bench.rows(&kernel, Vec::new())
}
