//! Runs of simulated drives through the town.

use std::fs;
use std::path::{Path, PathBuf};

use fingerpost_format::{FrameRecord, from_json_lines};
use tempfile::TempDir;

use crate::served::Served;
use crate::simulated_drive::{call, simulate, town};

/// A simulated drive and the run that was made of it.
pub(crate) struct Run {
    folder: TempDir,
}

impl Run {
    /// Of so many frames.
    pub(crate) fn make(frames: usize) -> Self {
        let run = Self { folder: TempDir::new().unwrap() };
        simulate(frames, &run.drive());
        run.again("run", "");
        run
    }

    /// Of so many frames of 640 x 480 pixels, 20 a second; of a quarter of them where the program is not optimised, which takes ten times
    /// as long.
    pub(crate) fn make_large(frames: usize) -> Self {
        let run = Self { folder: TempDir::new().unwrap() };
        let (map, route) = (town("town.osm"), town("town_route.geojson"));
        let (map, route, drive) = (map.display(), route.display(), run.drive());
        let size = if cfg!(debug_assertions) { "320x240" } else { "640x480" };
        call(&format!(
            "simulate --map {map} --route {route} --frames {frames} --size {size} --fps 20 --out {}",
            drive.display()
        ));
        run.again("run", "");
        run
    }

    /// Runs the drive into a folder of that name, with more arguments.
    pub(crate) fn again(&self, name: &str, more: &str) {
        let (drive, route, out) = (self.drive(), town("town_route.geojson"), self.path(name));
        let (drive, route, out) = (drive.display(), route.display(), out.display());
        let line = format!(
            "run {drive} --camera {drive}/camera.toml --route {route} --start-m 0 --out {out} {more}"
        );
        call(line.trim_end());
    }

    /// A path beside drive and run.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    pub(crate) fn drive(&self) -> PathBuf {
        self.path("drive")
    }

    pub(crate) fn out(&self) -> PathBuf {
        self.path("run")
    }

    pub(crate) fn records(&self) -> Vec<FrameRecord> {
        from_json_lines(&fs::read_to_string(self.out().join("frames.jsonl")).unwrap()).unwrap()
    }

    pub(crate) fn serve(&self, option: &str, path: &Path) -> Served {
        self.serve_with(&[(option, path)])
    }

    /// Serves the run with these options.
    pub(crate) fn serve_with(&self, options: &[(&str, &Path)]) -> Served {
        let out = self.out();
        let options = options.iter().flat_map(|(option, path)| [Path::new(option), path]);
        Served::start([Path::new("look"), &out].into_iter().chain(options))
    }
}
