//! Two runs of one drive held against each other: their summaries, each frame of both, and the frames in which they differ most.

use std::fs;

use serde_json::{Value, json};

use crate::chromium::Page;
use crate::simulated_run::Run;

/// Frames of the drive.
const FRAMES: usize = 80;

fn wait_for_frame(page: &mut Page, frame: u64) {
    page.wait_for(&format!("document.body.dataset.frame === '{frame}'"));
}

#[test]
fn two_runs_are_compared() {
    let run = Run::make(FRAMES);
    let settings = run.path("settings.toml");
    fs::write(&settings, "[track]\ndetect_present = 0.99\n\n[road_surface.memory]\nof = \"network\"\n")
        .unwrap();
    run.again("other", &format!("--config {}", settings.display()));
    let camera = run.drive().join("camera.toml");
    let served = run.serve_with(&[("--camera", &camera), ("--with", &run.path("other"))]);
    let mut page = Page::open(&format!("{}compare#frame=12", served.address));
    page.wait_for("document.body.dataset.ready === 'yes'");
    wait_for_frame(&mut page, 12);

    // Both runs' pictures and grounds, with what each has found.
    assert_eq!(
        page.value("[...document.querySelectorAll('#runs img')].filter((one) => one.naturalWidth).length"),
        json!(4)
    );
    // The settings that differ stand beside each other.
    let setting = page.value(
        "[...document.querySelectorAll('#summaries tr[data-name=\"track.detect_present\"] td')].map((one) => one.textContent)",
    );
    assert_eq!(setting, json!(["0.8", "0.99"]));
    let frames = page.value("document.querySelectorAll('#summaries tr[data-name=frames]').length");
    assert_eq!(frames, json!(1));

    // The first frame that differs is gone to, and its numbers are those of the two records.
    let differences: Value = serde_json::from_str(
        page.value("fetch('api/differences').then((answer) => answer.text())").as_str().unwrap(),
    )
    .unwrap();
    let events = differences["events"].as_array().unwrap();
    assert!(events.len() > 3, "{events:?}");
    let first = events.iter().find(|event| event["index"].as_u64() > Some(12)).unwrap();
    page.key("n", 0);
    wait_for_frame(&mut page, first["frame"].as_u64().unwrap());
    let peak = events.iter().find(|event| event["kind"] == "peak").unwrap();
    page.value(&format!(
        "[...document.querySelectorAll('#events button')].find((one) => one.textContent.endsWith({})).click()",
        peak["text"]
    ));
    wait_for_frame(&mut page, peak["frame"].as_u64().unwrap());
    assert_eq!(page.value("document.querySelectorAll('#numbers tr.differs').length > 0"), json!(true));
    page.key("ArrowRight", 0);
    wait_for_frame(&mut page, peak["frame"].as_u64().unwrap() + 1);

    // A step shows both: it has to take no more than 50 ms where the program is optimised.
    page.value("document.getElementById('seek').value = 0; document.getElementById('seek').dispatchEvent(new Event('input'))");
    wait_for_frame(&mut page, 0);
    let steps = page.value(
        "(async () => {
            const took = [];
            for (let step = 0; step < 40; step++) {
                const before = document.body.dataset.frame, since = performance.now();
                document.getElementById('forward').click();
                while (document.body.dataset.frame === before) await new Promise((done) => setTimeout(done));
                took.push(performance.now() - since);
            }
            return took.sort((a, b) => a - b);
        })()",
    );
    println!(
        "a step through two runs: {:.0} ms, the slowest of 40 {:.0} ms",
        steps[20].as_f64().unwrap(),
        steps[39].as_f64().unwrap()
    );

    page.has_names();
    let place = events.iter().find(|event| event["text"].as_str().unwrap().contains("place")).unwrap();
    page.value(&format!("location.hash = '#frame={}'", place["frame"]));
    wait_for_frame(&mut page, place["frame"].as_u64().unwrap());
    page.value("scrollTo(0, 0)");
    page.is_shown_in_every_window("compare");
    assert!(page.complaints.is_empty(), "{:?}", page.complaints);
}

#[test]
fn a_page_without_another_run_says_how_it_is_given() {
    let run = Run::make(5);
    let served = run.serve("--input", &run.drive());
    let mut page = Page::open(&format!("{}compare", served.address));
    page.wait_for("document.getElementById('message').textContent.includes('--with')");
}
