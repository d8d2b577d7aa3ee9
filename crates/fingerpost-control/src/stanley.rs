//! Stanley's controller: the front axle steers onto the path.
//!
//! S. Thrun et al., "Stanley: the robot that won the DARPA Grand Challenge", Journal of Field Robotics 23(9), 2006, section 9.2:
//! the wheels point along the path, and towards it by atan(k e / v), with the front axle's distance e from it.
//!
//! Here the path is the rear axle's. The front axle's is the one that it traces when the rear axle follows that: the wheelbase
//! ahead along the tangent, turned by atan(L kappa). Without this the rear axle would cut a corner of 6 m by 0.6 m. What the path will
//! bend more while the wheels turn is added.

use crate::{
    Command, ControlError, ControlEvidence, Controller, ControllerName, PathPoint, Situation, SpeedPlan,
    VehicleLimits, foot,
};
use nalgebra::Point2;

/// Added to the speed, so that a slow vehicle is not steered hard for small errors, m/s.
const SOFTENING_MPS: f64 = 1.0;

/// The controller.
#[derive(Debug, Clone)]
pub struct Stanley {
    limits: VehicleLimits,
    /// The front axle's path.
    front: Vec<PathPoint>,
}

impl Stanley {
    /// Stanley's controller for a vehicle.
    pub const fn new(limits: VehicleLimits) -> Self {
        Self { limits, front: Vec::new() }
    }

    /// Rate at which an error fades, 1/s: within the time that is looked ahead.
    fn gain_per_s(&self) -> f64 {
        1.0 / self.limits.look_ahead_s.max(0.1)
    }
}

impl Controller for Stanley {
    fn name(&self) -> &'static str {
        ControllerName::Stanley.name()
    }

    fn control(
        &mut self,
        situation: &Situation<'_>,
        evidence: &mut ControlEvidence,
    ) -> Result<Command, ControlError> {
        let beside = evidence.begin(situation)?;
        let no_path = situation.no_path();
        let limits = &self.limits;
        self.front.clear();
        self.front.extend(situation.path.iter().map(|point| {
            let place = point.place() + point.direction() * limits.wheelbase_m;
            let heading_rad = point.heading_rad + limits.steer_rad(point.curvature_per_m);
            PathPoint { x_m: place.x, y_m: place.y, heading_rad, ..*point }
        }));
        let axle = foot(&self.front, Point2::new(limits.wheelbase_m, 0.0)).ok_or(no_path)?;
        evidence.aim = Some(axle.on_path.place());
        let towards_rad =
            libm::atan2(-self.gain_per_s() * axle.left_m, situation.speed_mps.abs() + SOFTENING_MPS);
        let here_per_m = beside.on_path.curvature_per_m;
        let soon_per_m = limits.curvature_soon_per_m(situation, beside.on_path.along_m).ok_or(no_path)?;
        let turning_rad = limits.steer_rad(soon_per_m) - limits.steer_rad(here_per_m);
        Ok(Command {
            steer_rad: axle.on_path.heading_rad + towards_rad + turning_rad,
            speed_mps: SpeedPlan::new(limits, situation).speed_mps,
        })
    }
}
