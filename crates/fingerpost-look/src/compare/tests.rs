//! Differences of made-up runs.

use super::*;

fn record(frame: u64, state: &str, forward_m: Option<f64>) -> FrameRecord {
    let feature = forward_m.map_or("null".to_owned(), |forward_m| {
        format!(
            r#"{{"id": 7, "kind": "junction", "p": 0.8, "sub": {{}}, "present": 0.9, "forward_m": {forward_m}, "left_m": 0,
                "heading_rad": 0, "sigma_m": [0.4, 0.2]}}"#
        )
    });
    let text = format!(
        r#"{{"frame": {frame}, "t_s": {}, "state": "{state}", "feature": {feature}, "motion": null, "driving_line_m": [],
            "centreline": null, "lanes": null, "fix": null, "stage_ms": {{}}, "why": ""}}"#,
        frame as f64 / 2.0
    );
    serde_json::from_str(&text).expect("a record")
}

#[test]
fn the_frames_that_differ_most_are_named_a_while_apart() {
    let mut differences = Differences::default();
    for (index, forward_m) in [10.0, 10.5, 13.0, 12.0, 10.0, 10.0, 10.0, 11.0].into_iter().enumerate() {
        let one = record(index as u64, "tracking", Some(10.0));
        differences.add([index, index], [&one, &record(index as u64, "tracking", Some(forward_m))]);
    }
    differences.finish();
    let found: Vec<(u64, &str)> =
        differences.events().iter().map(|event| (event.frame, event.text.as_str())).collect();
    // That of frame 3 is within two seconds of the greatest.
    assert_eq!(found, [(2, "feature's place 3.00 m apart"), (7, "feature's place 1.00 m apart")]);
    assert!(differences.events().iter().all(|event| event.kind == DifferenceKind::Peak));
}

#[test]
fn states_that_differ_are_said_where_that_begins() {
    let mut differences = Differences::default();
    let states = ["searching", "searching", "searching", "tracking", "tracking"];
    for (index, state) in states.into_iter().enumerate() {
        let other = if index < 1 { "searching" } else { "tracking" };
        let forward = |state: &str| (state == "tracking").then_some(10.0);
        let frame = index as u64;
        differences.add(
            [index, index],
            [&record(frame, state, forward(state)), &record(frame, other, forward(other))],
        );
    }
    differences.finish();
    let found: Vec<(usize, &str)> =
        differences.events().iter().map(|event| (event.index, event.text.as_str())).collect();
    assert_eq!(found, [(1, "searching, the other tracking 7")]);
    assert_eq!(differences.frames(), [0, 1, 2, 3, 4]);
}
