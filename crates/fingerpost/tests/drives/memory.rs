//! The memory of the road over a world whose road is known everywhere, seen by a detector that is always right.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::collections::VecDeque;
use std::f64::consts::FRAC_PI_2;

use crate::painted::camera;
use fingerpost::Config;
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::motion::Motion;
use fingerpost::road_surface::{
    Knowledge, Memory, MemoryConfig, Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput,
    RoadMethod, RoadSurface,
};
use fingerpost_geometry::GroundPixel;
use fingerpost_vision::picture::{Plane, Rect, RgbImage};
use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

/// Road or not, by place in the map frame.
type World = fn(Point2<f64>) -> bool;

/// Half the width of all roads, metres.
const HALF_M: f64 = 3.0;

fn straight(p: Point2<f64>) -> bool {
    p.y.abs() < HALF_M
}

/// A ring road about the origin, 20 m in radius to its middle.
fn ring(p: Point2<f64>) -> bool {
    (p.coords.norm() - 20.0).abs() < HALF_M
}

/// Sees the world as it is.
struct TrueRoad {
    world: World,
    view: GroundView,
    /// Of the frames to come.
    poses: VecDeque<Isometry2<f64>>,
}

impl RoadDetector for TrueRoad {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let map_from_vehicle = self.poses.pop_front().unwrap();
        let (width, height) = input.validity.size();
        probability.reset(width, height, 0);
        for row in 0..height {
            for run in input.validity.runs(row) {
                for column in run.start..run.end {
                    let pixel = GroundPixel { column: column as f64, row: row as f64 };
                    let place = map_from_vehicle * self.view.grid().vehicle_from_ground(pixel);
                    probability.row_mut(row)[column] = if (self.world)(place) { 250 } else { 5 };
                }
            }
        }
        Ok(RoadEvidence::default())
    }

    fn reset(&mut self) {}
}

/// A vehicle with a memory.
struct Drive {
    view: GroundView,
    picture: GroundPicture,
    memory: Memory,
    surface: RoadSurface,
    evidence: RoadEvidence,
}

impl Drive {
    fn new(world: World, poses: &[Isometry2<f64>]) -> Self {
        let bins = Config::default().road_surface.backprojection.bins();
        let view = || GroundView::new(&Config::default().ground_view, bins, &camera()).unwrap();
        let seeing = TrueRoad { world, view: view(), poses: poses.iter().copied().collect() };
        let memory = Memory::new(RoadMethod::Memory, &MemoryConfig::default(), Box::new(seeing));
        let view = view();
        let (surface, evidence) = (RoadSurface::default(), RoadEvidence::default());
        Self { picture: view.black_picture(), view, memory, surface, evidence }
    }

    /// One frame after such a motion.
    fn step(&mut self, motion: Option<Isometry2<f64>>) {
        let frame = RgbImage::new(640, 480);
        let covariance = Matrix3::from_diagonal(&nalgebra::Vector3::new(1e-4, 1e-4, 1e-6));
        let motion =
            motion.map(|previous_from_current| Motion { previous_from_current, covariance, quality: 0.9 });
        let input = RoadInput {
            picture: &self.picture,
            validity: self.view.validity(),
            sample: Rect::default(),
            perspective: Perspective::Ground { view: &self.view, frame: &frame },
            motion: motion.as_ref(),
        };
        self.evidence = self.memory.detect(input, &mut self.surface).unwrap();
    }

    /// Drives the poses; the motion is theirs.
    fn along(world: World, poses: &[Isometry2<f64>]) -> Self {
        let mut drive = Self::new(world, poses);
        drive.step(None);
        for pair in poses.windows(2) {
            drive.step(Some(pair[0].inverse() * pair[1]));
        }
        drive
    }

    /// Shares of the pixels of a kind of knowledge that are told rightly, of places at least `margin_m` from any kerb, and how
    /// many there are.
    fn right(&self, world: World, pose: &Isometry2<f64>, kind: Knowledge, margin_m: f64) -> (f64, usize) {
        let (width, height) = self.surface.probability.size();
        let (mut right, mut count) = (0, 0);
        for row in 0..height {
            for column in 0..width {
                let seen = self.view.validity().plane();
                if self.surface.knowledge(seen, column, row) != kind {
                    continue;
                }
                let pixel = GroundPixel { column: column as f64, row: row as f64 };
                let place = pose * self.view.grid().vehicle_from_ground(pixel);
                let around = [(1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)]
                    .map(|(x, y)| world(place + margin_m * Vector2::new(x, y)));
                if around.iter().any(|road| *road != around[0]) {
                    continue;
                }
                count += 1;
                let p = self.surface.probability.get(column, row).unwrap();
                right += usize::from((p >= 128) == around[0]);
            }
        }
        (right as f64 / count.max(1) as f64, count)
    }
}

fn straight_on(frames: usize, step_m: f64) -> Vec<Isometry2<f64>> {
    (0..frames).map(|frame| Isometry2::translation(step_m * frame as f64, 0.0)).collect()
}

/// To the left round the ring, from its easternmost point.
fn round_the_ring(frames: usize, step_m: f64) -> Vec<Isometry2<f64>> {
    let pose = |frame: usize| {
        let turned = step_m * frame as f64 / 20.0;
        Isometry2::new(Vector2::new(20.0 * libm::cos(turned), 20.0 * libm::sin(turned)), turned + FRAC_PI_2)
    };
    (0..frames).map(pose).collect()
}

#[test]
fn a_first_frame_is_as_it_is_seen_and_nothing_is_remembered() {
    let poses = straight_on(1, 1.0);
    let drive = Drive::along(straight, &poses);
    let (right, count) = drive.right(straight, &poses[0], Knowledge::Seen, 0.0);
    assert!(right > 0.999 && count == drive.view.validity().seen(), "{right} of {count}");
    assert_eq!(drive.surface.known(), drive.view.validity());
    assert_eq!(drive.evidence.detector, "memory");
    assert!(drive.evidence.memory.unwrap().remembered_share.abs() < 1e-12);
}

#[test]
fn what_the_camera_does_not_see_is_remembered_from_where_it_did() {
    // Not in whole cells, and farther than the map reaches.
    for step_m in [0.37, 1.0, 1.3] {
        let poses = straight_on(60, step_m);
        let drive = Drive::along(straight, &poses);
        let pose = poses.last().unwrap();
        let (right, count) = drive.right(straight, pose, Knowledge::Remembered, 0.15);
        assert!(right > 0.99 && count > 10_000, "{step_m}: {right} of {count}");
        let (right, _) = drive.right(straight, pose, Knowledge::Seen, 0.0);
        assert!(right > 0.995, "{step_m}: {right}");
        let memory = drive.evidence.memory.unwrap();
        let known = drive.surface.known().seen() as f64 / (400.0 * 320.0);
        assert!((memory.seen_share + memory.remembered_share - known).abs() < 1e-9);
        assert!(memory.remembered_share > 0.1 && memory.kept > 0.9, "{memory:?}");
        // Unknown pixels say nothing.
        let unknown =
            drive.surface.probability.as_slice().iter().zip(drive.surface.known().plane().as_slice());
        assert!(unknown.filter(|(_, known)| **known == 0).all(|(p, _)| *p == 0));
    }
}

#[test]
fn in_a_turn_the_remembered_kerbs_stay_where_they_are() {
    let poses = round_the_ring(130, 0.7);
    let drive = Drive::along(ring, &poses);
    for (kind, margin_m, least) in [(Knowledge::Seen, 0.0, 0.995), (Knowledge::Remembered, 0.2, 0.98)] {
        let (right, count) = drive.right(ring, poses.last().unwrap(), kind, margin_m);
        assert!(right > least && count > 5_000, "{kind:?}: {right} of {count}");
    }
}

#[test]
fn a_wrong_motion_is_unlearned_within_a_few_frames() {
    let mut poses = straight_on(20, 1.0);
    let standing = *poses.last().unwrap();
    poses.extend([standing; 8]);
    let mut drive = Drive::new(straight, &poses);
    drive.step(None);
    (0..19).for_each(|_| drive.step(Some(Isometry2::translation(1.0, 0.0))));
    // The vehicle stands, but is said to have jumped two metres to the left.
    drive.step(Some(Isometry2::translation(0.0, 2.0)));
    let (at_once, _) = drive.right(straight, &standing, Knowledge::Seen, 0.0);
    assert!(at_once > 0.9, "what is seen outvotes what is remembered: {at_once}");
    (0..4).for_each(|_| drive.step(Some(Isometry2::identity())));
    let (right, _) = drive.right(straight, &standing, Knowledge::Seen, 0.0);
    assert!(right > 0.995, "{right}");
    // Unseen parts keep it no longer than the fading lets them.
    (0..3).for_each(|_| drive.step(None));
    let memory = drive.evidence.memory.unwrap();
    assert!((memory.kept - 0.5).abs() < 1e-12 && memory.remembered_share < 0.02, "{memory:?}");
}

#[test]
fn a_standing_vehicle_forgets_nothing_and_a_reset_all() {
    let mut poses = straight_on(20, 1.0);
    let standing = *poses.last().unwrap();
    poses.extend([standing; 42]);
    let mut drive = Drive::new(straight, &poses);
    drive.step(None);
    (0..19).for_each(|_| drive.step(Some(Isometry2::translation(1.0, 0.0))));
    let before = drive.evidence.memory.unwrap().remembered_share;
    (0..40).for_each(|_| drive.step(Some(Isometry2::identity())));
    let after = drive.evidence.memory.unwrap().remembered_share;
    assert!(after > 0.6 * before && before > 0.1, "{before}, {after}");
    drive.memory.reset();
    drive.step(Some(Isometry2::identity()));
    assert!(drive.evidence.memory.unwrap().remembered_share.abs() < 1e-12);
}
