//! The road surface: histogram, back-projection and disc.

use anyhow::Result;
use fingerpost_vision::backprojection::BackProjector;
use fingerpost_vision::colour::{BinDivision, grey_and_bins};
use fingerpost_vision::histogram::{BinCounter, Histogram};
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use fingerpost_vision::span::SpanMask;
use serde_json::json;

use super::ground::BINS;
use super::{Bench, Kernel, Promise, SIDE_PX, agreement, array_of_plane, array_of_rgb, size_of, square};
use crate::peer::Array;
use crate::results::{Agreement, Row};

/// Radius of the disc, pixels.
const DISC_RADIUS_PX: u16 = 2;
/// Pixels of that disc: rows of 1, 3, 5, 3 and 1.
const DISC: [[u8; 5]; 5] =
    [[0, 0, 1, 0, 0], [0, 1, 1, 1, 0], [1, 1, 1, 1, 1], [0, 1, 1, 1, 0], [0, 0, 1, 0, 0]];
/// Share of the pixels that must be in the same bin as OpenCV's: hue and saturation may differ by one at a bin's edge.
const SAME_BIN_SHARE: f64 = 0.99;

/// A square that is seen whole, as bins and as OpenCV's hue, saturation and value.
struct Scene {
    grey: Plane<u8>,
    bin: Plane<u16>,
    validity: ValidityMask,
    hsv: Array,
    histogram: Histogram,
}

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let picture = square(&bench.frames[0], SIDE_PX);
    let mut grey = Plane::new(SIDE_PX, SIDE_PX, 0);
    let mut bin = Plane::new(SIDE_PX, SIDE_PX, 0_u16);
    grey_and_bins(&picture, &BinDivision::new(BINS)?, &mut grey, &mut bin)?;
    let hsv = bench.opencv_gives("hsv", &json!({}), &[array_of_rgb(&picture)])?.swap_remove(0);
    let validity = ValidityMask::all_seen(SIDE_PX, SIDE_PX);
    let mut scene = Scene { grey, bin, validity, hsv, histogram: Histogram::new(BINS)? };
    let mut rows = histogram(bench, &mut scene)?;
    rows.extend(back_projection(bench, &scene)?);
    rows.extend(disc(bench, &scene)?);
    Ok(rows)
}

fn histogram(bench: &mut Bench<'_>, scene: &mut Scene) -> Result<Vec<Row>> {
    let whole = SpanMask::from_rect(Rect { x: 0, y: 0, width: SIDE_PX, height: SIDE_PX });
    let Scene { bin, validity, hsv, histogram, .. } = scene;
    BinCounter::default().count(bin.view(), validity, &whole, histogram)?;
    let theirs = bench.opencv_gives(
        "histogram",
        &json!({"bins": [BINS.hue, BINS.saturation]}),
        std::slice::from_ref(hsv),
    )?;
    let kernel = Kernel {
        what: "histogram of hue and saturation (calcHist)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (BinCounter::default(), Histogram::new(BINS)?),
        work: &|(counter, histogram)| {
            histogram.clear();
            Ok(counter.count(bin.view(), validity, &whole, histogram)?)
        },
        compare: &|(_, histogram)| {
            let pairs = histogram.masses().iter().zip(theirs[0].f32s());
            let apart: f64 = pairs.map(|(ours, theirs)| (ours - f64::from(theirs)).abs()).sum();
            let pixels = (SIDE_PX * SIDE_PX) as f64;
            let same = (pixels - 0.5 * apart) / pixels;
            let found = format!("{:.3} % of the pixels in the same bin", 100.0 * same);
            Ok(Agreement { found, holds: same >= SAME_BIN_SHARE })
        },
    };
    bench.rows(&kernel, Vec::new())
}

/// The histogram itself, its peak at 255, looked up for every pixel.
fn back_projection(bench: &mut Bench<'_>, scene: &Scene) -> Result<Vec<Row>> {
    let peak = scene.histogram.masses().iter().copied().fold(1.0, f64::max);
    let lookup: Vec<u8> =
        scene.histogram.masses().iter().map(|mass| (255.0 * mass / peak).round() as u8).collect();
    let scaled: Vec<f32> = lookup.iter().map(|&value| f32::from(value)).collect();
    let shape = [usize::from(BINS.hue), usize::from(BINS.saturation)];
    let inputs = [scene.hsv.clone(), Array::of_f32(&shape, &scaled)];
    let theirs = bench.opencv_gives("back_projection", &json!({}), &inputs)?;
    let kernel = Kernel {
        what: "back-projection (calcBackProject)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (BackProjector::new(0)?, Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(projector, probability)| {
            Ok(projector.project(&scene.bin, &scene.validity, &lookup, probability)?)
        },
        compare: &|(_, probability)| {
            Ok(agreement::same(probability.as_slice(), theirs[0].u8s(), SAME_BIN_SHARE))
        },
    };
    bench.rows(&kernel, Vec::new())
}

/// The mean under the disc; ours looks the values up besides.
fn disc(bench: &mut Bench<'_>, scene: &Scene) -> Result<Vec<Row>> {
    let values: Vec<u16> = scene.grey.as_slice().iter().map(|&value| u16::from(value)).collect();
    let values = Plane::from_vec(SIDE_PX, SIDE_PX, values)?;
    let itself: Vec<u8> = (0..=u8::MAX).collect();
    let area: u32 = DISC.iter().flatten().map(|&pixel| u32::from(pixel)).sum();
    let weights: Vec<f32> = DISC.iter().flatten().map(|&pixel| f32::from(pixel) / area as f32).collect();
    let inputs = [array_of_plane(&scene.grey), Array::of_f32(&[5, 5], &weights)];
    let theirs = bench.opencv_gives("correlation", &json!({}), &inputs)?;
    // At the border OpenCV mirrors the picture; here only what is seen counts.
    let radius = usize::from(DISC_RADIUS_PX);
    let inner = |values: &[u8]| -> Vec<u8> {
        let rows = values.chunks_exact(SIDE_PX).skip(radius).take(SIDE_PX - 2 * radius);
        rows.flat_map(|row| &row[radius..SIDE_PX - radius]).copied().collect()
    };
    let kernel = Kernel {
        what: "look-up and mean under a disc (filter2D alone)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: (BackProjector::new(DISC_RADIUS_PX)?, Plane::new(SIDE_PX, SIDE_PX, 0)),
        work: &|(projector, mean)| Ok(projector.project(&values, &scene.validity, &itself, mean)?),
        compare: &|(_, mean)| Ok(agreement::within(&inner(mean.as_slice()), &inner(theirs[0].u8s()), 1, 1.0)),
    };
    bench.rows(&kernel, Vec::new())
}
