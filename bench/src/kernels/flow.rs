//! Farneback's flow.

use anyhow::Result;
use fingerpost_vision::farneback::{Farneback, FarnebackParams, FlowField};
use serde_json::json;

use super::{Bench, Kernel, Promise, agreement, array_of_plane, grey_square, size_of};
use crate::results::Row;

/// Sides of the regions, pixels, and how many times as fast as OpenCV the flow is promised to be there.
const REGIONS: [(usize, Promise); 3] = [(128, FAST), (256, FAST), (512, Promise::EVERY)];
/// What is promised of regions that are used for motion.
const FAST: Promise = Promise { avx512: 3.0, ..Promise::EVERY };
/// Mean end-point difference from OpenCV's flow that is allowed, pixels.
const MEAN_DIFFERENCE_PX: f64 = 0.05;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (side_px, promise) in REGIONS {
        rows.extend(of_region(bench, side_px, promise)?);
    }
    Ok(rows)
}

fn of_region(bench: &mut Bench<'_>, side_px: usize, promise: Promise) -> Result<Vec<Row>> {
    let previous = grey_square(&bench.frames[0], side_px)?;
    let next = grey_square(&bench.frames[1], side_px)?;
    let inputs = [array_of_plane(&previous), array_of_plane(&next)];
    let theirs = bench.opencv_gives("farneback", &json!({}), &inputs)?;
    let kernel = Kernel {
        what: "Farneback flow",
        size: &size_of(side_px),
        promise,
        fresh: Farneback::new(FarnebackParams::default())?,
        work: &|farneback| Ok(farneback.flow(previous.view(), next.view(), None).map(drop)?),
        compare: &|farneback| {
            let ours = farneback.flow(previous.view(), next.view(), None)?;
            let difference = mean_end_point_difference(ours, &theirs[0].f32s());
            Ok(agreement::at_most("mean end-point difference", difference, MEAN_DIFFERENCE_PX))
        },
    };
    bench.rows(&kernel, Vec::new())
}

fn mean_end_point_difference(ours: &FlowField, theirs: &[f32]) -> f64 {
    let (pairs, _) = theirs.as_chunks::<2>();
    let ours = ours.dx.as_slice().iter().zip(ours.dy.as_slice());
    let sum: f64 = ours.zip(pairs).map(|((dx, dy), [x, y])| f64::from(libm::hypotf(dx - x, dy - y))).sum();
    sum / pairs.len().max(1) as f64
}
