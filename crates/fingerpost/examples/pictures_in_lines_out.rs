//! A drive folder in, one line a frame out: how far the vehicle moved, where the road's middle is, and what comes next.
//!
//!     fingerpost simulate --map town.osm --route route.geojson --out drive
//!     cargo run --release -p fingerpost --example pictures_in_lines_out -- drive

// An example is a program, whose output is for a person.
#![allow(clippy::print_stdout)]

use std::error::Error;
use std::path::PathBuf;

use fingerpost::map::read_route;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_io::{picture_paths, read_camera, read_picture, read_text};

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(std::env::args().nth(1).ok_or("give the folder of a drive")?);
    let camera = read_camera(&folder.join("camera.toml"))?.camera;
    let route = read_route(&read_text(&folder.join("route.geojson"))?)?;
    let mut pipeline = Pipeline::new(&Config::default(), &camera, Some(&route), None)?;
    for (index, path) in picture_paths(&folder.join("frames"))?.iter().enumerate() {
        let (output, _evidence) =
            pipeline.step(&read_picture(path)?, Sensors::default(), &mut |_stage| ())?;
        let moved_m = output.motion.map_or(0.0, |motion| motion.previous_from_current.translation.x);
        let middle_m =
            output.centreline.map_or_else(|| "?".to_owned(), |line| format!("{:.2}", line.offset_m));
        println!("{index}: moved {moved_m:.2} m, road's middle {middle_m} m left, {}", output.why);
    }
    Ok(())
}
