//! Equations 1 and 2 of paper 1 on surfaces that can be summed by hand, and masks by known places.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, route};
use fingerpost::feature_masks::{FeatureMaskConfig, MaskCache, node_pixel};
use fingerpost::feature_model::FeatureModel;
use fingerpost::matching::{LaidSurface, Match, MatchConfig, MatchedSurface, Matcher, Participation};
use fingerpost::road_surface::RoadSurface;
use fingerpost::vehicle::VehicleConfig;
use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_map::{FeatureKind, TangentPlane};
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::{Isometry2, Point2, Vector2};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const NORTH: &[Place] = &[(0.0, 0.0), (0.0, 60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

fn grid() -> GroundGrid {
    GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap()
}

fn crossroads() -> (FeatureModel, MaskCache) {
    let junction = Junction {
        kind: FeatureKind::Junction,
        approach: SOUTH,
        exit: NORTH,
        sides: &[EAST, WEST],
        width_m: 6.0,
    };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    let masks =
        MaskCache::new(&FeatureMaskConfig::default(), 0.0, &VehicleConfig::default(), &grid(), &model, None);
    (model, masks)
}

/// A surface whose probability is `p` of the place in the vehicle frame, unseen where `p` is none.
fn surface(p: impl Fn(Point2<f64>) -> Option<u8>) -> (RoadSurface, ValidityMask) {
    let grid = grid();
    let mut surface =
        RoadSurface { probability: Plane::new(grid.columns(), grid.rows(), 0), ..Default::default() };
    let mut validity = Plane::new(grid.columns(), grid.rows(), 0);
    for row in 0..grid.rows() {
        for column in 0..grid.columns() {
            let place = grid.vehicle_from_ground(GroundPixel { column: column as f64, row: row as f64 });
            if let Some(value) = p(place) {
                surface.probability.row_mut(row)[column] = value;
                validity.row_mut(row)[column] = 1;
            }
        }
    }
    let validity = ValidityMask::from_plane(validity);
    surface.sums.rebuild(surface.probability.view(), &validity).unwrap();
    (surface, validity)
}

fn pose(forward: f64, left: f64, heading: f64) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(forward, left), heading)
}

fn explained(laid: &LaidSurface<'_>, masks: &mut MaskCache, pose: Isometry2<f64>) -> Match {
    let mut matched = Match::default();
    laid.explain(masks, &pose, &mut matched).unwrap();
    matched
}

#[test]
fn each_arm_is_the_mean_under_it_and_the_feature_is_the_weakest() {
    let (_, mut masks) = crossroads();
    // Forward of 12 m the surface is 204 (0.8), behind 255; left of 2 m it is 102 (0.4).
    let (surface, validity) = surface(|p| {
        Some(if p.y > 2.0 {
            102
        } else if p.x > 12.0 {
            204
        } else {
            255
        })
    });
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    let p = |label: &str| matched.subs.iter().find(|sub| &*sub.label == label).unwrap().p.unwrap();
    assert!((p("approach") - 1.0).abs() < 0.01);
    assert!((p("exit") - 0.8).abs() < 0.01);
    // side_1 runs east, to the right, half on either side of the 12 m line.
    assert!((p("side_1") - 0.9).abs() < 0.02);
    // side_2 runs 10 m to the left: 2 m at 0.9 and 8 m at 0.4.
    assert!((p("side_2") - (0.2 * 0.9 + 0.8 * 0.4)).abs() < 0.02, "{}", p("side_2"));
    assert_eq!(matched.subs[matched.weakest.unwrap()].label.as_ref(), "side_2");
    assert!((matched.p.unwrap() - p("side_2")).abs() < 1e-12);
    assert_eq!(laid.probability(&mut masks, &pose(12.0, 0.0, 0.0)).unwrap(), matched.p);
}

#[test]
fn a_binary_surface_counts_pixels() {
    let (_, mut masks) = crossroads();
    let (surface, validity) = surface(|p| Some(if p.y > 2.0 { 102 } else { 204 }));
    let config = MatchConfig { surface: MatchedSurface::Binary, ..MatchConfig::default() };
    let mut matcher = Matcher::new(&config, &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    let p = |label: &str| matched.subs.iter().find(|sub| &*sub.label == label).unwrap().p.unwrap();
    assert!((p("side_1") - 1.0).abs() < 1e-9 && (p("side_2") - 0.2).abs() < 0.02);
}

#[test]
fn unseen_pixels_neither_count_for_nor_against_and_a_cut_arm_takes_no_part() {
    let (_, mut masks) = crossroads();
    let (surface, validity) = surface(|p| (p.y < 4.0).then_some(255));
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    let sub = |label: &str| matched.subs.iter().find(|sub| &*sub.label == label).unwrap();
    // 4 m of the left arm are seen, 3 of them on the crossing road.
    assert_eq!(sub("side_2").participation, Participation::CutByValidity);
    assert!((sub("side_2").p.unwrap() - 1.0).abs() < 1e-9);
    assert!((sub("side_2").seen_share - 0.4).abs() < 0.02);
    assert_eq!(sub("side_1").participation, Participation::TakesPart);
    assert!((matched.p.unwrap() - 1.0).abs() < 1e-9);
    // Close to the lower edge the approach is out of view.
    let near = explained(&laid, &mut masks, pose(6.0, 0.0, 0.0));
    let approach = near.subs.iter().find(|sub| &*sub.label == "approach").unwrap();
    assert_eq!(approach.participation, Participation::TooShort);
}

#[test]
fn a_feature_whose_heading_is_to_the_left_has_its_exit_there() {
    let (_, mut masks) = crossroads();
    let at = pose(12.0, 1.0, 0.2);
    let (column, row) = node_pixel(&grid(), &at);
    assert_eq!((column, row), (180, 160), "12 m ahead and 1 m left");
    let drawn = masks.at(0.2).unwrap();
    let exit = drawn.subs.iter().find(|sub| &*sub.label == "exit").unwrap();
    // 6 m out along the exit: forward 6 cos 0.2, left 6 sin 0.2.
    let expected = [-6.0 * libm::sin(0.2_f64) / 0.05, -6.0 * libm::cos(0.2_f64) / 0.05];
    let row = expected[1].round() as i32;
    let span = exit.spans.spans().iter().find(|span| span.row == row).unwrap();
    let middle = 0.5 * f64::from(span.start + span.end - 1);
    assert!((middle - expected[0]).abs() < 1.0, "{middle} for {expected:?}");
    assert!(
        (f64::from(span.end - span.start) - 9.0 / libm::cos(0.2)).abs() < 1.5,
        "a quarter of 1.8 m is 9 pixels"
    );
}

#[test]
fn the_vehicle_on_a_bent_approach_sees_the_feature_round_the_bend() {
    let bent: &[Place] = &[(0.0, 0.0), (0.0, -10.0), (-20.0, -10.0)];
    let junction =
        Junction { kind: FeatureKind::Junction, approach: bent, exit: NORTH, sides: &[EAST], width_m: 6.0 };
    let (route, _) = route(&junction);
    let model = FeatureModel::new(&route.features[0], &TangentPlane::new(route.line[0].at)).unwrap();
    // 15 m before the node the vehicle drives east, 5 m before the corner: the node is 5 m ahead and 10 m left.
    let seen = model.vehicle_from_feature(15.0, 0.0, 0.0);
    assert!((seen.translation.vector - Vector2::new(5.0, 10.0)).norm() < 0.01, "{seen}");
    assert!((seen.rotation.angle() - std::f64::consts::FRAC_PI_2).abs() < 1e-3);
    for heading in [-0.2, 0.0, 0.1] {
        let seen = model.vehicle_from_feature(15.0, 0.5, heading);
        assert!((model.heading_off_approach_rad(&seen) - heading).abs() < 1e-9);
    }
    let left = model.vehicle_from_feature(15.0, 1.0, 0.0);
    assert!(
        (left.translation.vector - Vector2::new(5.0, 9.0)).norm() < 0.01,
        "1 m further left it is 1 m nearer"
    );
}

/// Whether a place belongs to the crossroads with its node 12 m ahead.
fn on_the_crossroads(place: Point2<f64>) -> bool {
    place.y.abs() < 3.0 || (place.x - 12.0).abs() < 3.0
}

#[test]
fn an_arm_with_verges_stands_out_from_them() {
    let (_, mut masks) = crossroads();
    let (surface, validity) = surface(|p| Some(if on_the_crossroads(p) { 204 } else { 51 }));
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    for sub in &matched.subs {
        for verge in sub.verges {
            let verge = verge.unwrap();
            assert!((verge.arm_p - 0.8).abs() < 1e-9 && (verge.verge_p - 0.2).abs() < 1e-9, "{sub:?}");
            assert!(verge.beyond_m > 3.0, "outside the edge: {sub:?}");
        }
        assert!((sub.contrast().unwrap() - 0.6).abs() < 1e-9);
    }
    assert!((matched.contrast().unwrap() - 0.6).abs() < 1e-9);
    assert!((matched.confidence().unwrap() - 0.8 * 0.8).abs() < 1e-9);
}

#[test]
fn an_endless_paved_area_matches_without_contrast() {
    let (_, mut masks) = crossroads();
    let (surface, validity) = surface(|_| Some(255));
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    assert!(matched.p.unwrap() > 0.999);
    assert!(matched.contrast().unwrap().abs() < 1e-9 && matched.confidence().unwrap().abs() < 1e-9);
}

#[test]
fn an_arm_of_which_one_verge_is_unseen_has_half_the_contrast() {
    let (_, mut masks) = crossroads();
    // Nothing is seen beyond the far edge of the crossing road.
    let (surface, validity) =
        surface(|p| (p.x < 15.0).then_some(if on_the_crossroads(p) { 255 } else { 51 }));
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid());
    let laid = matcher.laid(&surface, &validity).unwrap();
    let matched = explained(&laid, &mut masks, pose(12.0, 0.0, 0.0));
    let sub = |label: &str| matched.subs.iter().find(|sub| &*sub.label == label).unwrap();
    // Looking outwards along the arm to the east, which is side 1, far is left.
    let [far, near] = sub("side_1").verges;
    assert!((near.unwrap().contrast() - 0.8).abs() < 1e-9, "{near:?}");
    assert_eq!(far, None, "nothing but road is seen there");
    assert!((sub("side_1").contrast().unwrap() - 0.4).abs() < 1e-9);
    assert!(sub("exit").verges.iter().all(Option::is_none));
}
