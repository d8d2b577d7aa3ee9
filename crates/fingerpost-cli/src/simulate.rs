//! `fingerpost simulate`: a drive on a map's roads or on a made-up one, rendered, with truth.

mod course;
mod world;

use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::builder::PossibleValuesParser;
use clap::{Args, ValueEnum};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount, View};
use fingerpost_io::{BusTexts, CROSSINGS_FILE, DriveFolder, FolderKind, FrameFormat, JsonLinesFile};
use fingerpost_map::{Route, write_route};
use fingerpost_sim::{
    BUS_DATABASE, BUS_SETTINGS, Conditions, CornerStyle, SimConfig, Simulator, TrafficSide, windscreen_camera,
};
use rayon::prelude::*;

use self::course::CourseArgs;
use self::world::WorldArgs;
pub(crate) use self::world::known_vehicle;
use crate::arguments::{InputLimit, PictureSize};
use crate::examples::examples;
use crate::interrupt::Preparation;
use crate::{inputs, output, output_path};

/// Drive a simulated vehicle along a route and write what its camera sees, with the truth: frames, camera.toml,
/// route.geojson, truth.jsonl, times.txt and a mask of the road surface for each frame; and what its bus says: can.log,
/// car.dbc and can.toml. Give the folder to `run`.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "simulate --map town.osm --route route.geojson --conditions wet --out drive",
    "simulate --course highway --length-m 500 --driving drifting --out drive"
))]
pub(crate) struct SimulateArgs {
    /// OpenStreetMap data of the area, .osm (XML) or .osm.pbf.
    #[arg(long, value_name = "FILE", required_unless_present_any = ["course", "world"])]
    map: Option<PathBuf>,
    #[command(flatten)]
    limit: InputLimit,
    /// Route on that map, as written by `fingerpost route`.
    #[arg(long, value_name = "FILE", required_unless_present_any = ["course", "world"], requires = "map")]
    route: Option<PathBuf>,
    #[command(flatten)]
    road: CourseArgs,
    #[command(flatten)]
    world: WorldArgs,
    /// Everything random follows from this number; the same seed gives the same bytes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// What the day is like; ideal is flat, still and without noise.
    #[arg(long, value_name = "NAME", default_value = "clear",
          value_parser = PossibleValuesParser::new(Conditions::names()))]
    conditions: String,
    /// Stop after so many frames; without it the drive goes to the route's end.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    frames: Option<u64>,
    /// Size of the pictures, pixels, 640x480 by default, with --world as drawn; the camera's focal length goes with the width.
    #[arg(long, value_name = "WxH", conflicts_with = "camera")]
    size: Option<PictureSize>,
    /// Frames a second, 10 by default, with --world as drawn; 0.1 to 1000.
    #[arg(long, value_parser = crate::arguments::simulated_rate)]
    fps: Option<f64>,
    /// A calibrated camera to look through, in place of a 75 degree one, 1.5 m above the road and 1.5 m ahead of the
    /// rear axle, looking 8 degrees down.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Side of the road that the vehicle keeps to.
    #[arg(long, value_enum, default_value = "right")]
    traffic: Traffic,
    /// Lens of the camera that is looked through without --camera.
    #[arg(long, value_enum, default_value = "none", conflicts_with = "camera")]
    lens: Lens,
    /// Store frames without loss, five times as large.
    #[arg(long)]
    png: bool,
    /// Store frames without loss and unpacked, as portable pixmaps (P6), twenty times as large.
    #[arg(long, conflicts_with = "png")]
    ppm: bool,
    /// Write what each pixel shows, too: classes/NNNNNN.png, grey levels of 0 nothing, 1 road, 2 paint on it, 3 raised ground, 4 verge,
    /// 5 vehicle or other thing, 6 structure, 7 sky.
    #[arg(long)]
    classes: bool,
    /// Folder to write: a new or empty one, or one of an earlier `simulate`, whose drive is replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

impl SimulateArgs {
    /// How many frames at most.
    fn frames(&self) -> Option<usize> {
        self.frames.and_then(|frames| usize::try_from(frames).ok())
    }
}

/// The side of the road that is driven on.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Traffic {
    Left,
    Right,
    Centre,
}

/// A lens of a camera that is not given as a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Lens {
    /// A pinhole.
    None,
    /// A dashcam's barrel distortion.
    BrownConrady,
}

/// Focal length of the default camera as a share of the picture's width: 420 pixels of 640, 75 degrees.
const FOCAL_SHARE: f64 = 420.0 / 640.0;
/// Mount of the default camera, behind the windscreen of a car.
const MOUNT: Mount = Mount {
    height_m: 1.5,
    pitch_rad: 8.0 * (std::f64::consts::PI / 180.0),
    yaw_rad: 0.0,
    roll_rad: 0.0,
    x_m: 1.5,
    y_m: 0.0,
};
/// Barrel distortion of a common dashcam: straight lines at the picture's side bend by some 20 of 640 pixels.
const DASHCAM_LENS: [f64; 5] = [-0.25, 0.07, 0.0005, -0.0003, -0.01];

impl Lens {
    fn distortion(self) -> Result<Distortion, GeometryError> {
        match self {
            Self::None => Ok(Distortion::None),
            Self::BrownConrady => Distortion::brown_conrady(&DASHCAM_LENS),
        }
    }

    /// A camera with this lens in place of its own.
    fn on(self, camera: &Camera) -> Result<Camera, GeometryError> {
        match camera.view() {
            View::Calibrated { intrinsics, mount, .. } => {
                let (width, height) = (camera.width(), camera.height());
                Camera::calibrated(width, height, *intrinsics, self.distortion()?, *mount)
            }
            View::RoadPlane(_) => Ok(camera.clone()),
        }
    }
}

/// The default camera.
pub(crate) fn default_camera(size: PictureSize, lens: Lens) -> Result<Camera, GeometryError> {
    let (width, height) = (size.width as f64, size.height as f64);
    let f = FOCAL_SHARE * width;
    let intrinsics = Intrinsics { fx: f, fy: f, cx: 0.5 * (width - 1.0), cy: 0.5 * (height - 1.0) };
    Camera::calibrated(size.width, size.height, intrinsics, lens.distortion()?, MOUNT)
}

/// What is rendered, and what is written of it beside the pictures.
struct Plan {
    simulator: Simulator,
    /// The camera and the route as the drive's owner knows them.
    camera: Camera,
    route: Route,
    settings: String,
}

/// Pictures where nothing else is said.
const SIZE: PictureSize = PictureSize { width: 640, height: 480 };

/// Streets with kerbs have corners of their own.
pub(crate) fn corners(conditions: &Conditions) -> CornerStyle {
    if conditions.kerbs > 0.0 { CornerStyle::Drawn } else { CornerStyle::default() }
}

fn plan(args: &SimulateArgs) -> Result<Plan> {
    if args.world.is_wanted() {
        return args.world.plan(args);
    }
    let conditions = Conditions::named(&args.conditions)?;
    let config = SimConfig {
        seed: args.seed,
        fps: args.fps.unwrap_or(SimConfig::default().fps),
        frames: args.frames(),
        traffic: match args.traffic {
            Traffic::Left => TrafficSide::Left,
            Traffic::Right => TrafficSide::Right,
            Traffic::Centre => TrafficSide::Centre,
        },
        corners: corners(&conditions),
        conditions,
        ..SimConfig::default()
    };
    let (graph, route, config) = match (args.road.course, &args.map, &args.route) {
        (Some(course), ..) => {
            let (road, config) = args.road.drive(course, args.seed, config);
            let (graph, route) = road.roads()?;
            (graph, route, config)
        }
        (None, Some(map), Some(route)) => {
            (inputs::road_graph(map, args.limit)?, inputs::route(route)?, config)
        }
        (None, ..) => bail!("neither a road nor a map with a route; give --course, or --map and --route"),
    };
    let size = args.size.unwrap_or(SIZE);
    let camera = match (&args.camera, args.road.course) {
        (Some(path), _) => inputs::camera(path)?,
        (None, Some(_)) => args.lens.on(&windscreen_camera(size.width, size.height)?)?,
        (None, None) => default_camera(size, args.lens)?,
    };
    let simulator = Simulator::new(&graph, &route, &camera, &config)?;
    Ok(Plan { simulator, camera, route, settings: BUS_SETTINGS.to_owned() })
}

/// Writes the drive.
pub(crate) fn simulate(args: &SimulateArgs) -> Result<()> {
    let preparation = Preparation::listen()?;
    let Plan { simulator, camera, route, settings } = plan(args)?;
    let inputs = [&args.map, &args.route, &args.camera].into_iter().flatten().map(PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::Drive, inputs)?;
    let format = match (args.png, args.ppm) {
        (true, _) => FrameFormat::Png,
        (_, true) => FrameFormat::Ppm,
        _ => FrameFormat::Jpeg,
    };
    let interrupt = preparation.work_begins();
    let mut folder = DriveFolder::create(&args.out, format)?;
    folder.write_camera(&camera_to_toml(&camera)?)?;
    folder.write_route(&write_route(&route)?)?;
    if simulator.has_heights() {
        folder.expect_heights()?;
    }
    if args.classes {
        folder.expect_classes()?;
    }
    let log = simulator.bus_log();
    folder.write_bus(BusTexts { log: &log, database: BUS_DATABASE, settings: &settings })?;
    if args.road.course.is_some() {
        let path = args.out.join(CROSSINGS_FILE);
        let mut lines = JsonLinesFile::create(&path)?;
        simulator.crossings().iter().try_for_each(|crossing| lines.append(crossing))?;
        lines.finish()?;
    }

    log::info!(
        "drive of {} frames, {} x {} pixels, conditions {}, seed {}",
        simulator.frames(),
        camera.width(),
        camera.height(),
        if args.world.is_wanted() { "of the world" } else { &args.conditions },
        args.seed
    );
    let bar = output::progress(Some(simulator.frames() as u64), "frames");
    let mut written = 0;
    // Enough frames in hand to keep every core busy, few enough to fit into any memory.
    let at_once = 2 * rayon::current_num_threads();
    while written < simulator.frames() && !interrupt.wanted() {
        let batch = written..simulator.frames().min(written + at_once);
        let truths = batch.clone().into_par_iter().map(|index| {
            let frame = simulator.frame(index);
            folder.write_frame(index as u64, &frame.picture)?;
            folder.write_road_mask(index as u64, &frame.road)?;
            if let Some(heights) = &frame.heights {
                folder.write_heights(index as u64, heights)?;
            }
            if args.classes {
                folder.write_classes(index as u64, &frame.classes)?;
            }
            Ok(frame.truth)
        });
        for truth in truths.collect::<Result<Vec<_>>>()? {
            folder.append(&truth)?;
        }
        written = batch.end;
        bar.set_position(written as u64);
    }
    folder.finish()?;
    bar.finish_and_clear();
    if interrupt.wanted() {
        bail!("interrupted after {written} frames; they are in {}", args.out.display());
    }
    output::message(&format!("{written} frames with truth in {}", args.out.display()));
    Ok(())
}
