//! `fingerpost look`: a finished run stepped through, felt and compared, or a drive's camera set up, on a local web page.

mod classes;
mod compare;
mod feel;
mod method;
mod pictures;
mod run_files;
mod run_map;
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
use fingerpost_server::{Handler, Limits, LocalServer, Pictures};

use self::pictures::{FolderPictures, RunRecording};
use self::run_files::RunFiles;
use self::run_map::run_map;
use self::set_up::{SetUpArgs, SetUpFiles};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::{camera_size, inputs, output};

/// Step through a finished run frame by frame, or set a drive up by eye, on a web page that is served to this machine alone.
///
/// Of a run it shows the camera's picture with what was found in it, the road from above, where the vehicle is on the map, why it was
/// decided so, every number of the frame, and curves over time with what happened and the worst frames, to jump to. Its part "Feel"
/// runs the last five seconds up to a frame again with other settings and shows each stage before and after; "Save" on it writes what
/// was changed. With another run of the same drive its part "Compare" shows both in each frame, and where they differ most. Of a
/// drive, a folder of pictures or a video, it shows the horizon, a metre grid and the ground view, which follow while the mount is
/// dragged, and with --route the route, whose start can be dragged too; "Calibrate from this drive" does what `calibrate mount` does,
/// and "Save" writes camera and route.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "look run --input drive --route route.geojson --with other",
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
    /// Calibration of the camera. Of a run: to draw places on the road into its pictures, and to ask the road network about them;
    /// by default the camera.toml of --input, where one is. Of a drive: its lens, and what its mount begins as, which may be rough; by default the camera.toml in it.
    #[arg(long, value_name = "FILE")]
    camera: Option<PathBuf>,
    /// Another run of the same drive, to compare the two frame by frame.
    #[arg(long, value_name = "OTHER_RUN")]
    with: Option<PathBuf>,
    /// Folder that `tune` has written: each point of its front is taken over into "Feel" by a click.
    #[arg(long, value_name = "DIR")]
    tuned: Option<PathBuf>,
    /// Route, as written by `fingerpost route`. Of a run: the one that it followed, to show it on the map and to run parts of it
    /// again with other settings; by default the route.geojson of --input, where one is. Of a drive: it is drawn into the picture
    /// from its start on, which can be moved along it.
    #[arg(long, value_name = "FILE")]
    route: Option<PathBuf>,
    /// File that "Save" writes: of a run the changed settings, fingerpost.toml by default; of a drive the camera, set_up_camera.toml by
    /// default.
    #[arg(long, value_name = "FILE")]
    save: Option<PathBuf>,
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
    if is_run {
        if let Some(option) = args.set_up.given() {
            bail!("{} is a run, of which nothing is set up; leave {option} out", args.run.display());
        }
        return serve(server, run_page(args)?);
    }
    let of_runs = [("--input", &args.input), ("--with", &args.with), ("--tuned", &args.tuned)];
    if let Some((option, _)) = of_runs.iter().find(|(_, value)| value.is_some()) {
        bail!("{} is no run, which has a frames.jsonl; of a drive leave {option} out", args.run.display());
    }
    let LookArgs { camera, route, save, .. } = args;
    let files = SetUpFiles { camera: camera.as_deref(), route: route.as_deref(), save: save.as_deref() };
    serve(server, set_up::page(&args.run, &files, &args.set_up)?)
}

fn serve<H: Handler>(server: LocalServer, page: H) -> Result<()> {
    output::message(&format!("open {} in a browser; Ctrl-C ends the program", server.address()));
    let interrupt = Interrupt::listen()?;
    Ok(server.serve(&Arc::new(page), interrupt.flag())?)
}

/// The page of a run, with another one where that is wanted.
fn run_page(args: &LookArgs) -> Result<RunPage> {
    let run = RunFiles::open(&args.run)?;
    let recording = RunRecording::open(&args.run, &run.overview);
    let picture_px = run.summary.as_ref().and_then(|summary| summary.picture_px);
    let camera = camera(args, picture_px)?;
    let feel = feel::open(args, &run, camera.as_ref(), pictures(args, recording.as_ref())?)?;
    let classes = classes::open(&run, camera.as_ref(), pictures(args, recording.as_ref())?)?;
    let other = args.with.as_deref().map(|other| -> Result<_> {
        let other_run = RunFiles::open(other)?;
        let differences = compare::differences(&run, &other_run)?;
        let recording = RunRecording::open(other, &other_run.overview);
        // Its pictures may have another size.
        let picture_px = other_run.summary.as_ref().and_then(|summary| summary.picture_px);
        let camera = self::camera(args, picture_px)?;
        Ok((plain_page(args, other_run, recording.as_ref(), camera)?, differences))
    });
    let other = other.transpose()?;
    let page = plain_page(args, run, recording.as_ref(), camera)?.with_feel(feel).with_classes(classes);
    Ok(match other {
        Some((other, differences)) => page.with_comparison(other, differences),
        None => page,
    })
}

/// The page on which a run is stepped through.
fn plain_page(
    args: &LookArgs,
    run: RunFiles,
    recording: Option<&RunRecording>,
    camera: Option<Camera>,
) -> Result<RunPage> {
    let ground_area = run.config_toml.as_deref().and_then(ground_area);
    let RunFiles { title, overview, records, fixes, summary, config_toml } = run;
    let mut page = RunPage::new(&title, overview, Box::new(records)).with_results(summary, config_toml);
    if let Some(map) = run_map(args, &fixes)? {
        page = page.with_map(&map);
    }
    if let Some(camera) = camera {
        page = page.with_camera(camera);
    }
    if let Some(pictures) = pictures(args, recording)? {
        page = page.with_pictures(pictures);
    }
    if let Some((recording, area)) = recording.zip(ground_area) {
        page = page.with_ground_views(recording.pictures(Channel::GroundView), area);
        if let Some(surfaces) = recording.road_surfaces() {
            page = page.with_road_surfaces(surfaces);
        }
    }
    Ok(page)
}

/// The pictures of the drive: those of --input, else those that a run has recorded.
fn pictures(args: &LookArgs, recording: Option<&RunRecording>) -> Result<Option<Box<dyn Pictures>>> {
    Ok(match &args.input {
        Some(input) => Some(Box::new(FolderPictures::open(input)?)),
        None => recording.map(|recording| recording.pictures(Channel::CameraImage)),
    })
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
    let Some(path) = args.beside_drive(args.camera.as_deref(), "camera.toml") else { return Ok(None) };
    let camera = inputs::camera(&path)?;
    let Some(size_px) = picture_px else { return Ok(Some(camera)) };
    let [width, height] = size_px.map(|side| side as usize);
    camera_size::of_pictures(camera, (width, height), &path.display().to_string()).map(Some)
}
