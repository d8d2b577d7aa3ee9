//! How far made-up drives go until they are converged: `convergence KILOMETRES MAP.osm...` shares the kilometres among the maps.
//!
//! Each drive is two kilometres at random through a map's roads, with sensors that err, and is located without a start on the same
//! map drawn a metre or two wrong. Prints a line a map and one of all.

// Functions shared with the tests unwrap; figures are what it is for.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

#[path = "../tests/drives/mod.rs"]
mod drives;

use std::path::Path;

use drives::score::quantile;
use drives::{Numbers, Score, drive, line, locate, typical_faults};
use fingerpost_map::{OsmData, RoadGraph};

const DRIVE_M: f64 = 2000.0;
/// Roads at random that end early before a map is given up.
const TRIES: usize = 10_000;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let kilometres: f64 = arguments.next().ok_or("give the kilometres to drive, then maps")?.parse()?;
    let maps: Vec<String> = arguments.collect();
    if maps.is_empty() {
        return Err("name OpenStreetMap files".into());
    }
    println!(
        "| map | driven | converged | after (median) | 95 % | median error | median level | rows outside |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let (mut all, mut all_m, mut all_drives) = (Score::default(), 0.0, 0);
    for map in &maps {
        let osm = OsmData::from_bytes(&std::fs::read(map)?)?;
        let roads = RoadGraph::from_osm(&osm)?;
        let (mut score, mut driven_m, mut seed) = (Score::default(), 0.0, 0);
        while driven_m < 1e3 * kilometres / maps.len() as f64 {
            let mut numbers = Numbers(10_000 + seed);
            seed += 1;
            let road = (0..TRIES).find_map(|_| line(&roads, DRIVE_M, &mut numbers));
            let road = road.ok_or("the map has no drive of two kilometres")?;
            let rows = drive(&road, typical_faults(&mut numbers), &mut numbers);
            driven_m += rows.last().map_or(0.0, |(_, pose)| pose.driven_m);
            score.add(&locate(&osm, &rows, &mut numbers));
        }
        let name = Path::new(map).file_stem().unwrap_or_default().to_string_lossy();
        print(&name, &score, driven_m, seed);
        all.add(&score);
        (all_m, all_drives) = (all_m + driven_m, all_drives + seed);
    }
    print("all", &all, all_m, all_drives);
    Ok(())
}

fn print(name: &str, score: &Score, driven_m: f64, drives: u64) {
    println!(
        "| {name} | {:.0} km | {} of {drives} | {:.0} m | {:.0} m | {:.1} m | {:.1} m | {:.2} % |",
        driven_m / 1e3,
        drives - score.never_converged as u64,
        quantile(&score.converged_m, 0.5),
        quantile(&score.converged_m, 0.95),
        score.median_error_m(),
        quantile(&score.levels_m, 0.5),
        100.0 * score.violations_part()
    );
}
