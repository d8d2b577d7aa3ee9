//! A controller with the vehicle's limits.

use crate::{
    Command, ControlError, ControlEvidence, Controller, ControllerName, FuzzyController, FuzzyError, Moving,
    PathPoint, PurePursuit, RuleBase, Situation, SpeedPlan, Stanley, VehicleLimits, foot, seen_from,
};
use nalgebra::Point2;

/// The chosen controller, the vehicle's limits, and what came of the last situation.
pub struct Steersman {
    controller: Box<dyn Controller>,
    limits: VehicleLimits,
    evidence: ControlEvidence,
    plan: SpeedPlan,
    /// The path as it is seen when the wheels have turned.
    path: Vec<PathPoint>,
}

impl Steersman {
    /// One of the controllers; `rules` is the text of the fuzzy one's.
    ///
    /// # Errors
    /// [`FuzzyError`] when the fuzzy controller is chosen and its rules cannot be used.
    pub fn new(name: ControllerName, limits: VehicleLimits, rules: &str) -> Result<Self, FuzzyError> {
        let controller: Box<dyn Controller> = match name {
            ControllerName::PurePursuit => Box::new(PurePursuit::new(limits)),
            ControllerName::Stanley => Box::new(Stanley::new(limits)),
            ControllerName::Fuzzy => Box::new(FuzzyController::new(limits, RuleBase::parse(rules)?)?),
        };
        Ok(Self::with(controller, limits))
    }

    /// A controller of one's own.
    pub fn with(controller: Box<dyn Controller>, limits: VehicleLimits) -> Self {
        let (evidence, plan, path) = (ControlEvidence::default(), SpeedPlan::default(), Vec::new());
        Self { controller, limits, evidence, plan, path }
    }

    /// What the vehicle is to do in a situation, within what it can do in `dt_s` seconds; without a time its wheels may be anywhere.
    ///
    /// # Errors
    /// [`ControlError`] when the situation cannot be steered in.
    pub fn steer(&mut self, situation: &Situation<'_>, dt_s: Option<f64>) -> Result<Command, ControlError> {
        situation.check()?;
        let no_path = ControlError::NoPath { points: situation.path.len() };
        let beside = foot(situation.path, Point2::origin()).ok_or(no_path)?;
        // By the time that the wheels are where they are wished the vehicle has driven on with what was asked for before.
        let from = Moving { steer_rad: situation.steer_rad, speed_mps: situation.speed_mps };
        let soon = self.limits.driven(from, self.limits.steering_lag_s);
        seen_from(&soon, situation.path, &mut self.path);
        let seen = Situation { path: &self.path, ..*situation };
        let wished = self.controller.control(&seen, &mut self.evidence)?;
        (self.evidence.offset_m, self.evidence.heading_rad) = (beside.left_m, -beside.on_path.heading_rad);
        self.evidence.aim = self.evidence.aim.map(|aim| soon * aim);
        let (now, ahead) = (SpeedPlan::new(&self.limits, situation), SpeedPlan::new(&self.limits, &seen));
        // What has no rules goes as fast as is sound from where the vehicle will be: that is the plan then, with its reason.
        self.plan = if self.rules().is_empty() && ahead.speed_mps < now.speed_mps { ahead } else { now };
        let wished = Command { speed_mps: wished.speed_mps.min(self.plan.speed_mps), ..wished };
        let (command, limited) = self.limits.limited(wished, from, dt_s);
        self.evidence.limited = limited;
        Ok(command)
    }

    /// The controller's name.
    pub fn name(&self) -> &'static str {
        self.controller.name()
    }

    /// The texts of the controller's rules, in their order; none of controllers without rules.
    pub fn rules(&self) -> &[String] {
        self.controller.rules()
    }

    /// The vehicle's limits.
    pub const fn limits(&self) -> &VehicleLimits {
        &self.limits
    }

    /// How the last command came about.
    pub const fn evidence(&self) -> &ControlEvidence {
        &self.evidence
    }

    /// The highest speed that was sound in the last situation, and why.
    pub const fn speed_plan(&self) -> &SpeedPlan {
        &self.plan
    }
}

impl std::fmt::Debug for Steersman {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Steersman")
            .field("controller", &self.name())
            .field("limits", &self.limits)
            .finish_non_exhaustive()
    }
}
