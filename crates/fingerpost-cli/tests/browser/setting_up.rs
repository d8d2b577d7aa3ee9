//! A drive set up by eye: a mount that is wrong is dragged right or calibrated, its ground view follows, the start is dragged along the
//! route, and what is saved is what was set.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use fingerpost_format::{camera_from_toml, camera_to_toml};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, View};
use fingerpost_map::read_route;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::chromium::Page;
use crate::served::Served;
use crate::simulated_drive::{call, simulate, town};

/// How wrong the calibration is at first, degrees.
const PITCH_OFF_DEG: f64 = 1.5;
const YAW_OFF_DEG: f64 = -2.0;

fn mount(camera: &Camera) -> Mount {
    let View::Calibrated { mount, .. } = camera.view() else { panic!("a camera with a mount") };
    *mount
}

fn read_camera(path: &Path) -> Camera {
    camera_from_toml(&fs::read_to_string(path).unwrap()).unwrap()
}

/// What the page has drawn last.
fn drawn(page: &mut Page) -> Value {
    serde_json::from_str(page.value("document.body.dataset.drawn").as_str().unwrap()).unwrap()
}

/// Waits until a number of the mount is drawn as it stands.
fn wait_for_drawing(page: &mut Page, name: &str) {
    page.wait_for(&format!(
        "JSON.parse(document.body.dataset.drawn).{name} === document.getElementById('{name}').valueAsNumber"
    ));
}

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

/// The files of a drive of so many frames, and its camera on a mount that is turned by so many degrees of pitch.
struct RoughDrive {
    folder: TempDir,
    truth: Mount,
}

impl RoughDrive {
    fn simulate(frames: usize, pitch_off_deg: f64) -> Self {
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

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }
}

/// How far ahead the first junction is drawn, metres, and where in the picture.
fn junction(page: &mut Page) -> (f64, [f64; 2]) {
    let seen = page.value(
        "(async () => {
            const { height_m, pitch_deg, yaw_deg, roll_deg, start_m } = JSON.parse(document.body.dataset.drawn);
            const path = `api/mounts/${[height_m, pitch_deg, yaw_deg, roll_deg]}/starts/${start_m}/shapes`;
            const shapes = await (await fetch(path)).json();
            const ring = document.querySelector('#overlay circle.feature');
            const place = [ring.cx.baseVal.value, ring.cy.baseVal.value];
            return [shapes.find(({ kind }) => kind === 'feature').ground_m[0][0], place];
        })()",
    );
    (seen[0].as_f64().unwrap(), [0, 1].map(|axis| seen[1][axis].as_f64().unwrap()))
}

#[test]
fn the_start_is_dragged_along_the_route() {
    let rough = RoughDrive::simulate(5, 0.0);
    let (map, route) = (town("town.osm"), town("town_route.geojson"));
    let first = read_route(&fs::read_to_string(&route).unwrap()).unwrap().features[0].route_m;
    let [drive, camera, saved, saved_route] =
        ["drive", "rough.toml", "camera.toml", "route.geojson"].map(|name| rough.path(name));
    let arguments: [&OsStr; 12] = [
        "look".as_ref(),
        drive.as_ref(),
        "--camera".as_ref(),
        camera.as_ref(),
        "--map".as_ref(),
        map.as_ref(),
        "--route".as_ref(),
        route.as_ref(),
        "--save".as_ref(),
        saved.as_ref(),
        "--save-route".as_ref(),
        saved_route.as_ref(),
    ];
    let served = Served::start(arguments);
    let mut page = Page::open(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes' && document.body.dataset.drawn");
    let (ahead_m, _) = junction(&mut page);
    assert!((ahead_m - first).abs() < 0.1, "{ahead_m} m to the feature at {first} m");

    // The arrow stands in the middle of the map; the route is dragged to where it is 30 m on.
    let places = page.value(
        "(() => {
            const svg = document.getElementById('map'), into = svg.getScreenCTM();
            const line = document.querySelector('#map .route');
            return [0, 30].map((along) => {
                const { x, y } = line.getPointAtLength(along).matrixTransform(into); return [x, y]; });
        })()",
    );
    let [from, to] = [0, 1].map(|end| [0, 1].map(|axis| places[end][axis].as_f64().unwrap()));
    page.drag(from, to);
    page.wait_for("JSON.parse(document.body.dataset.drawn).start_m > 20");
    wait_for_start(&mut page);
    let start_m = drawn(&mut page)["start_m"].as_f64().unwrap();
    assert!((start_m - 30.0).abs() < 0.5, "{start_m}");
    let (ahead_m, [_, below]) = junction(&mut page);
    assert!((ahead_m - (first - start_m)).abs() < 0.1, "{ahead_m} m to the feature at {first} m");
    // By the keys of its slider, half a metre each.
    page.value("document.getElementById('start-slider').focus()");
    for key in ["ArrowRight", "ArrowRight", "ArrowLeft"] {
        page.key(key, 0);
    }
    wait_for_start(&mut page);
    let moved_m = drawn(&mut page)["start_m"].as_f64().unwrap();
    assert!((moved_m - start_m - 0.5).abs() < 1e-6, "{start_m} to {moved_m}");
    assert!(junction(&mut page).1[1] > below, "what is nearer lies lower");
    // More and less of the map, about the start.
    let across = |page: &mut Page, button: &str| {
        page.value(&format!("document.getElementById('{button}').click()"));
        page.value("document.getElementById('map').viewBox.baseVal.width")
    };
    assert_eq!(["farther", "farther", "nearer"].map(|button| across(&mut page, button)), [500, 1000, 500]);
    page.screenshot(&Path::new(env!("CARGO_TARGET_TMPDIR")).join("set_up_map_500.png"));
    across(&mut page, "nearer");
    // The start is that of the first frame.
    let routes = "document.querySelectorAll('#overlay polyline.route').length";
    assert_eq!(page.value(routes), json!(1));
    page.value("const seek = document.getElementById('seek'); seek.value = 3; seek.dispatchEvent(new Event('input'))");
    page.wait_for("JSON.parse(document.body.dataset.drawn).frame === 3");
    assert_eq!(page.value(routes), json!(0));
    page.value("seek.value = 0; seek.dispatchEvent(new Event('input'))");
    page.wait_for("JSON.parse(document.body.dataset.drawn).frame === 0");

    page.value("document.getElementById('keep').click()");
    page.wait_for("!document.getElementById('command').hidden");
    let command = page.value("document.getElementById('command').textContent");
    let command = command.as_str().unwrap();
    assert!(command.ends_with(&format!("--start-m {moved_m:.1} --out run")), "{command}");
    // The fix on the map begins there too.
    assert!(command.contains(" --near 47.21"), "{command}");
    let [kept, given] = [&saved_route, &route].map(|path| fs::read_to_string(path).unwrap());
    assert_eq!(read_route(&kept).unwrap(), read_route(&given).unwrap());
    let command = command.strip_prefix("fingerpost ").unwrap().strip_suffix("run").unwrap();
    call(&format!("{command}{}", rough.path("run").display()));
    let report = fs::read_to_string(rough.path("run").join("report.html")).unwrap();
    assert!(report.contains(&format!("--start-m {moved_m:.1}")));
    page.has_names();
    page.value("document.activeElement.blur(), scrollTo(0, 0)");
    page.is_shown_in_every_window("set_up_route");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}

/// Waits until the start is drawn as it stands.
fn wait_for_start(page: &mut Page) {
    page.wait_for(
        "JSON.parse(document.body.dataset.drawn).start_m === document.getElementById('start').valueAsNumber",
    );
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
