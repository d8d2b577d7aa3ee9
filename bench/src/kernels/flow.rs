//! Farneback's flow.

use anyhow::Result;
use fingerpost_vision::farneback::{Farneback, FarnebackParams, FlowField};
use serde_json::json;

use super::{Bench, agreement, array_of_plane, grey_square, size_of};
use crate::results::Row;

/// Sides of the regions, pixels, and how many times as fast as OpenCV the flow is promised to be there.
const REGIONS: [(usize, Option<f64>); 3] = [(128, Some(3.0)), (256, Some(3.0)), (512, None)];
/// Mean end-point difference from OpenCV's flow that is allowed, pixels.
const MEAN_DIFFERENCE_PX: f64 = 0.05;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    REGIONS.iter().map(|&(side_px, promised)| row(bench, side_px, promised)).collect()
}

fn row(bench: &mut Bench<'_>, side_px: usize, promised: Option<f64>) -> Result<Row> {
    let previous = grey_square(&bench.frames[0], side_px)?;
    let next = grey_square(&bench.frames[1], side_px)?;
    let mut farneback = Farneback::new(FarnebackParams::default())?;
    let ours = farneback.flow(previous.view(), next.view(), None)?.clone();
    let inputs = [array_of_plane(&previous), array_of_plane(&next)];
    let theirs = bench.opencv_gives("farneback", &json!({}), &inputs)?;
    let difference = mean_end_point_difference(&ours, &theirs[0].f32s());
    let agreement = agreement::at_most("mean end-point difference", difference, MEAN_DIFFERENCE_PX);
    let work = || {
        // The pictures are those of the call above, which was good.
        let _ = farneback.flow(previous.view(), next.view(), None);
    };
    bench.row(("Farneback flow", &size_of(side_px)), promised, agreement, work, Vec::new())
}

fn mean_end_point_difference(ours: &FlowField, theirs: &[f32]) -> f64 {
    let (pairs, _) = theirs.as_chunks::<2>();
    let ours = ours.dx.as_slice().iter().zip(ours.dy.as_slice());
    let sum: f64 = ours.zip(pairs).map(|((dx, dy), [x, y])| f64::from(libm::hypotf(dx - x, dy - y))).sum();
    sum / pairs.len().max(1) as f64
}
