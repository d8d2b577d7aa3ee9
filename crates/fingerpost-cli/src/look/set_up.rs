//! A drive whose camera is set up by eye.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use anyhow::{Context, Result, bail};
use fingerpost::ground_view::{GroundView, GroundViewConfig};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Camera;
use fingerpost_io::{picture_paths, read_picture, write_file};
use fingerpost_look::{CameraKeeper, GroundViews, Kept, MountPage};
use fingerpost_server::{Cause, Picture};
use fingerpost_vision::colour::HueSaturationBins;
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use fingerpost_vision::picture::RgbImage;

use super::pictures::FolderPictures;
use super::{area_of, folder_name};
use crate::output_path::{self, FileKind};
use crate::{camera_size, inputs, made_from};

/// JPEG quality of ground views.
const VIEW_QUALITY: u8 = 90;
/// Nobody reads the bins of these views.
const BINS: HueSaturationBins = HueSaturationBins { hue: 1, saturation: 1 };

/// The page of a drive whose camera's mount begins as `camera` has it; the one that is set up is saved as `save`.
pub(super) fn page(drive: &Path, camera: Option<&Path>, save: &Path) -> Result<MountPage> {
    let paths = picture_paths(drive)
        .with_context(|| format!("{} is no run, which has a frames.jsonl, and no drive", drive.display()))?;
    let beside = drive.join("camera.toml");
    let camera_path = camera.unwrap_or(&beside);
    output_path::check_file(save, FileKind::Camera, [camera_path, drive])?;
    let size_px = paths.iter().find_map(|path| Some(read_picture(path).ok()?.size()));
    let size_px =
        size_px.with_context(|| format!("no picture of {} can be read; give another", drive.display()))?;
    let source = camera_path.display().to_string();
    let camera = camera_size::of_pictures(inputs::camera(camera_path)?, size_px, &source)?;
    let view = GroundViewConfig::default();
    let (title, area) = (folder_name(drive), area_of(&view));
    let keeper = CameraFile { path: save.to_owned(), drive: drive.to_owned() };
    let frames = paths.len() as u64;
    let views = DriveViews { paths, view, last: Mutex::new(None) };
    let pictures = Box::new(FolderPictures::open(drive)?);
    match MountPage::new(&title, frames, camera, area, pictures, Box::new(views), Box::new(keeper)) {
        Some(page) => Ok(page),
        None => bail!(
            "{source} knows the camera by points, which have no mount; give one with a lens and a mount"
        ),
    }
}

/// Ground views of a drive's pictures.
struct DriveViews {
    paths: Vec<PathBuf>,
    view: GroundViewConfig,
    /// The picture that was asked for last, and its frame: while a mount is changed it stays the same.
    last: Mutex<Option<(u64, Arc<RgbImage>)>>,
}

impl DriveViews {
    fn picture(&self, frame: u64) -> Result<Arc<RgbImage>, Cause> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, picture)) = last.as_ref().filter(|(of, _)| *of == frame) {
            return Ok(Arc::clone(picture));
        }
        let path = usize::try_from(frame).ok().and_then(|index| self.paths.get(index));
        let picture = Arc::new(read_picture(path.ok_or("there is no such frame")?)?);
        *last = Some((frame, Arc::clone(&picture)));
        Ok(picture)
    }
}

impl GroundViews for DriveViews {
    fn ground_view(&self, frame: u64, camera: &Camera) -> Result<Picture, Cause> {
        let picture = self.picture(frame)?;
        let view = GroundView::new(&self.view, BINS, camera)?;
        let mut shown = view.black_picture();
        view.render(&picture, &mut shown)?;
        let bytes = jpeg_file(&shown.colour, VIEW_QUALITY, ChromaSampling::Full)?;
        Ok(Picture { content_type: "image/jpeg", bytes })
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
