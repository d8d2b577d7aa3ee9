//! A drive set up by eye: a mount that is wrong is dragged right or calibrated, its ground view follows, and what is saved is what was set.

use std::fs;
use std::path::Path;

use fingerpost_format::camera_to_toml;
use fingerpost_geometry::Mount;
use tempfile::TempDir;

use crate::chromium::Page;
use crate::served::Served;
use crate::set_up_page::{RoughDrive, drawn, mount, read_camera, wait_for_drawing};
use crate::simulated_drive::simulate;

/// How wrong the calibration is at first, degrees.
const PITCH_OFF_DEG: f64 = 1.5;
const YAW_OFF_DEG: f64 = -2.0;

#[test]
fn a_mount_that_is_wrong_is_dragged_right_and_saved() {
    let folder = TempDir::new().unwrap();
    let path = |name: &str| folder.path().join(name);
    simulate(5, &path("drive"));
    let right = read_camera(&path("drive").join("camera.toml"));
    let truth = mount(&right);
    let off = Mount {
        pitch_rad: truth.pitch_rad + PITCH_OFF_DEG.to_radians(),
        yaw_rad: truth.yaw_rad + YAW_OFF_DEG.to_radians(),
        ..truth
    };
    fs::write(path("rough.toml"), camera_to_toml(&right.with_mount(off).unwrap()).unwrap()).unwrap();
    let (drive, rough, saved) = (path("drive"), path("rough.toml"), path("camera.toml"));
    let arguments = [Path::new("look"), &drive, Path::new("--camera"), &rough, Path::new("--save"), &saved];
    let served = Served::start(arguments);
    let mut page = Page::open(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes' && document.body.dataset.drawn");
    let shots = Path::new(env!("CARGO_TARGET_TMPDIR"));
    page.screenshot(&shots.join("set_up_wrong_1280.png"));

    // The horizon goes down by the pitch and the road to the right by the yaw, to within a pixel of the screen.
    let scale = page.value("document.getElementById('stage').clientWidth").as_f64().unwrap() / 320.0;
    let focal =
        page.value("fetch('api/drive').then((answer) => answer.json()).then((drive) => drive.focal_px)");
    let moved = |axis: usize, angle_deg: f64| {
        (libm::tan(angle_deg.to_radians()) * focal[axis].as_f64().unwrap() * scale).round()
    };
    page.drag([300.0, 300.0], [300.0 + moved(0, -YAW_OFF_DEG), 300.0 + moved(1, PITCH_OFF_DEG)]);
    wait_for_drawing(&mut page, "pitch_deg");
    let now = drawn(&mut page);
    let near = |name: &str, expected_rad: f64| {
        let off_deg = now[name].as_f64().unwrap() - expected_rad.to_degrees();
        assert!(off_deg.abs() < 0.1, "{name} is off by {off_deg} degrees");
    };
    near("pitch_deg", truth.pitch_rad);
    near("yaw_deg", truth.yaw_rad);

    // The height by keys of its slider, a step of a centimetre each.
    page.value("document.getElementById('height_m-slider').focus()");
    for key in ["ArrowRight", "ArrowRight", "ArrowLeft"] {
        page.key(key, 0);
    }
    wait_for_drawing(&mut page, "height_m");
    let now = drawn(&mut page);
    assert!((now["height_m"].as_f64().unwrap() - truth.height_m - 0.01).abs() < 1e-3, "{now}");
    // It has to take no more than 100 ms where the program is optimised.
    println!("from a mount to its ground view: {:.0} ms", now["ms"].as_f64().unwrap());

    page.value("document.getElementById('keep').click()");
    page.wait_for("!document.getElementById('command').hidden");
    let command = page.value("document.getElementById('command').textContent");
    assert!(command.as_str().unwrap().contains(&format!("--camera {}", saved.display())), "{command}");
    let kept = mount(&read_camera(&saved));
    assert!((kept.pitch_rad.to_degrees() - now["pitch_deg"].as_f64().unwrap()).abs() < 1e-4);
    assert!((kept.height_m - now["height_m"].as_f64().unwrap()).abs() < 1e-6);
    assert_eq!((kept.x_m, kept.y_m), (truth.x_m, truth.y_m));

    // A mount that looks elsewhere is said, and the page goes on.
    page.value("const pitch = document.getElementById('pitch_deg'); pitch.value = -60; pitch.dispatchEvent(new Event('input'))");
    page.wait_for("document.getElementById('message').textContent.includes('No picture')");
    page.value("document.getElementById('again').click()");
    page.wait_for("document.getElementById('message').textContent === ''");
    page.drag([300.0, 300.0], [300.0 + moved(0, -YAW_OFF_DEG), 300.0 + moved(1, PITCH_OFF_DEG)]);
    wait_for_drawing(&mut page, "pitch_deg");
    page.has_names();
    page.value("document.activeElement.blur(), scrollTo(0, 0)");
    page.is_shown_in_every_window("set_up");
}

#[test]
fn a_mount_is_calibrated_from_the_drive() {
    let rough = RoughDrive::simulate(60, 1.0);
    let [drive, camera, saved] = ["drive", "rough.toml", "camera.toml"].map(|name| rough.path(name));
    let arguments = [Path::new("look"), &drive, Path::new("--camera"), &camera, Path::new("--save"), &saved];
    let served = Served::start(arguments);
    let mut page = Page::open(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes' && document.body.dataset.drawn");
    page.value("document.getElementById('search').click()");
    page.wait_for("document.body.dataset.search === 'found'");
    wait_for_drawing(&mut page, "pitch_deg");
    let off_deg = drawn(&mut page)["pitch_deg"].as_f64().unwrap() - rough.truth.pitch_rad.to_degrees();
    assert!(off_deg.abs() < 0.3, "off by {off_deg} degrees");
    let said = page.value("document.getElementById('searched').textContent");
    assert!(said.as_str().unwrap().contains("60 frames"), "{said}");
    page.is_shown_in_every_window("set_up_calibrated");
    // Pages of other sites begin no search and write nothing.
    let post = |path: &str, more: &str| {
        served.ask(&format!(
            "POST {path} HTTP/1.1\r\nHost: 127.0.0.1:PORT\r\nConnection: close\r\nContent-Length: 2\r\n{more}\r\n{{}}"
        ))
    };
    for path in ["/api/search", "/api/search/stop", "/api/set_up"] {
        let json = "Content-Type: application/json\r\n";
        assert!(post(path, &format!("{json}Origin: http://drive.example\r\n")).contains("403"), "{path}");
        assert!(post(path, "Content-Type: text/plain\r\n").contains("415"), "{path}");
    }
    assert!(!saved.exists());
    page.value("document.getElementById('keep').click()");
    page.wait_for("!document.getElementById('command').hidden");
    let kept_deg = mount(&read_camera(&saved)).pitch_rad.to_degrees();
    assert!((kept_deg - rough.truth.pitch_rad.to_degrees() - off_deg).abs() < 1e-3, "{kept_deg}");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}
