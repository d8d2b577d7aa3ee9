//! Times a look at the roads with about ten thousand hypotheses, on one core: `step_time MAP.osm`.
//!
//! The vehicle drives straight on, which rules out little. Prints the hypotheses and the milliseconds of each look, and of ten
//! thousand hypotheses at the median.

#![allow(clippy::print_stdout, reason = "figures are what it is for")]

use std::time::Instant;

use fingerpost_locate::{Locator, MotionSample, Traffic};
use fingerpost_map::{OsmData, RoadGraph};

/// Looks that are timed: 2.5 m of driving each.
const LOOKS: usize = 30;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = std::env::args().nth(1).ok_or("name an OpenStreetMap file")?;
    let graph = RoadGraph::from_osm(&OsmData::from_bytes(&std::fs::read(path)?)?)?;
    let mut locator = Locator::new(&graph, Traffic::Right, 1);
    let mut of_ten_thousand_ms = Vec::new();
    for row in 0..=LOOKS {
        let sample = MotionSample { t_s: 0.25 * row as f64, speed_mps: 10.0, yaw_rate_rps: 0.0 };
        let started = Instant::now();
        let fix = locator.step(sample)?;
        let look_ms = started.elapsed().as_secs_f64() * 1e3;
        let hypotheses = fix.map_or(0, |fix| fix.hypotheses);
        println!("{hypotheses} hypotheses, {look_ms:.1} ms");
        if row > 0 && hypotheses > 0 {
            of_ten_thousand_ms.push(look_ms * 1e4 / hypotheses as f64);
        }
    }
    of_ten_thousand_ms.sort_by(f64::total_cmp);
    if let Some(median_ms) = of_ten_thousand_ms.get(of_ten_thousand_ms.len() / 2) {
        println!("10000 hypotheses: {median_ms:.1} ms a look");
    }
    Ok(())
}
