//! The whole method on a simulated drive: which features come, how far ahead, and how far that is from the truth.
//!
//!     cargo run --release -p fingerpost --example simulated_drive

// An example is a program, whose output is for a person.
#![allow(clippy::print_stdout)]

use std::error::Error;

use fingerpost::geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost::map::{OsmData, RoadGraph, read_route};
use fingerpost::track::State;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_sim::{SimConfig, Simulator};

/// Mauren in Liechtenstein. Map data © OpenStreetMap contributors, ODbL 1.0.
const TOWN: &[u8] = include_bytes!("../../fingerpost-sim/assets/town.osm");
const ROUTE: &str = include_str!("../../fingerpost-sim/assets/town_route.geojson");

fn main() -> Result<(), Box<dyn Error>> {
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN)?)?;
    let route = read_route(ROUTE)?;
    let intrinsics = Intrinsics { fx: 280.0, fy: 280.0, cx: 159.5, cy: 119.5 };
    let mount = Mount { pitch_rad: 0.1, x_m: 1.5, ..Mount::level(1.4) };
    let camera = Camera::calibrated(320, 240, intrinsics, Distortion::None, mount)?;
    let world = SimConfig { frames: Some(330), ..SimConfig::default() };
    let simulator = Simulator::new(&graph, &route, &camera, &world)?;
    let mut pipeline = Pipeline::new(&Config::default(), &camera, Some(&route), Some(world.start_m))?;
    let mut before = State::default();
    let mut errors_m = Vec::new();
    for index in 0..simulator.frames() {
        let frame = simulator.frame(index);
        let sensors = Sensors { dt_s: (index > 0).then_some(1.0 / world.fps), ..Sensors::default() };
        let (output, _evidence) = pipeline.step(&frame.picture, sensors, &mut |_stage| ())?;
        if output.track.state != before {
            before = output.track.state;
            println!("frame {index}: {}", output.why);
        }
        let found = output.track.followed.as_ref().map(|f| f.vehicle_from_feature.translation.vector.x);
        errors_m
            .extend(found.zip(frame.truth.feature_forward_m).map(|(found, true_m)| (found - true_m).abs()));
    }
    errors_m.sort_by(f64::total_cmp);
    let median_m = errors_m.get(errors_m.len() / 2).ok_or("no feature was followed")?;
    println!("{} frames with a feature, its distance {median_m:.2} m off in the median", errors_m.len());
    Ok(())
}
