//! `fingerpost calibrate mount`: pitch, yaw, roll and height of a camera from a drive.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_calibration::{
    DrivenWay, DrivenWayError, Estimated, KnownScale, LaneWidth, MountCalibration, MountCalibrator,
};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::{Camera, Mount};
use fingerpost_io::{
    FfmpegPrograms, FrameClock, FrameError, FrameSource, SourceOptions, StampFaults, write_file,
};
use fingerpost_vision::picture::RgbImage;
use serde::Serialize;

use crate::arguments::number;
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::output_path::FileKind;
use crate::{camera_size, inputs, output, output_path};

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
    let known = known_scale(args);
    let camera = inputs::camera(&args.camera)?;
    let interrupt = Interrupt::listen()?;
    let mut source = inputs::frames(&args.input, &source_options(args, &interrupt))?;
    if source.clock() == FrameClock::Guessed && matches!(known, KnownScale::SpeedMps(_)) {
        bail!(
            "the height from --speed-mps is as wrong as the frame rate is, and that of {} is a guess; give the rate (--fps), or \
             --distance-m in place of the speed; nothing was written",
            args.input
        );
    }
    let camera = match source.picture_size() {
        Some(size) => camera_size::of_pictures(camera, size, &args.camera.display().to_string())?,
        None => camera,
    };
    let is_live = source.is_live();
    let mut calibrator = MountCalibrator::new(&camera)?;
    let faults = for_each_frame(source, args, &interrupt, |picture, t_s| Ok(calibrator.add(picture, t_s)?))?;
    inputs::say_stamp_faults(&args.input, faults);
    let mut calibration = calibrator.finish(known).context(NOTHING_WRITTEN)?;
    if let Some(lane_width_m) = args.lane_width_m {
        let seen =
            width_of_lane(args, &interrupt, &calibration.camera_on_mount(&camera).context(NOTHING_WRITTEN)?)?;
        calibration = calibration.with_lane_width(seen, lane_width_m);
    }
    let calibrated = calibration.camera_on_mount(&camera).context(NOTHING_WRITTEN)?;
    if known != KnownScale::Nothing && !is_live {
        let seen = driven_way(args, &interrupt, &calibrated)?;
        seen.map_or(Ok(()), |seen| calibration.held_against(seen, known)).context(NOTHING_WRITTEN)?;
    }
    write_file(&args.out, camera_to_toml(&calibrated)?)?;
    say(&calibration, args);
    if args.json { output::print_json(&report(&calibration)) } else { Ok(()) }
}

const NOTHING_WRITTEN: &str = "the mount cannot be trusted and nothing was written";

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

/// Hands every picture of the input on, and says what was wrong with their stamps; broken pictures are passed over.
fn for_each_frame(
    mut source: FrameSource,
    args: &MountArgs,
    interrupt: &Interrupt,
    mut take: impl FnMut(&RgbImage, f64) -> Result<()>,
) -> Result<StampFaults> {
    let most = args.frames.unwrap_or(u64::MAX);
    let bar = output::progress(source.length().map(|length| length.min(most)).or(args.frames), "frames");
    let mut left = most;
    while let Some(frame) = source.next().filter(|_| left > 0) {
        if interrupt.wanted() {
            bail!("interrupted; nothing was written");
        }
        left -= 1;
        match frame.picture {
            Ok(picture) => {
                take(&picture, frame.t_s).with_context(|| format!("frame {}", frame.index))?;
                source.recycle(picture);
            }
            Err(cause @ FrameError::Picture(_)) => output::message(&format!("passed over: {cause}")),
            Err(cause @ FrameError::Video(_)) => return Err(cause.into()),
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    if interrupt.wanted() {
        bail!("interrupted; nothing was written");
    }
    Ok(source.stamp_faults())
}

/// The way of the drive through the camera; none where it does not show the road just ahead, which is said.
fn driven_way(args: &MountArgs, interrupt: &Interrupt, camera: &Camera) -> Result<Option<Estimated>> {
    let mut way = DrivenWay::new(camera).map_err(DrivenWayError::from);
    if way.is_ok() {
        // What there is to say of the input has been said.
        let source = FrameSource::open(&args.input, &source_options(args, interrupt))?;
        for_each_frame(source, args, interrupt, |picture, _| {
            if let Err(error) = way.as_mut().map_or(Ok(()), |way| way.add(picture)) {
                way = Err(error);
            }
            Ok(())
        })?;
    }
    match way {
        Ok(way) => Ok(Some(way.way())),
        Err(error) => {
            output::message(&format!(
                "the height is not held against the way that the frames show through its camera: {error}"
            ));
            Ok(None)
        }
    }
}

/// How wide the lane looks through a camera of that height.
fn width_of_lane(args: &MountArgs, interrupt: &Interrupt, camera: &Camera) -> Result<Estimated> {
    let mut lane = LaneWidth::new(camera)?;
    // What there is to say of the input has been said.
    let source = FrameSource::open(&args.input, &source_options(args, interrupt))?;
    for_each_frame(source, args, interrupt, |picture, _| Ok(lane.add(picture)?))?;
    lane.width().context(
        "the drive shows no lane with markings on both sides for long enough, so that its width does not give the height; give \
         --speed-mps or --distance-m instead; nothing was written",
    )
}

fn say(calibration: &MountCalibration, args: &MountArgs) {
    let MountCalibration { mount, pitch, yaw, roll, height, .. } = calibration;
    let degrees = |what: &str, of: &Estimated| {
        output::message(&format!("{what}: {:.2}° ± {:.2}°", of.value.to_degrees(), of.sigma.to_degrees()));
    };
    degrees("pitch (positive nose down)", pitch);
    degrees("yaw (positive left)", yaw);
    match roll {
        Some(roll) if calibration.roll_taken_over => degrees("roll (positive left side up)", roll),
        Some(roll) => output::message(&format!(
            "roll kept at {:.2}°: the road shows {:.2}° ± {:.2}°, which a crowned road may do",
            mount.roll_rad.to_degrees(),
            roll.value.to_degrees(),
            roll.sigma.to_degrees()
        )),
        None => output::message(&format!(
            "roll kept at {:.2}°: too little of the road's surface was seen",
            mount.roll_rad.to_degrees()
        )),
    }
    match height {
        Some(height) => output::message(&format!("height: {:.3} m ± {:.3} m", height.value, height.sigma)),
        None => output::message(&format!(
            "height kept at {:.3} m; --speed-mps, --distance-m or --lane-width-m would measure it",
            mount.height_m
        )),
    }
    if let Some(doubt) = calibration.cadence_doubt() {
        output::message(&doubt.to_string());
    }
    output::message(&format!(
        "{} frames: {} moving, {} of them straight, {} with the road's surface; mount in {}",
        calibration.frames,
        calibration.frames_moving,
        calibration.frames_straight,
        calibration.frames_with_road,
        args.out.display()
    ));
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
