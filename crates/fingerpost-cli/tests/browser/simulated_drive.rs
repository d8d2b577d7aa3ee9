//! Simulated drives through the town.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A file that the simulator ships.
pub(crate) fn town(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../fingerpost-sim/assets").join(name)
}

/// Simulates so many frames of 320 x 240 pixels into a folder.
pub(crate) fn simulate(frames: usize, drive: &Path) {
    let (map, route) = (town("town.osm"), town("town_route.geojson"));
    let (map, route, drive) = (map.display(), route.display(), drive.display());
    call(&format!("simulate --map {map} --route {route} --frames {frames} --size 320x240 --out {drive}"));
}

/// Calls the program with a line of arguments that hold no spaces; it must end well.
pub(crate) fn call(line: &str) {
    let called = Command::new(env!("CARGO_BIN_EXE_fingerpost")).args(line.split(' ')).output().unwrap();
    assert!(called.status.success(), "{line}: {}", String::from_utf8_lossy(&called.stderr));
}
