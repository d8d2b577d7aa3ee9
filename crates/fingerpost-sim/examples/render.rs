//! Renders a drive and says how long a frame takes:
//! `render OUT [CONDITIONS [WxH [EVERY [MAP LAT,LON LAT,LON...|highway|country [MANNER]]]]]`.
//!
//! Every EVERYth frame goes to `OUT/NNNNNN.png`, its mask of the road to `OUT/NNNNNN_road.png` and the edges of the lane to
//! `OUT/NNNNNN_lane.png`. Without a map the drive is the one of the tests; on a highway or a country road it is driven in a
//! manner (keeping, drifting, changing, stopping) and seen from the windscreen.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "a tool to look at pictures with")]

#[path = "../tests/common/mod.rs"]
mod common;

use std::path::Path;
use std::time::Instant;

use fingerpost_geometry::Distortion;
use fingerpost_map::{FeatureOptions, LatLon, OsmData, RoadGraph, plan};
use fingerpost_sim::{
    Conditions, DrivingManner, DrivingPlan, RoadCourse, SimConfig, Simulator, windscreen_camera,
};

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
    let (width, height): (usize, usize) = (width.parse().unwrap(), height.parse().unwrap());
    let mut camera = common::camera(width, height, Distortion::None);
    let mut config = SimConfig { conditions, ..SimConfig::default() };
    let (graph, route) = match args.get(4).map(String::as_str) {
        Some(kind @ ("highway" | "country")) => {
            const LENGTH_M: f64 = 2000.0;
            let is_highway = kind == "highway";
            let course =
                if is_highway { RoadCourse::highway(1, LENGTH_M) } else { RoadCourse::country(1, LENGTH_M) };
            camera = windscreen_camera(width, height).unwrap();
            config.cruise_speed_mps = if is_highway { 30.0 } else { 20.0 };
            config.end_gap_m = 150.0;
            let manner = match word(5, "keeping").as_str() {
                "drifting" => DrivingManner::Drifting,
                "changing" => DrivingManner::Changing,
                "stopping" => DrivingManner::Stopping,
                _ => DrivingManner::Keeping,
            };
            config.driving = DrivingPlan::draw(manner, 1, 5.0, LENGTH_M, config.cruise_speed_mps);
            course.roads().unwrap()
        }
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
        for [u, v] in truth.lane_left_px.iter().chain(&truth.lane_right_px) {
            let first = 3 * (v.round() as usize * w + u.round() as usize);
            frame.picture.as_mut_slice()[first..first + 3].copy_from_slice(&[255, 0, 0]);
        }
        write_png(&path("_lane"), w, h, png::ColorType::Rgb, frame.picture.as_slice());
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
    for crossing in simulator.crossings() {
        println!("{crossing:?}");
    }
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
