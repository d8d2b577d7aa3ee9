//! A recorded drive, of the folder named by FINGERPOST_DATA, set up by eye and run. Missing data is a failure.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::chromium::Page;
use crate::served::Served;
use crate::set_up_page::{mount, read_camera};
use crate::simulated_drive::call;

/// The camera of KITTI odometry 00 by its calibration, as if it were level.
const LEVEL_CAMERA: &str = "[image]\nwidth = 1241\nheight = 376\n\
    [intrinsics]\nfx = 718.856\nfy = 718.856\ncx = 607.1928\ncy = 185.2157\n\
    [mount]\nheight_m = 1.65\npitch_deg = 0.0\nx_m = 1.5\n";
/// Of its camera, by the alignment of its ground views: 0.6 to 0.9.
const PITCH_DEG: f64 = 0.75;

fn data(name: &str) -> PathBuf {
    let path = PathBuf::from(std::env::var("FINGERPOST_DATA").unwrap()).join(name);
    assert!(path.exists(), "{} is missing", path.display());
    path
}

/// The number of the page's pitch.
fn pitch_deg(page: &mut Page) -> f64 {
    page.value("document.getElementById('pitch_deg').valueAsNumber").as_f64().unwrap()
}

fn wait_for_search(page: &mut Page, state: &str) {
    page.wait_for(&format!("document.body.dataset.search === '{state}'"));
}

#[test]
fn the_pitch_of_a_recorded_drive_is_dragged_right() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("level.toml"), LEVEL_CAMERA).unwrap();
    let (drive, level, saved) = (data("kitti/frames00"), path("level.toml"), path("camera.toml"));
    let arguments = [Path::new("look"), &drive, Path::new("--camera"), &level, Path::new("--save"), &saved];
    let served = Served::start(arguments);
    let mut page = Page::open(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes' && document.body.dataset.drawn");
    page.is_shown_in_every_window("recorded_level");
    page.resize([1280, 800]);

    // As far up as the horizon goes by that pitch.
    let scale = page.value("document.getElementById('stage').clientWidth").as_f64().unwrap() / 1241.0;
    let up = (libm::tan(PITCH_DEG.to_radians()) * 718.856 * scale).round();
    page.drag([300.0, 250.0], [300.0, 250.0 - up]);
    page.wait_for(
        "JSON.parse(document.body.dataset.drawn).pitch_deg === document.getElementById('pitch_deg').valueAsNumber",
    );
    let horizon_px = page.value("document.querySelector('#overlay .horizon').points[0].y").as_f64().unwrap();
    assert!(
        (horizon_px - (185.2157 - libm::tan(PITCH_DEG.to_radians()) * 718.856)).abs() < 1.3,
        "{horizon_px}"
    );
    page.is_shown_in_every_window("recorded_pitched");
    page.value("document.getElementById('keep').click()");
    page.wait_for("!document.getElementById('command').hidden");

    let dragged_deg = mount(&read_camera(&saved)).pitch_rad.to_degrees();
    println!("dragged to a pitch of {dragged_deg:.3} degrees");
    assert!((dragged_deg - PITCH_DEG).abs() < 0.1, "{dragged_deg}");
    let command = page.value("document.getElementById('command').textContent");
    let command = command.as_str().unwrap().strip_prefix("fingerpost ").unwrap().strip_suffix("run").unwrap();
    call(&format!("{command}{} --frames 20 --no-recording", path("run").display()));

    // The grid fits: its lines meet where the drive's own motion says that the vehicle drives to. While that is searched for, it can be
    // stopped.
    page.value("document.getElementById('search').click()");
    wait_for_search(&mut page, "running");
    page.value("document.getElementById('stop').click()");
    wait_for_search(&mut page, "idle");
    assert!((pitch_deg(&mut page) - dragged_deg).abs() < 1e-3);
    page.value("document.getElementById('search').click()");
    page.wait_for(
        "document.getElementById('progress').max === 130 && document.getElementById('progress').value > 0",
    );
    page.is_shown_in_every_window("recorded_searching");
    wait_for_search(&mut page, "found");
    let found_deg = pitch_deg(&mut page);
    println!("calibrated to a pitch of {found_deg:.3} degrees");
    assert!((found_deg - dragged_deg).abs() < 0.1, "{found_deg} and {dragged_deg}");
    page.is_shown_in_every_window("recorded_calibrated");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
