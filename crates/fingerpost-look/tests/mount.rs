//! What the page that sets a drive up asks, without a network.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, Pixel, Polyline, View};
use fingerpost_look::{
    DriveFrames, DriveSources, GroundArea, GroundViews, Kept, MountPage, MountSearch, RouteMap, RoutePlace,
    SearchState, SetUpKeeper,
};
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use nalgebra::Point2;
use serde_json::{Value, json};

/// Pictures, ground views, files and search of a drive, each saying what it was asked for.
struct Drive;

fn picture(text: &str) -> Picture {
    Picture { content_type: "image/png", bytes: text.as_bytes().to_vec() }
}

fn mount(camera: &Camera) -> Mount {
    match camera.view() {
        View::Calibrated { mount, .. } => *mount,
        View::RoadPlane(_) => Mount::level(0.0),
    }
}

impl Pictures for Drive {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        Ok(picture(&frame.to_string()))
    }
}

impl GroundViews for Drive {
    fn ground_view(&self, frame: u64, camera: &Camera) -> Result<Picture, Cause> {
        let Mount { height_m, pitch_rad, x_m, .. } = mount(camera);
        if pitch_rad < 0.0 {
            return Err("the camera looks elsewhere".into());
        }
        Ok(picture(&format!(
            "frame {frame} from {height_m} m, {:.1} degrees, {x_m} m",
            pitch_rad.to_degrees()
        )))
    }
}

impl SetUpKeeper for Drive {
    fn keep(&self, camera: &Camera, start_m: Option<f64>) -> Result<Kept, Cause> {
        let pitch_deg = mount(camera).pitch_rad.to_degrees();
        Ok(Kept { files: vec!["camera.toml".to_owned()], command: format!("{pitch_deg:.2} {start_m:?}") })
    }
}

impl MountSearch for Drive {
    fn begin(&self, camera: &Camera) -> Result<(), Cause> {
        if mount(camera).roll_rad == 0.0 { Ok(()) } else { Err("a calibration goes on already".into()) }
    }

    fn stop(&self) {}

    fn state(&self) -> SearchState {
        let said = vec!["pitch: 2 degrees".to_owned()];
        SearchState::Found { mount: Mount { pitch_rad: 2.0_f64.to_radians(), ..Mount::level(1.4) }, said }
    }
}

const AREA: GroundArea = GroundArea { near_m: 4.0, far_m: 20.0, half_width_m: 10.0 };

fn page_of(camera: Camera) -> Option<MountPage> {
    let frames = DriveFrames { title: "drive".to_owned(), count: 3, step: 2 };
    let sources = DriveSources {
        pictures: Box::new(Drive),
        ground_views: Box::new(Drive),
        keeper: Box::new(Drive),
        search: Box::new(Drive),
    };
    MountPage::new(frames, camera, AREA, sources)
}

fn page() -> MountPage {
    let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
    let mount = Mount { pitch_rad: 0.05, x_m: 1.5, ..Mount::level(1.4) };
    page_of(Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap()).unwrap()
}

/// A route of 100 m to the east with a junction in its middle.
fn page_with_route() -> MountPage {
    let line = Polyline::new([Point2::new(0.0, 0.0), Point2::new(100.0, 0.0)]).unwrap();
    let road = vec![Point2::new(50.0, -80.0), Point2::new(50.0, 80.0)];
    let junction = RoutePlace { p_in_map: Point2::new(50.0, 0.0), label: "junction".to_owned() };
    page().with_route(RouteMap::new(line, vec![road], vec![junction]), 12.0)
}

fn ask(method: &str, path: &str, body: &Value) -> Answer {
    asked(&page(), method, path, body)
}

fn asked(page: &MountPage, method: &str, path: &str, body: &Value) -> Answer {
    page.answer(Request { method, path, body: body.to_string().as_bytes() })
}

fn text(answer: Answer) -> String {
    String::from_utf8(answer.body).unwrap()
}

#[test]
fn the_page_begins_with_the_cameras_mount() {
    let drive: Value = serde_json::from_slice(&ask("GET", "/api/drive", &Value::Null).body).unwrap();
    assert_eq!(
        drive["mount"],
        json!({"height_m": 1.4, "pitch_deg": 2.864789, "yaw_deg": 0.0, "roll_deg": 0.0})
    );
    assert_eq!((&drive["picture_px"], &drive["frames"]), (&json!([640, 480]), &json!(3)));
    assert_eq!((&drive["frame_step"], &drive["route"]), (&json!(2), &Value::Null));
    for path in [
        "/",
        "/mount.js",
        "/route_map.js",
        "/search.js",
        "/shapes.js",
        "/frames.js",
        "/look.css",
        "/mount.css",
    ] {
        assert_eq!(ask("GET", path, &Value::Null).status, 200, "{path}");
    }
}

#[test]
fn another_mount_gives_another_grid_and_ground_view() {
    let grid = text(ask("GET", "/api/mounts/1.5,0,0,0/shapes", &Value::Null));
    let grid: Vec<Value> = serde_json::from_str(&grid).unwrap();
    assert_eq!(grid[0]["kind"], "horizon");
    let ten = grid.iter().find(|shape| shape["label"] == "10 m ahead").unwrap();
    // 8.5 m before the camera and 1.5 m below it.
    let v = ten["picture_px"][0][0][1].as_f64().unwrap();
    assert!((v - 239.5 - 500.0 * 1.5 / 8.5).abs() < 0.01, "{v}");
    let view = text(ask("GET", "/api/mounts/1.5,2,0,0/frames/2", &Value::Null));
    assert_eq!(view, "frame 2 from 1.5 m, 2.0 degrees, 1.5 m");
    assert_eq!(text(ask("GET", "/api/frames/4/picture", &Value::Null)), "4");
}

#[test]
fn what_is_no_mount_or_shows_nothing_is_said() {
    for (path, status, word) in [
        ("/api/mounts/1.5,2,0/shapes", 400, "HEIGHT_M"),
        ("/api/mounts/1.5,2,0,x/shapes", 400, "HEIGHT_M"),
        ("/api/mounts/NaN,0,0,0/shapes", 400, "mount.height_m"),
        ("/api/mounts/1.5,89,0,0/frames/0", 400, "mount.pitch_deg"),
        ("/api/mounts/1.5,-1,0,0/frames/0", 422, "elsewhere"),
        ("/api/mounts/1.5,0,0,0/frames/6", 404, "there are 3"),
        ("/api/mounts/1.5,0,0,0/frames/1", 404, "in steps of 2"),
        ("/api/mounts/1.5,0,0,0/starts/5/shapes", 404, "--route"),
        ("/api/frames/-1/picture", 404, "there are 3"),
        ("/api/run", 404, "no such"),
    ] {
        let answer = ask("GET", path, &Value::Null);
        assert_eq!(answer.status, status, "{path}");
        assert!(text(answer).contains(word), "{path}");
    }
}

#[test]
fn the_route_is_seen_from_its_start() {
    let page = page_with_route();
    let get = |path: &str| asked(&page, "GET", path, &Value::Null);
    let drive: Value = serde_json::from_slice(&get("/api/drive").body).unwrap();
    assert_eq!(
        (&drive["route"]["start_m"], &drive["route"]["map"]["length_m"]),
        (&json!(12.0), &json!(100.0))
    );
    for start_m in [0.0, 12.0, 20.5] {
        let shapes = get(&format!("/api/mounts/1.5,0,0,0/starts/{start_m}/shapes"));
        let shapes: Vec<Value> = serde_json::from_slice(&shapes.body).unwrap();
        assert_eq!(shapes[0]["kind"], "horizon");
        let junction = shapes.iter().find(|shape| shape["kind"] == "feature").unwrap();
        assert_eq!(junction["ground_m"], json!([[50.0 - start_m, 0.0]]));
        // As far before the camera as it is, and 1.5 m below it.
        let v = junction["picture_px"][0][0][1].as_f64().unwrap();
        assert!((v - 239.5 - 500.0 * 1.5 / (50.0 - start_m - 1.5)).abs() < 0.01, "{v}");
    }
    for start_m in ["-1", "100.1", "NaN", "x"] {
        let refused = get(&format!("/api/mounts/1.5,0,0,0/starts/{start_m}/shapes"));
        assert_eq!(refused.status, 400, "{start_m}");
        assert!(text(refused).contains("100.0 m long"), "{start_m}");
    }
}

#[test]
fn what_was_set_up_is_kept_with_the_command_that_runs_it() {
    let mount = json!({"height_m": 1.5, "pitch_deg": 1.25, "yaw_deg": 0, "roll_deg": 0});
    let keep = |page: &MountPage, set_up: Value| asked(page, "POST", "/api/set_up", &set_up);
    let kept = keep(&page(), json!({ "mount": mount, "start_m": null }));
    let kept: Value = serde_json::from_slice(&kept.body).unwrap();
    assert_eq!(kept, json!({"files": ["camera.toml"], "command": "1.25 None"}));
    let kept = text(keep(&page_with_route(), json!({ "mount": mount, "start_m": 99.5 })));
    assert!(kept.contains("1.25 Some(99.5)"), "{kept}");
    assert_eq!(keep(&page_with_route(), json!({ "mount": mount, "start_m": 101 })).status, 400);
    assert_eq!(keep(&page(), json!({ "mount": mount, "start_m": 5 })).status, 404);
    let sunk = json!({"height_m": -1, "pitch_deg": 0, "yaw_deg": 0, "roll_deg": 0});
    for wrong in [json!({}), json!({ "mount": sunk, "start_m": null })] {
        assert_eq!(keep(&page(), wrong).status, 400);
    }
}

#[test]
fn a_mount_is_searched_for_from_where_it_is() {
    let mount = |roll_deg: f64| json!({"height_m": 1.5, "pitch_deg": 1, "yaw_deg": 0, "roll_deg": roll_deg});
    let state: Value = serde_json::from_slice(&ask("POST", "/api/search", &mount(0.0)).body).unwrap();
    let found = json!({"height_m": 1.4, "pitch_deg": 2.0, "yaw_deg": 0.0, "roll_deg": 0.0});
    assert_eq!(state, json!({"is": "found", "mount": found, "said": ["pitch: 2 degrees"]}));
    assert_eq!(ask("POST", "/api/search", &mount(1.0)).status, 409);
    assert_eq!(ask("POST", "/api/search", &json!({})).status, 400);
    assert_eq!(ask("POST", "/api/search/stop", &json!({})).status, 200);
    assert_eq!(ask("GET", "/api/search", &Value::Null).status, 200);
}

#[test]
fn a_camera_that_is_known_by_points_has_no_mount() {
    let pixels = [[100.0, 400.0], [540.0, 400.0], [400.0, 300.0], [240.0, 300.0]];
    let road = [[5.0, 2.0], [5.0, -2.0], [12.0, -2.0], [12.0, 2.0]];
    let camera = Camera::from_points(
        640,
        480,
        pixels.map(|[u, v]| Pixel::new(u, v)),
        road.map(|[x, y]| Point2::new(x, y)),
    );
    assert!(page_of(camera.unwrap()).is_none());
}
