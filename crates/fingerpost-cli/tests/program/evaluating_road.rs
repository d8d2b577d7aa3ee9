//! Road detectors on pictures whose road is known.

use std::fs;
use std::path::Path;

use fingerpost_io::{read_picture, write_grey_png, write_png};
use fingerpost_vision::picture::{Plane, RgbImage};
use tempfile::TempDir;

use crate::program::{Called, call_line};

const WIDTH: usize = 96;
const HEIGHT: usize = 72;
const ROAD: u8 = 3;
const VOID: u8 = 11;

/// Folders of pictures and labels: a grey road that widens towards the camera, on green, below a blue sky.
pub(crate) struct Scenes {
    folder: TempDir,
}

impl Scenes {
    pub(crate) fn new() -> Self {
        let folder = TempDir::new().unwrap();
        for sub in ["images", "labels"] {
            fs::create_dir(folder.path().join(sub)).unwrap();
        }
        let scenes = Self { folder };
        for index in [2, 10] {
            scenes.paint(index, HEIGHT);
        }
        scenes
    }

    fn paint(&self, index: usize, label_rows: usize) {
        let (mut picture, mut labels) = (RgbImage::new(WIDTH, HEIGHT), Plane::new(WIDTH, label_rows, 0));
        for row in 0..HEIGHT {
            let (pixels, _) = picture.row_mut(row).as_chunks_mut::<3>();
            for (column, pixel) in pixels.iter_mut().enumerate() {
                let grain = ((column * 7 + row * 13 + index * 5) % 11) as u8;
                let road = row >= HEIGHT / 3 && 2 * column.abs_diff(WIDTH / 2) < row;
                *pixel = match (row < HEIGHT / 3, road) {
                    (true, _) => [120, 170, 230],
                    (_, true) => [100 + grain; 3],
                    _ => [60, 120 + grain, 40],
                };
                if row < label_rows {
                    labels.row_mut(row)[column] = if road { ROAD } else { 7 };
                }
            }
        }
        labels.row_mut(label_rows - 1).fill(VOID);
        write_png(&self.path(&format!("images/f{index}.png")), &picture).unwrap();
        write_grey_png(&self.path(&format!("labels/f{index}.png")), &labels).unwrap();
    }

    pub(crate) fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    fn evaluate(&self, more: &str) -> Called {
        let folder = self.folder.path().display();
        call_line(&format!("evaluate road --images {folder}/images {more}"))
    }

    pub(crate) fn against_labels(&self, more: &str) -> Called {
        let folder = self.folder.path().display();
        self.evaluate(&format!("--labels {folder}/labels --road {ROAD} --void {VOID} {more}"))
    }
}

fn exists(path: &Path) -> bool {
    fs::metadata(path).is_ok_and(|file| file.len() > 0)
}

#[test]
fn every_detector_gets_its_numbers() {
    let scenes = Scenes::new();
    let sheet = scenes.path("sheet.png");
    let called = scenes.against_labels(&format!("--json --sheet {}", sheet.display())).done();
    let numbers: serde_json::Value = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(numbers["frames"], 2);
    let detectors = numbers["detectors"].as_array().unwrap();
    assert!(detectors.iter().any(|of| of["detector"] == "backprojection"));
    assert!(detectors.iter().all(|of| of["detector"] != "onnx"), "no network is given");
    for of in detectors {
        let [max_f, iou] = ["max_f", "iou"].map(|key| of[key].as_f64().unwrap());
        assert!(iou > 0.9 && max_f >= iou && max_f <= 1.0, "{of}");
        assert!((0.0..=1.0).contains(&of["threshold"].as_f64().unwrap()), "{of}");
        assert!(of["ms_per_frame"].as_f64().unwrap() > 0.0, "{of}");
        assert!(called.stderr.contains(of["detector"].as_str().unwrap()), "{}", called.stderr);
    }
    assert!(read_picture(&sheet).unwrap().width() > WIDTH);
}

#[test]
fn one_detector_on_pictures_without_labels_makes_a_sheet() {
    let scenes = Scenes::new();
    let sheet = scenes.path("sheet.png");
    let line = format!("--detector backprojection --stills --json --sheet {}", sheet.display());
    let numbers: serde_json::Value = serde_json::from_str(&scenes.evaluate(&line).done().stdout).unwrap();
    assert_eq!(numbers["detectors"].as_array().unwrap().len(), 1);
    assert_eq!(numbers["detectors"][0].get("iou"), None);
    assert!(exists(&sheet));
    let height_px = || read_picture(&sheet).unwrap().height();
    let without_px = height_px();
    scenes.evaluate(&format!("{line} --ground-view assumed")).done();
    assert!(height_px() > without_px + 200, "a row of ground views for each picture");
    scenes.evaluate(&format!("{line} --ground-view nothing.toml")).refused(1, &["nothing.toml"]);
    scenes.evaluate("--labels x --road 1 --ground-view assumed").refused(2, &["--sheet"]);
}

#[test]
fn what_does_not_belong_together_is_refused() {
    let scenes = Scenes::new();
    scenes.evaluate("").refused(2, &["--labels", "--sheet"]);
    scenes.evaluate("--labels x").refused(2, &["--road"]);
    scenes.against_labels("--detector lidar").refused(2, &["\"lidar\" is no detector", "backprojection"]);
    scenes.against_labels("--from-row 1.5").refused(2, &["1.5", "0 to below 0.95"]);
    scenes.against_labels("--road 9").refused(2, &["--road"]);
    let folder = scenes.folder.path().display().to_string();
    call_line(&format!("evaluate road --images {folder} --sheet {folder}/s.png"))
        .refused(1, &["holds no picture"]);
    scenes
        .evaluate(&format!("--labels {folder}/labels --road 9"))
        .refused(1, &["no pixel of the labels is road (9)"]);

    scenes.paint(10, HEIGHT - 1);
    scenes.against_labels("").refused(1, &["f10.png", "96 x 72", "96 x 71"]);
    fs::remove_file(scenes.path("labels/f10.png")).unwrap();
    scenes.against_labels("").refused(1, &["f10.png has no labels"]);
    fs::remove_file(scenes.path("images/f10.png")).unwrap();
    scenes.paint(12, HEIGHT);
    fs::remove_file(scenes.path("images/f12.png")).unwrap();
    scenes.against_labels("").refused(1, &["f12.png belongs to no picture"]);
    fs::copy(scenes.path("images/f2.png"), scenes.path("labels/f2.png")).unwrap();
    fs::remove_file(scenes.path("labels/f12.png")).unwrap();
    scenes.against_labels("").refused(1, &["f2.png is a coloured picture"]);
}
