//! What the page asks, without a network.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use fingerpost_look::{NetworkClasses, Overview, Records, RunPage, SeenClass};
use fingerpost_server::{Answer, Cause, Handler, Picture, Pictures, Request};
use serde_json::{Value, json};

/// A number with more digits than a float has, to see that records go out as they were written.
const RECORD: &str = r#"{"frame": 30, "t_s": 0.10, "state": "no_route", "feature": null, "motion": null, "driving_line_m": [[5.00, 0]], "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": "<b>"}"#;

struct OneRecord;

impl Records for OneRecord {
    fn line(&self, index: usize) -> Result<Vec<u8>, Cause> {
        if index == 1 { Err("the disk is gone".into()) } else { Ok(RECORD.as_bytes().to_vec()) }
    }
}

struct NumberedPictures;

impl Pictures for NumberedPictures {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        Ok(Picture { content_type: "image/png", bytes: frame.to_string().into_bytes() })
    }
}

fn page_of_a_run() -> RunPage {
    let mut overview = Overview::default();
    for _ in 0..2 {
        overview.add(&serde_json::from_str(RECORD).unwrap());
    }
    RunPage::new("run", overview, Box::new(OneRecord))
}

fn ask(page: &RunPage, method: &str, path: &str) -> Answer {
    page.answer(Request { method, path, body: &[] })
}

#[test]
fn a_record_goes_out_as_it_was_written() {
    let answer = ask(&page_of_a_run(), "GET", "/api/records/0");
    assert_eq!(answer.status, 200);
    let text = String::from_utf8(answer.body).unwrap();
    assert!(text.starts_with(&format!("{{\"record\":{RECORD},\"shapes\":[")), "{text}");
    let whole: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(whole["shapes"][0]["kind"], "driving_line");
    assert_eq!(
        ask(&page_of_a_run(), "GET", "/api/records/0"),
        ask(&page_of_a_run(), "GET", "/api/records/0")
    );
}

#[test]
fn what_is_not_there_is_said() {
    let page = page_of_a_run();
    for (path, status, word) in [
        ("/api/records/2", 404, "there are 2"),
        ("/api/records/x", 404, "there are 2"),
        ("/api/records/1", 500, "the disk is gone"),
        ("/api/records/0/picture", 404, "--input"),
        ("/other.js", 404, "no such"),
        ("/../Cargo.toml", 404, "no such"),
    ] {
        let answer = ask(&page, "GET", path);
        assert_eq!(answer.status, status, "{path}");
        assert!(String::from_utf8(answer.body).unwrap().contains(word), "{path}");
    }
    assert_eq!(ask(&page, "POST", "/api/run").status, 404, "nothing can be changed");
}

#[test]
fn pictures_are_asked_for_by_the_frames_number_in_the_input() {
    let page = page_of_a_run().with_pictures(Box::new(NumberedPictures));
    assert_eq!(ask(&page, "GET", "/api/records/0/picture").body, b"30");
    let run: Value = serde_json::from_slice(&ask(&page, "GET", "/api/run").body).unwrap();
    assert_eq!((&run["has_pictures"], &run["frames"][1]), (&Value::Bool(true), &Value::from(30)));
}

#[test]
fn what_the_network_sees_is_told_with_its_colours_or_why_it_is_not_there() {
    let run =
        |page: &RunPage| -> Value { serde_json::from_slice(&ask(page, "GET", "/api/run").body).unwrap() };
    let legend = vec![SeenClass::new("road", [40, 200, 90])];
    let page =
        page_of_a_run().with_classes(Ok(NetworkClasses { legend, pictures: Box::new(NumberedPictures) }));
    assert_eq!(
        run(&page)["classes"],
        json!({ "legend": [{ "name": "road", "colour": "#28c85a" }], "lacking": null })
    );
    assert_eq!(ask(&page, "GET", "/api/records/1/classes").body, b"30");
    let page = page_of_a_run().with_classes(Err("no network".to_owned()));
    assert_eq!(run(&page)["classes"], json!({ "legend": [], "lacking": "no network" }));
    assert_eq!(ask(&page, "GET", "/api/records/1/classes").status, 404);
}

#[test]
fn every_part_of_the_page_is_there() {
    let page = page_of_a_run();
    let text = |path: &str| {
        let answer = ask(&page, "GET", path);
        assert_eq!(answer.status, 200, "{path}");
        String::from_utf8(answer.body).unwrap()
    };
    let (html, main) = (text("/"), text("/look.js"));
    assert!(html.contains("look.js") && html.contains("look.css"));
    text("/look.css");
    for script in main.lines().filter_map(|line| line.split(" from \"./").nth(1)) {
        text(&format!("/{}", script.trim_end_matches("\";")));
    }
}
