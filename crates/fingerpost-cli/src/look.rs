//! `fingerpost look`: a finished run stepped through, or a drive's camera set up, on a local web page.

mod pictures;
mod run_files;
mod set_up;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Result, bail};
use clap::Args;
use fingerpost::Config;
use fingerpost::ground_view::GroundViewConfig;
use fingerpost_geometry::Camera;
use fingerpost_look::{GroundArea, RunPage};
use fingerpost_record::recording::Channel;
use fingerpost_server::{Handler, Limits, LocalServer};

use self::pictures::{FolderPictures, RunRecording};
use self::run_files::RunFiles;
use self::set_up::SetUpArgs;
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::{camera_size, inputs, output};

/// Step through a finished run frame by frame, or set a drive up by eye, on a web page that is served to this machine alone.
///
/// Of a run it shows the camera's picture with what was found in it, the road from above, why it was decided so, every number of the
/// frame, and curves over time with what happened, to jump to; nothing is written. Of a drive, a folder of pictures or a video, it shows
/// the horizon, a metre grid and the ground view, which follow while the mount is dragged, and with --route the route, whose start can
/// be dragged too; "Calibrate from this drive" does what `calibrate mount` does, and "Save" writes camera and route.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "look run --camera camera.toml",
    "look drive --camera rough.toml --map town.osm --route route.geojson --save camera.toml"
))]
pub(crate) struct LookArgs {
    /// Folder that `run` has written, or a drive: a folder of pictures, a drive folder, or a video file.
    #[arg(value_name = "RUN|DRIVE")]
    run: PathBuf,
    /// Where the run's pictures are: the folder of pictures or drive folder that it was given. By default those that the run has
    /// recorded in run.mcap.
    #[arg(long, value_name = "DRIVE")]
    input: Option<PathBuf>,
    /// Calibration of the camera. Of a run: to draw places on the road into its pictures; by default the camera.toml of --input, where
    /// one is. Of a drive: what its mount begins as; by default the camera.toml in it.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    #[command(flatten)]
    set_up: SetUpArgs,
    /// Port of the page on 127.0.0.1; 0 for any that is free.
    #[arg(long, value_name = "N", default_value_t = 8421)]
    port: u16,
}

/// Serves the page.
pub(crate) fn look(args: &LookArgs) -> Result<()> {
    let server = LocalServer::open(args.port, Limits::default())?;
    let is_run = args.run.join("frames.jsonl").exists();
    match (is_run, args.set_up.given(), &args.input) {
        (true, Some(option), _) => {
            bail!("{} is a run, of which nothing is set up; leave {option} out", args.run.display())
        }
        (true, None, _) => serve(server, run_page(args)?),
        (false, _, Some(_)) => {
            bail!("{} is no run, which has a frames.jsonl; of a drive leave --input out", args.run.display())
        }
        (false, _, None) => serve(server, set_up::page(&args.run, args.camera.as_deref(), &args.set_up)?),
    }
}

fn serve<H: Handler>(server: LocalServer, page: H) -> Result<()> {
    output::message(&format!("open {} in a browser; Ctrl-C ends the program", server.address()));
    let interrupt = Interrupt::listen()?;
    Ok(server.serve(&Arc::new(page), interrupt.flag())?)
}

/// The page of a run.
fn run_page(args: &LookArgs) -> Result<RunPage> {
    let RunFiles { title, overview, records, summary, config_toml } = RunFiles::open(&args.run)?;
    let recording = RunRecording::open(&args.run, &overview);
    let ground_area = config_toml.as_deref().and_then(ground_area);
    let picture_px = summary.as_ref().and_then(|summary| summary.picture_px);
    let mut page = RunPage::new(&title, overview, Box::new(records)).with_results(summary, config_toml);
    if let Some(camera) = camera(args, picture_px)? {
        page = page.with_camera(camera);
    }
    if let Some(recording) = &recording {
        page = page.with_pictures(recording.pictures(Channel::CameraImage));
        if let Some(area) = ground_area {
            page = page.with_ground_views(recording.pictures(Channel::GroundView), area);
        }
    }
    if let Some(input) = &args.input {
        page = page.with_pictures(Box::new(FolderPictures::open(input)?));
    }
    Ok(page)
}

/// What the ground view showed by the run's settings; none where they are another program's.
fn ground_area(config_toml: &str) -> Option<GroundArea> {
    Some(area_of(&Config::from_toml(config_toml).ok()?.ground_view))
}

/// What a ground view of these settings shows.
const fn area_of(view: &GroundViewConfig) -> GroundArea {
    GroundArea { near_m: view.near_m, far_m: view.far_m, half_width_m: view.half_width_m }
}

/// The name of a folder, which a page has for its title.
fn folder_name(folder: &Path) -> String {
    let place = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
    place.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

/// The camera that took the pictures, at their size.
fn camera(args: &LookArgs, picture_px: Option<[u32; 2]>) -> Result<Option<Camera>> {
    let beside = args.input.as_ref().map(|drive| drive.join("camera.toml")).filter(|path| path.is_file());
    let Some(path) = args.camera.clone().or(beside) else { return Ok(None) };
    let camera = inputs::camera(&path)?;
    let Some(size_px) = picture_px else { return Ok(Some(camera)) };
    let [width, height] = size_px.map(|side| side as usize);
    camera_size::of_pictures(camera, (width, height), &path.display().to_string()).map(Some)
}
