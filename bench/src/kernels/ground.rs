//! The ground view: resampling and colours.

use anyhow::Result;
use fingerpost_vision::colour::{BinDivision, HueSaturationBins, grey, hue_saturation};
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::warp::WarpTable;
use serde_json::json;

use super::{Bench, Kernel, Promise, SIDE_PX, agreement, array_of_rgb, rust_crates, size_of, square};
use crate::peer::Array;
use crate::results::{Agreement, Row};
use crate::trapezium::Trapezium;

/// Division into bins, as in the method and in the peer's loop.
pub const BINS: HueSaturationBins = HueSaturationBins { hue: 32, saturation: 32 };
/// Share of the pixels that must be within a grey level of OpenCV's.
const NEAR_SHARE: f64 = 0.999;

pub fn rows(bench: &mut Bench<'_>) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for side_px in [SIDE_PX, SIDE_PX / 2] {
        rows.extend(warp(bench, side_px)?);
        rows.extend(ground(bench, side_px)?);
    }
    let picture = square(&bench.frames[0], SIDE_PX);
    rows.extend(luma(bench, &picture)?);
    rows.extend(hues(bench, &picture)?);
    Ok(rows)
}

/// The peer's ground view: a table, its maps for OpenCV, and a title's size.
fn ground_view(frame: &RgbImage, side_px: usize) -> Result<(WarpTable, [Array; 3], String)> {
    let (width, height) = frame.size();
    let trapezium = Trapezium::new((width, height), side_px)?;
    let table = WarpTable::new(side_px, side_px, width, height, |column, row| trapezium.place(column, row))?;
    Ok((table, trapezium.maps(), format!("{height}p to {side_px}")))
}

/// The share of seen pixels that are near OpenCV's; unseen ones show nothing.
fn near_where_seen(table: &WarpTable, ours: &[u8], theirs: &[u8], channels: usize) -> Agreement {
    let seen = table.validity().plane().as_slice();
    let values = ours.chunks_exact(channels).zip(theirs.chunks_exact(channels)).zip(seen);
    let pixels = values.filter(|(_, seen)| **seen != 0);
    let (mut near, mut all) = (0, 0);
    for ((ours, theirs), _) in pixels {
        all += 1;
        near += usize::from(ours.iter().zip(theirs).all(|(a, b)| a.abs_diff(*b) <= 1));
    }
    agreement::share_of(near, all, NEAR_SHARE, "within 1")
}

fn warp(bench: &mut Bench<'_>, side_px: usize) -> Result<Vec<Row>> {
    let frame = &bench.frames[0];
    let (table, [map_x, map_y, _], size) = ground_view(frame, side_px)?;
    let inputs = [array_of_rgb(frame), map_x, map_y];
    let theirs = bench.opencv_gives("remap", &json!({}), &inputs)?;
    let kernel = Kernel {
        what: "ground view, colour (remap)",
        size: &size,
        promise: Promise::EVERY,
        fresh: RgbImage::new(side_px, side_px),
        work: &|colour| Ok(table.warp_rgb(frame, colour)?),
        compare: &|colour| {
            Ok(near_where_seen(&table, colour.as_slice(), theirs[0].u8s(), RgbImage::CHANNELS))
        },
    };
    let others = rust_crates::remaps(frame, [&inputs[1].f32s(), &inputs[2].f32s()], side_px);
    bench.rows(&kernel, others)
}

fn ground(bench: &mut Bench<'_>, side_px: usize) -> Result<Vec<Row>> {
    let frame = &bench.frames[0];
    let (table, [map_x, map_y, _], size) = ground_view(frame, side_px)?;
    let division = BinDivision::new(BINS)?;
    let fresh = (
        RgbImage::new(side_px, side_px),
        Plane::new(side_px, side_px, 0_u8),
        Plane::new(side_px, side_px, 0_u16),
    );
    let theirs = bench.opencv_gives("ground", &json!({}), &[array_of_rgb(frame), map_x, map_y])?;
    let kernel = Kernel {
        what: "ground view, colour, grey, bin (remap, 2 cvtColor)",
        size: &size,
        promise: Promise::EVERY,
        fresh,
        work: &|(colour, luma, bin)| Ok(table.warp_ground(frame, &division, colour, luma, bin)?),
        compare: &|(_, luma, _)| Ok(near_where_seen(&table, luma.as_slice(), theirs[2].u8s(), 1)),
    };
    bench.rows(&kernel, Vec::new())
}

fn luma(bench: &mut Bench<'_>, picture: &RgbImage) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("grey", &json!({}), &[array_of_rgb(picture)])?;
    let kernel = Kernel {
        what: "grey (cvtColor)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh: Plane::new(SIDE_PX, SIDE_PX, 0),
        work: &|luma| Ok(grey(picture, luma)?),
        compare: &|luma| Ok(agreement::within(luma.as_slice(), theirs[0].u8s(), 1, 1.0)),
    };
    bench.rows(&kernel, rust_crates::greys(picture))
}

fn hues(bench: &mut Bench<'_>, picture: &RgbImage) -> Result<Vec<Row>> {
    let theirs = bench.opencv_gives("hsv", &json!({}), &[array_of_rgb(picture)])?;
    let (pixels, _) = theirs[0].u8s().as_chunks::<3>();
    let fresh = (Plane::new(SIDE_PX, SIDE_PX, 0), Plane::new(SIDE_PX, SIDE_PX, 0));
    let kernel = Kernel {
        what: "hue and saturation (cvtColor)",
        size: &size_of(SIDE_PX),
        promise: Promise::EVERY,
        fresh,
        work: &|(hue, saturation)| Ok(hue_saturation(picture, hue, saturation)?),
        compare: &|(hue, saturation)| {
            let ours = hue.as_slice().iter().zip(saturation.as_slice());
            let near = ours.zip(pixels).filter(|((hue, saturation), [h, s, _])| {
                let apart = hue.abs_diff(*h);
                apart.min(180 - apart.min(180)) <= 1 && saturation.abs_diff(*s) <= 1
            });
            Ok(agreement::share_of(near.count(), SIDE_PX * SIDE_PX, 1.0, "within 1"))
        },
    };
    bench.rows(&kernel, Vec::new())
}
