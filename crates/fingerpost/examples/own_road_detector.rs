//! A stage of one's own: a detector that takes whatever is as grey as the ground right ahead for road.
//!
//!     cargo run --release -p fingerpost --example own_road_detector

// An example is a program, whose output is for a person.
#![allow(clippy::print_stdout)]

use std::error::Error;

use fingerpost::geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost::map::{OsmData, RoadGraph, read_route};
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::{RoadDetector, RoadError, RoadEvidence, RoadInput};
use fingerpost::vision::picture::Plane;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_sim::{SimConfig, Simulator};

/// Mauren in Liechtenstein. Map data © OpenStreetMap contributors, ODbL 1.0.
const TOWN: &[u8] = include_bytes!("../../fingerpost-sim/assets/town.osm");
const ROUTE: &str = include_str!("../../fingerpost-sim/assets/town_route.geojson");

/// Road has the grey of the sample, to within some levels.
struct GreyOfTheSample {
    tolerance: u8,
}

impl RoadDetector for GreyOfTheSample {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let (grey, seen) = (&input.picture.grey, input.validity.plane());
        let rows = input.sample.y..input.sample.y + input.sample.height;
        let columns = input.sample.x..input.sample.x + input.sample.width;
        let mut sampled: Vec<u8> = rows.flat_map(|row| grey.row(row)[columns.clone()].to_vec()).collect();
        sampled.sort_unstable();
        let road = sampled.get(sampled.len() / 2).copied().unwrap_or(128);
        probability.reset(grey.width(), grey.height(), 0);
        for row in 0..grey.height() {
            let pixels = grey.row(row).iter().zip(seen.row(row));
            for (to, (grey, seen)) in probability.row_mut(row).iter_mut().zip(pixels) {
                let off = grey.abs_diff(road).min(2 * self.tolerance);
                *to = if *seen == 0 {
                    0
                } else {
                    255 - (255 * u16::from(off) / u16::from(2 * self.tolerance)) as u8
                };
            }
        }
        Ok(RoadEvidence { detector: "grey of the sample", sample: input.sample, ..RoadEvidence::default() })
    }

    fn reset(&mut self) {}
}

fn main() -> Result<(), Box<dyn Error>> {
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(TOWN)?)?;
    let route = read_route(ROUTE)?;
    let intrinsics = Intrinsics { fx: 280.0, fy: 280.0, cx: 159.5, cy: 119.5 };
    let mount = Mount { pitch_rad: 0.1, x_m: 1.5, ..Mount::level(1.4) };
    let camera = Camera::calibrated(320, 240, intrinsics, Distortion::None, mount)?;
    let world = SimConfig { frames: Some(60), ..SimConfig::default() };
    let simulator = Simulator::new(&graph, &route, &camera, &world)?;
    let parts =
        Parts { road_detector: Some(Box::new(GreyOfTheSample { tolerance: 12 })), ..Parts::default() };
    let start_m = Some(world.start_m);
    let mut pipeline = Pipeline::with_parts(&Config::default(), &camera, Some(&route), start_m, parts)?;
    for index in 0..simulator.frames() {
        let frame = simulator.frame(index);
        let (output, evidence) = pipeline.step(&frame.picture, Sensors::default(), &mut |_stage| ())?;
        if index % 10 == 0 {
            println!("frame {index}, road by the {}: {}", evidence.road.detector, output.why);
        }
    }
    Ok(())
}
