//! Shapes lie where the calibration has them.

use fingerpost_geometry::{Distortion, Intrinsics, Mount};

use super::*;

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
    Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).expect("a camera")
}

/// A record with a feature 10 m ahead and 2 m to the left, a rival, a driving line, a road's middle and an edge of the lane.
fn record(mount: &str) -> FrameRecord {
    let text = format!(
        r#"{{"frame": 3, "t_s": 0.3, "state": "tracking", "motion": null, "fix": null, "stage_ms": {{}}, "why": "", {mount}
        "feature": {{"id": 2, "kind": "junction", "p": 0.8, "sub": {{}}, "forward_m": 10, "left_m": 2, "heading_rad": 0,
            "sigma_m": [0.5, 0.25],
            "rivals": [{{"forward_m": 14, "left_m": 0, "sigma_m": [1, 1], "present": 0.1}}]}},
        "driving_line_m": [[5, 0], [10, 0], [-4, 0], [20, 1]],
        "centreline": {{"offset_m": 0.5, "heading_rad": 0, "curvature_per_m": 0.01, "steer_rad": null}},
        "lanes": {{"left_px": [[100.5, 479], [300, 250]], "right_px": []}}}}"#
    );
    serde_json::from_str(&text).expect("a record")
}

fn of_kind(shapes: &[Shape], kind: ShapeKind) -> Vec<Shape> {
    shapes.iter().filter(|shape| shape.kind == kind).cloned().collect()
}

#[test]
fn places_on_the_road_lie_in_the_picture_where_the_camera_shows_them() {
    let shapes = shapes(&record(""), Some(&camera()));
    // 100 px left of the middle, 75 px below the horizon.
    let feature = &of_kind(&shapes, ShapeKind::Feature)[0];
    assert_eq!(
        (feature.ground_m.as_slice(), feature.picture_px.as_slice()),
        (&[[10.0, 2.0]][..], &[vec![[219.5, 314.5]]][..])
    );
    assert_eq!(feature.label, "junction 2, 10.0 m ahead, P(F) 0.80");
    let horizon = &of_kind(&shapes, ShapeKind::Horizon)[0].picture_px;
    assert!(horizon.iter().flatten().all(|[_, v]| (v - 239.5).abs() < 0.02), "{horizon:?}");
    let middle = &of_kind(&shapes, ShapeKind::Centreline)[0].ground_m;
    assert_eq!((middle[0], middle[middle.len() - 1]), ([0.0, 0.5], [20.0, 2.5]));
    let edges = of_kind(&shapes, ShapeKind::LaneEdge);
    assert_eq!(
        (edges.len(), edges[0].picture_px.as_slice()),
        (1, &[vec![[100.5, 479.0], [300.0, 250.0]]][..])
    );
    assert!(edges[0].ground_m.is_empty(), "this record has it in the picture alone");
}

#[test]
fn a_line_is_cut_where_the_camera_does_not_see_it() {
    let line = &of_kind(&shapes(&record(""), Some(&camera())), ShapeKind::DrivingLine)[0];
    assert_eq!(line.ground_m.len(), 4);
    let lengths: Vec<usize> = line.picture_px.iter().map(Vec::len).collect();
    assert_eq!(lengths, [2, 1], "behind the camera there is no picture");
}

#[test]
fn doubts_are_two_standard_deviations_wide() {
    let doubts = of_kind(&shapes(&record(""), None), ShapeKind::Doubt);
    assert_eq!(doubts.len(), 2, "of the feature and of its rival");
    let outline = &doubts[1].ground_m;
    assert_eq!((outline.first(), outline.last()), (Some(&[11.0, 2.0]), Some(&[11.0, 2.0])));
    let most_left = outline.iter().map(|place| place[1]).fold(f64::MIN, f64::max);
    assert!((most_left - 2.5).abs() < 1e-9, "{most_left}");
}

#[test]
fn a_nose_that_is_down_moves_the_picture_up() {
    let down = r#""mount": {"pitch_deg": 1, "yaw_deg": 0, "roll_deg": 0, "suspension_pitch_deg": 0.5,
        "sigma_deg": [1, 1, 1, 1], "state": "valid"},"#;
    let shapes = shapes(&record(down), Some(&camera()));
    let horizon = &of_kind(&shapes, ShapeKind::Horizon)[0].picture_px[0];
    let middle = horizon.iter().min_by(|a, b| (a[0] - 319.5).abs().total_cmp(&(b[0] - 319.5).abs()));
    let raised_px = 239.5 - middle.expect("a horizon")[1];
    assert!((raised_px - 500.0 * libm::tan(1.5_f64.to_radians())).abs() < 0.05, "{raised_px}");
}

#[test]
fn without_a_camera_only_what_was_in_pixels_is_in_the_picture() {
    for shape in shapes(&record(""), None) {
        assert_eq!(shape.picture_px.is_empty(), shape.kind != ShapeKind::LaneEdge, "{shape:?}");
        assert_ne!(shape.kind, ShapeKind::Horizon);
    }
}
