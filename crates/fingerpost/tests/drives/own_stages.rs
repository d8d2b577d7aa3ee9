//! Stages that a program gives the pipeline in place of the configuration's act there.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, World, camera_of_width, route};
use fingerpost::lanes::{Lane, LaneDetector, LaneEdge, LaneError, LaneEvidence, LaneInput, LaneMethod, Side};
use fingerpost::matching::{FeatureMatcher, LaidSurface, MatchConfig};
use fingerpost::pipeline::Parts;
use fingerpost::road_surface::RoadSurface;
use fingerpost::track::{Followed, State};
use fingerpost::vehicle::Traffic;
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_geometry::{Camera, GroundGrid};
use fingerpost_map::FeatureKind;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::Plane;
use fingerpost_vision::span::RowSums;
use nalgebra::{Isometry2, Vector2};

const WIDTH_M: f64 = 5.5;
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];
/// The vehicle comes from 26 to 8 m before the node.
const FRAMES: usize = 30;
const STEP_M: f64 = 0.6;

fn settings() -> Config {
    let mut config = crate::painted::config();
    config.ground_view.metres_per_pixel = 0.1;
    // The painted roads meet at sharp corners.
    config.track.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    config
}

/// What comes of a drive towards a T-junction with these stages.
fn drive(config: &Config, parts: impl FnOnce(&GroundGrid) -> Parts) -> Vec<FrameOutput> {
    let camera = camera_of_width(320);
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    let (route, _) = route(&junction);
    let world = World::new(&[SOUTH, EAST, WEST].map(|road| (road, WIDTH_M)));
    let view = &config.ground_view;
    let grid = GroundGrid::new(view.near_m, view.far_m, view.half_width_m, view.metres_per_pixel).unwrap();
    let mut pipeline = Pipeline::with_parts(config, &camera, Some(&route), None, parts(&grid)).unwrap();
    let frame = |i: usize| {
        let place = Vector2::new(0.0, STEP_M * i as f64 - 26.0);
        let picture = world.picture(&camera, &Isometry2::new(place, std::f64::consts::FRAC_PI_2));
        pipeline.step(&picture, Sensors::default(), &mut |_| {}).unwrap().0.clone()
    };
    (0..FRAMES).map(frame).collect()
}

/// Lays masks over nothing but verge.
struct NoRoad {
    config: MatchConfig,
    grid: GroundGrid,
    none: Plane<u8>,
    sums: RowSums,
}

impl FeatureMatcher for NoRoad {
    fn lay<'a>(&'a mut self, surface: &'a RoadSurface) -> Result<LaidSurface<'a>, PictureError> {
        let (width, height) = surface.probability.size();
        self.none.reset(width, height, 0);
        self.sums.rebuild(self.none.view(), surface.known())?;
        Ok(LaidSurface::over(&self.config, &self.grid, &self.sums))
    }
}

#[test]
fn a_matcher_of_ones_own_explains_what_is_found_and_does_not_decide_it() {
    let config = settings();
    let usual = drive(&config, |_| Parts::default());
    let blind = drive(&config, |grid| Parts {
        matcher: Some(Box::new(NoRoad {
            config: config.matching.clone(),
            grid: *grid,
            none: Plane::default(),
            sums: RowSums::default(),
        })),
        ..Parts::default()
    });
    let found = |outputs: &[FrameOutput]| {
        let place = |followed: &Followed| (followed.index, followed.vehicle_from_feature, followed.present);
        let frame = |output: &FrameOutput| (output.track.state, output.track.followed.as_ref().map(place));
        outputs.iter().map(frame).collect::<Vec<_>>()
    };
    assert!(found(&usual).iter().any(|(state, _)| *state == State::Tracking));
    assert_eq!(found(&usual), found(&blind));
    let match_p = |outputs: &[FrameOutput]| {
        let tracked = outputs.iter().filter(|output| output.track.state == State::Tracking);
        tracked.filter_map(|output| output.track.followed.as_ref()?.matched.p).collect::<Vec<f64>>()
    };
    assert!(match_p(&usual).iter().all(|p| *p > 0.0), "{:?}", match_p(&usual));
    let blind_p = match_p(&blind);
    assert!(!blind_p.is_empty() && blind_p.iter().all(|p| *p == 0.0), "{blind_p:?}");
}

/// A lane whose left edge lies as many centimetres to the left as frames were seen.
#[derive(Default)]
struct Widening {
    frames: u32,
    evidence: LaneEvidence,
}

impl LaneDetector for Widening {
    fn find(
        &mut self,
        _: &Camera,
        _: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        self.frames += 1;
        let edge = LaneEdge { offset_m: 0.01 * f64::from(self.frames), ..LaneEdge::default() };
        *lane = Some(Lane::between([Some(edge), None]));
        Ok(&self.evidence)
    }

    fn reset(&mut self) {
        self.frames = 0;
    }
}

#[test]
fn a_lane_finder_of_ones_own_is_asked_in_every_frame() {
    let mut config = settings();
    config.lanes.finder = LaneMethod::Off;
    assert!(drive(&config, |_| Parts::default()).iter().all(|output| output.lane.is_none()));
    let parts = Parts { lane_finder: Some(Box::new(Widening::default())), ..Parts::default() };
    let outputs = drive(&config, |_| parts);
    // Where the vehicle turns through the junction lanes end.
    let before = outputs.iter().take_while(|output| output.track.state != State::Arrived);
    assert!(before.clone().count() > FRAMES / 2);
    for (i, output) in before.enumerate() {
        let lane = output.lane.as_ref().unwrap();
        assert!(lane.edge(Side::Right).is_none());
        assert!((lane.edge(Side::Left).unwrap().offset_m - 0.01 * (i + 1) as f64).abs() < 1e-12, "frame {i}");
    }
}
