//! A vehicle that goes where it is steered: the kinematic bicycle with a rear axle that does not slip, and with the lags
//! and limits of its steering, engine and brake.
//!
//! Steering and speed follow what is asked as first-order lags (Rajamani, "Vehicle Dynamics and Control", 2nd edition,
//! equation 5.13, of a speed), each cut off at its greatest rate. Between two instants the steering angle is constant and
//! the rear axle goes along a piece of a circle of radius wheelbase / tan(steering angle), taken in closed form.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;

/// Length of a step, seconds: a tenth of the fastest lag.
const STEP_S: f64 = 0.01;
/// Slower than this a braked vehicle stands, m/s.
const STANDS_MPS: f64 = 0.02;

/// What a vehicle is asked to do.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct DriveCommand {
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
}

/// How a vehicle follows what it is asked. The defaults are those of a car with electric power steering and a comfortable
/// driver's use of engine and brake.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Actuation {
    /// Time constant of the steering, seconds, 0.02 to 2.
    pub steer_lag_s: f64,
    /// Fastest change of the front wheels' angle, rad/s, 0.05 to 5.
    pub steer_rate_rps: f64,
    /// Time constant of the speed, seconds, 0.05 to 5.
    pub speed_lag_s: f64,
    /// Most acceleration, m/s2, 0.1 to 10.
    pub speed_up_mps2: f64,
    /// Most braking, m/s2, 0.1 to 10.
    pub brake_mps2: f64,
    /// Fastest speed, m/s, 0.5 to 40.
    pub fastest_mps: f64,
}

impl Default for Actuation {
    fn default() -> Self {
        Self {
            steer_lag_s: 0.15,
            // 400 degrees a second of the steering wheel at a ratio of 15.
            steer_rate_rps: 0.46,
            speed_lag_s: 0.5,
            speed_up_mps2: 1.5,
            brake_mps2: 4.0,
            fastest_mps: 25.0,
        }
    }
}

impl Actuation {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`] names the first that no vehicle has.
    pub fn check(&self) -> Result<(), SimError> {
        check_range("actuation.steer_lag_s", self.steer_lag_s, 0.02, 2.0, "0.02 to 2 seconds")?;
        check_range("actuation.steer_rate_rps", self.steer_rate_rps, 0.05, 5.0, "0.05 to 5 rad/s")?;
        check_range("actuation.speed_lag_s", self.speed_lag_s, 0.05, 5.0, "0.05 to 5 seconds")?;
        check_range("actuation.speed_up_mps2", self.speed_up_mps2, 0.1, 10.0, "0.1 to 10 m/s2")?;
        check_range("actuation.brake_mps2", self.brake_mps2, 0.1, 10.0, "0.1 to 10 m/s2")?;
        check_range("actuation.fastest_mps", self.fastest_mps, 0.5, 40.0, "0.5 to 40 m/s")
    }
}

/// A vehicle at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bicycle {
    /// Middle of the rear axle, metres.
    pub p_in_map: Point2<f64>,
    /// Direction of the body, radians anticlockwise from the x axis.
    pub heading_rad: f64,
    /// Speed of the rear axle, m/s.
    pub speed_mps: f64,
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Distance between the axles, metres.
    wheelbase_m: f64,
    /// Greatest angle of the front wheels, radians.
    full_lock_rad: f64,
    actuation: Actuation,
    /// What the speed changed by in the last step, m/s2.
    lengthwise_mps2: f64,
}

impl Bicycle {
    /// A vehicle that stands straight at a place. `turning_radius_m` is the radius of the rear axle's tightest circle.
    pub fn standing(
        p_in_map: Point2<f64>,
        heading_rad: f64,
        wheelbase_m: f64,
        turning_radius_m: f64,
        actuation: Actuation,
    ) -> Self {
        Self {
            p_in_map,
            heading_rad,
            speed_mps: 0.0,
            steer_rad: 0.0,
            wheelbase_m,
            full_lock_rad: libm::atan(wheelbase_m / turning_radius_m),
            actuation,
            lengthwise_mps2: 0.0,
        }
    }

    /// Curvature of the rear axle's way, 1/m, positive to the left.
    pub fn curvature_per_m(&self) -> f64 {
        libm::tan(self.steer_rad) / self.wheelbase_m
    }

    /// Acceleration along the body, m/s2, negative while it brakes.
    pub const fn lengthwise_mps2(&self) -> f64 {
        self.lengthwise_mps2
    }

    /// Lets `dt_s` pass while `command` holds. Numbers that are not finite ask for nothing: the angle stays, and the
    /// vehicle brakes.
    pub fn drive(&mut self, command: DriveCommand, dt_s: f64) {
        let steps = (dt_s / STEP_S).ceil().max(1.0);
        for _ in 0..steps as usize {
            self.step(command, dt_s / steps);
        }
    }

    fn step(&mut self, command: DriveCommand, dt_s: f64) {
        let Actuation { steer_lag_s, steer_rate_rps, speed_lag_s, speed_up_mps2, brake_mps2, fastest_mps } =
            self.actuation;
        let asked_rad = if command.steer_rad.is_finite() { command.steer_rad } else { self.steer_rad };
        let asked_rad = asked_rad.clamp(-self.full_lock_rad, self.full_lock_rad);
        let rate_rps = ((asked_rad - self.steer_rad) / steer_lag_s).clamp(-steer_rate_rps, steer_rate_rps);
        self.steer_rad += rate_rps * dt_s;
        let asked_mps = if command.speed_mps.is_finite() { command.speed_mps } else { 0.0 };
        let asked_mps = asked_mps.clamp(0.0, fastest_mps);
        let before_mps = self.speed_mps;
        let change_mps2 = ((asked_mps - before_mps) / speed_lag_s).clamp(-brake_mps2, speed_up_mps2);
        self.speed_mps = (before_mps + change_mps2 * dt_s).max(0.0);
        if asked_mps <= 0.0 && self.speed_mps < STANDS_MPS {
            self.speed_mps = 0.0;
        }
        self.lengthwise_mps2 = (self.speed_mps - before_mps) / dt_s;
        self.roll(0.5 * (before_mps + self.speed_mps) * dt_s);
    }

    /// Moves along the circle of the front wheels' angle.
    fn roll(&mut self, way_m: f64) {
        let turned_rad = way_m * self.curvature_per_m();
        // The chord of an arc lies in the direction of its middle and is shorter by the sine of half of its turn.
        let half_rad = 0.5 * turned_rad;
        let shortened = if half_rad.abs() > 1e-9 { libm::sin(half_rad) / half_rad } else { 1.0 };
        let (sin, cos) = libm::sincos(self.heading_rad + half_rad);
        self.p_in_map += Vector2::new(cos, sin) * (way_m * shortened);
        self.heading_rad = wrap_angle(self.heading_rad + turned_rad);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn car() -> Bicycle {
        Bicycle::standing(Point2::new(3.0, -2.0), 0.0, 2.7, 5.0, Actuation::default())
    }

    #[test]
    fn a_held_angle_drives_the_circle_of_its_radius() {
        for steer_rad in [0.2_f64, -0.2, 0.45, -0.03] {
            let mut vehicle = Bicycle { steer_rad, speed_mps: 6.0, ..car() };
            let radius_m = 2.7 / libm::tan(steer_rad);
            // To the left of a vehicle that looks east is north.
            let centre = vehicle.p_in_map + Vector2::new(0.0, radius_m);
            for _ in 0..400 {
                vehicle.drive(DriveCommand { steer_rad, speed_mps: 6.0 }, 0.1);
                let off_m = (vehicle.p_in_map - centre).norm() - radius_m.abs();
                assert!(off_m.abs() < 1e-9, "{off_m} m off the circle");
            }
            let turned = 40.0 * 6.0 / radius_m;
            assert!(wrap_angle(vehicle.heading_rad - turned).abs() < 1e-9);
        }
    }

    #[test]
    fn a_wheel_turned_left_leads_to_the_left() {
        let mut vehicle = car();
        for _ in 0..20 {
            vehicle.drive(DriveCommand { steer_rad: 0.3, speed_mps: 5.0 }, 0.1);
        }
        assert!(vehicle.heading_rad > 0.3 && vehicle.p_in_map.y > -2.0 && vehicle.p_in_map.x > 3.0);
    }

    #[test]
    fn steering_keeps_its_rate_and_comes_to_what_is_asked() {
        let mut vehicle = car();
        let mut before_rad = 0.0;
        for _ in 0..300 {
            vehicle.drive(DriveCommand { steer_rad: 0.4, speed_mps: 0.0 }, 0.01);
            assert!((vehicle.steer_rad - before_rad).abs() <= 0.46 * 0.01 + 1e-12);
            before_rad = vehicle.steer_rad;
        }
        assert!((vehicle.steer_rad - 0.4).abs() < 1e-4);
        // Full lock is the turning circle.
        vehicle.drive(DriveCommand { steer_rad: 2.0, speed_mps: 0.0 }, 5.0);
        assert!((1.0 / vehicle.curvature_per_m() - 5.0).abs() < 1e-6);
    }

    #[test]
    fn speed_follows_within_engine_and_brake() {
        let mut vehicle = car();
        let mut rolled_m = 0.0;
        for _ in 0..1000 {
            let before = vehicle;
            vehicle.drive(DriveCommand { steer_rad: 0.0, speed_mps: 8.0 }, 0.01);
            assert!(vehicle.lengthwise_mps2() <= 1.5 + 1e-9);
            rolled_m += (vehicle.p_in_map - before.p_in_map).norm();
        }
        assert!((vehicle.speed_mps - 8.0).abs() < 1e-3);
        assert!((rolled_m - (vehicle.p_in_map.x - 3.0)).abs() < 1e-9, "straight on");
        let from_m = vehicle.p_in_map.x;
        vehicle.drive(DriveCommand { steer_rad: 0.0, speed_mps: 0.0 }, 10.0);
        assert!(vehicle.speed_mps.abs() < 1e-12);
        // 8 m/s at 4 m/s2 are 8 m, and the lag's last 2 m/s take another metre of coasting down.
        let stopped_in_m = vehicle.p_in_map.x - from_m;
        assert!((8.0..9.5).contains(&stopped_in_m), "{stopped_in_m} m");
    }

    #[test]
    fn the_way_does_not_depend_on_how_time_is_cut() {
        let commands = [(0.2, 5.0), (-0.1, 7.0), (0.0, 3.0)];
        let driven = |pieces: usize| {
            let mut vehicle = car();
            for (steer_rad, speed_mps) in commands {
                (0..pieces).for_each(|_| {
                    vehicle.drive(DriveCommand { steer_rad, speed_mps }, 2.0 / pieces as f64);
                });
            }
            vehicle
        };
        let (one, many) = (driven(20), driven(200));
        assert!((one.p_in_map - many.p_in_map).norm() < 1e-6);
        assert!((one.heading_rad - many.heading_rad).abs() < 1e-7);
    }

    #[test]
    fn a_command_of_no_numbers_brakes() {
        let mut vehicle = Bicycle { speed_mps: 5.0, steer_rad: 0.1, ..car() };
        vehicle.drive(DriveCommand { steer_rad: f64::NAN, speed_mps: f64::NAN }, 5.0);
        assert!(vehicle.speed_mps.abs() < 1e-12 && (vehicle.steer_rad - 0.1).abs() < 1e-12);
        assert!(vehicle.p_in_map.x.is_finite());
    }
}
