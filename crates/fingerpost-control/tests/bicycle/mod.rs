//! A kinematic bicycle with a steering rate, a lag and a brake.

use fingerpost_control::{Command, VehicleLimits};
use nalgebra::{Isometry2, Vector2};

/// Its state; metres, radians.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Bicycle {
    pub(crate) forward_m: f64,
    pub(crate) left_m: f64,
    pub(crate) heading_rad: f64,
    pub(crate) speed_mps: f64,
    pub(crate) steer_rad: f64,
}

impl Bicycle {
    /// `map_from_vehicle`.
    pub(crate) fn pose(&self) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(self.forward_m, self.left_m), self.heading_rad)
    }

    /// Drives for some seconds towards what is commanded.
    pub(crate) fn step(&mut self, limits: &VehicleLimits, command: Command, dt_s: f64) {
        const PIECES: usize = 10;
        let dt_s = dt_s / PIECES as f64;
        for _ in 0..PIECES {
            let rate = ((command.steer_rad - self.steer_rad) / limits.steering_lag_s)
                .clamp(-limits.steering_rate_radps, limits.steering_rate_radps);
            self.steer_rad += rate * dt_s;
            let acceleration =
                ((command.speed_mps - self.speed_mps) / 0.3).clamp(-2.0 * limits.deceleration_mps2, 1.5);
            self.speed_mps = (self.speed_mps + acceleration * dt_s).max(0.0);
            self.heading_rad += self.speed_mps * libm::tan(self.steer_rad) / limits.wheelbase_m * dt_s;
            self.forward_m += self.speed_mps * libm::cos(self.heading_rad) * dt_s;
            self.left_m += self.speed_mps * libm::sin(self.heading_rad) * dt_s;
        }
    }
}
