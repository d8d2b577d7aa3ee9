//! Paper 3's own tracker on painted pictures.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failed expectation is a failed test"
)]

#[path = "../../fingerpost-lanes/tests/lanes/road.rs"]
mod road;

use fingerpost_control::VehicleState;
use fingerpost_geometry::Camera;
use fingerpost_lanes::{Lane, LaneDetector, LaneFinder, LaneInput, LanesConfig, LineVerdict, Side};
use fingerpost_papers::SectionTracker;
use fingerpost_vision::picture::RgbImage;

use road::{Road, camera, deviation_px};

fn straight(painted: fn(f64) -> bool) -> Road {
    Road { edges_m: [1.6, -1.8], heading_rad: 0.0, curvature_per_m: 0.0, painted }
}

/// What a finder says of each of some pictures.
fn lanes(finder: &mut dyn LaneDetector, camera: &Camera, pictures: &[&RgbImage]) -> Vec<Lane> {
    let (vehicle, mut lane) = (VehicleState::default(), None);
    let mut one = |(index, frame): (usize, &&RgbImage)| {
        let dt_s = (index > 0).then_some(0.03);
        finder
            .find(camera, &LaneInput { frame, dt_s, vehicle: &vehicle, pitch_change: None }, &mut lane)
            .unwrap();
        lane.clone().unwrap()
    };
    pictures.iter().enumerate().map(&mut one).collect()
}

fn tracker() -> SectionTracker {
    SectionTracker::new(&LanesConfig::default()).unwrap()
}

#[test]
fn inner_edges_are_found_in_the_first_frame_on_their_sides() {
    let camera = camera(3.0);
    let road = Road { heading_rad: 0.01, ..straight(|_| true) };
    let lane = &lanes(&mut tracker(), &camera, &[&road.picture(&camera)])[0];
    for (side, offset_m) in Side::BOTH.into_iter().zip(road.edges_m) {
        // The paint is 15 to 20 pixels wide at the picture's base.
        let off = deviation_px(&camera, &road, lane, side);
        assert!(off < 3.5, "{side:?}: {off} px");
        let edge = lane.edge(side).unwrap();
        assert!((edge.offset_m - offset_m).abs() < 0.1, "{side:?}: {} m", edge.offset_m);
        assert!((edge.heading_rad - 0.01).abs() < 0.03, "{side:?}: {}", edge.heading_rad);
    }
}

#[test]
fn a_bend_is_followed_by_the_spline_and_has_its_sign() {
    let camera = camera(3.0);
    for sign in [1.0, -1.0] {
        let road = Road { curvature_per_m: 0.006 * sign, ..straight(|_| true) };
        let lane = &lanes(&mut tracker(), &camera, &[&road.picture(&camera)])[0];
        for side in Side::BOTH {
            let off = deviation_px(&camera, &road, lane, side);
            assert!(off < 4.0, "{sign}, {side:?}: {off} px");
        }
        let curvatures = Side::BOTH.map(|side| sign * lane.edge(side).unwrap().curvature_per_m);
        let mean_per_m = curvatures.iter().sum::<f64>() / 2.0;
        assert!((0.001..0.009).contains(&mean_per_m), "{sign}: {curvatures:?}");
    }
}

#[test]
fn a_lane_that_disappears_is_kept_and_comes_back_after_a_successive_sequence() {
    let camera = camera(3.0);
    let painted = straight(|_| true).picture(&camera);
    let bare = straight(|_| false).picture(&camera);
    // The buffer shows the paint for a few frames after it is gone.
    let config = LanesConfig { buffer_frames: 1, keep_frames: 5, ..LanesConfig::default() };
    let pictures: Vec<&RgbImage> =
        [(&painted, 2), (&bare, 8), (&painted, 4)].iter().flat_map(|(p, n)| vec![*p; *n]).collect();
    let lanes = lanes(&mut SectionTracker::new(&config).unwrap(), &camera, &pictures);
    for side in Side::BOTH {
        let shown: Vec<bool> = lanes.iter().map(|lane| lane.edge(side).is_some()).collect();
        let expected = [vec![true; 2], vec![true; 5], vec![false; 3], vec![false; 2], vec![true; 2]].concat();
        assert_eq!(shown, expected, "{side:?}");
        let kept = lanes.iter().map_while(|lane| lane.edge(side)).map(|edge| edge.kept_frames);
        assert_eq!(kept.collect::<Vec<_>>(), [0, 0, 1, 2, 3, 4, 5]);
    }
}

/// The paper's indicator: the far section is not drawn in a frame that has no valid place there, whatever the ones before had.
#[test]
fn the_far_section_is_drawn_only_where_it_is_seen() {
    let camera = camera(3.0);
    let whole = straight(|_| true).picture(&camera);
    let near = straight(|ahead_m| ahead_m < 14.0).picture(&camera);
    let config = LanesConfig { buffer_frames: 1, ..LanesConfig::default() };
    let mut tracker = SectionTracker::new(&config).unwrap();
    let lanes = lanes(&mut tracker, &camera, &[&whole, &near, &near]);
    let ends_m = |lane: &Lane| {
        let last = Side::BOTH.map(|side| *lane.edge(side).unwrap().points_px.last().unwrap());
        last.map(|pixel| camera.ground_of_pixel(pixel).unwrap().x)
    };
    assert!(ends_m(&lanes[0]).iter().all(|end_m| *end_m > 33.0));
    for lane in &lanes[1..] {
        assert!(ends_m(lane).iter().all(|end_m| (12.0..25.0).contains(end_m)), "{:?}", ends_m(lane));
    }
}

/// Both edges of a marking are extracted, and the largest inner angle tells the inner one.
#[test]
fn outer_edges_are_candidates_and_not_the_lane() {
    let camera = camera(3.0);
    let picture = straight(|_| true).picture(&camera);
    let candidates = |finder: &mut dyn LaneDetector| {
        let (vehicle, mut lane) = (VehicleState::default(), None);
        let input = LaneInput { frame: &picture, dt_s: None, vehicle: &vehicle, pitch_change: None };
        let evidence = finder.find(&camera, &input, &mut lane).unwrap();
        assert!(evidence.steps.oriented.as_slice().iter().any(|edge| *edge != 0));
        evidence.candidates.iter().filter(|c| c.section == 0).copied().collect::<Vec<_>>()
    };
    let outside_m = |candidate: &fingerpost_lanes::LineCandidate| {
        let place = camera.ground_of_pixel(candidate.lower_px).unwrap();
        let (sign, edge_m) = if candidate.side == Side::Left { (1.0, 1.6) } else { (-1.0, -1.8) };
        sign * (place.y - edge_m)
    };
    let by_sections = candidates(&mut tracker());
    for side in Side::BOTH {
        let of_side = || by_sections.iter().filter(move |c| c.side == side);
        assert!(of_side().any(|c| (outside_m(c) - 0.15).abs() < 0.03), "{side:?}: {by_sections:?}");
        let kept = of_side().find(|c| c.verdict == LineVerdict::Kept).unwrap();
        assert!(outside_m(kept).abs() < 0.05, "{kept:?}");
    }
    let by_paint = candidates(&mut LaneFinder::new(&LanesConfig::default()).unwrap());
    assert!(by_paint.iter().all(|c| outside_m(c) < 0.1), "{by_paint:?}");
}
