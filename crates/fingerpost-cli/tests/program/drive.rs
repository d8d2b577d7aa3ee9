//! A small simulated drive that many tests read: along a road and left at a T-junction.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use tempfile::TempDir;

use crate::program::call_line;

/// A road to the east with a T-junction (node 2) after 46 m, and a side road to the north; 1e-5 degrees are 1.11 m of
/// latitude and 0.76 m of longitude.
pub(crate) const MAP: &str = r#"<osm version="0.6">
<node id="1" lat="47.0" lon="9.5"/><node id="2" lat="47.0" lon="9.5006"/><node id="3" lat="47.0" lon="9.5014"/>
<node id="4" lat="47.0006" lon="9.5006"/>
<way id="10"><nd ref="1"/><nd ref="2"/><nd ref="3"/><tag k="highway" v="residential"/></way>
<way id="11"><nd ref="2"/><nd ref="4"/><tag k="highway" v="residential"/></way>
</osm>"#;

/// Frames of the drive.
pub(crate) const FRAMES: usize = 80;

/// Files that the tests read and nobody writes.
pub(crate) struct Drive {
    folder: TempDir,
}

impl Drive {
    /// The drive, simulated when it is first asked for.
    pub(crate) fn get() -> &'static Self {
        static DRIVE: OnceLock<Drive> = OnceLock::new();
        DRIVE.get_or_init(|| {
            let drive = Self { folder: TempDir::new().unwrap() };
            fs::write(drive.map(), MAP).unwrap();
            let (map, route) = (drive.map(), drive.route());
            let (map, route) = (map.display(), route.display());
            call_line(&format!("route --map {map} --from 47,9.5 --to 47.0005,9.5006 --out {route}")).done();
            drive.simulate(&drive.path());
            drive
        })
    }

    /// Simulates the drive into a folder.
    pub(crate) fn simulate(&self, out: &Path) {
        let (map, route, out) = (self.map(), self.route(), out.display());
        let (map, route) = (map.display(), route.display());
        let line = format!(
            "simulate --map {map} --route {route} --frames {FRAMES} --size 320x240 --conditions ideal --out {out}"
        );
        call_line(&line).done();
    }

    /// The drive folder.
    pub(crate) fn path(&self) -> PathBuf {
        self.folder.path().join("drive")
    }

    pub(crate) fn map(&self) -> PathBuf {
        self.folder.path().join("map.osm")
    }

    pub(crate) fn route(&self) -> PathBuf {
        self.folder.path().join("planned.geojson")
    }

    pub(crate) fn camera(&self) -> PathBuf {
        self.path().join("camera.toml")
    }

    pub(crate) fn truth(&self) -> PathBuf {
        self.path().join("truth.jsonl")
    }

    /// A folder of one's own with the drive's first `count` pictures.
    pub(crate) fn pictures(&self, count: usize) -> TempDir {
        let folder = TempDir::new().unwrap();
        for index in 0..count {
            let name = format!("{index:06}.jpg");
            fs::copy(self.path().join("frames").join(&name), folder.path().join(&name)).unwrap();
        }
        folder
    }

    /// Arguments of a run on `input` with this drive's camera and route.
    pub(crate) fn run_line(&self, input: &Path, out: &Path) -> String {
        format!(
            "run {} --camera {} --route {} --start-m 5 --out {}",
            input.display(),
            self.camera().display(),
            self.route().display(),
            out.display()
        )
    }
}
