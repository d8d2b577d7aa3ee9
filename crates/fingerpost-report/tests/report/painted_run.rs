//! A short painted drive through the whole method, with everything that a report is made of.

#![allow(unreachable_pub, reason = "shared by test programs and an example")]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

#[path = "../../../fingerpost/tests/painted/mod.rs"]
mod painted;

use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

use fingerpost::track::State;
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_format::{
    FeatureRecord, FeatureSummary, FrameRecord, MotionRecord, StageTime, Summary, TrackState, TruthRecord,
};
use fingerpost_geometry::Camera;
use fingerpost_map::{FeatureKind, Route};
use fingerpost_report::{KeyFrameChoice, KeyFrames, Scene, Setting};
use nalgebra::{Isometry2, Point2, Vector2};
use painted::{Junction, Place, World, route};

const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];
const ROAD_WIDTH_M: f64 = 5.5;
/// Frames a second of the painted drive.
const FPS: f64 = 10.0;

/// What came of the drive.
pub struct PaintedRun {
    pub setting: Setting,
    pub records: Vec<FrameRecord>,
    pub truth: Vec<TruthRecord>,
    pub summary: Summary,
    pub route: Route,
    pub key_frames: KeyFrames,
}

/// Camera of the drive: about 75 degrees wide, 1.5 m high.
pub fn camera() -> Camera {
    painted::camera()
}

/// Drives towards a T-junction, shows every frame to `see`, and then turns right into it. A `name` for the junction.
pub fn painted_run(camera: &Camera, name: &str, see: &mut dyn FnMut(&Scene<'_>)) -> PaintedRun {
    let world = World::new(&[(SOUTH, ROAD_WIDTH_M), (EAST, ROAD_WIDTH_M), (WEST, ROAD_WIDTH_M)]);
    let junction = Junction {
        kind: FeatureKind::Junction,
        approach: SOUTH,
        exit: EAST,
        sides: &[WEST],
        width_m: ROAD_WIDTH_M,
    };
    let (mut route, map_from_place) = route(&junction);
    name.clone_into(&mut route.features[0].name);
    let mut config = Config::default();
    config.vehicle.traffic = Traffic::Centre;
    let mut pipeline = Pipeline::new(&config, camera, Some(&route), None).unwrap();
    let setting = Setting::new(camera, &pipeline);
    let mut run = PaintedRun {
        setting,
        records: Vec::new(),
        truth: Vec::new(),
        summary: Summary::default(),
        route,
        key_frames: KeyFrames::default(),
    };
    let mut choice = KeyFrameChoice::new(None);
    for frame in 0..36 {
        let y = -28.0 + 0.6 * frame as f64;
        let place_from_vehicle = Isometry2::new(Vector2::new(0.0, y), FRAC_PI_2);
        let picture = world.picture(camera, &place_from_vehicle);
        let (output, evidence) = pipeline.step(&picture, Sensors::default(), &mut |_| {}).unwrap();
        let t_s = frame as f64 / FPS;
        let scene =
            Scene { setting: &run.setting, frame, t_s, picture: &picture, output, evidence: &evidence };
        see(&scene);
        if let Some(chosen) = choice.consider(frame, output, evidence.track) {
            run.key_frames.add(chosen.draw(&scene)).unwrap();
        }
        run.records.push(record(frame, t_s, output));
        let node = place_from_vehicle.inverse() * Point2::origin();
        let p_in_map = Point2::from(place_from_vehicle.translation.vector) + map_from_place;
        run.truth.push(TruthRecord {
            frame,
            t_s,
            x_m: p_in_map.x,
            y_m: p_in_map.y,
            heading_rad: FRAC_PI_2,
            feature_id: Some(7),
            feature_forward_m: Some(node.x),
            feature_left_m: Some(node.y),
            ..TruthRecord::default()
        });
    }
    run.summary = summary(&run.records, name);
    run
}

fn record(frame: u64, t_s: f64, output: &FrameOutput) -> FrameRecord {
    let feature = output.track.followed.as_ref().map(|followed| FeatureRecord {
        id: 7,
        kind: "junction".to_owned(),
        p: followed.matched.p,
        sub: followed.matched.subs.iter().filter_map(|sub| Some((sub.label.to_string(), sub.p?))).collect(),
        contrast: Default::default(),
        confidence: None,
        present: Some(followed.present),
        rivals: Vec::new(),
        forward_m: followed.vehicle_from_feature.translation.x,
        left_m: followed.vehicle_from_feature.translation.y,
        heading_rad: followed.vehicle_from_feature.rotation.angle(),
        sigma_m: [0.2, 0.1],
    });
    FrameRecord {
        camera: None,
        sought: None,
        frame,
        t_s,
        state: match output.track.state {
            State::NoRoute => TrackState::NoRoute,
            State::Searching => TrackState::Searching,
            State::Tracking => TrackState::Tracking,
            State::Arrived => TrackState::Arrived,
            State::Lost => TrackState::Lost,
            State::RouteDone => TrackState::RouteDone,
        },
        feature,
        motion: output.motion.as_ref().map(|motion| MotionRecord {
            forward_m: motion.previous_from_current.translation.x,
            left_m: motion.previous_from_current.translation.y,
            yaw_rad: motion.previous_from_current.rotation.angle(),
            quality: motion.quality,
            doubt: None,
        }),
        mount: None,
        signals: None,
        surface: None,
        driving_line_m: Vec::new(),
        driving_line_curvature_per_m: Vec::new(),
        centreline: None,
        no_centreline: None,
        lanes: None,
        fix: None,
        advice: None,
        route_m: output.track.route_m,
        stage_ms: BTreeMap::new(),
        why: output.why.clone(),
        error: None,
    }
}

fn summary(records: &[FrameRecord], name: &str) -> Summary {
    let first = |state: TrackState| records.iter().find(|r| r.state == state);
    let detected = first(TrackState::Tracking);
    Summary {
        written_by: None,
        frames: records.len() as u64,
        fps: 41.5,
        stage_ms: BTreeMap::from([
            ("road".to_owned(), StageTime { median: 3.1, p95: 4.0 }),
            ("motion".to_owned(), StageTime { median: 9.2, p95: 12.5 }),
        ]),
        features: vec![FeatureSummary {
            id: 7,
            name: name.to_owned(),
            kind: "junction".to_owned(),
            detected_frame: detected.map(|r| r.frame),
            detected_forward_m: detected.and_then(|r| Some(r.feature.as_ref()?.forward_m)),
            arrived_frame: first(TrackState::Arrived).map(|r| r.frame),
            max_p: Some(0.93),
            ..FeatureSummary::default()
        }],
        ..Summary::default()
    }
}
