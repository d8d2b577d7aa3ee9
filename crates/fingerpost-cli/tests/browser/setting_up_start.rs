//! Where a drive begins, set up by eye: the start is dragged along the route until what the map has lies in the picture.

use std::ffi::OsStr;
use std::fs;
use std::path::Path;

use fingerpost_map::read_route;
use serde_json::json;

use crate::chromium::Page;
use crate::served::Served;
use crate::set_up_page::{RoughDrive, drawn};
use crate::simulated_drive::{call, town};

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
