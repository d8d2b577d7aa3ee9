//! The marking page in Debian's Chromium: points are set, dragged and removed, frames stepped, edits undone, marks saved
//! and loaded again, truth exported.

use std::fs;
use std::path::Path;

use fingerpost_format::{MarksFile, marks_from_json};
use fingerpost_io::read_truth;
use serde_json::json;

use crate::chromium::Page;
use crate::painted_drive::{FRAMES, paint_drive};
use crate::served::Served;

/// `fingerpost mark` on a drive.
fn start(drive: &Path, out: &Path) -> Served {
    Served::start([Path::new("mark"), drive, Path::new("--out"), out])
}

/// The marks as they are saved.
fn saved(out: &Path) -> MarksFile {
    marks_from_json(&fs::read_to_string(out.join("marks.json")).unwrap()).unwrap()
}

/// Where the page shows a pixel of the picture.
fn place(page: &mut Page, [u, v]: [f64; 2]) -> [f64; 2] {
    let found = page.value(&format!(
        "(() => {{ const box = document.getElementById('canvas').getBoundingClientRect();
             const [x, y] = window.markView.place([{u}, {v}]); return [box.left + x, box.top + y]; }})()"
    ));
    [found[0].as_f64().unwrap(), found[1].as_f64().unwrap()]
}

fn click(page: &mut Page, at: [f64; 2]) {
    let at = place(page, at);
    page.click(at, "left");
    said(page, "saved");
}

/// Waits for the word that ends an action, and takes it away.
fn said(page: &mut Page, word: &str) {
    page.wait_for(&format!("document.getElementById('message').textContent.includes('{word}')"));
    page.value("document.getElementById('message').textContent = ''");
}

fn wait_for_frame(page: &mut Page, frame: u64, edges: &str) {
    page.wait_for(&format!(
        "document.getElementById('frame').valueAsNumber === {frame}
             && document.getElementById('edges').textContent === '{edges}'"
    ));
}

fn near(found: [f64; 2], expected: [f64; 2]) -> bool {
    // A pixel of the screen is less than one of the picture here.
    (found[0] - expected[0]).abs() <= 1.0 && (found[1] - expected[1]).abs() <= 1.0
}

#[test]
fn marking_with_mouse_and_keys() {
    let folder = tempfile::TempDir::new().unwrap();
    let (drive, out) = (folder.path().join("drive"), folder.path().join("out"));
    paint_drive(&drive);
    let marking = start(&drive, &out);
    let mut page = Page::open(&marking.address);
    page.wait_for("document.body.dataset.ready === 'yes'");

    // The left edge in the first frame: three points, one of them dragged, one removed and brought back.
    for point in [[40.0, 230.0], [100.0, 150.0], [60.0, 190.0]] {
        click(&mut page, point);
    }
    let (from, to) = (place(&mut page, [60.0, 190.0]), place(&mut page, [70.0, 190.0]));
    page.drag(from, to);
    said(&mut page, "saved");
    let points = saved(&out).left[0].points_px.clone();
    assert_eq!(points.len(), 3);
    assert!(near(points[0], [40.0, 230.0]) && near(points[1], [70.0, 190.0]), "{points:?}");
    let at = place(&mut page, [70.0, 190.0]);
    page.click(at, "right");
    said(&mut page, "saved");
    assert_eq!(saved(&out).left[0].points_px.len(), 2);
    page.key("z", 2);
    said(&mut page, "saved");
    assert_eq!(saved(&out).left[0].points_px, points);
    page.key("y", 2);
    said(&mut page, "saved");
    assert_eq!(saved(&out).left[0].points_px.len(), 2);

    // The right edge is not there at first; both are at the end, where the picture is zoomed.
    page.key("2", 0);
    page.key("n", 0);
    said(&mut page, "saved");
    wait_for_frame(&mut page, 0, "left marked (key), right no edge (key)");
    page.value("document.getElementById('export').click()");
    said(&mut page, "not marked in frames");
    page.key("End", 0);
    wait_for_frame(&mut page, FRAMES - 1, "left not marked, right not marked");
    let middle = place(&mut page, [160.0, 228.0]);
    page.wheel_up(middle);
    for point in [[230.0, 215.0], [210.0, 165.0]] {
        click(&mut page, point);
    }
    page.key("1", 0);
    for point in [[60.0, 230.0], [120.0, 150.0]] {
        click(&mut page, point);
    }
    page.key("0", 0);
    let shots = Path::new(env!("CARGO_TARGET_TMPDIR"));
    page.screenshot(&shots.join("marking_key.png"));

    // Between the key frames the left edge is half way, and the right one is not there.
    page.value("const frame = document.getElementById('frame'); frame.value = 5; frame.dispatchEvent(new Event('change'))");
    wait_for_frame(&mut page, 5, "left marked, right no edge");
    page.screenshot(&shots.join("marking_between.png"));
    page.value("document.getElementById('export').click()");
    said(&mut page, "written");
    let truth = read_truth(&out.join("truth.jsonl")).unwrap();
    assert_eq!(truth.len() as u64, FRAMES);
    assert!(near(truth[5].lane_left_px[0], [50.0, 230.0]), "{:?}", truth[5].lane_left_px);
    assert!(truth[5].lane_right_px.is_empty());
    assert!(near(truth[10].lane_right_px[0], [230.0, 215.0]));
    assert!(out.join("tusimple.json").exists());
    page.is_shown_in_every_window("marking");
    page.resize([1280, 800]);
    page.key("PageDown", 0);
    wait_for_frame(&mut page, FRAMES - 1, "left marked (key), right marked (key)");
    page.key("ArrowLeft", 8);
    wait_for_frame(&mut page, 0, "left marked (key), right no edge (key)");
    // The refused export is the only thing that may show up in the console.
    let strange: Vec<_> = page.complaints.iter().filter(|text| !text.contains("409")).collect();
    assert!(strange.is_empty(), "{strange:?}");

    // A program that is killed has lost nothing.
    let before = saved(&out);
    drop(marking);
    let again = start(&drive, &out);
    let mut page = Page::open(&again.address);
    wait_for_frame(&mut page, 0, "left marked (key), right no edge (key)");
    assert_eq!(page.value("document.getElementById('undo').disabled"), json!(true));
    page.key("Backspace", 0);
    said(&mut page, "saved");
    assert_eq!((before.left.len(), saved(&out).left.len()), (2, 1));
}

#[test]
fn other_names_and_other_sites_are_refused() {
    let folder = tempfile::TempDir::new().unwrap();
    let drive = folder.path().join("drive");
    paint_drive(&drive);
    let marking = start(&drive, &folder.path().join("out"));
    let get = |host: &str| {
        marking.ask(&format!("GET /api/state HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n"))
    };
    assert!(get("127.0.0.1:PORT").contains("200"));
    assert!(get("localhost:PORT").contains("200"));
    assert!(get("marks.example:PORT").contains("403"));
    let post = |more: &str| {
        marking.ask(&format!(
            "POST /api/undo HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nConnection: close\r\nContent-Length: 2\r\n{more}\r\n{{}}"
        ))
    };
    assert!(post("Content-Type: application/json\r\n").contains("409"));
    assert!(post("Content-Type: application/json\r\nOrigin: http://marks.example\r\n").contains("403"));
    assert!(post("Content-Type: text/plain\r\n").contains("415"));
}
