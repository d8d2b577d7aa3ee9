//! The search against the plain loop over the same poses.

use fingerpost_geometry::{GroundGrid, Polyline};
use fingerpost_map::{ArmRole, FeatureKind};
use fingerpost_vision::picture::{Plane, ValidityMask};
use nalgebra::Point2;

use super::*;
use crate::feature_masks::{FeatureMaskConfig, MaskCurve};
use crate::feature_model::ArmModel;
use crate::matching::{MatchConfig, Matcher};
use crate::road_surface::RoadSurface;
use crate::track::ExpectedAhead;
use crate::vehicle::VehicleConfig;

const WIDTH_M: f64 = 5.0;

fn crossroads() -> FeatureModel {
    let arm = |role, label: &str, forward: f64, left: f64| ArmModel {
        role,
        label: label.into(),
        course: Polyline::new([Point2::origin(), Point2::new(60.0 * forward, 60.0 * left)]).unwrap(),
        width_m: WIDTH_M,
        mouth_m: 0.5 * WIDTH_M,
        leaves_after_m: None,
    };
    FeatureModel {
        id: 7,
        name: "A x B".to_owned(),
        kind: FeatureKind::Junction,
        route_m: 60.0,
        arms: vec![
            arm(ArmRole::Approach, "approach", -1.0, 0.0),
            arm(ArmRole::Exit, "exit", 0.1, -0.995),
            arm(ArmRole::Side, "side_1", 0.0, 1.0),
        ],
        map_from_feature: Isometry2::identity(),
    }
}

/// Roads at `vehicle_from_feature` under noise, seen between two slanted lines.
fn surface(
    grid: &GroundGrid,
    feature: &FeatureModel,
    vehicle_from_feature: &Isometry2<f64>,
    seed: u32,
) -> (RoadSurface, ValidityMask) {
    let (columns, rows) = (grid.columns(), grid.rows());
    let mut surface = RoadSurface { probability: Plane::new(columns, rows, 0), ..RoadSurface::default() };
    let mut seen = Plane::new(columns, rows, 0);
    let mut noise = seed;
    for row in 0..rows {
        for column in 0..columns {
            let pixel = fingerpost_geometry::GroundPixel { column: column as f64, row: row as f64 };
            let p = grid.vehicle_from_ground(pixel);
            let p_in_feature = vehicle_from_feature.inverse() * p;
            let on_road = |arm: &ArmModel| arm.course.nearest(p_in_feature).left_m.abs() < 0.5 * WIDTH_M;
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let road = if feature.arms.iter().any(on_road) { 190 } else { 20 };
            surface.probability.row_mut(row)[column] = road + (noise >> 26) as u8;
            seen.row_mut(row)[column] = u8::from(p.y.abs() < 0.8 * p.x);
        }
    }
    let validity = ValidityMask::from_plane(seen);
    surface.sums.rebuild(surface.probability.view(), &validity).unwrap();
    (surface, validity)
}

/// Every pose scored on its own and in full; the best as the module's documentation says.
fn plain(
    (laid, expectation): (&LaidSurface<'_>, Expectation<'_>),
    masks: &mut MaskCache,
    threshold: f64,
    poses: impl Iterator<Item = Isometry2<f64>>,
) -> Tried {
    let all: Vec<Isometry2<f64>> = poses.collect();
    let mut tried = Tried { count: all.len(), ..Tried::default() };
    let mut closest: Option<(Isometry2<f64>, f64)> = None;
    let mut ranked = Vec::new();
    let key = |masks: &MaskCache, pose: &Isometry2<f64>| {
        (masks.key(pose.rotation.angle()), node_pixel(laid.grid(), pose).1)
    };
    let mut rest = &all[..];
    while let Some(first) = rest.first() {
        let length = rest.iter().take_while(|pose| key(masks, pose) == key(masks, first)).count();
        let mut scored = Vec::new();
        for pose in &rest[..length] {
            scored.extend(laid.score(masks, pose, 0.0).unwrap().map(|p| (*pose, p)));
        }
        for &(pose, p) in &scored {
            if closest.is_none_or(|(_, best_p)| p > best_p) {
                closest = Some((pose, p));
            }
        }
        let highest = scored.iter().map(|(_, p)| *p).fold(0.0, f64::max);
        scored.retain(|(_, p)| *p >= threshold.max(highest - AS_GOOD));
        let row = node_pixel(laid.grid(), first).1;
        let middle = scored.get(scored.len() / 2);
        ranked.extend(middle.map(|&(pose, p)| Ranked { pose, p, row, rank: f64::NEG_INFINITY }));
        rest = &rest[length..];
    }
    tried.closest = closest.map(|(pose, _)| pose);
    if let Some(best) = rank_all((laid, expectation), masks, &mut ranked).unwrap() {
        let middle = middle_of(&ranked, &best);
        let p = laid.score(masks, &middle, threshold).unwrap();
        let as_good =
            p.filter(|p| rank((laid, expectation), masks, &middle, *p).unwrap() >= best.rank - 2.0 * AS_GOOD);
        let best = as_good.map_or((best.pose, best.p), |p| (middle, p));
        (tried.best, tried.closest) = (Some(best), Some(best.0));
    }
    tried
}

#[test]
fn rows_at_a_time_find_what_one_by_one_finds() {
    let grid = GroundGrid::new(4.0, 20.0, 8.0, 0.1).unwrap();
    let (feature, vehicle) = (crossroads(), VehicleConfig::default());
    let curve = MaskCurve::new(&FeatureMaskConfig::default(), &vehicle, &feature).unwrap();
    let mut masks =
        MaskCache::new(&FeatureMaskConfig::default(), 4.0, &vehicle, &grid, &feature, curve.as_ref());
    let mut matcher = Matcher::new(&MatchConfig::default(), &grid);
    let config = TrackConfig::default();
    let mut search = CandidateSearch::default();
    let mut found = 0;
    for seed in 0..12_u32 {
        let off = f64::from(seed) - 6.0;
        let truth = Isometry2::new(Vector2::new(13.0 + 0.6 * off, 0.2 * off), 0.02 * off);
        let (surface, validity) = surface(&grid, &feature, &truth, seed);
        let laid = matcher.laid(&surface, &validity).unwrap();
        for threshold in [0.5, 0.75, 0.85, 0.95] {
            let predicted = Isometry2::new(Vector2::new(12.3 + 0.5 * off, 0.0), 0.0);
            let predicted = PoseFilter::new(predicted, [1.2, 0.8, 0.1]);
            let by_rows = search
                .about(&config, &laid, &mut masks, threshold, (&predicted, Reach::of(&config)))
                .unwrap();
            let seen = (&laid, Expectation::About(&predicted));
            let poses = poses_about(&config, predicted.pose(), Reach::of(&config));
            assert_eq!(by_rows, plain(seen, &mut masks, threshold, poses));
            found += usize::from(by_rows.best.is_some());

            let config = TrackConfig { detect_threshold_at_verge: threshold, ..config.clone() };
            let range = 6.0..=18.0;
            let expected = [ExpectedAhead { ahead_m: 12.0 + off, sigma_m: 2.0 }];
            for expectation in [Expectation::Anywhere, Expectation::Ahead(&feature, &expected)] {
                let by_rows =
                    search.along_approach(&config, &laid, &feature, &mut masks, &range, expectation).unwrap();
                let poses = poses_along_approach(&config, &feature, &range);
                assert_eq!(by_rows, plain((&laid, expectation), &mut masks, threshold, poses));
            }
            let by_rows = search
                .along_approach(&config, &laid, &feature, &mut masks, &range, Expectation::Anywhere)
                .unwrap();
            found += usize::from(by_rows.best.is_some());
        }
    }
    assert!(
        (24..90).contains(&found),
        "{found} of 96 searches reach their threshold: a fair mixture is wanted"
    );
}
