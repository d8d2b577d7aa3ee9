//! A video set up by eye.

use std::fs;
use std::path::Path;
use std::process::Command;

use fingerpost_format::camera_to_toml;
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use serde_json::json;
use tempfile::TempDir;

use crate::chromium::Page;
use crate::served::Served;

/// Of a long video every so many-th frame is shown.
#[test]
fn a_video_is_set_up() {
    let folder = TempDir::new().unwrap();
    let [video, camera, saved] =
        ["long.mp4", "rough.toml", "camera.toml"].map(|name| folder.path().join(name));
    let made = Command::new("ffmpeg")
        .args(["-v", "error", "-f", "lavfi", "-i", "testsrc2=size=320x240:rate=25:duration=20"])
        .arg(&video)
        .status();
    assert!(made.unwrap().success());
    let intrinsics = Intrinsics { fx: 300.0, fy: 300.0, cx: 159.5, cy: 119.5 };
    let level = Mount { pitch_rad: 0.1, ..Mount::level(1.4) };
    let rough = Camera::calibrated(320, 240, intrinsics, Distortion::None, level).unwrap();
    fs::write(&camera, camera_to_toml(&rough).unwrap()).unwrap();
    let arguments = [Path::new("look"), &video, Path::new("--camera"), &camera, Path::new("--save"), &saved];
    let served = Served::start(arguments);
    let mut page = Page::open(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes' && document.body.dataset.drawn");
    // 500 frames, of which 240 at the most are kept.
    let drive = page.value(
        "fetch('api/drive').then((answer) => answer.json()).then((drive) => [drive.frames, drive.frame_step])",
    );
    assert_eq!(drive, json!([167, 3]));
    let pixels = "(() => {
        const canvas = document.createElement('canvas'); [canvas.width, canvas.height] = [320, 240];
        const drawing = canvas.getContext('2d'); drawing.drawImage(document.getElementById('picture'), 0, 0);
        return [...drawing.getImageData(0, 0, 320, 240).data].join(); })()";
    let first = page.value(pixels);
    for (wanted, shown) in [(250, 249), (1_000_000, 498)] {
        page.value(&format!(
            "{{ const frame = document.getElementById('frame'); frame.value = {wanted}; frame.dispatchEvent(new Event('change')); }}"
        ));
        page.wait_for(&format!("JSON.parse(document.body.dataset.drawn).frame === {shown}"));
        assert_ne!(page.value(pixels), first, "frame {shown}");
    }
    page.value("document.getElementById('keep').click()");
    page.wait_for("!document.getElementById('command').hidden");
    let command = page.value("document.getElementById('command').textContent");
    assert!(command.as_str().unwrap().contains(&format!("run {} --camera", video.display())), "{command}");
    // What shows no drive is said, and the mount stays.
    page.value("document.getElementById('search').click()");
    page.wait_for("document.body.dataset.search === 'failed'");
    let said = page.value("document.getElementById('searched').textContent");
    assert!(said.as_str().unwrap().contains("cannot be trusted"), "{said}");
    assert_eq!(page.value("document.getElementById('pitch_deg').valueAsNumber"), json!(5.7296));
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
