//! The road surface: histogram, back-projection and disc.

use anyhow::Result;
use fingerpost_vision::backprojection::BackProjector;
use fingerpost_vision::colour::{BinDivision, grey_and_bins};
use fingerpost_vision::histogram::{BinCounter, Histogram};
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use fingerpost_vision::span::SpanMask;
use serde_json::json;

use super::ground::BINS;
use super::{Bench, PROMISED, SIDE_PX, agreement, array_of_plane, array_of_rgb, size_of, square};
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
    Ok(vec![histogram(bench, &mut scene)?, back_projection(bench, &scene)?, disc(bench, &scene)?])
}

fn histogram(bench: &mut Bench<'_>, scene: &mut Scene) -> Result<Row> {
    let mut counter = BinCounter::default();
    let whole = SpanMask::from_rect(Rect { x: 0, y: 0, width: SIDE_PX, height: SIDE_PX });
    let Scene { bin, validity, hsv, histogram, .. } = scene;
    counter.count(bin.view(), validity, &whole, histogram)?;
    let theirs = bench.opencv_gives(
        "histogram",
        &json!({"bins": [BINS.hue, BINS.saturation]}),
        std::slice::from_ref(hsv),
    )?;
    let pairs = histogram.masses().iter().zip(theirs[0].f32s());
    let apart: f64 = pairs.map(|(ours, theirs)| (ours - f64::from(theirs)).abs()).sum();
    let pixels = (SIDE_PX * SIDE_PX) as f64;
    let same = (pixels - 0.5 * apart) / pixels;
    let found = format!("{:.3} % of the pixels in the same bin", 100.0 * same);
    let agreement = Agreement { found, holds: same >= SAME_BIN_SHARE };
    let mut again = histogram.clone();
    let work = || {
        again.clear();
        let _ = counter.count(bin.view(), validity, &whole, &mut again);
    };
    let title = ("histogram of hue and saturation (calcHist)", &*size_of(SIDE_PX));
    bench.row(title, Some(PROMISED), agreement, work, Vec::new())
}

/// The histogram itself, its peak at 255, looked up for every pixel.
fn back_projection(bench: &mut Bench<'_>, scene: &Scene) -> Result<Row> {
    let peak = scene.histogram.masses().iter().copied().fold(1.0, f64::max);
    let lookup: Vec<u8> =
        scene.histogram.masses().iter().map(|mass| (255.0 * mass / peak).round() as u8).collect();
    let mut projector = BackProjector::new(0)?;
    let mut probability = Plane::new(SIDE_PX, SIDE_PX, 0);
    projector.project(&scene.bin, &scene.validity, &lookup, &mut probability)?;
    let scaled: Vec<f32> = lookup.iter().map(|&value| f32::from(value)).collect();
    let shape = [usize::from(BINS.hue), usize::from(BINS.saturation)];
    let inputs = [scene.hsv.clone(), Array::of_f32(&shape, &scaled)];
    let theirs = bench.opencv_gives("back_projection", &json!({}), &inputs)?;
    let same = probability.as_slice().iter().zip(theirs[0].u8s()).filter(|(a, b)| a == b).count();
    let agreement = agreement::share_of(same, SIDE_PX * SIDE_PX, SAME_BIN_SHARE, "the same");
    let work = || {
        let _ = projector.project(&scene.bin, &scene.validity, &lookup, &mut probability);
    };
    let title = ("back-projection (calcBackProject)", &*size_of(SIDE_PX));
    bench.row(title, Some(PROMISED), agreement, work, Vec::new())
}

/// The mean under the disc; ours looks the values up besides.
fn disc(bench: &mut Bench<'_>, scene: &Scene) -> Result<Row> {
    let values: Vec<u16> = scene.grey.as_slice().iter().map(|&value| u16::from(value)).collect();
    let values = Plane::from_vec(SIDE_PX, SIDE_PX, values)?;
    let itself: Vec<u8> = (0..=u8::MAX).collect();
    let mut projector = BackProjector::new(DISC_RADIUS_PX)?;
    let mut mean = Plane::new(SIDE_PX, SIDE_PX, 0);
    projector.project(&values, &scene.validity, &itself, &mut mean)?;
    let area: u32 = DISC.iter().flatten().map(|&pixel| u32::from(pixel)).sum();
    let kernel: Vec<f32> = DISC.iter().flatten().map(|&pixel| f32::from(pixel) / area as f32).collect();
    let inputs = [array_of_plane(&scene.grey), Array::of_f32(&[5, 5], &kernel)];
    let theirs = bench.opencv_gives("correlation", &json!({}), &inputs)?;
    // At the border OpenCV mirrors the picture; here only what is seen counts.
    let radius = usize::from(DISC_RADIUS_PX);
    let inner = |values: &[u8]| -> Vec<u8> {
        let rows = values.chunks_exact(SIDE_PX).skip(radius).take(SIDE_PX - 2 * radius);
        rows.flat_map(|row| &row[radius..SIDE_PX - radius]).copied().collect()
    };
    let agreement = agreement::within(&inner(mean.as_slice()), &inner(theirs[0].u8s()), 1, 1.0);
    let work = || {
        let _ = projector.project(&values, &scene.validity, &itself, &mut mean);
    };
    let title = ("look-up and mean under a disc (filter2D alone)", &*size_of(SIDE_PX));
    bench.row(title, Some(PROMISED), agreement, work, Vec::new())
}
