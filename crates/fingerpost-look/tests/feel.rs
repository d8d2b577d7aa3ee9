//! Settings felt: what runs is asked for once, what is refused is said of its setting, and no run without them has them.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use fingerpost_format::{FrameRecord, TriedSettings};
use fingerpost_look::{
    Beginning, FeelPage, Feelable, Overview, Records, Refusal, Reruns, RunPage, SavedSettings, StageView,
    Stretch,
};
use fingerpost_server::{Answer, Cause, Handler, Limits, Picture, Request};
use serde_json::{Value, json};

const RECORD: &str = r#"{"frame": 0, "t_s": 0, "state": "no_route", "feature": null, "motion": null, "driving_line_m": [],
    "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""}"#;

struct OneRecord;

impl Records for OneRecord {
    fn line(&self, _: usize) -> Result<Vec<u8>, Cause> {
        Ok(RECORD.as_bytes().to_vec())
    }
}

/// Counts how often a stretch is run; its second stage shows what was changed.
struct Counted(Arc<AtomicUsize>);

impl Reruns for Counted {
    fn run_again(&self, _: usize, changed: &TriedSettings, longest: Duration) -> Result<Stretch, Refusal> {
        // The server cuts off what takes longer than it grants.
        assert!(2 * longest < Limits::default().request_time);
        self.0.fetch_add(1, Ordering::Relaxed);
        if let Some(key) = changed.keys().find(|key| key.as_str() == "wrong") {
            return Err(Refusal { key: Some(key.clone()), cause: "give another".into() });
        }
        let stage = |name, text: String| StageView {
            name,
            legend: "",
            picture: Picture { content_type: "image/png", bytes: text.into_bytes() },
        };
        let changed = serde_json::to_string(changed).unwrap_or_default();
        Ok(Stretch {
            beginning: Beginning { frame: 0, duration_s: 0.0, frames: 1, route_m: None },
            record: serde_json::from_str(RECORD)
                .map_err(|cause| Refusal { key: None, cause: Box::new(cause) })?,
            stages: vec![stage("camera", String::new()), stage("road", changed)],
        })
    }

    fn save(&self, _: &TriedSettings) -> Result<SavedSettings, Refusal> {
        Ok(SavedSettings { file: "fingerpost.toml".to_owned(), command: "fingerpost run".to_owned() })
    }
}

fn page() -> RunPage {
    let mut overview = Overview::default();
    overview.add(&serde_json::from_str::<FrameRecord>(RECORD).unwrap());
    RunPage::new("run", overview, Box::new(OneRecord))
}

fn page_with_feel(runs: &Arc<AtomicUsize>) -> RunPage {
    let feelable = Feelable { schema: json!({}), values: json!({}), points: Vec::new() };
    page().with_feel(Ok(FeelPage::new(feelable, Box::new(Counted(Arc::clone(runs))))))
}

fn post(page: &RunPage, path: &str, changed: &Value) -> (u16, Value) {
    let answer = page.answer(Request { method: "POST", path, body: changed.to_string().as_bytes() });
    (answer.status, serde_json::from_slice(&answer.body).unwrap())
}

fn get(page: &RunPage, path: &str) -> Answer {
    page.answer(Request { method: "GET", path, body: &[] })
}

#[test]
fn a_stretch_is_run_once_before_and_once_a_change() {
    let runs = Arc::default();
    let page = page_with_feel(&runs);
    let (_, felt) = post(&page, "/api/feel/records/0", &json!({}));
    assert_eq!((&felt["after"], runs.load(Ordering::Relaxed)), (&Value::Null, 1));
    let (_, felt) = post(&page, "/api/feel/records/0", &json!({ "a": 1 }));
    assert_eq!(runs.load(Ordering::Relaxed), 2);
    // The picture that nothing has changed is not there twice.
    assert_eq!(felt["after"]["stages"][0]["picture"], Value::Null);
    let picture = |felt: &Value, when: &str| {
        get(&page, &format!("/{}", felt[when]["stages"][1]["picture"].as_str().unwrap())).body
    };
    assert_eq!((picture(&felt, "before"), picture(&felt, "after")), (b"{}".to_vec(), b"{\"a\":1}".to_vec()));
    // Pictures of changes long past are gone, those before are not.
    for value in 0..20 {
        post(&page, "/api/feel/records/0", &json!({ "a": value }));
    }
    assert_eq!(picture(&felt, "before"), b"{}");
    let gone = felt["after"]["stages"][1]["picture"].as_str().unwrap();
    assert_eq!(get(&page, &format!("/{gone}")).status, 404);
}

#[test]
fn what_is_refused_names_its_setting() {
    let page = page_with_feel(&Arc::default());
    let (status, answer) = post(&page, "/api/feel/records/0", &json!({ "wrong": 1 }));
    assert_eq!((status, answer), (400, json!({ "error": "give another", "key": "wrong" })));
    assert_eq!(post(&page, "/api/feel/records/0", &json!([1])).0, 400);
    assert_eq!(post(&page, "/api/feel/records/1", &json!({})).0, 404);
    assert_eq!(get(&page, "/api/feel/stretches/1/x").status, 404);
    assert_eq!(post(&page, "/api/feel/saved", &json!({})).1["file"], "fingerpost.toml");
}

#[test]
fn what_is_missing_is_said() {
    let without = page().with_feel(Err("give --camera".to_owned()));
    assert_eq!(post(&without, "/api/feel/records/0", &json!({})), (404, json!({ "error": "give --camera" })));
    assert_eq!(get(&without, "/feel").status, 200);
}
