//! `fingerpost demo`: a simulated drive through a small town, and the method on it.

use std::path::PathBuf;
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread;

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost::{Config, Sensors};
use fingerpost_io::RunFolder;
use fingerpost_map::{OsmData, RoadGraph, read_route};
use fingerpost_record::FrameTime;
use fingerpost_sim::{SimConfig, SimFrame, Simulator, TOWN_OSM, TOWN_ROUTE};
use rayon::prelude::*;

use crate::arguments::PictureSize;
use crate::driver::{Driver, RunSetting, Sequence};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::overlap::{self, Overlap};
use crate::recorder::{Pictures, Recorder, RecordingWish, RunEnd, Subject, Wishes};
use crate::simulate::{Lens, default_camera};
use crate::{facts, made_from, output};

/// Simulate a drive through a small town and run the method on it: nothing else is needed. Writes a run folder; the
/// truth is only used to measure the results.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "demo",
    "demo --out results --json"
))]
pub(crate) struct DemoArgs {
    /// Folder to write: a new or empty one, or one of an earlier run, whose results are replaced.
    #[arg(long, value_name = "DIR", default_value = "fingerpost-demo")]
    out: PathBuf,
    /// Print what summary.json holds on standard output.
    #[arg(long)]
    json: bool,
}

/// Picture size of a small dashcam.
const SIZE: PictureSize = PictureSize { width: 640, height: 480 };
/// Rendered frames that may wait for the method: enough to even out slow ones.
const WAITING_FRAMES: usize = 8;

/// Every so many frames one is written with all that was seen in it: one in five seconds.
const PICTURE_EVERY_FRAMES: u64 = 50;

/// Simulates, runs and reports.
pub(crate) fn demo(args: &DemoArgs) -> Result<()> {
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN_OSM)?)?;
    let route = read_route(TOWN_ROUTE)?;
    let camera = default_camera(SIZE, Lens::None)?;
    let sim_config = SimConfig::default();
    let simulator = Simulator::new(&graph, &route, &camera, &sim_config)?;
    let setting = RunSetting {
        config: &Config::default(),
        camera: &camera,
        route: Some(&route),
        start_m: Some(sim_config.start_m),
        sequence: Sequence::Drive,
    };
    let wishes = Wishes {
        title: "Fingerpost demo: a simulated drive through Mauren".to_owned(),
        pictures: Pictures::Every(PICTURE_EVERY_FRAMES),
        video: None,
        recording: RecordingWish::Mcap,
        live: None,
    };
    log::info!("the town: {}", facts::of_roads(&graph));
    log::info!("the drive: {}", facts::of_route(&route));
    log::info!("the vehicle's {}", facts::of_camera(&camera));
    log::info!("drive of {} frames, simulated with seed {}", simulator.frames(), sim_config.seed);
    let frames = Some(simulator.frames() as u64);
    let mut driver = Driver::new(setting, &wishes, frames)?;
    let bar = output::progress(frames, "frames");
    let made_from = vec![
        ("command", made_from::command_line(std::env::args_os())),
        ("camera", facts::of_camera(&camera)),
        ("map", facts::of_roads(&graph)),
        ("route", facts::of_route(&route)),
    ];
    let subject = Subject { made_from, ..driver.subject(setting)? };
    let mut recorder = Recorder::create(RunFolder::create(&args.out)?, subject, wishes, bar)?;
    let interrupt = Interrupt::listen()?;
    let mut truth = Vec::with_capacity(simulator.frames());
    let (sender, receiver) = sync_channel(WAITING_FRAMES);
    let followed: Result<()> = thread::scope(|scope| {
        scope.spawn(|| render(&simulator, sender));
        // The receiver ends with the closure, and with it the rendering, however the loop ends.
        let receiver: Receiver<SimFrame> = receiver;
        let rendered = receiver.iter().take_while(|_| !interrupt.wanted()).enumerate();
        let results = rendered.map(|(index, frame)| {
            let time = FrameTime { frame: index as u64, t_s: index as f64 / sim_config.fps };
            truth.push(frame.truth);
            driver.step(time, &frame.picture, Sensors::default())
        });
        overlap::each(Overlap::Writing, results, |result| recorder.add(result))
    });
    let frames = recorder.frames();
    let complete = followed.is_ok() && frames == simulator.frames() as u64;
    let summary =
        recorder.finish(if complete { RunEnd::Complete } else { RunEnd::Interrupted }, None, Some(&truth));
    followed.with_context(|| format!("the demo ended after {frames} frames"))?;
    if interrupt.wanted() {
        bail!("interrupted after {frames} frames; results so far are in {}", args.out.display());
    }
    let summary = summary?;
    output::print_summary(&summary, &[], &args.out);
    if args.json { output::print_json(&summary) } else { Ok(()) }
}

/// Renders the drive in its order, as fast as frames are taken; ends with the drive or when nobody takes them any more.
fn render(simulator: &Simulator, sender: SyncSender<SimFrame>) {
    let at_once = rayon::current_num_threads();
    for first in (0..simulator.frames()).step_by(at_once) {
        let batch = first..simulator.frames().min(first + at_once);
        let frames: Vec<SimFrame> = batch.into_par_iter().map(|index| simulator.frame(index)).collect();
        for frame in frames {
            if sender.send(frame).is_err() {
                return;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_map::{ArmRole, FeatureKind, RouteFeature};

    use super::*;

    /// Sides of the arms that the route passes by: positive left, seen along the exit.
    fn passed_sides(feature: &RouteFeature) -> Vec<f64> {
        let exit = feature.arms.iter().find(|arm| arm.role == ArmRole::Exit).unwrap();
        let sides = feature.arms.iter().filter(|arm| arm.role == ArmRole::Side);
        sides.map(|side| libm::sin(side.bearing_rad - exit.bearing_rad)).collect()
    }

    #[test]
    fn the_demo_has_every_kind_of_feature() {
        let features = read_route(TOWN_ROUTE).unwrap().features;
        assert!(features.len() >= 8);
        let has = |wanted: &dyn Fn(&RouteFeature) -> bool| features.iter().any(wanted);
        assert!(has(&|f| f.kind == FeatureKind::Junction && f.arms.len() == 3 && f.turn_rad > 1.0), "left T");
        assert!(
            has(&|f| f.kind == FeatureKind::Junction && f.arms.len() == 3 && f.turn_rad < -1.0),
            "right T"
        );
        assert!(has(&|f| f.kind == FeatureKind::SideRoad && passed_sides(f)[0] > 0.0), "side road left");
        assert!(has(&|f| f.kind == FeatureKind::SideRoad && passed_sides(f)[0] < 0.0), "side road right");
        assert!(has(&|f| f.arms.len() == 4), "crossroads");
        assert!(has(&|f| f.kind == FeatureKind::Bend), "bend");
    }
}
