//! Reductions of pictures, and the filters of floating-point pictures that the flow is made with.

use anyhow::Result;
use fingerpost_vision::filter::{BoxMean, SeparableFilter, gaussian_taps};
use fingerpost_vision::picture::Plane;
use fingerpost_vision::pyramid::{Resizer, halve, reduce};
use serde_json::json;

use super::{
    Bench, PROMISED, SIDE_PX, agreement, array_of_floats, array_of_plane, grey_square, rust_crates, size_of,
};
use crate::results::Row;

/// Largest difference of a smoothed or resampled grey level that is allowed: that of adding up in another order.
const FLOAT_BOUND: f32 = 1e-3;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let grey = grey_square(&bench.frames[0], SIDE_PX)?;
    let values: Vec<f32> = grey.as_slice().iter().map(|&value| f32::from(value)).collect();
    let floats = Plane::from_vec(SIDE_PX, SIDE_PX, values)?;
    Ok(vec![
        halving(bench, &grey)?,
        reduction(bench, &grey)?,
        resizing(bench, &floats)?,
        gaussian(bench, &floats)?,
        box_mean(bench, &floats)?,
    ])
}

fn halving(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Row> {
    let mut half = Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0);
    halve(grey.view(), &mut half)?;
    let theirs = bench.opencv_gives("resize_half", &json!({}), &[array_of_plane(grey)])?;
    let agreement = agreement::identical(half.as_slice(), theirs[0].u8s());
    let work = || {
        let _ = halve(grey.view(), &mut half);
    };
    bench.row(
        ("halving, 8 bit (resize)", &size_of(SIDE_PX)),
        Some(PROMISED),
        agreement,
        work,
        rust_crates::halvings(grey),
    )
}

fn reduction(bench: &mut Bench<'_>, grey: &Plane<u8>) -> Result<Row> {
    let mut half = Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0);
    reduce(grey.view(), &mut half)?;
    let theirs = bench.opencv_gives("pyramid_reduction", &json!({}), &[array_of_plane(grey)])?;
    let agreement = agreement::identical(half.as_slice(), theirs[0].u8s());
    let work = || {
        let _ = reduce(grey.view(), &mut half);
    };
    bench.row(
        ("pyramid reduction, 8 bit (pyrDown)", &size_of(SIDE_PX)),
        Some(PROMISED),
        agreement,
        work,
        rust_crates::reductions(grey),
    )
}

fn resizing(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Row> {
    let mut resizer = Resizer::default();
    let mut half = Plane::new(SIDE_PX / 2, SIDE_PX / 2, 0.0);
    resizer.resize(floats, &mut half, 1.0);
    let theirs = bench.opencv_gives("resize_half", &json!({}), &[array_of_floats(floats)])?;
    let agreement = agreement::floats_within(half.as_slice(), &theirs[0].f32s(), FLOAT_BOUND);
    let work = || resizer.resize(floats, &mut half, 1.0);
    bench.row(("resize to half, f32", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, Vec::new())
}

fn gaussian(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Row> {
    let (side, sigma_px) = (5, 1.1);
    let mut filter = SeparableFilter::new(&gaussian_taps(sigma_px, side / 2));
    let mut smooth = Plane::new(SIDE_PX, SIDE_PX, 0.0);
    filter.apply(floats, &mut smooth)?;
    let parameters = json!({"side": side, "sigma": sigma_px});
    let theirs = bench.opencv_gives("gaussian", &parameters, &[array_of_floats(floats)])?;
    let agreement = agreement::floats_within(smooth.as_slice(), &theirs[0].f32s(), FLOAT_BOUND);
    let work = || {
        let _ = filter.apply(floats, &mut smooth);
    };
    bench.row(("Gaussian 5 x 5, f32", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, Vec::new())
}

fn box_mean(bench: &mut Bench<'_>, floats: &Plane<f32>) -> Result<Row> {
    let radius_px = 7;
    let mut filter = BoxMean::new(radius_px);
    let mut smooth = Plane::new(SIDE_PX, SIDE_PX, 0.0);
    filter.apply(floats, &mut smooth)?;
    let parameters = json!({"side": 2 * radius_px + 1, "replicate": true});
    let theirs = bench.opencv_gives("box_mean", &parameters, &[array_of_floats(floats)])?;
    let agreement = agreement::floats_within(smooth.as_slice(), &theirs[0].f32s(), FLOAT_BOUND);
    let work = || {
        let _ = filter.apply(floats, &mut smooth);
    };
    bench.row(("box mean 15 x 15, f32", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, Vec::new())
}
