//! What the page asks, without a network.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use std::sync::{Arc, Mutex};

use fingerpost_format::MarksFile;
use fingerpost_mark::{Desk, Keeper, LaneMarks, truth_of_marks};
use fingerpost_server::{Cause, Handler, Picture, Pictures, Request};
use serde_json::{Value, json};

struct OnePicture;

impl Pictures for OnePicture {
    fn picture(&self, frame: u64) -> Result<Picture, Cause> {
        if frame == 2 {
            return Err("its file is damaged".into());
        }
        Ok(Picture { content_type: "image/png", bytes: vec![frame as u8] })
    }
}

/// What was kept last, and whether the disk is full.
#[derive(Debug, Clone, Default)]
struct Shelf(Arc<Mutex<(Option<MarksFile>, bool)>>);

impl Keeper for Shelf {
    fn keep(&mut self, marks: &MarksFile) -> Result<(), Cause> {
        let mut shelf = self.0.lock().unwrap();
        if shelf.1 {
            return Err("the disk is full".into());
        }
        shelf.0 = Some(marks.clone());
        Ok(())
    }

    fn export(&mut self, marks: &LaneMarks) -> Result<Vec<String>, Cause> {
        truth_of_marks(marks, |_| 0.0)?;
        Ok(vec!["truth.jsonl".to_owned()])
    }
}

fn desk() -> (Desk, Shelf) {
    let shelf = Shelf::default();
    let marks = LaneMarks::new("drive", [640, 480], 3);
    (Desk::new(marks, Box::new(OnePicture), Box::new(shelf.clone())), shelf)
}

fn ask(desk: &Desk, method: &str, path: &str, body: &Value) -> (u16, Value) {
    let body = body.to_string();
    let answer = desk.answer(Request { method, path, body: body.as_bytes() });
    (answer.status, serde_json::from_slice(&answer.body).unwrap_or_default())
}

fn edit(desk: &Desk, side: &str, frame: u64, points: &Value) -> (u16, Value) {
    ask(desk, "POST", "/api/edit", &json!({ "side": side, "frame": frame, "points_px": points }))
}

#[test]
fn every_edit_is_kept_and_can_be_taken_back() {
    let (desk, shelf) = desk();
    let (status, answer) = edit(&desk, "left", 0, &json!([[10.0, 400.0], [5.0, 470.004]]));
    assert_eq!((status, &answer["frame"], &answer["state"]["can_undo"]), (200, &json!(0), &json!(true)));
    assert_eq!(answer["edges"]["left"]["points_px"], json!([[5.0, 470.0], [10.0, 400.0]]));
    assert_eq!(answer["edges"]["right"]["marked"], "unmarked");
    let kept = || shelf.0.lock().unwrap().0.clone().unwrap();
    assert_eq!(kept().left[0].points_px, [[5.0, 470.0], [10.0, 400.0]]);
    edit(&desk, "right", 2, &json!([]));
    assert_eq!(ask(&desk, "GET", "/api/state", &Value::Null).1["right"], json!([[2, false]]));
    assert_eq!(ask(&desk, "POST", "/api/undo", &json!({})).1["frame"], 2);
    assert!(kept().right.is_empty());
    assert_eq!(ask(&desk, "POST", "/api/redo", &json!({})).0, 200);
    assert_eq!(kept().right.len(), 1);
    assert_eq!(ask(&desk, "POST", "/api/redo", &json!({})).0, 409);
    edit(&desk, "left", 0, &Value::Null);
    assert!(kept().left.is_empty());
}

#[test]
fn an_edit_that_cannot_be_kept_says_so_and_is_kept_with_the_next() {
    let (desk, shelf) = desk();
    shelf.0.lock().unwrap().1 = true;
    let (status, answer) = edit(&desk, "left", 0, &json!([[10.0, 400.0]]));
    assert_eq!(status, 500);
    assert!(answer["error"].as_str().unwrap().contains("the disk is full"));
    shelf.0.lock().unwrap().1 = false;
    edit(&desk, "left", 2, &json!([[10.0, 400.0]]));
    assert_eq!(shelf.0.lock().unwrap().0.as_ref().unwrap().left.len(), 2);
}

#[test]
fn pictures_curves_and_export() {
    let (desk, _) = desk();
    let picture = desk.answer(Request { method: "GET", path: "/api/frames/1/picture", body: b"" });
    assert_eq!((picture.status, picture.content_type, picture.body), (200, "image/png", vec![1]));
    let (status, answer) = ask(&desk, "GET", "/api/frames/2/picture", &Value::Null);
    assert_eq!((status, answer["error"].as_str()), (500, Some("its file is damaged")));
    let (_, curve) = ask(&desk, "POST", "/api/curve", &json!({ "points_px": [[0.0, 0.0], [8.0, 8.0]] }));
    assert_eq!(curve["curve_px"], json!([[8.0, 8.0], [4.0, 4.0], [0.0, 0.0]]));

    let (status, answer) = ask(&desk, "POST", "/api/export", &json!({}));
    assert_eq!(status, 409);
    assert!(answer["error"].as_str().unwrap().contains("the left edge is not marked in frames 0 to 2"));
    for side in ["left", "right"] {
        edit(&desk, side, 0, &json!([]));
        edit(&desk, side, 2, &json!([]));
    }
    assert_eq!(ask(&desk, "POST", "/api/export", &json!({})).1["files"], json!(["truth.jsonl"]));
}

#[test]
fn what_is_no_request_is_refused() {
    let (desk, shelf) = desk();
    let status = |method, path, body: &Value| ask(&desk, method, path, body).0;
    assert_eq!(status("GET", "/../Cargo.toml", &Value::Null), 404);
    assert_eq!(status("GET", "/api/frames/3/edges", &Value::Null), 404);
    assert_eq!(status("GET", "/api/frames/-1/picture", &Value::Null), 404);
    assert_eq!(status("GET", "/api/edit", &Value::Null), 404);
    assert_eq!(status("POST", "/api/edit", &json!({ "side": "middle" })), 400);
    assert_eq!(status("POST", "/api/curve", &json!([])), 400);
    assert_eq!(edit(&desk, "left", 3, &json!([])).0, 404);
    // A curve over so many rows would need more memory than there is.
    let endless = json!([[0.0, 0.0], [8.0, 1e300]]);
    assert_eq!(status("POST", "/api/curve", &json!({ "points_px": endless })), 400);
    assert_eq!(edit(&desk, "left", 0, &endless).0, 400);
    assert!(shelf.0.lock().unwrap().0.is_none());
}

#[test]
fn the_page_is_whole() {
    let (desk, _) = desk();
    let get = |path| desk.answer(Request { method: "GET", path, body: b"" });
    let page = String::from_utf8(get("/").body).unwrap();
    for path in ["/mark.css", "/mark.js"] {
        assert!(page.contains(path.trim_start_matches('/')), "{path}");
        assert_eq!(get(path).status, 200, "{path}");
    }
    assert_eq!(get("/view.js").content_type, "text/javascript; charset=utf-8");
    // The page needs no network but the program's own.
    for file in ["/", "/mark.js", "/view.js", "/mark.css"] {
        let text = String::from_utf8(get(file).body).unwrap();
        assert!(!text.contains("http://") && !text.contains("https://"), "{file}");
    }
}
