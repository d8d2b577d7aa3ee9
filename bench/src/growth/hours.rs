//! A long drive: what a frame costs late in it.

use anyhow::{Context, Result};
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_sim::{SimConfig, Simulator};
use fingerpost_vision::picture::RgbImage;

use super::cost::{Cost, Growth, Powers};
use crate::footage::{dashcam, town};
use crate::measure::{median, processor_ms};

/// Lengths of the drive at which its costs are taken, hours.
const HOURS: [f64; 4] = [0.1, 0.5, 2.0, 10.0];
/// Frames a second of it, and the size of its pictures and of the ground view's pixels: few and coarse, so that ten hours pass in
/// two minutes. Its metres and seconds, with which something could grow, are all there, and 72,000 frames.
const FPS: f64 = 2.0;
const SIZE_PX: (usize, usize) = (160, 120);
const METRES_PER_PIXEL: f64 = 0.1;
/// Frames that it is made of, over and over: a minute.
const FRAMES: usize = 120;
/// Frames before each of the lengths whose median counts.
const TIMED: usize = 600;

/// Neither time nor memory of a frame grows with the length of the drive.
pub fn hours() -> Result<Growth> {
    let frames = frames()?;
    let mut costs = Vec::new();
    let mut pipeline = None;
    let (mut held_bytes, mut done) = (0_i64, 0_usize);
    for hours in HOURS {
        let until = (3_600.0 * hours * FPS) as usize;
        let mut laps_ms = Vec::with_capacity(until - done);
        let mut went = Ok(());
        let taken = allocation_counter::measure(|| {
            went = drive(&mut pipeline, &frames, done..until, &mut laps_ms);
        });
        went?;
        held_bytes += taken.bytes_current;
        let late = laps_ms.len().saturating_sub(TIMED);
        costs.push(Cost { size: hours, ms: median(&mut laps_ms[late..]), bytes: held_bytes as f64 });
        done = until;
    }
    let what = "frame of the whole method, by the hours driven before it";
    Ok(Growth::new(what, "h", costs, Powers { ms: 0.0, bytes: 0.0 }))
}

fn drive(
    pipeline: &mut Option<Pipeline>,
    frames: &[RgbImage],
    indices: std::ops::Range<usize>,
    laps_ms: &mut Vec<f64>,
) -> Result<()> {
    if pipeline.is_none() {
        let mut config = Config::default();
        config.ground_view.metres_per_pixel = METRES_PER_PIXEL;
        *pipeline = Some(Pipeline::new(&config, &dashcam(SIZE_PX.0, SIZE_PX.1)?, None, None)?);
    }
    let pipeline = pipeline.as_mut().context("no pipeline was made")?;
    for index in indices {
        let sensors = Sensors { dt_s: Some(1.0 / FPS), ..Sensors::default() };
        let start_ms = processor_ms();
        pipeline.step(&frames[index % frames.len()], sensors, &mut |_stage| ())?;
        laps_ms.push(processor_ms() - start_ms);
    }
    Ok(())
}

fn frames() -> Result<Vec<RgbImage>> {
    let (graph, route) = town()?;
    let world = SimConfig { fps: FPS, ..SimConfig::default() };
    let simulator = Simulator::new(&graph, &route, &dashcam(SIZE_PX.0, SIZE_PX.1)?, &world)?;
    Ok((0..FRAMES.min(simulator.frames())).map(|index| simulator.frame(index).picture).collect())
}
