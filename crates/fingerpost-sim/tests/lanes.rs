//! The truth of the lane by known places, and against the picture.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

mod common;

use fingerpost_format::{MarkingColour, MarkingKind, MarkingRecord};
use fingerpost_geometry::{Camera, Distortion};
use fingerpost_sim::{
    Conditions, CoursePiece, DrivingManner, DrivingPlan, RoadCourse, SimConfig, SimFrame, Simulator,
    windscreen_camera,
};

/// A scene without objects, so that nothing hides the road.
const BARE: Conditions = Conditions { trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::IDEAL };

fn simulator(camera: &Camera, conditions: Conditions) -> Simulator {
    let graph = common::graph();
    let config = SimConfig { conditions, ..SimConfig::default() };
    Simulator::new(&graph, &common::route(&graph), camera, &config).unwrap()
}

/// The frame when the vehicle is about `x` metres east on Main Street, before its first corner.
fn frame_on_main_street(simulator: &Simulator, x: f64) -> SimFrame {
    let index = (0..simulator.frames()).find(|&i| simulator.truth(i).x_m >= x).unwrap();
    simulator.frame(index)
}

/// The column of an edge at a row, interpolated.
fn column_at(edge: &[[f64; 2]], row: f64) -> Option<f64> {
    edge.windows(2).find(|pair| (pair[1][1]..=pair[0][1]).contains(&row)).map(|pair| {
        let share = (pair[0][1] - row) / (pair[0][1] - pair[1][1]);
        pair[0][0] + share * (pair[1][0] - pair[0][0])
    })
}

#[test]
fn edges_are_the_inner_sides_of_the_lines_by_hand() {
    let camera = common::camera(640, 480, Distortion::None);
    let truth = frame_on_main_street(&simulator(&camera, BARE), 65.0).truth;
    // Main Street is 6 m wide: its right line is 0.14 m wide about 0.25 m from the edge, its left one about the axis.
    for (edge_px, edge_m, inner_m) in [
        (&truth.lane_left_px, &truth.lane_left_m, -0.07),
        (&truth.lane_right_px, &truth.lane_right_m, -3.0 + 0.25 + 0.07),
    ] {
        assert!(edge_px.len() > 40 && edge_px.len() == edge_m.len());
        let (sin, cos) = libm::sincos(8_f64.to_radians());
        for (pixel, p) in edge_px.iter().zip(edge_m) {
            // Main Street runs along the x axis; the vehicle's heading is the street's to a millionth.
            assert!((p[1] - (inner_m - truth.y_m)).abs() < 1e-4, "{p:?}");
            // From the camera, 1.5 m ahead and 1.5 m up, turned down by 8 degrees.
            let (ahead, down) = (p[0] - 1.5, 1.5);
            let depth = ahead * cos + down * sin;
            let u = 319.5 - 420.0 * p[1] / depth;
            let v = 239.5 + 420.0 * (down * cos - ahead * sin) / depth;
            assert!((pixel[0] - u).abs() < 0.01 && (pixel[1] - v).abs() < 0.01, "{pixel:?}: {u}, {v}");
        }
        // The street goes on to x = 120 m, where the mouth of North Road interrupts the lines.
        assert!(edge_m.last().unwrap()[0] > 45.0, "{:?}", edge_m.last());
        assert!((edge_px[0][1] - 479.0).abs() < 1e-3 || edge_px[0][0] > 638.99, "{:?}", edge_px[0]);
        for pair in edge_m.windows(2).filter(|pair| pair[1][0] < 16.0) {
            assert!((pair[1][0] - pair[0][0]) < 0.2501);
        }
    }
    let white = |kind| Some(MarkingRecord { kind, colour: MarkingColour::White });
    assert_eq!(truth.lane_left_marking, white(MarkingKind::Broken));
    assert_eq!(truth.lane_right_marking, white(MarkingKind::Continuous));
    assert_eq!(truth.turn_signal, None);
}

/// Where brightness along a row first reaches half of the paint's, from `from` in steps of `step`.
fn step_column(frame: &SimFrame, row: usize, from: usize, step: isize) -> f64 {
    let grey = |u: usize| {
        let [r, g, b] = frame.picture.get(u, row).unwrap().map(f64::from);
        (r + g + b) / 3.0
    };
    let (mut u, mut brightest) = (from, from);
    for _ in 0..14 {
        u = u.checked_add_signed(step).unwrap();
        if grey(u) > grey(brightest) {
            brightest = u;
        }
    }
    let half = 0.5 * (grey(from) + grey(brightest));
    let mut u = from;
    while grey(u) < half {
        u = u.checked_add_signed(step).unwrap();
    }
    let before = u.checked_add_signed(-step).unwrap();
    before as f64 + step as f64 * (half - grey(before)) / (grey(u) - grey(before))
}

#[test]
fn the_picture_has_its_brightness_step_where_the_truth_has_the_edge() {
    for distortion in [Distortion::None, Distortion::brown_conrady(&[-0.25, 0.05, 0.0, 0.0]).unwrap()] {
        let camera = common::camera(640, 480, distortion);
        let frame = frame_on_main_street(&simulator(&camera, Conditions { road_wear: 0.2, ..BARE }), 65.0);
        let mut checked = 0;
        for row in (250..400).step_by(10) {
            let right = column_at(&frame.truth.lane_right_px, row as f64).unwrap();
            if right > 620.0 {
                continue;
            }
            // Gaps are as dark as the road: the right line is the one without.
            let found = step_column(&frame, row, right as usize - 6, 1);
            assert!((found - right).abs() < 0.6, "row {row}: step at {found}, edge at {right}");
            checked += 1;
        }
        assert!(checked >= 10, "{checked} rows");
    }
}

#[test]
fn edges_follow_the_ground_and_the_body() {
    let camera = common::camera(640, 480, Distortion::None);
    let rough = Conditions {
        markings: BARE.markings,
        noise_levels: 0.0,
        shadow_strength: 0.0,
        road_wear: 0.2,
        ..Conditions { trees_per_100_m: 0.0, houses_per_100_m: 0.0, ..Conditions::ROUGH }
    };
    let frame = frame_on_main_street(&simulator(&camera, rough), 65.0);
    for row in (270..400).step_by(10) {
        let Some(right) = column_at(&frame.truth.lane_right_px, row as f64).filter(|u| *u < 620.0) else {
            continue;
        };
        let found = step_column(&frame, row, right as usize - 6, 1);
        assert!((found - right).abs() < 1.0, "row {row}: step at {found}, edge at {right}");
    }
}

#[test]
fn roads_without_lines_have_no_edges() {
    let camera = common::camera(320, 240, Distortion::None);
    let frame = frame_on_main_street(&simulator(&camera, Conditions::UNMARKED), 65.0);
    assert!(frame.truth.lane_left_px.is_empty() && frame.truth.lane_right_px.is_empty());
    assert!(frame.truth.lane_left_m.is_empty() && frame.truth.lane_left_marking.is_none());
}

/// Drives with a windscreen camera, without objects and noise.
fn on_course(course: &RoadCourse, conditions: Conditions) -> Simulator {
    let (graph, route) = course.roads().unwrap();
    let conditions = Conditions {
        trees_per_100_m: 0.0,
        houses_per_100_m: 0.0,
        noise_levels: 0.0,
        vignette: 0.0,
        road_wear: 0.3,
        ..conditions
    };
    let driving = DrivingPlan::draw(DrivingManner::Keeping, 1, 0.0, 1e4, 20.0);
    let config =
        SimConfig { conditions, cruise_speed_mps: 20.0, end_gap_m: 100.0, driving, ..SimConfig::default() };
    Simulator::new(&graph, &route, &windscreen_camera(640, 480).unwrap(), &config).unwrap()
}

#[test]
fn in_bends_and_over_waves_the_step_is_at_the_edge() {
    let simulator = on_course(&RoadCourse::country(2, 700.0), Conditions::LANE_CONTINUOUS);
    let mut checked = 0;
    for index in (20..simulator.frames()).step_by(60) {
        let frame = simulator.frame(index);
        for row in (235..470).step_by(9) {
            for (edge, step) in [(&frame.truth.lane_left_px, -1), (&frame.truth.lane_right_px, 1)] {
                let Some(column) = column_at(edge, row as f64).filter(|u| (40.0..600.0).contains(u)) else {
                    continue;
                };
                let inside = (column.round() as usize).checked_add_signed(-6 * step).unwrap();
                let found = step_column(&frame, row, inside, step);
                assert!((found - column).abs() < 0.8, "frame {index}, row {row}: {found}, edge at {column}");
                checked += 1;
            }
        }
    }
    assert!(checked > 150, "{checked} edges");
}

#[test]
fn edges_reach_from_the_pictures_border_to_sixty_metres() {
    for course in [RoadCourse::highway(1, 600.0), RoadCourse::country(1, 600.0)] {
        let simulator = on_course(&course, Conditions::LANE_BROKEN);
        for index in (0..simulator.frames()).step_by(25) {
            let truth = simulator.truth(index);
            for (px, m) in
                [(&truth.lane_left_px, &truth.lane_left_m), (&truth.lane_right_px, &truth.lane_right_m)]
            {
                let [u, v] = px[0];
                assert!(
                    v > 478.99 || !(0.01..638.99).contains(&u),
                    "the first point is on the border: {u}, {v}"
                );
                let far = m.last().unwrap();
                assert!(
                    libm::hypot(far[0], far[1]) > 60.0 || !(1.0..638.0).contains(&px.last().unwrap()[0]),
                    "{far:?}"
                );
            }
        }
    }
}

#[test]
fn markings_are_named_as_they_are_painted() {
    let course = RoadCourse::straight(200.0);
    let looks = |conditions| {
        let truth = on_course(&course, conditions).truth(3);
        (truth.lane_left_marking, truth.lane_right_marking)
    };
    let look = |kind, colour| Some(MarkingRecord { kind, colour });
    let white = |kind| look(kind, MarkingColour::White);
    for (conditions, left, right) in [
        (Conditions::LANE_CONTINUOUS, white(MarkingKind::Continuous), white(MarkingKind::Continuous)),
        (Conditions::LANE_BROKEN, white(MarkingKind::Broken), white(MarkingKind::Broken)),
        (Conditions::LANE_DOUBLE, white(MarkingKind::Double), white(MarkingKind::Continuous)),
        (
            Conditions::LANE_YELLOW,
            look(MarkingKind::Double, MarkingColour::Yellow),
            white(MarkingKind::Continuous),
        ),
        (Conditions::LANE_NONE, None, None),
    ] {
        assert_eq!(looks(conditions), (left, right));
    }
}

#[test]
fn between_the_points_of_a_tight_bend_lines_are_straight_to_a_tenth_of_a_pixel() {
    let pieces =
        vec![CoursePiece::Bend { radius_m: 60.0, turn_rad: 1.5 }, CoursePiece::Straight { length_m: 100.0 }];
    let simulator =
        on_course(&RoadCourse { pieces, ..RoadCourse::straight(1.0) }, Conditions::LANE_CONTINUOUS);
    let truth = simulator.truth(20);
    for edge in [&truth.lane_left_px, &truth.lane_right_px] {
        for three in edge.windows(3).filter(|three| three[0][1] - three[2][1] > 0.5) {
            // The chord over two pieces leaves the middle point by four times what a piece leaves the bend by.
            let without = [three[0], three[2]];
            let gap = (column_at(&without, three[1][1]).unwrap() - three[1][0]).abs();
            assert!(gap < 0.4, "{gap} at {:?}", three[1]);
        }
    }
}
