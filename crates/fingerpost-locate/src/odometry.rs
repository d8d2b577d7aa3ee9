//! Motion between two moments, gathered from the vehicle's speed and yaw rate, with the derivatives and noise that their errors cause.
//!
//! Every hypothesis moves by the same measurements: they are integrated once, in the vehicle's frame at the first moment, with the
//! derivatives by the yaw rate's bias and scale (preintegration: C. Forster et al., "On-manifold preintegration", IEEE T-RO 2017).

use nalgebra::{Matrix3, Vector2, Vector3};

/// White noise of a yaw rate, rad/s over the square root of a hertz: 0.03 degrees, three times the data sheets of automotive
/// MEMS gyroscopes (Bosch SMI7xx, Murata SCC2000), for vibration.
pub const YAW_RATE_NOISE: f64 = 5.2e-4;
/// Error by a road's superelevation and the body's roll, beside the gyroscope's scale: this part of every turn.
const TURN_ERROR: f64 = 0.01;
/// Slip and quantisation, metres over the square root of a metre driven.
const FORWARD_NOISE: f64 = 0.03;
/// Sideways slip, metres over the square root of a metre driven.
const SIDE_NOISE: f64 = 0.02;

/// One row of a motion log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionSample {
    /// Time, seconds.
    pub t_s: f64,
    /// Speed forward, metres a second; negative when reversing.
    pub speed_mps: f64,
    /// Yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: f64,
}

/// Motion over the time from one picture to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionInterval {
    /// How long it is, seconds.
    pub time_s: f64,
    /// Mean speed forward, metres a second; negative when reversing.
    pub speed_mps: f64,
    /// Mean yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: f64,
    /// Variance of the turn, square radians.
    pub turn_variance_rad2: f64,
    /// Variance of the distance beside slip and the speed's scale, square metres: of a speed that is not measured but taken to go on.
    pub distance_variance_m2: f64,
}

/// Motion since a moment, in the vehicle's frame at that moment.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Time, seconds.
    pub time_s: f64,
    /// Distance driven, metres; reversing counts as well.
    pub driven_m: f64,
    /// Place, metres.
    pub place_m: Vector2<f64>,
    /// Turn, radians to the left.
    pub turn_rad: f64,
    /// Derivative of the place by the yaw rate's bias, metres per radian a second. (That of the turn is minus the time.)
    pub place_by_bias: Vector2<f64>,
    /// Derivative of the place by what the true turn is greater by, as a part of it, metres. (That of the turn is the turn.)
    pub place_by_turn_scale: Vector2<f64>,
    /// Covariance of place and turn from noise.
    pub covariance: Matrix3<f64>,
}

impl Default for Motion {
    fn default() -> Self {
        Self {
            time_s: 0.0,
            driven_m: 0.0,
            place_m: Vector2::zeros(),
            turn_rad: 0.0,
            place_by_bias: Vector2::zeros(),
            place_by_turn_scale: Vector2::zeros(),
            covariance: Matrix3::zeros(),
        }
    }
}

impl Motion {
    /// Goes on for `time_s` seconds at this speed (m/s) and yaw rate (rad/s), as a gyroscope measures it.
    pub fn go_on(&mut self, speed_mps: f64, yaw_rate_rps: f64, time_s: f64) {
        let turn_variance_rad2 = YAW_RATE_NOISE.powi(2) * time_s;
        let distance_variance_m2 = 0.0;
        self.go_on_by(&MotionInterval {
            time_s,
            speed_mps,
            yaw_rate_rps,
            turn_variance_rad2,
            distance_variance_m2,
        });
    }

    /// The same with the variances of turn and distance.
    pub fn go_on_by(&mut self, interval: &MotionInterval) {
        let MotionInterval { time_s, speed_mps, yaw_rate_rps, turn_variance_rad2, distance_variance_m2 } =
            *interval;
        let (forward_m, turn_rad) = (speed_mps * time_s, yaw_rate_rps * time_s);
        // The chord of the arc has the heading of its middle.
        let heading = self.turn_rad + 0.5 * turn_rad;
        let ahead = Vector2::new(libm::cos(heading), libm::sin(heading));
        let left = Vector2::new(-ahead.y, ahead.x);
        self.place_by_bias -= left * (forward_m * (self.time_s + 0.5 * time_s));
        self.place_by_turn_scale += left * (forward_m * heading);

        let moved = Matrix3::new(1.0, 0.0, left.x * forward_m, 0.0, 1.0, left.y * forward_m, 0.0, 0.0, 1.0);
        let by_turn = Vector3::new(0.5 * left.x * forward_m, 0.5 * left.y * forward_m, 1.0);
        let (along, across) = (Vector3::new(ahead.x, ahead.y, 0.0), Vector3::new(left.x, left.y, 0.0));
        // Such an error is the same all through a turn: squared over the whole, not over its parts.
        let scale =
            TURN_ERROR.powi(2) * ((self.turn_rad + turn_rad).powi(2) - self.turn_rad.powi(2)).max(0.0);
        self.covariance = moved * self.covariance * moved.transpose()
            + by_turn * by_turn.transpose() * (turn_variance_rad2 + scale)
            + along * along.transpose() * (FORWARD_NOISE.powi(2) * forward_m.abs() + distance_variance_m2)
            + across * across.transpose() * (SIDE_NOISE.powi(2) * forward_m.abs());

        self.place_m += ahead * forward_m;
        self.turn_rad += turn_rad;
        self.time_s += time_s;
        self.driven_m += forward_m.abs();
    }
}
