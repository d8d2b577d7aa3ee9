//! How the loop's rate grows and shrinks with the width of the picture and the size of the ground view.

use anyhow::Result;
use fingerpost_vision::picture::RgbImage;
use fingerpost_vision::warp::WarpTable;

use crate::footage::Footage;
use crate::measure::{Effort, median};
use crate::results::{Figure, Section};
use crate::trapezium::Trapezium;
use crate::whole_loop::Loop;

/// Widths of the picture, pixels: from those of the papers to those of today's dashcams.
const WIDTHS_PX: [usize; 8] = [150, 256, 384, 512, 640, 768, 960, 1024];
/// Side of the ground view while the picture's width changes, pixels.
const SIDE_PX: usize = 256;
/// Sides of the ground view for the footage's own width, pixels.
const SIDES_PX: [usize; 6] = [128, 192, 256, 384, 512, 768];

/// Frames a second of the whole loop, without decoding.
pub fn growth(effort: Effort, footage: &Footage) -> Result<Section> {
    let mut section =
        Section::new("Growth", "frames a second of the whole loop on one thread, without decoding");
    for width in WIDTHS_PX {
        let frames: Vec<RgbImage> =
            footage.frames.iter().map(|frame| resized(frame, width)).collect::<Result<_>>()?;
        section.figures.push(rate(effort, &frames, SIDE_PX)?);
    }
    for side_px in SIDES_PX {
        section.figures.push(rate(effort, &footage.frames, side_px)?);
    }
    Ok(section)
}

fn rate(effort: Effort, frames: &[RgbImage], side_px: usize) -> Result<Figure> {
    let (width, height) = frames[0].size();
    let mut work = Loop::new(&Trapezium::new((width, height), side_px)?)?;
    let mut times_ms = Vec::new();
    for frame in frames.iter().cycle().take(effort.rounds * frames.len()) {
        times_ms.push(work.step(frame)?.iter().sum());
    }
    Ok(Figure {
        what: format!("picture {width} x {height}, ground view {side_px} x {side_px}"),
        value: 1e3 / median(&mut times_ms),
        unit: "frames/s",
        promised: None,
    })
}

/// The frame at another width, its shape kept.
fn resized(frame: &RgbImage, width: usize) -> Result<RgbImage> {
    let scale = frame.width() as f64 / width as f64;
    let height = (frame.height() as f64 / scale).round() as usize;
    let place = |x: usize, y: usize| {
        let clamp = |value: f64, length: usize| value.clamp(0.0, length as f64 - 1.0);
        Some([
            clamp((x as f64 + 0.5) * scale - 0.5, frame.width()),
            clamp((y as f64 + 0.5) * scale - 0.5, frame.height()),
        ])
    };
    let table = WarpTable::new(width, height, frame.width(), frame.height(), place)?;
    let mut resized = RgbImage::new(width, height);
    table.warp_rgb(frame, &mut resized)?;
    Ok(resized)
}
