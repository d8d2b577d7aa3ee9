//! Road detectors that ask a network, in ONNX Runtime itself: its library is the one that `FINGERPOST_ONNX_LIBRARY` names.

use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::Command;

use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::evaluating_road::Scenes;
use crate::program::{Called, command, frames};

/// The network that takes green for road.
const MODEL: &str =
    concat!("\"", env!("CARGO_MANIFEST_DIR"), "/../fingerpost-onnx/tests/models/green_is_road.onnx\"");

/// A configuration file in a folder of its own.
struct Configured {
    folder: TempDir,
}

impl Configured {
    /// A detector and its network, which is told that all is road that is not green; one of its settings is another.
    fn new(detector: &str, (key, value): (&str, &str)) -> Self {
        let mut network = BTreeMap::from([
            ("model", MODEL),
            ("width_px", "96"),
            ("height_px", "72"),
            ("road_classes", "[0]"),
        ]);
        network.insert(key, value);
        let network: String = network.iter().map(|(key, value)| format!("onnx.{key} = {value}\n")).collect();
        let folder = TempDir::new().unwrap();
        let text = format!("[road_surface]\ndetector = \"{detector}\"\nmemory.of = \"onnx\"\n{network}");
        fs::write(folder.path().join("fingerpost.toml"), text).unwrap();
        Self { folder }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("fingerpost.toml")
    }

    fn out(&self) -> PathBuf {
        self.folder.path().join("run")
    }

    fn run(&self) -> Command {
        let drive = Drive::get();
        let mut run = command();
        run.args(drive.run_line(&drive.path(), &self.out()).split_whitespace());
        run.arg("--config").arg(self.path());
        run
    }
}

#[test]
fn a_network_stands_in_the_table_of_detectors() {
    let (scenes, configured) = (Scenes::new(), Configured::new("combined", ("threads", "2")));
    let called = scenes.against_labels(&format!("--json --config {}", configured.path().display())).done();
    let numbers: serde_json::Value = serde_json::from_str(&called.stdout).unwrap();
    let detectors = numbers["detectors"].as_array().unwrap();
    for name in ["onnx", "memory", "combined"] {
        let of = detectors.iter().find(|of| of["detector"] == name).unwrap();
        assert!(of["iou"].as_f64().unwrap() > 0.9, "{of}");
    }
}

#[test]
fn a_run_remembers_what_a_network_finds() {
    let configured = Configured::new("memory", ("output", "\"scores\""));
    Called::from(configured.run().output().unwrap()).done();
    let records = frames(&configured.out());
    assert_eq!(records.len(), FRAMES);
    for record in &records {
        assert_eq!(record.error, None);
        let surface = record.surface.as_ref().unwrap();
        assert_eq!(surface.detector, "memory");
        assert!(surface.p > 0.3, "grey is as likely road as not: {surface:?}");
    }
}

#[test]
fn what_cannot_be_run_is_refused_with_the_reason() {
    let refused = |setting, words: &[&str]| {
        let output = Configured::new("onnx", setting).run().output().unwrap();
        Called::from(output).refused(1, words);
    };
    refused(("model", "\"\""), &["road_surface.onnx.model", "give the path"]);
    refused(("model", "\"nothing.onnx\""), &["nothing.onnx", "cannot be read"]);
    refused(("model", "\"Cargo.toml\""), &["Cargo.toml", "cannot be loaded"]);
    refused(("width_px", "7"), &["road_surface.onnx.width_px = 7", "16 to 4096"]);
    refused(("layout", "\"nhwc\""), &["green_is_road.onnx", "1 x 3 x ? x ?", "layout"]);
    refused(("road_classes", "[5]"), &["road_surface.onnx.road_classes", "2 classes"]);
    refused(("output", "\"masks\""), &["road_surface.onnx.output", "scores"]);
    refused(("library", "\"/nowhere/lib.so\""), &["/nowhere/lib.so", "install"]);
    let configured = Configured::new("onnx", ("library", "\"\""));
    let output = configured.run().env("FINGERPOST_ONNX_LIBRARY", "/elsewhere/lib.so").output().unwrap();
    Called::from(output).refused(1, &["/elsewhere/lib.so", "FINGERPOST_ONNX_LIBRARY"]);
}
