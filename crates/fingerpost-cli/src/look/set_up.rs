//! A drive whose camera is set up by eye.

mod footage;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use fingerpost::ground_view::GroundViewConfig;
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Camera;
use fingerpost_io::write_file;
use fingerpost_look::{CameraKeeper, DriveFrames, DriveSources, Kept, MountPage};
use fingerpost_server::Cause;

use self::footage::{Footage, FootagePictures, FootageViews};
use super::{area_of, folder_name};
use crate::output_path::{self, FileKind};
use crate::{camera_size, inputs, made_from};

/// The page of a drive whose camera's mount begins as `camera` has it; the one that is set up is saved as `save`.
pub(super) fn page(drive: &Path, camera: Option<&Path>, save: &Path) -> Result<MountPage> {
    let name = drive.to_str().with_context(|| format!("{} has no name in UTF-8", drive.display()))?;
    let footage = Footage::open(name)
        .with_context(|| format!("{name} is no run, which has a frames.jsonl, and no drive"))?;
    let beside = drive.join("camera.toml");
    let camera_path = camera.unwrap_or(&beside);
    output_path::check_file(save, FileKind::Camera, [camera_path, drive])?;
    let size_px = footage.picture_size();
    let size_px = size_px.with_context(|| format!("no picture of {name} can be read; give another drive"))?;
    let source = camera_path.display().to_string();
    let camera = camera_size::of_pictures(inputs::camera(camera_path)?, size_px, &source)?;
    let view = GroundViewConfig::default();
    let area = area_of(&view);
    let frames = DriveFrames { title: folder_name(drive), count: footage.count(), step: footage.step() };
    let footage = Arc::new(footage);
    let sources = DriveSources {
        pictures: Box::new(FootagePictures(Arc::clone(&footage))),
        ground_views: Box::new(FootageViews { footage, view }),
        keeper: Box::new(CameraFile { path: save.to_owned(), drive: drive.to_owned() }),
    };
    match MountPage::new(frames, camera, area, sources) {
        Some(page) => Ok(page),
        None => bail!(
            "{source} knows the camera by points, which have no mount; give one with a lens and a mount"
        ),
    }
}

/// The file that the camera is saved in.
struct CameraFile {
    path: PathBuf,
    drive: PathBuf,
}

impl CameraKeeper for CameraFile {
    fn keep(&self, camera: &Camera) -> Result<Kept, Cause> {
        write_file(&self.path, camera_to_toml(camera)?)?;
        let words = ["fingerpost", "run"].map(OsString::from).into_iter();
        let words = words.chain([self.drive.clone().into(), "--camera".into(), self.path.clone().into()]);
        let command = format!("{} --out run", made_from::command_line(words));
        Ok(Kept { file: self.path.display().to_string(), command })
    }
}
