//! The whole method on a simulated drive: how long a frame takes, and how much longer one in a hundred.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::Result;
use fingerpost::{Config, Pipeline, Sensors, Stage};
use fingerpost_sim::{SimConfig, Simulator};
use fingerpost_vision::picture::RgbImage;

use crate::footage::{dashcam, town};
use crate::measure::{median, percentile};
use crate::results::{Figure, Section};

/// Frames of the drive: a minute, with junctions, side roads and bends.
const FRAMES: usize = 600;
/// Size of the pictures, pixels: the demo's.
const SIZE_PX: (usize, usize) = (640, 480);
/// Times that the drive is driven. Every time does the same work, so that the median of a frame's times is without what else
/// the machine did in one of them.
const DRIVES: usize = 3;
/// Longest that a frame is promised to take: in the median, and all but one in a hundred; milliseconds.
const PROMISED_MEDIAN_MS: f64 = 3.0;
const PROMISED_P99_MS: f64 = 7.5;
/// Largest ratio of the two that is promised.
const PROMISED_RATIO: f64 = 2.5;

/// Times of every frame, milliseconds, of the whole and of each stage; one a drive.
#[derive(Debug)]
struct Laps {
    whole_ms: Vec<Vec<f64>>,
    stages_ms: BTreeMap<Stage, Vec<Vec<f64>>>,
}

/// Times the method with its default settings.
pub fn whole_method() -> Result<Section> {
    let (graph, route) = town()?;
    let camera = dashcam(SIZE_PX.0, SIZE_PX.1)?;
    let drive = SimConfig::default();
    let simulator = Simulator::new(&graph, &route, &camera, &drive)?;
    let frames: Vec<RgbImage> =
        (0..FRAMES.min(simulator.frames())).map(|index| simulator.frame(index).picture).collect();
    let config = Config::default();
    let mut laps = Laps { whole_ms: vec![Vec::new(); frames.len()], stages_ms: BTreeMap::new() };
    for _ in 0..DRIVES {
        let mut pipeline = Pipeline::new(&config, &camera, Some(&route), Some(drive.start_m))?;
        for (index, frame) in frames.iter().enumerate() {
            let dt_s = (index > 0).then_some(1.0 / drive.fps);
            let start = Instant::now();
            let mut last = start;
            pipeline.step(frame, Sensors { dt_s, ..Sensors::default() }, &mut |stage| {
                let now = Instant::now();
                let of_stage = laps.stages_ms.entry(stage).or_insert_with(|| vec![Vec::new(); FRAMES]);
                of_stage[index].push(now.duration_since(last).as_secs_f64() * 1e3);
                last = Instant::now();
            })?;
            laps.whole_ms[index].push(start.elapsed().as_secs_f64() * 1e3);
        }
    }
    Ok(section(laps, frames.len()))
}

fn section(laps: Laps, frames: usize) -> Section {
    let mut section = Section::new(
        "Whole method",
        &format!(
            "one thread, without decoding; {frames} frames of the demo's drive at {} x {}; a frame's \
             time is the median of {DRIVES} drives",
            SIZE_PX.0, SIZE_PX.1
        ),
    );
    let [median_ms, p99_ms] = of_frames(laps.whole_ms);
    let mut add = |what: String, value: f64, unit: &'static str, promised_most: Option<f64>| {
        section.figures.push(Figure { what, value, unit, promised_most });
    };
    add("frame, median".to_owned(), median_ms, "ms", Some(PROMISED_MEDIAN_MS));
    add("frame, 99th percentile".to_owned(), p99_ms, "ms", Some(PROMISED_P99_MS));
    let ratio = p99_ms / median_ms;
    add("99th percentile over the median".to_owned(), ratio, "", Some(PROMISED_RATIO));
    for (stage, times_ms) in laps.stages_ms {
        let [median_ms, p99_ms] = of_frames(times_ms);
        add(format!("stage {stage:?}, median"), median_ms, "ms", None);
        add(format!("stage {stage:?}, 99th percentile"), p99_ms, "ms", None);
    }
    section
}

/// Median and 99th percentile over the frames that have times.
fn of_frames(times_ms: Vec<Vec<f64>>) -> [f64; 2] {
    let with_times = times_ms.into_iter().filter(|of_frame| !of_frame.is_empty());
    let mut each_ms: Vec<f64> = with_times.map(|mut of_frame| median(&mut of_frame)).collect();
    [median(&mut each_ms), percentile(&mut each_ms, 0.99)]
}
