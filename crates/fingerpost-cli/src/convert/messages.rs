//! MCAP recordings and ROS 2 bags.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_format::CameraInfo;
use fingerpost_io::bag::{Choice, Content, Records, RecordsError, Role, Survey, Wanted, decode, survey};
use fingerpost_io::{FolderKind, bag_files, open_bag};

use super::kept_messages;
use super::recorded_drive::RecordedDrive;
use crate::arguments::InputLimit;
use crate::examples::examples;
use crate::interrupt::{Interrupt, Preparation};
use crate::mount_args::{KnownCamera, MountArgs, PictureKindArgs, check_lens_against_topic};
use crate::{inputs, output, output_path};

/// From an MCAP recording: Foxglove's messages in protobuf, as run.mcap holds them, or ROS 2's in CDR. Topics of pictures
/// (raw, JPEG or PNG), calibration, GPS, twist or odometry, and an inertial unit; the only one of its kind is taken. A recording that
/// breaks off is converted as far as it goes.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "convert mcap run.mcap --camera camera.toml --out drive",
    "convert mcap recording.mcap --height-m 1.4 --image-topic /front/image --out drive"
))]
pub(crate) struct McapArgs {
    /// The recording.
    #[arg(value_name = "FILE")]
    input: PathBuf,
    #[command(flatten)]
    recording: RecordingArgs,
}

/// From a ROS 2 bag with MCAP storage: sensor_msgs Image or CompressedImage, CameraInfo, NavSatFix and Imu, geometry_msgs Twist,
/// TwistStamped or TwistWithCovarianceStamped, nav_msgs Odometry, in CDR; the only topic of its kind is taken.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "convert bag recorded_bag --height-m 1.4 --out drive",
    "convert bag recorded_bag --mount mount.toml --rectified --image-topic /front/image_rect --out drive"
))]
pub(crate) struct BagArgs {
    /// The bag's folder, or one of its files.
    #[arg(value_name = "BAG")]
    input: PathBuf,
    #[command(flatten)]
    recording: RecordingArgs,
}

#[derive(Debug, Args)]
struct RecordingArgs {
    #[command(flatten)]
    mount: MountArgs,
    /// Topic of the camera's pictures, where there are several.
    #[arg(long, value_name = "TOPIC")]
    image_topic: Option<String>,
    /// Topic of the camera's calibration, where there are several.
    #[arg(long, value_name = "TOPIC", conflicts_with = "camera")]
    camera_info_topic: Option<String>,
    /// Topic of GPS positions, where there are several.
    #[arg(long, value_name = "TOPIC")]
    gps_topic: Option<String>,
    /// Topic of the vehicle's twist or odometry, where there are several; its axes are those of its frame (REP 103).
    #[arg(long, value_name = "TOPIC")]
    twist_topic: Option<String>,
    /// Topic of the inertial unit, where there are several; its yaw rate goes before the twist's. Its axes are those of its frame, by
    /// /tf_static or by its name.
    #[arg(long, value_name = "TOPIC")]
    imu_topic: Option<String>,
    #[command(flatten)]
    pictures: PictureKindArgs,
    #[command(flatten)]
    limit: InputLimit,
    /// Folder to write: a new or empty one, or one of an earlier `convert`, which is replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what was converted on standard output.
    #[arg(long)]
    json: bool,
}

/// Converts a recording.
pub(crate) fn mcap(args: &McapArgs) -> Result<()> {
    convert(&args.input, std::slice::from_ref(&args.input), &args.recording)
}

/// Converts a bag.
pub(crate) fn bag(args: &BagArgs) -> Result<()> {
    convert(&args.input, &bag_files(&args.input)?, &args.recording)
}

fn convert(input: &Path, files: &[PathBuf], args: &RecordingArgs) -> Result<()> {
    let inputs = args.mount.inputs().chain(files).map(PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::ConvertedDrive, inputs)?;
    let preparation = Preparation::listen()?;
    let known = args.mount.known()?;
    let streams = files.iter().map(|path| open_bag(path)).collect::<Result<Vec<_>, _>>()?;
    let Survey { topics, without_channel, cut_short } = survey(streams);
    let of_input = || input.display().to_string();
    let cut_short = match cut_short {
        Some(cause) if topics.is_empty() && !matches!(cause, RecordsError::BreaksOff) => {
            return Err(cause).with_context(of_input);
        }
        cut_short => cut_short.map(|cause| format!("{}: {cause}", input.display())),
    };
    let choice = Choice::of(&topics, &wanted(args)).with_context(of_input);
    if let (Err(_), Some(cause)) = (&choice, &cut_short) {
        output::message(cause);
    }
    let choice = choice?;
    kept_messages::check(&topics, &choice, args.limit).with_context(of_input)?;
    let image_topic = choice.topic(Role::Pictures).unwrap_or_default();
    let (camera, source) = match known {
        KnownCamera::Whole(camera) => {
            check_lens_against_topic(&camera, image_topic);
            (*camera, "--camera".to_owned())
        }
        KnownCamera::Mount(mount) => {
            let (topic, info) = calibration(files, &choice).with_context(of_input)?;
            let read = info.camera(args.pictures.of_topic(image_topic), mount).with_context(of_input)?;
            (inputs::say_remarks(read, &topic), topic)
        }
    };
    let interrupt = preparation.work_begins();
    let drive = read(files, &choice, RecordedDrive::new(&args.out, camera, source, &choice), &interrupt)?;
    let converted = drive.finish(input)?;
    if let Some(cause) = &cut_short {
        output::message(&format!("{cause}; what came before is converted"));
    }
    if without_channel > 0 {
        output::message(&format!(
            "{}: {without_channel} messages are of no channel that was introduced before them, and are passed over; \
             `mcap recover` writes what can be read",
            input.display()
        ));
    }
    if interrupt.wanted() {
        bail!("interrupted after {} frames; they are in {}", converted.frames, args.out.display());
    }
    let what = [
        (Role::Pictures, format!("{} frames", converted.frames)),
        (Role::Gps, format!("{} GPS positions", converted.gps_positions)),
        (Role::Twist, format!("{} rows of motion", converted.motion_rows)),
        (Role::Imu, "inertial measurements".to_owned()),
    ];
    let said: Vec<String> = what
        .into_iter()
        .filter_map(|(role, what)| Some(format!("{what} from {}", choice.topic(role)?)))
        .collect();
    output::message(&format!("{} in {}", said.join(", "), args.out.display()));
    if args.json { output::print_json(&converted) } else { Ok(()) }
}

fn wanted(args: &RecordingArgs) -> Wanted {
    Wanted {
        image: args.image_topic.clone(),
        camera_info: args.camera_info_topic.clone(),
        gps: args.gps_topic.clone(),
        twist: args.twist_topic.clone(),
        imu: args.imu_topic.clone(),
    }
}

/// The topic that gives the calibration, and its first one.
fn calibration(files: &[PathBuf], choice: &Choice) -> Result<(String, CameraInfo)> {
    let Some(topic) = choice.topic(Role::Calibration) else {
        bail!(
            "it has no calibration of the camera (sensor_msgs/msg/CameraInfo or foxglove.CameraCalibration); give one with --camera"
        );
    };
    for file in files {
        for record in Records::new(open_bag(file)?).map_while(Result::ok) {
            let schema = choice.schema_of(&record.topic).filter(|_| *record.topic == *topic);
            let Some(schema) = schema else { continue };
            if let Content::Calibration(info) =
                decode(schema, &record.data).with_context(|| topic.to_owned())?.content
            {
                return Ok((topic.to_owned(), info));
            }
        }
    }
    bail!("its calibration cannot be read any more; was the file changed meanwhile?")
}

/// Reads on until the recording ends or breaks off.
fn read(
    files: &[PathBuf],
    choice: &Choice,
    mut drive: RecordedDrive,
    interrupt: &Interrupt,
) -> Result<RecordedDrive> {
    for file in files {
        // Why a file breaks off is known from the survey.
        for record in Records::new(open_bag(file)?).map_while(Result::ok) {
            if interrupt.wanted() {
                return Ok(drive);
            }
            let Some(schema) = choice.schema_of(&record.topic) else { continue };
            let message = match decode(schema, &record.data) {
                Ok(message) => message,
                Err(cause) => {
                    drive.pass_over(|| format!("{}: {cause}", record.topic));
                    continue;
                }
            };
            // What does not say when it was so has the time at which it was recorded.
            let at_ns = message.stamp_ns.unwrap_or(record.log_ns);
            match message.content {
                Content::Picture(picture) => drive.add_picture(at_ns, &picture)?,
                Content::Gps(Some(position)) => drive.add_gps(at_ns, position),
                Content::Twist(twist) => drive.add_twist(at_ns, twist),
                Content::Inertial(Some(inertial)) => drive.add_inertial(at_ns, inertial),
                Content::Transforms(transforms) => drive.add_transforms(transforms),
                Content::Calibration(_) | Content::Gps(None) | Content::Inertial(None) => {}
            }
        }
    }
    Ok(drive)
}
