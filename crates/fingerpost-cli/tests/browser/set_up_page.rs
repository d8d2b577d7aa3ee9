//! What tests of the page on which a drive is set up share.

use std::fs;
use std::path::{Path, PathBuf};

use fingerpost_format::{camera_from_toml, camera_to_toml};
use fingerpost_geometry::{Camera, Mount, View};
use serde_json::Value;
use tempfile::TempDir;

use crate::chromium::Page;
use crate::simulated_drive::simulate;

/// The mount of a camera that has one.
pub(crate) fn mount(camera: &Camera) -> Mount {
    let View::Calibrated { mount, .. } = camera.view() else { panic!("a camera with a mount") };
    *mount
}

/// The camera of a file.
pub(crate) fn read_camera(path: &Path) -> Camera {
    camera_from_toml(&fs::read_to_string(path).unwrap()).unwrap()
}

/// What the page has drawn last.
pub(crate) fn drawn(page: &mut Page) -> Value {
    serde_json::from_str(page.value("document.body.dataset.drawn").as_str().unwrap()).unwrap()
}

/// Waits until a number of the mount is drawn as it stands.
pub(crate) fn wait_for_drawing(page: &mut Page, name: &str) {
    page.wait_for(&format!(
        "JSON.parse(document.body.dataset.drawn).{name} === document.getElementById('{name}').valueAsNumber"
    ));
}

/// The files of a drive of so many frames, and its camera on a mount that is turned by so many degrees of pitch.
pub(crate) struct RoughDrive {
    folder: TempDir,
    pub(crate) truth: Mount,
}

impl RoughDrive {
    pub(crate) fn simulate(frames: usize, pitch_off_deg: f64) -> Self {
        let folder = TempDir::new().unwrap();
        let drive = folder.path().join("drive");
        simulate(frames, &drive);
        let camera = read_camera(&drive.join("camera.toml"));
        let truth = mount(&camera);
        let off = Mount { pitch_rad: truth.pitch_rad + pitch_off_deg.to_radians(), ..truth };
        let rough = camera_to_toml(&camera.with_mount(off).unwrap()).unwrap();
        fs::write(folder.path().join("rough.toml"), rough).unwrap();
        Self { folder, truth }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}
