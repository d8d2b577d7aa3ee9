//! Lanes on painted pictures, where every edge is known.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failed expectation is a failed test"
)]

mod road;
mod settings;

use fingerpost_control::VehicleState;
use fingerpost_geometry::{Camera, Pixel};
use fingerpost_lanes::{Lane, LaneError, LaneFinder, LaneInput, LanesConfig, Side};
use fingerpost_vision::picture::RgbImage;

use self::road::{HEIGHT, Road, WIDTH, camera, deviation_px};

fn found(camera: &Camera, pictures: &[RgbImage]) -> Lane {
    let mut finder = LaneFinder::new(&LanesConfig::default()).unwrap();
    let mut lane = None;
    for (index, frame) in pictures.iter().enumerate() {
        let vehicle = VehicleState::default();
        let input =
            LaneInput { frame, dt_s: (index > 0).then_some(0.05), vehicle: &vehicle, pitch_change: None };
        finder.find(camera, &input, &mut lane).unwrap();
    }
    lane.unwrap()
}

#[test]
fn edges_are_found_in_the_first_frame_on_their_sides_to_a_fraction_of_a_pixel() {
    let camera = camera(3.0);
    let road = Road { edges_m: [1.5, -1.9], heading_rad: 0.01, curvature_per_m: 0.0, painted: |_| true };
    let lane = found(&camera, &[road.picture(&camera)]);
    for side in Side::BOTH {
        let off = deviation_px(&camera, &road, &lane, side);
        assert!(off < 0.7, "{side:?}: {off} px");
    }
    let [left, right] = Side::BOTH.map(|side| lane.edge(side).unwrap());
    assert!((left.offset_m - 1.5).abs() < 0.03 && (right.offset_m + 1.9).abs() < 0.03, "{lane:?}");
    assert!((left.heading_rad - 0.01).abs() < 0.003);
    assert!((lane.width_m().unwrap() - 3.4).abs() < 0.04);
}

#[test]
fn a_bend_to_the_left_has_a_positive_curvature() {
    let camera = camera(3.0);
    let road = Road { edges_m: [1.6, -1.8], heading_rad: 0.0, curvature_per_m: 0.004, painted: |_| true };
    let pictures = vec![road.picture(&camera); 6];
    let lane = found(&camera, &pictures);
    let curvature = lane.edge(Side::Left).unwrap().curvature_per_m;
    assert!((curvature - 0.004).abs() < 8e-4, "{curvature}");
    for side in Side::BOTH {
        assert!(deviation_px(&camera, &road, &lane, side) < 0.8);
    }
}

/// Parallel edges show how the camera is pitched: the places on the road come right although the calibration is off.
#[test]
fn a_pitch_that_the_calibration_does_not_know_is_found() {
    let (assumed, real) = (camera(3.0), camera(3.8));
    let road = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: |_| true };
    let mut finder = LaneFinder::new(&LanesConfig::default()).unwrap();
    let (picture, vehicle, mut lane) = (road.picture(&real), VehicleState::default(), None);
    let mut pitch_deg = 0.0;
    for index in 0..20 {
        let input = LaneInput {
            frame: &picture,
            dt_s: (index > 0).then_some(0.05),
            vehicle: &vehicle,
            pitch_change: None,
        };
        pitch_deg = finder.find(&assumed, &input, &mut lane).unwrap().pitch_rad.to_degrees();
    }
    // Edges that seem to spread may also be a wider lane: most of the pitch is found, its sign surely.
    assert!((0.4..1.0).contains(&pitch_deg), "{pitch_deg}");
    for side in Side::BOTH {
        assert!(deviation_px(&real, &road, &lane.clone().unwrap(), side) < 1.0);
    }
}

#[test]
fn gaps_of_a_broken_line_are_bridged() {
    let camera = camera(3.0);
    let dashes = |ahead_m: f64| (ahead_m - 9.0).rem_euclid(12.0) < 3.0;
    let road = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: dashes };
    let pictures = vec![road.picture(&camera); 4];
    let lane = found(&camera, &pictures);
    for side in Side::BOTH {
        let off = deviation_px(&camera, &road, &lane, side);
        assert!(off < 2.0, "{side:?}: {off} px");
    }
}

#[test]
fn a_road_without_paint_and_one_with_mere_steps_have_no_lane() {
    let camera = camera(3.0);
    let bare = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: |_| false };
    let lane = found(&camera, &vec![bare.picture(&camera); 5]);
    assert!(Side::BOTH.iter().all(|side| lane.edge(*side).is_none()));
    // A bright verge beside a grey road: an edge, and no marking.
    let mut verge = bare.picture(&camera);
    for v in 0..HEIGHT {
        for u in 0..WIDTH {
            let place = camera.ground_of_pixel(Pixel::new(u as f64, v as f64));
            if place.is_some_and(|p| p.y.abs() > 1.7) {
                verge.row_mut(v)[3 * u..3 * u + 3].fill(170);
            }
        }
    }
    let lane = found(&camera, &vec![verge; 5]);
    assert!(Side::BOTH.iter().all(|side| lane.edge(*side).is_none()));
}

#[test]
fn an_edge_that_disappears_is_kept_for_a_while_and_then_dropped() {
    let camera = camera(3.0);
    let road = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: |_| true };
    let bare = Road { painted: |_| false, ..road };
    let config = LanesConfig::default();
    let mut pictures = vec![road.picture(&camera); 3];
    pictures.extend(vec![bare.picture(&camera); 5]);
    let kept = found(&camera, &pictures);
    assert_eq!(kept.edge(Side::Left).unwrap().kept_frames, 5);
    pictures.extend(vec![bare.picture(&camera); config.keep_frames as usize]);
    assert!(found(&camera, &pictures).edge(Side::Left).is_none());
}

/// Where the left edge is said to be after a lane was seen for long, its left line then not at all, and then `last`.
fn left_after_a_gap(camera: &Camera, last: &[RgbImage]) -> f64 {
    let road = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: |_| true };
    let gap = Road { edges_m: [50.0, -1.7], ..road };
    let mut pictures = vec![road.picture(camera); 24];
    pictures.extend(vec![gap.picture(camera); 3]);
    pictures.extend_from_slice(last);
    found(camera, &pictures).edge(Side::Left).unwrap().offset_m
}

#[test]
fn what_flashes_beside_an_edge_in_its_gap_is_not_the_edge_and_what_lasts_is() {
    let camera = camera(3.0);
    let elsewhere = Road { edges_m: [1.0, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted: |_| true };
    let elsewhere = elsewhere.picture(&camera);
    let flashed_m = left_after_a_gap(&camera, &vec![elsewhere.clone(); 2]);
    assert!((flashed_m - 1.7).abs() < 0.1, "{flashed_m}");
    let lasted_m = left_after_a_gap(&camera, &vec![elsewhere; 6]);
    assert!((lasted_m - 1.0).abs() < 0.1, "{lasted_m}");
}

#[test]
fn the_yaw_rate_says_to_which_side_the_lane_leads() {
    let camera = camera(3.0);
    for curvature_per_m in [1.0 / 45.0, -1.0 / 45.0] {
        let road = Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m, painted: |_| true };
        let frame = road.picture(&camera);
        // Votes for lines in the upper sections of the first frame, with a yaw rate along the bend and against it.
        let votes = |yaw_rate_rps: f64| {
            // Near the vehicle the bend hardly shows.
            let config = LanesConfig { least_range_m: 35.0, ..LanesConfig::default() };
            let mut finder = LaneFinder::new(&config).unwrap();
            let vehicle = VehicleState {
                speed_mps: Some(12.0),
                yaw_rate_rps: Some(yaw_rate_rps),
                ..VehicleState::default()
            };
            let input = LaneInput { frame: &frame, dt_s: None, vehicle: &vehicle, pitch_change: None };
            let mut lane = None;
            let evidence = finder.find(&camera, &input, &mut lane).unwrap();
            evidence.candidates.iter().filter(|c| c.section > 1).map(|c| c.votes).sum::<u32>()
        };
        let (along, against) = (votes(12.0 * curvature_per_m), votes(-12.0 * curvature_per_m));
        assert!(along > 3 * against, "{curvature_per_m}: {along} votes along, {against} against");
    }
}

#[test]
fn a_frame_of_another_size_is_refused() {
    let camera = camera(3.0);
    let mut finder = LaneFinder::new(&LanesConfig::default()).unwrap();
    for (width, height) in [(WIDTH / 2, HEIGHT / 2), (WIDTH, HEIGHT + 1), (WIDTH + 1, HEIGHT), (0, 0)] {
        let (frame, vehicle) = (RgbImage::new(width, height), VehicleState::default());
        let input = LaneInput { frame: &frame, dt_s: None, vehicle: &vehicle, pitch_change: None };
        let mut lane = None;
        let error = finder.find(&camera, &input, &mut lane).unwrap_err();
        assert!(matches!(error, LaneError::Picture(_)), "{error:?}");
        let said = error.to_string();
        assert!(said.contains(&format!("{width} x {height}")) && said.contains("640 x 480"), "{said}");
        assert_eq!(lane, None);
    }
}
