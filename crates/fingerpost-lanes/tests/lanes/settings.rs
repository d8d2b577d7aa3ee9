//! What the settings do to the lane that is found.

use fingerpost_control::VehicleState;
use fingerpost_lanes::{Lane, LaneFinder, LaneInput, LanesConfig, Side};
use fingerpost_vision::picture::RgbImage;

use super::road::{HEIGHT, Road, camera};

/// Frames that are enough for an edge to be given out.
const FRAMES: usize = 6;
/// How far from the largest range an edge may end, metres: the region's rows come eight at a time.
const BEYOND_M: f64 = 2.0;

/// The lane after as many frames of a picture, seen at a speed, m/s.
fn found(config: &LanesConfig, frame: &RgbImage, speed_mps: Option<f64>) -> Lane {
    let mut finder = LaneFinder::new(config).unwrap();
    let mut lane = None;
    let vehicle = VehicleState { speed_mps, ..VehicleState::default() };
    for index in 0..FRAMES {
        let dt_s = (index > 0).then_some(0.01);
        let input = LaneInput { frame, dt_s, vehicle: &vehicle, pitch_change: None };
        finder.find(&camera(3.0), &input, &mut lane).unwrap();
    }
    lane.unwrap()
}

fn sides(lane: &Lane) -> [bool; 2] {
    Side::BOTH.map(|side| lane.edge(side).is_some())
}

fn straight(painted: fn(f64) -> bool) -> Road {
    Road { edges_m: [1.7, -1.7], heading_rad: 0.0, curvature_per_m: 0.0, painted }
}

/// How far ahead the lane's edges end, metres.
fn ends_m(lane: &Lane) -> [f64; 2] {
    let last = Side::BOTH.map(|side| *lane.edge(side).unwrap().points_px.last().unwrap());
    last.map(|pixel| camera(3.0).ground_of_pixel(pixel).unwrap().x)
}

#[test]
fn lines_are_searched_for_as_far_as_the_reaction_time_needs() {
    let picture = straight(|ahead_m| ahead_m > 14.0).picture(&camera(3.0));
    for (reaction_time_s, speed_mps, expected) in [
        (0.1, Some(20.0), false),
        (0.9, Some(20.0), true),
        (0.465, Some(5.0), false),
        (0.465, Some(35.0), true),
        (0.1, None, true),
    ] {
        let config = LanesConfig { reaction_time_s, ..LanesConfig::default() };
        let found = sides(&found(&config, &picture, speed_mps));
        assert_eq!(found, [expected; 2], "{reaction_time_s} s, {speed_mps:?} m/s");
    }
}

#[test]
fn edges_are_given_out_to_the_largest_range() {
    let picture = straight(|_| true).picture(&camera(3.0));
    for most_range_m in [15.0, 20.0, 35.0] {
        let config = LanesConfig { most_range_m, ..LanesConfig::default() };
        let ends_m = ends_m(&found(&config, &picture, Some(5.0)));
        let expected = most_range_m - BEYOND_M..most_range_m + BEYOND_M;
        assert!(ends_m.iter().all(|end_m| expected.contains(end_m)), "{most_range_m} m: {ends_m:?}");
    }
}

/// Paper 3, III-C: the far section's indicator.
#[test]
fn an_edge_ends_where_its_place_is_no_longer_known() {
    let ends_m = |painted| {
        let picture = straight(painted).picture(&camera(3.0));
        ends_m(&found(&LanesConfig::default(), &picture, None))
    };
    let [near_m, far_m] = [ends_m(|ahead_m| ahead_m < 8.0), ends_m(|ahead_m| ahead_m < 16.0)];
    assert!(near_m.iter().all(|end_m| (15.0..30.0).contains(end_m)), "{near_m:?}");
    assert!(far_m.iter().all(|end_m| *end_m > 33.0), "{far_m:?}");
}

#[test]
fn a_line_that_turns_away_from_the_one_before_is_not_taken() {
    let camera = camera(3.0);
    // Too short a piece to be taken by itself, and a line farther on that leads elsewhere.
    let piece = Road { edges_m: [1.7, -20.0], ..straight(|ahead_m| ahead_m < 6.0) };
    let away = |ahead_m: f64| ahead_m > 8.0;
    let away = Road { edges_m: [0.35, -20.0], heading_rad: 0.09, ..straight(away) }.picture(&camera);
    let mut picture = piece.picture(&camera);
    for v in 0..HEIGHT {
        picture.row_mut(v).iter_mut().zip(away.row(v)).for_each(|(level, away)| *level = (*level).max(*away));
    }
    for (max_turn_deg, expected) in [(8.0, false), (45.0, true)] {
        let lane = found(&LanesConfig { max_turn_deg, ..LanesConfig::default() }, &picture, None);
        assert_eq!(sides(&lane), [expected, false], "{max_turn_deg} degrees");
    }
}

#[test]
fn pieces_smaller_than_the_least_area_lead_to_no_lane() {
    let dashes = |ahead_m: f64| (ahead_m - 9.0).rem_euclid(6.0) < 2.0;
    let picture = straight(dashes).picture(&camera(3.0));
    for (min_area_px, expected) in [(25.0, true), (300.0, false)] {
        let lane = found(&LanesConfig { min_area_px, ..LanesConfig::default() }, &picture, None);
        assert_eq!(sides(&lane), [expected; 2], "{min_area_px} pixels");
    }
}
