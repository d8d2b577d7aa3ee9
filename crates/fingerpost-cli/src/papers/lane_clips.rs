//! Paper 3's measures (IV-B) on simulated clips of marked roads: accuracy by region of interest and threshold.
//!
//! The lane finder is the program's with its default settings. It follows the paper's stages and goes beyond them, so that the
//! figures say what becomes of the paper's claims here, not what its own program would do.

use anyhow::Result;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_eval::{LaneMeasure, evaluate_lanes};
use fingerpost_papers::claims::{Measured, cell_name};
use fingerpost_record::{FrameTime, frame_record};
use fingerpost_sim::{
    Conditions, DrivingManner, DrivingPlan, RoadCourse, SimConfig, Simulator, windscreen_camera,
};

use crate::interrupt::Interrupt;

/// The paper's pictures (III: "480x640 at the frame rate of 30fps").
const PICTURE_PX: [u32; 2] = [640, 480];
const FPS: f64 = 30.0;
/// Length of a clip: five seconds, so that a hundred metres of a line pass at 20 m/s, and a dozen of its gaps.
const FRAMES: usize = 150;
/// Speed, m/s: a country road's.
const SPEED_MPS: f64 = 20.0;
/// The clip's first place on its road, and the road beyond its end, as far as lines are seen, metres.
const START_M: f64 = 5.0;
const END_GAP_M: f64 = 150.0;

/// Measures the clip of a seed on the day of that name; none when it was interrupted.
pub(super) fn measure(
    sample: &str,
    seed: u64,
    frames: usize,
    interrupt: &Interrupt,
) -> Result<Option<Measured>> {
    let frames = frames.min(FRAMES);
    let length_m = frames as f64 / FPS * SPEED_MPS;
    let road = RoadCourse::country(seed, START_M + length_m + END_GAP_M);
    let (graph, route) = road.roads()?;
    let to_m = START_M + length_m;
    let drawn = SimConfig {
        seed,
        fps: FPS,
        frames: Some(frames),
        conditions: Conditions::named(sample)?,
        cruise_speed_mps: SPEED_MPS,
        start_m: START_M,
        end_gap_m: road.length_m() - to_m,
        driving: DrivingPlan::draw(DrivingManner::Keeping, seed, START_M, to_m, SPEED_MPS),
        ..SimConfig::default()
    };
    let [width, height] = PICTURE_PX.map(|side| side as usize);
    let camera = windscreen_camera(width, height)?;
    let simulator = Simulator::new(&graph, &route, &camera, &drawn)?;
    let mut pipeline = Pipeline::new(&Config::default(), &camera, None, None)?;
    let (mut records, mut truth) = (Vec::new(), Vec::new());
    for index in 0..simulator.frames() {
        if interrupt.wanted() {
            return Ok(None);
        }
        let frame = simulator.frame(index);
        let sensors = Sensors { dt_s: (index > 0).then_some(1.0 / FPS), ..Sensors::default() };
        let (output, evidence) = pipeline.step(&frame.picture, sensors, &mut |_| {})?;
        let time = FrameTime { frame: index as u64, t_s: index as f64 / FPS };
        records.push(frame_record(time, output, &evidence, &[], Default::default()));
        truth.push(frame.truth);
    }
    let evaluation = evaluate_lanes(&records, &truth, PICTURE_PX, &LaneMeasure::default())?;
    let cells = evaluation.cells.iter();
    Ok(Some(cells.map(|cell| (cell_name(cell.roi_rows, cell.threshold_px2), cell.accuracy_pct)).collect()))
}
