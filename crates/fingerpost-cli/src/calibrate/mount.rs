//! `fingerpost calibrate mount`: pitch, yaw, roll and height of a camera from a drive.

use std::path::{Path, PathBuf};

use anyhow::Result;
use clap::Args;
use fingerpost_calibration::{Estimated, KnownScale, MountCalibration};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Mount;
use fingerpost_io::{FfmpegPrograms, SourceOptions, write_file};
use serde::Serialize;

use crate::arguments::number;
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::mount_search::MountSearch;
use crate::output_path::FileKind;
use crate::{inputs, output, output_path};

/// Find the direction in which a camera is mounted from a drive, mostly straight ahead, and write its camera.toml.
///
/// Pitch and yaw come from the point of the picture that the vehicle drives towards, and from the road's own motion; roll
/// from the road. The height needs a known speed, distance or lane width and stays as in the calibration without one. A
/// drive that does not show the mount well enough is refused and nothing is written.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("scale")))]
#[command(before_long_help = examples!(
    "calibrate mount drive.mp4 --camera rough.toml --speed-mps 13.9 --out camera.toml",
    "calibrate mount pictures/ --fps 10 --camera rough.toml --lane-width-m 3.5 --out camera.toml"
))]
pub(crate) struct MountArgs {
    /// A folder of pictures, a drive folder of `simulate`, or anything ffmpeg reads.
    #[arg(value_name = "INPUT")]
    input: String,
    /// Calibration of the camera; its mount is where the search begins, roughly is enough.
    #[arg(long, value_name = "FILE")]
    camera: PathBuf,
    /// Mean speed of the vehicle over the whole input, metres a second; 0.5 to 100.
    #[arg(long, value_name = "V", group = "scale", value_parser = number(0.5, 100.0, "speed", "metres a second"))]
    speed_mps: Option<f64>,
    /// Distance driven from the first frame to the last, metres; 5 to 1e6.
    #[arg(long, value_name = "D", group = "scale", value_parser = number(5.0, 1e6, "distance", "metres"))]
    distance_m: Option<f64>,
    /// Width of the lane that is driven in, from the middle of one marking to the middle of the other, metres; 1.5 to 8.
    #[arg(long, value_name = "W", group = "scale", value_parser = number(1.5, 8.0, "width of a lane", "metres"))]
    lane_width_m: Option<f64>,
    /// Stop after so many frames.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Frames a second, 0.01 to 1000: of pictures without times.txt (else the times in their names, or 10 as a guess), and of a video in
    /// place of its own times. Bare streams (.h264, .hevc, .mjpeg) have none and need it. Where a times.txt, a camera or a
    /// stream times the frames, it is refused.
    #[arg(long, value_name = "N", value_parser = crate::arguments::frame_rate)]
    fps: Option<f64>,
    /// Calibration to write, camera.toml.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Print the mount with its standard deviations as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// A value with its standard deviation, as it is printed.
#[derive(Debug, Serialize)]
struct Printed {
    value: f64,
    sigma: f64,
}

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Report {
    pitch_deg: Printed,
    yaw_deg: Printed,
    /// As the road showed it.
    roll_deg: Option<Printed>,
    /// Whether the written mount has that roll; if not, it has the one given.
    roll_taken_over: bool,
    /// None where no length was given and the height was kept.
    height_m: Option<Printed>,
    /// Pitch from the direction of travel alone, and from the road's plane alone.
    travel_pitch_deg: Printed,
    road_pitch_deg: Option<Printed>,
    distance_m: Option<f64>,
    frames: usize,
    frames_moving: usize,
    frames_straight: usize,
    frames_with_road: usize,
    /// Frames that repeat the one before while the vehicle moves, and frames that are missing between others, if the ways are read
    /// rightly.
    frames_repeated: usize,
    frames_missing: usize,
    /// The mount as written.
    mount: WrittenMount,
}

#[derive(Debug, Serialize)]
struct WrittenMount {
    height_m: f64,
    pitch_deg: f64,
    yaw_deg: f64,
    roll_deg: f64,
    x_m: f64,
    y_m: f64,
}

/// Calibrates the mount.
pub(crate) fn mount(args: &MountArgs) -> Result<()> {
    output_path::check_file(&args.out, FileKind::Camera, [Path::new(&args.input), &args.camera])?;
    let camera = inputs::camera(&args.camera)?;
    let interrupt = Interrupt::listen()?;
    let search = MountSearch {
        input: &args.input,
        options: source_options(args, &interrupt),
        frames: args.frames,
        known: known_scale(args),
        lane_width_m: args.lane_width_m,
        stop: interrupt.flag(),
        bar: &|frames| output::progress(frames, "frames"),
    };
    let found = search.find(camera, &args.camera.display().to_string())?;
    write_file(&args.out, camera_to_toml(&found.camera)?)?;
    found.lines().iter().for_each(|line| output::message(line));
    output::message(&format!("{}; mount in {}", found.frames_line(), args.out.display()));
    if args.json { output::print_json(&report(&found.calibration)) } else { Ok(()) }
}

fn known_scale(args: &MountArgs) -> KnownScale {
    match (args.speed_mps, args.distance_m) {
        (Some(speed_mps), _) => KnownScale::SpeedMps(speed_mps),
        (None, Some(distance_m)) => KnownScale::DistanceM(distance_m),
        (None, None) => KnownScale::Nothing,
    }
}

fn source_options(args: &MountArgs, interrupt: &Interrupt) -> SourceOptions {
    let programs = FfmpegPrograms { stop: Some(interrupt.shared_flag()), ..inputs::ffmpeg() };
    SourceOptions { fps: args.fps, programs, ..SourceOptions::default() }
}

fn report(calibration: &MountCalibration) -> Report {
    let degrees = |of: Estimated| Printed { value: of.value.to_degrees(), sigma: of.sigma.to_degrees() };
    let Mount { height_m, pitch_rad, yaw_rad, roll_rad, x_m, y_m } = calibration.mount;
    Report {
        pitch_deg: degrees(calibration.pitch),
        yaw_deg: degrees(calibration.yaw),
        roll_deg: calibration.roll.map(degrees),
        roll_taken_over: calibration.roll_taken_over,
        height_m: calibration.height.map(|height| Printed { value: height.value, sigma: height.sigma }),
        travel_pitch_deg: degrees(calibration.travel_pitch),
        road_pitch_deg: calibration.road_pitch.map(degrees),
        distance_m: calibration.distance_m,
        frames: calibration.frames,
        frames_moving: calibration.frames_moving,
        frames_straight: calibration.frames_straight,
        frames_with_road: calibration.frames_with_road,
        frames_repeated: calibration.frames_repeated,
        frames_missing: calibration.frames_missing,
        mount: WrittenMount {
            height_m,
            pitch_deg: pitch_rad.to_degrees(),
            yaw_deg: yaw_rad.to_degrees(),
            roll_deg: roll_rad.to_degrees(),
            x_m,
            y_m,
        },
    }
}
