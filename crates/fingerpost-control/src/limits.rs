//! What the vehicle can do, and what it is allowed to.

use nalgebra::{Isometry2, Vector2};

use crate::command::{Command, Limited};
use crate::path::chord_m;
use crate::{PathPoint, Situation, at};

/// Acceleration to the side that tyres hold on a wet road, m/s²: a friction of 0.4.
const GRIP_MPS2: f64 = 4.0;

/// No path is kept to less than this, metres: with no clearance at all a vehicle would stand before every bend.
const LEAST_CLEARANCE_M: f64 = 0.05;

/// How a vehicle moves when it is told something.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Moving {
    /// Steering angle that was asked for last, radians.
    pub steer_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// Limits of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleLimits {
    /// Distance between the axles, metres.
    pub wheelbase_m: f64,
    /// Radius of the tightest path of the rear axle's middle, metres.
    pub turning_radius_m: f64,
    /// How fast the front wheels can be turned, rad/s.
    pub steering_rate_radps: f64,
    /// Time from a steering angle that is asked for to the wheels having it, seconds.
    pub steering_lag_s: f64,
    /// Largest acceleration to the side, m/s².
    pub lateral_acceleration_mps2: f64,
    /// Room on either side of it that the path keeps, metres: so far from the path it may come while its wheels turn.
    pub clearance_m: f64,
    /// Deceleration with which it stops within what it sees, m/s².
    pub deceleration_mps2: f64,
    /// Time until it begins to brake, seconds.
    pub reaction_s: f64,
    /// Highest speed, m/s.
    pub speed_max_mps: f64,
    /// Distance ahead that controllers look at, as driving time, seconds.
    pub look_ahead_s: f64,
    /// The same at the least, metres.
    pub look_ahead_min_m: f64,
}

impl VehicleLimits {
    /// Largest angle of the front wheels, radians: that of the turning circle.
    pub fn steer_max_rad(&self) -> f64 {
        libm::atan(self.wheelbase_m / self.turning_radius_m)
    }

    /// Angle of the front wheels for a curvature (1/m) of the rear axle's path, radians: the bicycle model without slip.
    pub fn steer_rad(&self, curvature_per_m: f64) -> f64 {
        libm::atan(self.wheelbase_m * curvature_per_m)
    }

    /// Curvature of the rear axle's path, 1/m, at an angle of the front wheels, radians.
    pub fn curvature_per_m(&self, steer_rad: f64) -> f64 {
        libm::tan(steer_rad) / self.wheelbase_m
    }

    /// Angle of the front wheels, radians, at which a vehicle so fast (m/s) slides on a wet road.
    pub fn grip_rad(&self, speed_mps: f64) -> f64 {
        self.steer_rad(GRIP_MPS2 / speed_mps.powi(2).max(1e-3))
    }

    /// How far ahead controllers look at a speed, metres.
    pub fn look_ahead_m(&self, speed_mps: f64) -> f64 {
        (self.look_ahead_s * speed_mps.abs()).max(self.look_ahead_min_m)
    }

    /// Speed at which a curvature (1/m) asks for the largest acceleration to the side, m/s.
    pub fn bend_speed_mps(&self, curvature_per_m: f64) -> f64 {
        (self.lateral_acceleration_mps2 / curvature_per_m.abs().max(1e-9)).sqrt().min(self.speed_max_mps)
    }

    /// Curvature, 1/m, of a path from beside the rear axle at `beside_m` along it, as far ahead as the vehicle drives while its wheels
    /// are half turned to it: a corner that begins at once is met in the middle of the turning.
    pub fn curvature_soon_per_m(&self, situation: &Situation<'_>, beside_m: f64) -> Option<f64> {
        let here = at(situation.path, beside_m)?;
        let speed_mps = situation.speed_mps.max(0.0);
        let half_turned_m = |curvature_per_m: f64| {
            let turn_rad = (self.steer_rad(curvature_per_m) - situation.steer_rad).abs();
            0.5 * speed_mps * turn_rad / self.steering_rate_radps
        };
        let is_due = |point: &&PathPoint| {
            let ahead_m = point.along_m - beside_m;
            ahead_m > 0.0 && ahead_m <= half_turned_m(point.curvature_per_m)
        };
        let due = situation.path.iter().rev().find(is_due);
        Some(due.map_or(here.curvature_per_m, |point| point.curvature_per_m))
    }

    /// Speed at which a path is kept to [`VehicleLimits::clearance_m`] where its curvature changes at once from one to another, 1/m; m/s.
    ///
    /// Wheels that turn at a steady rate drive a clothoid where the path has a step. Begun in time it lies beside the path by L² Δκ / 24,
    /// where L is its length: the shift of the circle that every clothoid between a straight line and an arc has.
    pub fn turning_mps(&self, from_per_m: f64, to_per_m: f64) -> f64 {
        let time_s = (self.steer_rad(to_per_m) - self.steer_rad(from_per_m)).abs() / self.steering_rate_radps;
        let length_m =
            (24.0 * self.clearance_m.max(LEAST_CLEARANCE_M) / (to_per_m - from_per_m).abs().max(1e-9)).sqrt();
        (length_m / time_s.max(1e-9)).min(self.speed_max_mps)
    }

    /// Where a vehicle at this speed (m/s) and steering angle (radians) is after some seconds, as a pose in its frame before.
    pub fn driven(&self, from: Moving, time_s: f64) -> Isometry2<f64> {
        let way_m = from.speed_mps * time_s;
        let turn_rad = way_m * self.curvature_per_m(from.steer_rad);
        let chord = Vector2::new(libm::cos(0.5 * turn_rad), libm::sin(0.5 * turn_rad));
        Isometry2::new(chord * chord_m(way_m, turn_rad), turn_rad)
    }

    /// The most of what is wished for that the vehicle can do within `dt_s` seconds. Without a time the wheels may be anywhere.
    pub fn limited(&self, wished: Command, from: Moving, dt_s: Option<f64>) -> (Command, Limited) {
        let (circle_rad, grip_rad) = (self.steer_max_rad(), self.grip_rad(from.speed_mps));
        let most_rad = circle_rad.min(grip_rad);
        let mut steer = wished.steer_rad.clamp(-most_rad, most_rad);
        let mut limited = Limited {
            turning_circle: wished.steer_rad.abs() > circle_rad + 1e-9,
            grip: wished.steer_rad.abs().min(circle_rad) > grip_rad + 1e-9,
            ..Limited::default()
        };
        if let Some(dt_s) = dt_s.filter(|dt_s| dt_s.is_finite() && *dt_s >= 0.0) {
            let from_rad = from.steer_rad.clamp(-circle_rad, circle_rad);
            let reach_rad = self.steering_rate_radps * dt_s;
            let reached = steer.clamp(from_rad - reach_rad, from_rad + reach_rad);
            limited.steering_rate = (reached - steer).abs() > 1e-9;
            steer = reached;
        }
        // A vehicle that wants to turn harder than it does is too fast for it.
        let turns_rad = steer.abs().max(wished.steer_rad.abs().min(circle_rad));
        let most_mps = self.bend_speed_mps(self.curvature_per_m(turns_rad));
        let speed_mps = wished.speed_mps.clamp(0.0, most_mps);
        limited.speed = wished.speed_mps > most_mps + 1e-9;
        (Command { steer_rad: steer, speed_mps }, limited)
    }
}

impl Default for VehicleLimits {
    /// A passenger car. Steering rate: 0.4 rad/s (M. Althoff, M. Koschi, S. Manzinger: CommonRoad, 2017, vehicle models).
    /// Accelerations: what passengers take for comfortable, below the 3 m/s² to the side that ISO 11270 allows a lane-keeping system. To the
    /// side it is less than the 2.0 m/s² of comfort: of 16 simulated drives the fuzzy controller left the road at junctions in 3 with that, in 1 with 1.4.
    fn default() -> Self {
        Self {
            wheelbase_m: 2.7,
            turning_radius_m: 5.0,
            steering_rate_radps: 0.4,
            steering_lag_s: 0.2,
            lateral_acceleration_mps2: 1.4,
            clearance_m: 0.1,
            deceleration_mps2: 2.0,
            reaction_s: 0.5,
            speed_max_mps: 30.0 / 3.6,
            look_ahead_s: 0.8,
            look_ahead_min_m: 4.0,
        }
    }
}
