//! The ground view: resampling and colours.

use anyhow::Result;
use fingerpost_vision::colour::{BinDivision, HueSaturationBins, grey, hue_saturation};
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::warp::WarpTable;
use serde_json::json;

use super::{Bench, PROMISED, SIDE_PX, agreement, array_of_rgb, rust_crates, size_of, square};
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
        rows.push(warp(bench, side_px)?);
        rows.push(ground(bench, side_px)?);
    }
    let picture = square(&bench.frames[0], SIDE_PX);
    rows.push(luma(bench, &picture)?);
    rows.push(hues(bench, &picture)?);
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

fn warp(bench: &mut Bench<'_>, side_px: usize) -> Result<Row> {
    let frame = &bench.frames[0];
    let (table, [map_x, map_y, _], size) = ground_view(frame, side_px)?;
    let mut colour = RgbImage::new(side_px, side_px);
    table.warp_rgb(frame, &mut colour)?;
    let inputs = [array_of_rgb(frame), map_x, map_y];
    let theirs = bench.opencv_gives("remap", &json!({}), &inputs)?;
    let agreement = near_where_seen(&table, colour.as_slice(), theirs[0].u8s(), RgbImage::CHANNELS);
    let others = rust_crates::remaps(frame, [&inputs[1].f32s(), &inputs[2].f32s()], side_px);
    let work = || {
        let _ = table.warp_rgb(frame, &mut colour);
    };
    bench.row(("ground view, colour (remap)", &size), Some(PROMISED), agreement, work, others)
}

fn ground(bench: &mut Bench<'_>, side_px: usize) -> Result<Row> {
    let frame = &bench.frames[0];
    let (table, [map_x, map_y, _], size) = ground_view(frame, side_px)?;
    let division = BinDivision::new(BINS)?;
    let mut colour = RgbImage::new(side_px, side_px);
    let mut luma = Plane::new(side_px, side_px, 0_u8);
    let mut bin = Plane::new(side_px, side_px, 0_u16);
    table.warp_ground(frame, &division, &mut colour, &mut luma, &mut bin)?;
    let theirs = bench.opencv_gives("ground", &json!({}), &[array_of_rgb(frame), map_x, map_y])?;
    let agreement = near_where_seen(&table, luma.as_slice(), theirs[2].u8s(), 1);
    let work = || {
        let _ = table.warp_ground(frame, &division, &mut colour, &mut luma, &mut bin);
    };
    let title = ("ground view, colour, grey and bin in one (remap, cvtColor twice)", size.as_str());
    bench.row(title, Some(PROMISED), agreement, work, Vec::new())
}

fn luma(bench: &mut Bench<'_>, picture: &RgbImage) -> Result<Row> {
    let mut luma = Plane::new(SIDE_PX, SIDE_PX, 0);
    grey(picture, &mut luma)?;
    let theirs = bench.opencv_gives("grey", &json!({}), &[array_of_rgb(picture)])?;
    let agreement = agreement::within(luma.as_slice(), theirs[0].u8s(), 1, 1.0);
    let work = || {
        let _ = grey(picture, &mut luma);
    };
    let others = rust_crates::greys(picture);
    bench.row(("grey (cvtColor)", &size_of(SIDE_PX)), Some(PROMISED), agreement, work, others)
}

fn hues(bench: &mut Bench<'_>, picture: &RgbImage) -> Result<Row> {
    let mut hue = Plane::new(SIDE_PX, SIDE_PX, 0);
    let mut saturation = Plane::new(SIDE_PX, SIDE_PX, 0);
    hue_saturation(picture, &mut hue, &mut saturation)?;
    let theirs = bench.opencv_gives("hsv", &json!({}), &[array_of_rgb(picture)])?;
    let (pixels, _) = theirs[0].u8s().as_chunks::<3>();
    let ours = hue.as_slice().iter().zip(saturation.as_slice());
    let near = ours.zip(pixels).filter(|((hue, saturation), [h, s, _])| {
        let apart = hue.abs_diff(*h);
        apart.min(180 - apart.min(180)) <= 1 && saturation.abs_diff(*s) <= 1
    });
    let agreement = agreement::share_of(near.count(), SIDE_PX * SIDE_PX, 1.0, "within 1");
    let work = || {
        let _ = hue_saturation(picture, &mut hue, &mut saturation);
    };
    let title = ("hue and saturation (cvtColor)", &*size_of(SIDE_PX));
    bench.row(title, Some(PROMISED), agreement, work, Vec::new())
}
