//! Frames against which something speaks, in made-up runs at ten frames a second.

use serde_json::json;

use super::*;

fn record(frame: u64, more: serde_json::Value) -> FrameRecord {
    let mut record = json!({"frame": frame, "t_s": frame as f64 / 10.0, "state": "tracking", "feature": null, "motion": null,
        "driving_line_m": [], "centreline": null, "lanes": null, "fix": null, "stage_ms": {}, "why": ""});
    if let (Some(record), serde_json::Value::Object(more)) = (record.as_object_mut(), more) {
        record.extend(more);
    }
    serde_json::from_value(record).expect("a record")
}

fn feature(id: i64, forward_m: f64, left_m: f64, present: f64) -> serde_json::Value {
    json!({"id": id, "kind": "junction", "p": 0.8, "sub": {}, "present": present, "forward_m": forward_m, "left_m": left_m,
        "heading_rad": 0, "sigma_m": [0.4, 0.2]})
}

fn worst(records: &[FrameRecord]) -> Vec<(u64, String)> {
    let mut worst = Worst::default();
    records.iter().enumerate().for_each(|(index, record)| worst.add(index, record));
    let times_s: Vec<f64> = records.iter().map(|record| record.t_s).collect();
    worst.events(&times_s).into_iter().map(|event| (event.frame, event.text)).collect()
}

#[test]
fn the_least_sure_frames_are_named_apart_in_time() {
    let present = |frame: u64| match frame {
        20 => 0.5,
        // Of the same doubt as the frame before.
        21 => 0.6,
        50 => 0.4,
        80 => 0.7,
        // The fourth is one too many.
        110 => 0.8,
        _ => 0.99,
    };
    let records: Vec<FrameRecord> = (0..120)
        .map(|frame| record(frame, json!({"feature": feature(7, 10.0, 0.0, present(frame))})))
        .collect();
    let frames: Vec<u64> = worst(&records).into_iter().map(|(frame, _)| frame).collect();
    assert_eq!(frames, [50, 20, 80]);
    assert_eq!(worst(&records)[0].1, "in doubt: 7 is there with probability 0.40");
}

#[test]
fn a_place_that_moves_with_the_vehicle_does_not_jump() {
    let motion =
        json!({"forward_m": 1.0, "left_m": 0.0, "yaw_rad": std::f64::consts::FRAC_PI_2, "quality": 1.0});
    let at = |frame, id, forward_m, left_m| {
        record(frame, json!({"feature": feature(id, forward_m, left_m, 0.99), "motion": motion}))
    };
    // Ten metres ahead; a metre on and a quarter turned to the left it is nine metres to the right.
    assert!(worst(&[at(0, 7, 10.0, 0.0), at(1, 7, 0.0, -9.0)]).is_empty());
    assert!(worst(&[at(0, 7, 10.0, 0.0), at(1, 8, 0.0, -5.0)]).is_empty(), "another feature");
    let found = worst(&[at(0, 7, 10.0, 0.0), at(1, 7, 1.6, -9.0)]);
    assert_eq!(found, [(1, "jump: 7 lies 1.60 m from where the motion puts it, 4.0 sigma".to_owned())]);
}

#[test]
fn a_measurement_far_from_the_place_contradicts_it() {
    let fix = |innovation_m: [f64; 2], accepted: bool| {
        let measured =
            json!({"kind": "gps", "innovation_m": innovation_m, "sigma_m": [2.0, 2.0], "accepted": accepted});
        json!({"fix": {"lat": 49.0, "lon": 8.4, "heading_rad": 0, "sigma_m": 1, "bound_m": 4, "measurements": [measured]}})
    };
    let found = worst(&[record(0, fix([1.0, 3.0], true)), record(1, fix([6.0, 8.0], false))]);
    let text = "contradiction: GPS puts the vehicle 10.0 m from its place on the map, 5.0 sigma; not used";
    assert_eq!(found, [(1, text.to_owned())]);
}

#[test]
fn a_frame_that_takes_longer_than_most_is_slow() {
    let took = |frame, road_ms: f64| record(frame, json!({"stage_ms": {"match": 5.0, "road": road_ms}}));
    let records: Vec<FrameRecord> =
        (0..30).map(|frame| took(frame, if frame == 12 { 45.0 } else { 6.0 })).collect();
    assert_eq!(worst(&records), [(12, "slow: 50 ms, of which 45 ms road".to_owned())]);
    assert!(worst(&records[..12]).is_empty(), "all take as long");
}
