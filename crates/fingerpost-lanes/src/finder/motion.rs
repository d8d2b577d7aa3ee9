//! The vehicle's motion as the lane is carried on by it: held for a moment where it fails, doubted where dashes contradict it.

use fingerpost_geometry::Camera;

use super::LaneFinder;
use crate::LaneInput;
use crate::lane_filter::LaneMotion;
use fingerpost_geometry::ObservedAngle;

/// How long a motion is held that is not known anew, seconds.
const MOST_HELD_S: f64 = 0.5;

/// The vehicle's motion as it was last known.
#[derive(Debug, Clone, Copy)]
pub(super) struct HeldMotion {
    speed_mps: f64,
    yaw_rate_rps: f64,
    age_s: f64,
}

impl LaneFinder {
    pub(super) fn predict(&mut self, input: &LaneInput<'_>) {
        let dt_s = input.dt_s.unwrap_or(0.0);
        match input.vehicle.speed_mps.zip(input.vehicle.yaw_rate_rps) {
            Some((speed_mps, yaw_rate_rps)) => {
                self.held = Some(HeldMotion { speed_mps, yaw_rate_rps, age_s: 0.0 });
            }
            // A motion that fails for a moment goes on as it was.
            None => {
                self.held.iter_mut().for_each(|held| held.age_s += dt_s);
                self.held = self.held.filter(|held| held.age_s <= MOST_HELD_S);
            }
        }
        let believed = self.held.filter(|_| !self.dashes.contradict_motion());
        let forward_m = believed.map(|held| dt_s * held.speed_mps);
        let yaw_rad = believed.map(|held| dt_s * held.yaw_rate_rps);
        let dt_s = input.dt_s;
        let pitch_change = self.pitch_change(input);
        self.filter.predict(&LaneMotion { dt_s, forward_m, yaw_rad, pitch_change });
        for followed in &mut self.followed {
            followed.notes.advance(forward_m.unwrap_or(0.0));
        }
    }

    /// The change of the pitch, where the pitch before it is known: two edges show it, one alone does not.
    pub(super) fn pitch_change(&self, input: &LaneInput<'_>) -> Option<ObservedAngle> {
        input.pitch_change.filter(|_| self.followed.iter().all(|edge| edge.active && edge.kept_frames == 0))
    }

    /// Holds the motion against the dashes of the lane as it is known now.
    pub(super) fn look_at_dashes(&mut self, camera: &Camera, input: &LaneInput<'_>) {
        let sides = [0, 1].map(|side| self.followed[side].active);
        self.dashes.look_at(camera, &self.filter, input.frame, sides);
        if let Some((held, dt_s)) = self.held.zip(input.dt_s) {
            self.dashes.judge_motion(dt_s * held.speed_mps, dt_s);
        }
    }
}
