//! KITTI's raw and odometry sequences.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_format::{
    CameraInfo, KittiOxts, KittiTime, MotionLogRow, PictureKind, PoseLogRow, camera_to_toml, kitti_oxts,
    kitti_projection, kitti_timestamps, parse_times,
};
use fingerpost_geometry::Mount;
use fingerpost_io::{
    ConvertedDrive, ConvertedLogs, FolderKind, PictureEnding, picture_paths, read_bytes, read_picture,
    read_text, text_files,
};

use super::recorded_drive::Converted;
use crate::arguments::number;
use crate::examples::examples;
use crate::interrupt::Preparation;
use crate::{output, output_path};

/// Where KITTI's cameras sit (Geiger et al. 2013, figure 3): above the road, and ahead of the inertial unit, which is at the rear
/// axle.
const HEIGHT_M: f64 = 1.65;
const AHEAD_M: f64 = 0.27 + 0.81;

/// From a sequence of KITTI: a raw drive, as 2011_09_26_drive_0001_sync with image_02/data and oxts, whose calibration
/// calib_cam_to_cam.txt is beside the drive; or a folder of the odometry benchmark, as sequences/00 with image_2, times.txt and
/// calib.txt. The camera is 1.65 m above the road and level; `calibrate mount` finds how it looks.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "convert kitti 2011_09_26_drive_0001_sync --out drive",
    "convert kitti sequences/00 --camera 0 --out drive"
))]
pub(crate) struct KittiArgs {
    /// Folder of the sequence.
    #[arg(value_name = "SEQUENCE")]
    input: PathBuf,
    /// Number of the camera: 0 and 1 are grey, 2 and 3 have colour.
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(0..=3))]
    camera: u8,
    /// Height of the camera above the road, metres, 0.05 to 20.
    #[arg(long, value_name = "H", default_value_t = HEIGHT_M, value_parser = number(0.05, 20.0, "height", "metres"))]
    height_m: f64,
    /// Calibration, where it is elsewhere: calib_cam_to_cam.txt or calib.txt.
    #[arg(long, value_name = "FILE")]
    calibration: Option<PathBuf>,
    /// Folder to write: a new or empty one, or one of an earlier `convert`, which is replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what was converted on standard output.
    #[arg(long)]
    json: bool,
}

/// Where the files of a sequence are.
struct Sequence {
    pictures: PathBuf,
    times: Times,
    calibration: PathBuf,
    /// Of GPS and inertial unit, where there are any.
    oxts: Option<PathBuf>,
}

/// The two forms of times.
enum Times {
    /// Dates and times of day.
    Stamps(PathBuf),
    /// Seconds.
    Seconds(PathBuf),
}

impl Sequence {
    fn find(folder: &Path, camera: u8) -> Result<Self> {
        let raw = folder.join(format!("image_{camera:02}"));
        if raw.join("data").is_dir() {
            let oxts = folder.join("oxts");
            return Ok(Self {
                pictures: raw.join("data"),
                times: Times::Stamps(raw.join("timestamps.txt")),
                calibration: folder.join("..").join("calib_cam_to_cam.txt"),
                oxts: oxts.join("data").is_dir().then_some(oxts),
            });
        }
        let odometry = folder.join(format!("image_{camera}"));
        if odometry.is_dir() {
            return Ok(Self {
                pictures: odometry,
                times: Times::Seconds(folder.join("times.txt")),
                calibration: folder.join("calib.txt"),
                oxts: None,
            });
        }
        bail!(
            "{} has neither image_{camera:02}/data, as a raw drive, nor image_{camera}, as an odometry sequence; check the path, or \
             choose another camera (--camera 0 to 3)",
            folder.display()
        )
    }
}

/// Converts.
pub(crate) fn kitti(args: &KittiArgs) -> Result<()> {
    let Sequence { pictures, times, calibration, oxts } = Sequence::find(&args.input, args.camera)?;
    let calibration = args.calibration.as_ref().unwrap_or(&calibration);
    let inputs = [&args.input, calibration].map(PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::ConvertedDrive, inputs)?;
    let preparation = Preparation::listen()?;
    let projection = kitti_projection(&read_text(calibration)?, args.camera)
        .with_context(|| calibration.display().to_string())?;
    let paths = picture_paths(&pictures)?;
    let (times_s, since) = read_times(&times)?;
    if times_s.len() != paths.len() {
        bail!(
            "{} has {} pictures and {} times; copy the sequence again",
            pictures.display(),
            paths.len(),
            times_s.len()
        );
    }
    let first = paths.first().context("a sequence without pictures")?;
    let (width, height) = read_picture(first)?.size();
    let info = CameraInfo { width, height, projection, ..CameraInfo::default() };
    let mount = Mount { x_m: AHEAD_M, ..Mount::level(args.height_m) };
    let camera = info.camera(PictureKind::Rectified, mount);
    let camera = camera.with_context(|| calibration.display().to_string())?.camera;
    let (logs, passed_over) = match oxts.zip(since) {
        Some((oxts, since)) => read_oxts(&oxts, since, times_s.last().copied().unwrap_or_default())?,
        None => (ConvertedLogs::default(), 0),
    };
    let interrupt = preparation.work_begins();
    let mut drive = ConvertedDrive::create(&args.out, &camera_to_toml(&camera)?)?;
    for (path, t_s) in paths.iter().zip(&times_s).take_while(|_| !interrupt.wanted()) {
        let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
        let ending = if is_png { PictureEnding::Png } else { PictureEnding::Jpeg };
        drive.add_packed(*t_s, ending, &read_bytes(path)?)?;
    }
    let converted = Converted {
        frames: drive.frames(),
        passed_over,
        length_s: times_s.last().copied().unwrap_or_default(),
        gps_positions: logs.gps.len(),
        motion_rows: logs.motion.len(),
        poses: logs.poses.len(),
    };
    drive.finish(&logs)?;
    if interrupt.wanted() {
        bail!("interrupted after {} frames; they are in {}", converted.frames, args.out.display());
    }
    output::message(&format!(
        "{} frames, {} GPS positions with motion and true poses in {}",
        converted.frames,
        converted.gps_positions,
        args.out.display()
    ));
    if args.json { output::print_json(&converted) } else { Ok(()) }
}

/// Times of the pictures since the first of them, and on which clock, where they say.
fn read_times(times: &Times) -> Result<(Vec<f64>, Option<KittiTime>)> {
    match times {
        Times::Stamps(path) => {
            let stamps = kitti_timestamps(&read_text(path)?).with_context(|| path.display().to_string())?;
            let since = stamps.first().copied();
            let times_s = stamps.iter().filter_map(|stamp| Some(stamp.since_s(since?))).collect();
            Ok((times_s, since))
        }
        Times::Seconds(path) => {
            let times_s = parse_times(&read_text(path)?).with_context(|| path.display().to_string())?;
            Ok((times_s, None))
        }
    }
}

/// GPS, motion and poses during the pictures, and how many lines were passed over.
fn read_oxts(folder: &Path, since: KittiTime, last_s: f64) -> Result<(ConvertedLogs, u64)> {
    let stamps_path = folder.join("timestamps.txt");
    let stamps =
        kitti_timestamps(&read_text(&stamps_path)?).with_context(|| stamps_path.display().to_string())?;
    let paths = text_files(&folder.join("data"))?;
    if paths.len() != stamps.len() {
        bail!(
            "{} has {} lines of data and {} times; copy it again",
            folder.display(),
            paths.len(),
            stamps.len()
        );
    }
    let (mut logs, mut passed_over) = (ConvertedLogs::default(), 0);
    let mut last_row_s = f64::NEG_INFINITY;
    for (path, stamp) in paths.iter().zip(stamps) {
        let t_s = stamp.since_s(since);
        let oxts = kitti_oxts(&read_text(path)?).with_context(|| path.display().to_string())?;
        // The unit starts and ends some milliseconds beside the camera.
        if !(0.0..=last_s).contains(&t_s) || t_s <= last_row_s {
            passed_over += 1;
            continue;
        }
        last_row_s = t_s;
        let KittiOxts { lat_deg, lon_deg, heading_rad, speed_mps, yaw_rate_rps } = oxts;
        logs.gps.push((t_s, [lat_deg, lon_deg]));
        logs.motion.push(MotionLogRow { t_s, speed_mps, yaw_rate_rps });
        logs.poses.push(PoseLogRow { t_s, lat: lat_deg, lon: lon_deg, heading_rad });
    }
    Ok((logs, passed_over))
}
