//! A drive that is set up by eye: its camera's mount, and where on its route it begins.

mod footage;
pub(super) mod route;
mod saved;
mod search;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost::ground_view::GroundViewConfig;
use fingerpost_look::{DriveFrames, DriveSources, MountPage};

use self::footage::{Footage, FootagePictures, FootageViews};
use self::route::DrivenRoute;
use self::saved::SavedFiles;
use self::search::SearchInDrive;
use super::{area_of, folder_name};
use crate::arguments::{InputLimit, number};
use crate::{camera_size, inputs};

/// Where the camera of a drive is saved where nothing else is said.
const SAVED_CAMERA: &str = "set_up_camera.toml";

/// What is said of a drive that is set up.
#[derive(Debug, Args)]
pub(super) struct SetUpArgs {
    /// OpenStreetMap data, .osm (XML) or .osm.pbf, whose roads are drawn about the route as well.
    #[arg(long, value_name = "FILE", requires = "route")]
    map: Option<PathBuf>,
    /// Distance along the route at the first frame, metres, as it is before anybody moves it; 0 by default.
    #[arg(long, value_name = "M", requires = "route", value_parser = number(0.0, 1e6, "place on a route", "metres"))]
    start_m: Option<f64>,
    /// File that "Save" writes the route to; set_up_route.geojson by default.
    #[arg(long, value_name = "FILE", requires = "route")]
    save_route: Option<PathBuf>,
    #[command(flatten)]
    limit: InputLimit,
}

impl SetUpArgs {
    /// The first of those that a run has no use for that was given.
    pub(super) fn given(&self) -> Option<&'static str> {
        let Self { start_m, save_route, .. } = self;
        let options = [("--start-m", start_m.is_some()), ("--save-route", save_route.is_some())];
        options.into_iter().find_map(|(name, is_given)| is_given.then_some(name))
    }
}

/// The files that are named of a run as well.
pub(super) struct SetUpFiles<'a> {
    /// What the mount begins as.
    pub(super) camera: Option<&'a Path>,
    pub(super) route: Option<&'a Path>,
    /// Where the camera is saved.
    pub(super) save: Option<&'a Path>,
}

/// The page of a drive.
pub(super) fn page(drive: &Path, files: &SetUpFiles<'_>, args: &SetUpArgs) -> Result<MountPage> {
    let name = drive.to_str().with_context(|| format!("{} has no name in UTF-8", drive.display()))?;
    let footage = Footage::open(name)
        .with_context(|| format!("{name} is no run, which has a frames.jsonl, and no drive"))?;
    let beside = drive.join("camera.toml");
    if files.camera.is_none() && !beside.is_file() {
        bail!(
            "{name} brings no camera.toml; give the camera with --camera: its lens as it is, and a mount that may be rough, as \
             height_m = 1.5 and pitch_deg = 0.0, which the page sets right (the book has every key, under \"camera.toml\")"
        );
    }
    let camera_path = files.camera.unwrap_or(&beside);
    let size_px = footage.picture_size();
    let size_px = size_px.with_context(|| format!("no picture of {name} can be read; give another drive"))?;
    let source = camera_path.display().to_string();
    let camera = camera_size::of_pictures(inputs::camera(camera_path)?, size_px, &source)?;
    let route = DrivenRoute::open(files.route, args)?;
    let (route, to_save) =
        route.map(|DrivenRoute { map, start_m, to_save }| ((map, start_m), to_save)).unzip();
    let inputs = [Some(drive), Some(camera_path), files.route, args.map.as_deref()];
    let saved = SavedFiles {
        drive: name.to_owned(),
        camera: files.save.unwrap_or(Path::new(SAVED_CAMERA)).to_owned(),
        route: to_save,
        inputs: inputs.into_iter().flatten().map(Path::to_owned).collect(),
    };
    saved.check()?;
    let view = GroundViewConfig::default();
    let area = area_of(&view);
    let frames = DriveFrames { title: folder_name(drive), count: footage.count(), step: footage.step() };
    let footage = Arc::new(footage);
    let sources = DriveSources {
        pictures: Box::new(FootagePictures(Arc::clone(&footage))),
        ground_views: Box::new(FootageViews { footage, view }),
        keeper: Box::new(saved),
        search: Box::new(SearchInDrive::new(name.to_owned(), source.clone())),
    };
    let Some(page) = MountPage::new(frames, camera, area, sources) else {
        bail!("{source} knows the camera by points, which have no mount; give one with a lens and a mount")
    };
    Ok(match route {
        Some((map, start_m)) => page.with_route(map, start_m),
        None => page,
    })
}
