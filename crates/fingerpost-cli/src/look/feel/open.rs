//! What settings are felt with: given by arguments, or found beside the drive.

use std::path::{Path, PathBuf};
use std::sync::Mutex;

use anyhow::Result;
use fingerpost_format::{FrameRecord, TrackState};
use fingerpost_geometry::Camera;
use fingerpost_look::{FeelPage, Feelable};
use fingerpost_server::Pictures;

use super::front::points;
use super::{Frames, Kept, RunAgain, SettingsFile, StretchPictures, schema};
use crate::inputs;
use crate::look::LookArgs;
use crate::look::method::Method;
use crate::look::run_files::RunFiles;

/// Where settings are saved where nothing else is said.
const SAVED_SETTINGS: &str = "fingerpost.toml";

/// The part of a run's page on which settings are felt, or what it lacks.
pub(in crate::look) fn open(
    args: &LookArgs,
    run: &RunFiles,
    camera: Option<&Camera>,
    pictures: Option<Box<dyn Pictures>>,
) -> Result<Result<FeelPage, String>> {
    let route_path = args.beside_drive(args.route.as_deref(), "route.geojson");
    let points = args.tuned.as_deref().map(points).transpose()?.unwrap_or_default();
    let camera_path = args.beside_drive(args.camera.as_deref(), "camera.toml");
    let of_front = args.tuned.iter().flat_map(|folder| points.iter().map(|point| folder.join(&point.name)));
    let kept = [args.run.join("config.toml")].into_iter().chain(of_front).collect();
    let file = SettingsFile::at(
        args.save.as_deref().unwrap_or(Path::new(SAVED_SETTINGS)),
        kept,
        [args.input.as_deref(), camera_path.as_deref(), route_path.as_deref()],
    );
    // One that nobody named may be there, as long as nothing is saved.
    if args.save.is_some() {
        file.check()?;
    }
    let lacking = |what: &str| Ok(Err(format!("To feel settings, {what}.")));
    let method = match Method::of(run, camera) {
        Ok(method) => method,
        Err(what) => return lacking(what),
    };
    let Some(pictures) = pictures else {
        return lacking("say where the pictures are with --input");
    };
    let route = route_path.as_deref().map(inputs::route).transpose()?;
    let records = run.records.clone();
    let first: FrameRecord = serde_json::from_slice(&records.bytes(0)?)?;
    if first.state != TrackState::NoRoute && route.is_none() {
        return lacking("give the route that the run followed with --route");
    }
    let scaling = method.scaling()?;
    let camera = method.scaled_camera(scaling.as_ref());
    let config = method.config;
    let feelable = Feelable { schema: schema(), values: config.to_json(), points };
    let size_px = (camera.width(), camera.height());
    let run_again = RunAgain {
        config,
        camera,
        route: route.filter(|_| first.state != TrackState::NoRoute),
        frames: Frames::of(&run.overview),
        records,
        kept: Mutex::new(Kept { pictures: StretchPictures::new(pictures, size_px, scaling), ahead: None }),
        file,
    };
    Ok(Ok(FeelPage::new(feelable, Box::new(run_again))))
}

impl LookArgs {
    /// A file that is given, or else the one of that name in the folder of --input.
    pub(in crate::look) fn beside_drive(&self, given: Option<&Path>, name: &str) -> Option<PathBuf> {
        let beside = || self.input.as_ref().map(|drive| drive.join(name)).filter(|path| path.is_file());
        given.map(Path::to_owned).or_else(beside)
    }
}
