//! Pure pursuit: an arc from the rear axle to a point of the path ahead.
//!
//! R. C. Coulter, "Implementation of the pure pursuit path tracking algorithm", CMU-RI-TR-92-01, 1992: a point at the distance l,
//! y to the left, lies on the arc of curvature 2 y / l². On a path of constant curvature the vehicle comes onto it without an error.

use crate::{
    Command, ControlError, ControlEvidence, Controller, ControllerName, Situation, SpeedPlan, VehicleLimits,
    at,
};

/// The controller.
#[derive(Debug, Clone, Copy)]
pub struct PurePursuit {
    limits: VehicleLimits,
}

impl PurePursuit {
    /// Pure pursuit of a vehicle.
    pub const fn new(limits: VehicleLimits) -> Self {
        Self { limits }
    }
}

impl Controller for PurePursuit {
    fn name(&self) -> &'static str {
        ControllerName::PurePursuit.name()
    }

    fn control(
        &mut self,
        situation: &Situation<'_>,
        evidence: &mut ControlEvidence,
    ) -> Result<Command, ControlError> {
        evidence.begin(situation)?;
        let no_path = situation.no_path();
        let look_ahead_m = self.limits.look_ahead_m(situation.speed_mps);
        let aim = at(situation.path, look_ahead_m).ok_or(no_path)?.place();
        evidence.aim = Some(aim);
        let curvature_per_m = 2.0 * aim.y / aim.coords.norm_squared().max(1e-9);
        Ok(Command {
            steer_rad: self.limits.steer_rad(curvature_per_m),
            speed_mps: SpeedPlan::new(&self.limits, situation).speed_mps,
        })
    }
}
