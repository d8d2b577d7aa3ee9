//! Where a ray meets a street that has heights of its own: road, kerb or pavement.
//!
//! The search begins where the ground's waves are met and goes along the ray from the highest that a street lies above them to the
//! lowest below, in steps no longer than what it must not miss, and halves the step in which the ray went below the ground.

use nalgebra::Point3;

use super::nearby::{Candidates, first_hit};
use super::{FrameView, GROUND_REACH_M, Renderer, Shot};
use crate::ground::GroundPoint;
use crate::object::{Ray, dot};
use crate::street::{HIGHEST_M, LOWEST_M, StreetPoint};

/// Longest step over ground, metres: shorter than an island is wide and than a lowered kerb's ramp.
const STEP_M: f32 = 0.2;
/// Most steps of a ray: those that meet the ground flatter take longer ones.
const MOST_STEPS: f32 = 24.0;
/// Streets farther off are seen too flatly to tell their heights, metres.
const REACH_M: f32 = 80.0;
/// How often the last step is halved: to a millimetre of ground.
const HALVINGS: usize = 8;
/// A rise of the ground by more than this within the halved step is a kerb's face, metres for each metre.
const FACE_SLOPE: f32 = 1.0;

/// What stands for a height of zero in a picture of heights, and how many steps a metre has: 0 stands for no ground.
const ZERO_HEIGHT: f32 = 32_768.0;
const STEPS_PER_M: f32 = 1000.0;
/// A place is seen where nothing nearer is met, give or take so much of its distance and so many metres.
const SEEN_SHARE: f32 = 0.01;
const SEEN_M: f32 = 0.05;

/// Where a ray meets the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Met {
    /// Distance along the ray, metres; infinite above the horizon.
    pub(super) t: f32,
    /// Unit vector out of the face that is met; none on level ground.
    pub(super) face: Option<[f32; 3]>,
}

impl Renderer {
    /// Whether streets have heights of their own.
    pub(crate) fn has_street(&self) -> bool {
        self.painter.has_street()
    }

    /// The ground at a place, with the edges that are seen there.
    #[inline]
    pub(crate) fn ground_at(&self, x: f32, y: f32) -> GroundPoint {
        self.painter.edged(x, y, self.ground.at(x, y))
    }

    /// How high a street lies above the ground's waves at a place (map frame), metres; 0 where there is none.
    pub(crate) fn street_height_m(&self, x: f32, y: f32) -> f32 {
        if !self.painter.has_street() {
            return 0.0;
        }
        self.painter.street_height_m(x, y, &self.ground.at(x, y))
    }

    /// The street at a place of the map, metres; none where no street has kerbs.
    pub(crate) fn street_at(&self, x: f32, y: f32) -> Option<StreetPoint> {
        if !self.painter.has_street() {
            return None;
        }
        self.painter.street_at(x, y, &self.ground.at(x, y))
    }

    /// Whether nothing stands between the camera and a place (map frame).
    pub(crate) fn is_open(&self, view: &FrameView, p_in_map: Point3<f64>) -> bool {
        let p_in_camera = view.map_from_camera.inverse_transform_point(&p_in_map);
        let shot = Shot::new(self, view);
        let distance_m = p_in_camera.coords.norm() as f32;
        let in_camera = [0, 1, 2].map(|i| p_in_camera[i] as f32 / distance_m);
        let direction = shot.turned(in_camera);
        let mut candidates = Candidates::default();
        shot.near.touching((direction, 1.0, 0.0), &mut candidates.seen);
        let nearest_m = distance_m * (1.0 - SEEN_SHARE) - SEEN_M;
        let ray = Ray { origin: shot.origin, direction };
        first_hit(&shot.things, &ray, 0.0..nearest_m, &candidates.seen).is_none()
            && shot.met(direction, shot.ground_distance(direction, &mut shot.ground_m.clone())).t >= nearest_m
    }
}

/// The plane on which the vehicle stands: a place on it and the unit vector up from it.
pub(super) struct Upwards {
    up: [f32; 3],
    at: [f32; 3],
}

impl Upwards {
    pub(super) fn new(view: &FrameView) -> Self {
        let up = view.map_from_vehicle.rotation * nalgebra::Vector3::z();
        Self {
            up: [0, 1, 2].map(|i| up[i] as f32),
            at: [0, 1, 2].map(|i| view.map_from_vehicle.translation.vector[i] as f32),
        }
    }
}

impl Shot<'_> {
    /// Height above the vehicle's plane of the ground that a ray meets after `t`, in steps.
    pub(super) fn height(&self, d: [f32; 3], t: f32) -> u16 {
        let offset = [0, 1, 2].map(|i| self.origin[i] + t * d[i] - self.plane.at[i]);
        let steps = ZERO_HEIGHT + STEPS_PER_M * dot(offset, self.plane.up);
        steps.round().clamp(1.0, 65_535.0) as u16
    }

    /// Where a ray meets the ground, whose waves it meets after `waves_m`.
    #[inline]
    pub(super) fn met(&self, d: [f32; 3], waves_m: f32) -> Met {
        if !self.scene.painter.has_street() || waves_m > REACH_M.min(GROUND_REACH_M) {
            return Met { t: waves_m, face: None };
        }
        self.street_met(d, waves_m)
    }

    #[inline(never)]
    fn street_met(&self, d: [f32; 3], waves_m: f32) -> Met {
        let scene = self.scene;
        let at = |t: f32| (self.origin[0] + t * d[0], self.origin[1] + t * d[1]);
        let above_m = |t: f32| {
            let (x, y) = at(t);
            let waves_m = if scene.relief.is_flat() { 0.0 } else { scene.relief.height_m(x, y) };
            self.origin[2] + t * d[2] - waves_m - scene.street_height_m(x, y)
        };
        let (first, last) = ((waves_m + HIGHEST_M / d[2]).max(0.0), waves_m + LOWEST_M / d[2]);
        let flat = (d[0] * d[0] + d[1] * d[1]).sqrt();
        let steps = (flat * (last - first) / STEP_M).ceil().clamp(1.0, MOST_STEPS);
        let step = (last - first) / steps;
        let (mut over, mut under) = (first, last);
        for i in 1..=steps as usize {
            let t = first + step * i as f32;
            if above_m(t) <= 0.0 {
                under = t;
                break;
            }
            over = t;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (over + under);
            if above_m(middle) > 0.0 { over = middle } else { under = middle }
        }
        let span_m = flat * (under - over);
        let [(x0, y0), (x1, y1)] = [at(over), at(under)];
        let rise_m = scene.street_height_m(x1, y1) - scene.street_height_m(x0, y0);
        let face = (rise_m > FACE_SLOPE * span_m.max(1e-4)).then(|| {
            let [x, y] = scene.ground_at(x1, y1).edge_slope;
            let length = (x * x + y * y).sqrt().max(1e-6);
            [-x / length, -y / length, 0.0]
        });
        Met { t: 0.5 * (over + under), face }
    }
}
