//! Renders a drive and says how long a frame takes: `render OUT [CONDITIONS [WxH [EVERY [MAP LAT,LON LAT,LON...]]]]`.
//!
//! Every EVERYth frame goes to `OUT/NNNNNN.png`, its mask of the road to `OUT/NNNNNN_road.png`. Without a map the drive
//! is the one of the tests.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a tool to look at pictures with")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::Path;
use std::time::Instant;

use fingerpost_geometry::Distortion;
use fingerpost_map::{FeatureOptions, LatLon, OsmData, RoadGraph, plan};
use fingerpost_sim::{Conditions, SimConfig, Simulator};

/// Each frame is timed so often and the fastest counts, so that other work on the machine does not.
const REPEATS: usize = 5;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let word = |i: usize, default: &str| args.get(i).cloned().unwrap_or_else(|| default.to_owned());
    let out = word(0, "frames");
    let conditions = Conditions::named(&word(1, "clear")).unwrap();
    let size = word(2, "640x480");
    let (width, height) = size.split_once('x').unwrap();
    let every: usize = word(3, "10").parse().unwrap();
    let (graph, route) = match args.get(4) {
        Some(map) => {
            let graph =
                RoadGraph::from_osm(&OsmData::from_bytes(&std::fs::read(map).unwrap()).unwrap()).unwrap();
            let stops: Vec<LatLon> = args[5..].iter().map(|stop| place(stop)).collect();
            let route = plan(&graph, &stops, &FeatureOptions::default()).unwrap();
            (graph, route)
        }
        None => {
            let graph = common::graph();
            let route = common::route(&graph);
            (graph, route)
        }
    };
    let camera = common::camera(width.parse().unwrap(), height.parse().unwrap(), Distortion::None);
    let config = SimConfig { conditions, ..SimConfig::default() };
    let start = Instant::now();
    let simulator = Simulator::new(&graph, &route, &camera, &config).unwrap();
    println!("{} frames, ready after {:.2} s", simulator.frames(), start.elapsed().as_secs_f64());
    std::fs::create_dir_all(&out).unwrap();
    let mut milliseconds = Vec::new();
    for index in (0..simulator.frames()).step_by(every) {
        let (mut frame, mut fastest) = (simulator.frame(index), f64::INFINITY);
        for _ in 0..REPEATS {
            let start = Instant::now();
            frame = simulator.frame(index);
            fastest = fastest.min(1e3 * start.elapsed().as_secs_f64());
        }
        milliseconds.push(fastest);
        let (w, h) = frame.picture.size();
        let path = |end: &str| Path::new(&out).join(format!("{index:06}{end}.png"));
        write_png(&path(""), w, h, png::ColorType::Rgb, frame.picture.as_slice());
        write_png(&path("_road"), w, h, png::ColorType::Grayscale, frame.road.as_slice());
        let truth = frame.truth;
        println!(
            "{index:6} ({:7.2}, {:7.2}) m, {:6.1} deg, {:.2} m/s, feature {:?} {:?} m ahead",
            truth.x_m,
            truth.y_m,
            truth.heading_rad.to_degrees(),
            truth.speed_mps,
            truth.feature_id,
            truth.feature_forward_m.map(f64::round)
        );
    }
    milliseconds.sort_by(f64::total_cmp);
    println!("{:.1} ms a frame (median)", milliseconds[milliseconds.len() / 2]);
}

fn place(text: &str) -> LatLon {
    let (lat, lon) = text.split_once(',').unwrap();
    LatLon::new(lat.parse().unwrap(), lon.parse().unwrap()).unwrap()
}

fn write_png(path: &Path, width: usize, height: usize, colour: png::ColorType, bytes: &[u8]) {
    let file = std::io::BufWriter::new(std::fs::File::create(path).unwrap());
    let mut encoder = png::Encoder::new(file, width as u32, height as u32);
    encoder.set_color(colour);
    encoder.write_header().unwrap().write_image_data(bytes).unwrap();
}
