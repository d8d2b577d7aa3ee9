//! The loop against the picture's width and the ground view's side, and the whole method against its reach.

use anyhow::Result;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_vision::picture::RgbImage;
use fingerpost_vision::warp::WarpTable;

use super::cost::{Cost, Growth, Powers};
use crate::footage::Footage;
use crate::measure::{Effort, median, processor_ms};
use crate::trapezium::Trapezium;
use crate::whole_loop::Loop;

/// Widths of the picture, pixels: from those of the papers to those of today's cameras.
const WIDTHS_PX: [usize; 6] = [150, 256, 480, 640, 960, 1920];
/// Side of the ground view while the picture's width changes, pixels.
const SIDE_PX: usize = 256;
/// Sides of the ground view for the footage's own width, pixels.
const SIDES_PX: [usize; 4] = [128, 256, 512, 1024];
/// Far edges of the ground view, metres.
const REACHES_M: [f64; 4] = [20.0, 30.0, 40.0, 60.0];
/// Frames that fill what is kept from frame to frame, before any is timed.
const FIRST_FRAMES: usize = 5;

/// A frame of the loop grows no faster than the picture.
pub fn widths(effort: Effort, footage: &Footage) -> Result<Growth> {
    let mut costs = Vec::new();
    for width in WIDTHS_PX {
        let frames: Vec<RgbImage> =
            footage.frames.iter().map(|frame| resized(frame, width)).collect::<Result<_>>()?;
        costs.push(of_loop(effort, &frames, SIDE_PX, width)?);
    }
    let what = format!("frame of the loop, ground view {SIDE_PX} px, by the picture's width");
    Ok(Growth::new(&what, "px", costs, Powers { ms: 2.0, bytes: 2.0 }))
}

/// A frame of the loop grows no faster than the ground view.
pub fn sides(effort: Effort, footage: &Footage) -> Result<Growth> {
    let mut costs = Vec::new();
    for side_px in SIDES_PX {
        costs.push(of_loop(effort, &footage.frames, side_px, side_px)?);
    }
    let what = format!("frame of the loop, picture {} px, by the ground view's side", footage.size().0);
    Ok(Growth::new(&what, "px", costs, Powers { ms: 2.0, bytes: 2.0 }))
}

/// A frame of the whole method grows no faster than the length of ground that it sees.
pub fn reaches(effort: Effort, footage: &Footage) -> Result<Growth> {
    let mut costs = Vec::new();
    for far_m in REACHES_M {
        let mut config = Config::default();
        config.ground_view.far_m = far_m;
        let mut made = None;
        let taken = allocation_counter::measure(|| made = Some(started(&config, footage)));
        let Some(pipeline) = made else { continue };
        let ms = frame_ms(effort, &mut pipeline?, footage)?;
        costs.push(Cost { size: far_m, ms, bytes: taken.bytes_max as f64 });
    }
    let what = "frame of the whole method without a route, by the view's reach";
    Ok(Growth::new(what, "m", costs, Powers { ms: 1.0, bytes: 1.0 }))
}

/// The median processor time of a frame, milliseconds.
pub fn frame_ms(effort: Effort, pipeline: &mut Pipeline, footage: &Footage) -> Result<f64> {
    let mut laps_ms = Vec::new();
    for frame in footage.frames.iter().cycle().take(effort.rounds * footage.frames.len()) {
        let start_ms = processor_ms();
        pipeline.step(frame, Sensors::default(), &mut |_stage| ())?;
        laps_ms.push(processor_ms() - start_ms);
    }
    Ok(median(&mut laps_ms))
}

fn started(config: &Config, footage: &Footage) -> Result<Pipeline> {
    let mut pipeline = Pipeline::new(config, &footage.camera, None, None)?;
    for frame in footage.frames.iter().take(FIRST_FRAMES) {
        pipeline.step(frame, Sensors::default(), &mut |_stage| ())?;
    }
    Ok(pipeline)
}

fn of_loop(effort: Effort, frames: &[RgbImage], side_px: usize, size: usize) -> Result<Cost> {
    let (width, height) = frames[0].size();
    let trapezium = Trapezium::new((width, height), side_px)?;
    let mut made = None;
    let taken = allocation_counter::measure(|| {
        made = Some(Loop::new(&trapezium).and_then(|mut work| {
            frames.iter().take(FIRST_FRAMES).try_for_each(|frame| work.step(frame).map(drop))?;
            Ok(work)
        }));
    });
    let Some(work) = made else { anyhow::bail!("the loop was not made") };
    let mut work = work?;
    let mut laps_ms = Vec::new();
    for frame in frames.iter().cycle().take(effort.rounds * frames.len()) {
        let start_ms = processor_ms();
        work.step(frame)?;
        laps_ms.push(processor_ms() - start_ms);
    }
    Ok(Cost { size: size as f64, ms: median(&mut laps_ms), bytes: taken.bytes_max as f64 })
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
