//! Stepping through a run: by keys, slider, number, link, curve and event, at two widths, and what the page shows of a frame.

use std::fs;
use std::path::Path;
use std::time::Instant;

use fingerpost_format::{FrameRecord, TrackState, to_json_line};
use fingerpost_map::read_route;
use serde_json::{Value, json};

use crate::chromium::Page;
use crate::network_classes::shows_what_the_network_sees;
use crate::served::Served;
use crate::simulated_drive::town;
use crate::simulated_run::Run;

/// Frames of the drive: the town's first feature is found, arrived at and passed.
const FRAMES: usize = 80;

fn wait_for_frame(page: &mut Page, frame: u64) {
    page.wait_for(&format!("document.body.dataset.frame === '{frame}'"));
    assert_eq!(page.value("document.getElementById('frame').valueAsNumber"), json!(frame));
}

/// The text of a number's cell.
fn number(page: &mut Page, name: &str) -> f64 {
    let text = page.value(&format!("document.querySelector('tr[data-name=\"{name}\"] td').textContent"));
    text.as_str().unwrap().parse().unwrap()
}

#[test]
fn a_run_is_stepped_through() {
    let run = Run::make(FRAMES);
    let records = run.records();
    let found = records.iter().position(|record| record.state == TrackState::Tracking).unwrap();
    let found = found as u64;
    let served = run.serve("--camera", &run.drive().join("camera.toml"));

    // By a link, keys, slider, number and events.
    let mut page = Page::open(&format!("{}#frame=12", served.address));
    page.wait_for("document.body.dataset.ready === 'yes'");
    wait_for_frame(&mut page, 12);
    page.key("ArrowRight", 0);
    wait_for_frame(&mut page, 13);
    page.key("ArrowLeft", 0);
    page.key("ArrowRight", 8);
    wait_for_frame(&mut page, 22);
    page.key("End", 0);
    wait_for_frame(&mut page, FRAMES as u64 - 1);
    page.key("Home", 0);
    wait_for_frame(&mut page, 0);
    // Events of one frame are one step.
    let mut events = event_frames(&mut page);
    events.retain(|frame| *frame > 0);
    assert!(events.len() > 1 && events.contains(&found), "{events:?}");
    for frame in [events[0], events[1]] {
        page.key("n", 0);
        wait_for_frame(&mut page, frame);
    }
    page.key("p", 0);
    wait_for_frame(&mut page, events[0]);
    page.wait_for(&format!("location.hash === '#frame={}'", events[0]));
    page.value("const seek = document.getElementById('seek'); seek.value = 30; seek.dispatchEvent(new Event('input'))");
    wait_for_frame(&mut page, 30);
    page.value("location.hash = '#frame=41'");
    wait_for_frame(&mut page, 41);
    page.value("[...document.querySelectorAll('#events button')].find((one) => one.textContent.includes('found')).click()");
    wait_for_frame(&mut page, found);

    shows_what_the_record_says(&mut page, &records[found as usize]);
    shows_shapes_in_the_picture(&mut page, &served.address);

    // A click in the middle of the curves is a moment half way.
    let place = page.value(
        "(() => { const curve = document.querySelector('.curve svg'); curve.scrollIntoView({ block: 'center' });
             const box = curve.getBoundingClientRect();
             return [box.left + box.width / 2, box.top + box.height / 2]; })()",
    );
    page.click([0, 1].map(|axis| place[axis].as_f64().unwrap()), "left");
    wait_for_frame(&mut page, (FRAMES as u64 - 1) / 2);

    // The probability of road lies over the ground view.
    page.value("document.querySelector('#surface input').click()");
    page.wait_for("document.querySelectorAll('#ground img').length === 2");
    let sizes = page.value(
        "[...document.querySelectorAll('#ground img')].map((one) => [one.naturalWidth, one.naturalHeight])",
    );
    assert_eq!(sizes[0], sizes[1], "of the same area");

    shows_what_the_network_sees(&mut page);

    page.has_names();
    page.value("scrollTo(0, 0)");
    page.value(&format!("location.hash = '#frame={}'", found + 4));
    wait_for_frame(&mut page, found + 4);
    page.is_shown_in_every_window("look");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}

/// The frames of the events that are listed, each once.
fn event_frames(page: &mut Page) -> Vec<u64> {
    let events = page.value("fetch('api/run').then((run) => run.json()).then(({ events }) => events)");
    let mut frames: Vec<u64> =
        events.as_array().unwrap().iter().map(|event| event["frame"].as_u64().unwrap()).collect();
    frames.dedup();
    frames
}

fn shows_what_the_record_says(page: &mut Page, record: &FrameRecord) {
    let feature = record.feature.as_ref().unwrap();
    let numbers = [
        ("feature.forward_m", feature.forward_m),
        ("feature.p", feature.p.unwrap()),
        ("frame.t_s", record.t_s),
        ("stage_ms.road", record.stage_ms["road"]),
    ];
    for (name, recorded) in numbers {
        assert_eq!(number(page, name).to_bits(), recorded.to_bits(), "{name}");
    }
    let why = page.value("document.getElementById('why').textContent");
    assert_eq!(why.as_str(), Some(record.why.as_str()));
    let status = page.value("document.getElementById('status').textContent");
    assert!(status.as_str().unwrap().contains("tracking"), "{status}");
    // Every number of the record stands on the page.
    let whole = serde_json::to_value(record).unwrap();
    let keys = whole.as_object().unwrap().iter();
    let groups = keys.filter(|(_, value)| value.is_object()).map(|(key, _)| key.as_str());
    let captions =
        page.value("[...document.querySelectorAll('#numbers caption')].map((one) => one.textContent)");
    let captions: Vec<&str> = captions.as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert!(groups.clone().all(|group| captions.contains(&group)), "{captions:?}");
}

/// The feature's ring lies where the program says, and the picture is that of the drive.
fn shows_shapes_in_the_picture(page: &mut Page, address: &str) {
    let lies = page.value(&format!(
        "(async () => {{
            const index = document.getElementById('seek').value;
            const {{ shapes }} = await (await fetch(`{address}api/records/${{index}}`)).json();
            const [[[u, v]]] = shapes.find(({{ kind }}) => kind === 'feature').picture_px;
            const ring = document.querySelector('#overlay circle.feature').getBoundingClientRect();
            const stage = document.getElementById('stage').getBoundingClientRect();
            const scale = stage.width / 320;
            return [ring.x + ring.width / 2 - stage.x - (u + 0.5) * scale, ring.y + ring.height / 2 - stage.y - (v + 0.5) * scale];
        }})()"
    ));
    assert!((0..2).all(|axis| lies[axis].as_f64().unwrap().abs() < 0.5), "{lies}");
    let natural = page.value("[picture.naturalWidth, picture.naturalHeight]");
    assert_eq!(natural, json!([320, 240]));
    assert_eq!(page.value("document.querySelectorAll('#ground polyline.driving_line').length"), json!(1));
    // A box of the legend takes its kind away.
    page.value("document.querySelector('#legend input[data-kind=driving_line]').click()");
    assert_eq!(page.value("document.querySelectorAll('polyline.driving_line').length"), json!(0));
    page.value("document.querySelector('#legend input[data-kind=driving_line]').click()");
}

#[test]
fn the_fix_is_shown_on_the_map() {
    let run = Run::make(30);
    let (map, route) = (town("town.osm"), town("town_route.geojson"));
    let start = read_route(&fs::read_to_string(&route).unwrap()).unwrap().line[0].at;
    run.again("located", &format!("--map {} --near {},{}", map.display(), start.lat_deg, start.lon_deg));
    let located = run.path("located");
    // So early several places are possible still: a protection level is written in by hand.
    let frames = located.join("frames.jsonl");
    let bounded = fs::read_to_string(&frames).unwrap().replace("\"bound_m\":null", "\"bound_m\":7.5");
    fs::write(&frames, bounded).unwrap();
    let files = [("--camera", &run.drive().join("camera.toml")), ("--map", &map), ("--route", &route)];
    let arguments = files.iter().flat_map(|(option, path)| [Path::new(option), path.as_path()]);
    let served = Served::start([Path::new("look"), &located].into_iter().chain(arguments));
    let mut page = Page::open(&format!("{}#frame=25", served.address));
    wait_for_frame(&mut page, 25);

    // The arrow is at the fix, 0.8 m a frame along the route, in a ring as large as its protection level, and the map moves with it.
    let middle = |page: &mut Page| {
        let places = page.value(
            "(() => { const ring = document.querySelector('#map .bound'), { x, y, width, height } = document.getElementById('map').viewBox.baseVal;
                 return [ring.cx.baseVal.value, ring.cy.baseVal.value, ring.r.baseVal.value, x + width / 2, y + height / 2]; })()",
        );
        [0, 1, 2, 3, 4].map(|index| places[index].as_f64().unwrap())
    };
    let [x, y, radius, middle_x, middle_y] = middle(&mut page);
    assert!(libm::hypot(x - middle_x, y - middle_y) < 0.01 && radius > 0.0, "{radius}");
    assert!((number(&mut page, "fix.bound_m") - radius).abs() < 0.01);
    page.key("ArrowLeft", 8);
    wait_for_frame(&mut page, 15);
    let [before_x, before_y, ..] = middle(&mut page);
    let moved_m = libm::hypot(x - before_x, y - before_y);
    assert!((6.0..10.0).contains(&moved_m), "{moved_m}");
    let drawn = page.value("['.map-road', '.route', '.track'].map((kind) => document.querySelectorAll(`#map ${kind}`).length > 0)");
    assert_eq!(drawn, json!([true, true, true]));
    page.has_names();
    page.is_shown_in_every_window("look_map");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}

/// How long it takes is printed: it has to open in 2 s and step 20 times a second where the program is optimised.
#[test]
fn a_long_run_opens_and_steps_to_its_end() {
    let run = Run::make(FRAMES);
    let frames_path = run.out().join("frames.jsonl");
    let mut records = run.records();
    let short = records.clone();
    records.extend(short.iter().cycle().take(10_000 - FRAMES).cloned());
    let dt_s = short[1].t_s;
    for (record, frame) in records.iter_mut().zip(0..) {
        (record.frame, record.t_s) = (frame, dt_s * frame as f64);
    }
    let lines: Vec<String> = records.iter().map(|record| to_json_line(record).unwrap()).collect();
    fs::write(&frames_path, lines.concat()).unwrap();

    let started = Instant::now();
    let served = run.serve("--camera", &run.drive().join("camera.toml"));
    let read_s = started.elapsed().as_secs_f64();
    let mut page = Page::open("about:blank");
    let asked = Instant::now();
    page.go_to(&served.address);
    page.wait_for("document.body.dataset.ready === 'yes'");
    let open_s = read_s + asked.elapsed().as_secs_f64();

    // In the page itself: what the protocol of the test takes is no part of it.
    let steps = page.value(
        "(async () => {
            const took = [];
            for (let step = 0; step < 60; step++) {
                const before = document.body.dataset.frame, since = performance.now();
                document.getElementById('forward').click();
                while (document.body.dataset.frame === before) await new Promise((done) => setTimeout(done));
                took.push(performance.now() - since);
            }
            return took.sort((a, b) => a - b);
        })()",
    );
    let step_s = steps[30].as_f64().unwrap() / 1000.0;
    let slowest_s = steps[59].as_f64().unwrap() / 1000.0;
    println!(
        "10,000 frames: read in {read_s:.2} s, open in {open_s:.2} s; a step {:.0} ms, the slowest {:.0} ms",
        step_s * 1e3,
        slowest_s * 1e3
    );
    assert_eq!(page.value("document.body.dataset.frame"), json!("60"));
    page.key("End", 0);
    wait_for_frame(&mut page, 9_999);
}

#[test]
fn other_sites_are_refused() {
    let run = Run::make(FRAMES);
    let served = run.serve("--input", &run.drive());
    let get = |path: &str, more: &str| {
        served.ask(&format!("GET {path} HTTP/1.1\r\nConnection: close\r\n{more}\r\n"))
    };
    assert!(get("/api/run", "Host: 127.0.0.1:PORT\r\n").contains("200"));
    assert!(get("/api/run", "Host: run.example:PORT\r\n").contains("403"));
    assert!(get("/api/records/0", "Host: 127.0.0.1:PORT\r\nOrigin: http://run.example\r\n").contains("403"));
    assert!(get("/api/records/100000", "Host: 127.0.0.1:PORT\r\n").contains("404"));
    assert!(get("/api/records/5/picture", "Host: localhost:PORT\r\n").contains("200"));
}
