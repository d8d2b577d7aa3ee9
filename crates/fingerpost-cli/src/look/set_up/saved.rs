//! The files in which is saved what was set up.

use std::ffi::OsString;
use std::path::{self, PathBuf};

use anyhow::{Result, bail};
use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Camera;
use fingerpost_io::write_file;
use fingerpost_look::{Kept, SetUpKeeper};
use fingerpost_map::LatLon;
use fingerpost_server::Cause;

use super::route::RouteToSave;
use crate::made_from;
use crate::output_path::{self, FileKind};

/// The files, and the drive that is run with them.
pub(super) struct SavedFiles {
    pub(super) drive: String,
    pub(super) camera: PathBuf,
    pub(super) route: Option<RouteToSave>,
    /// What the drive is set up from.
    pub(super) inputs: Vec<PathBuf>,
}

impl SavedFiles {
    /// Refuses files that are inputs, or one another, or that may be the user's.
    pub(super) fn check(&self) -> Result<()> {
        let inputs = || self.inputs.iter().map(PathBuf::as_path);
        output_path::check_file(&self.camera, FileKind::Camera, inputs())?;
        let Some(route) = &self.route else { return Ok(()) };
        if path::absolute(&route.path)? == path::absolute(&self.camera)? {
            bail!("{} cannot hold both camera and route; name two files", route.path.display());
        }
        output_path::check_file(&route.path, FileKind::Route, inputs())
    }
}

impl SetUpKeeper for SavedFiles {
    fn keep(&self, camera: &Camera, start_m: Option<f64>) -> Result<Kept, Cause> {
        // Either may have been changed by hand since the program started.
        self.check()?;
        write_file(&self.camera, camera_to_toml(camera)?)?;
        let mut files = vec![self.camera.display().to_string()];
        let words = ["fingerpost", "run", self.drive.as_str(), "--camera"].map(OsString::from);
        let mut words = Vec::from(words);
        words.push(self.camera.clone().into());
        if let (Some(route), Some(start_m)) = (&self.route, start_m) {
            write_file(&route.path, &route.text)?;
            files.push(route.path.display().to_string());
            if let Some(map) = &route.map {
                words.extend(["--map".into(), map.into()]);
                if let Some(LatLon { lat_deg, lon_deg }) = route.place(start_m) {
                    words.extend(["--near".into(), format!("{lat_deg:.6},{lon_deg:.6}").into()]);
                }
            }
            words.extend(["--route".into(), route.path.clone().into()]);
            words.extend(["--start-m".into(), format!("{start_m:.1}").into()]);
        }
        let command = format!("{} --out run", made_from::command_line(words));
        Ok(Kept { files, command })
    }
}
