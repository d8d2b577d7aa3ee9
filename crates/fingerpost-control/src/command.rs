//! What a controller asks for, and how it came to it.

use nalgebra::Point2;

use crate::{ControlError, Foot, Situation, foot};

/// What the vehicle is to do.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Command {
    /// Angle of the front wheels (of the bicycle model's one), radians, positive to the left.
    pub steer_rad: f64,
    /// Speed to have, m/s; never negative.
    pub speed_mps: f64,
}

/// A rule that took part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FiredRule {
    /// Its number in the rule text, from one.
    pub number: usize,
    /// How far its conditions hold, 0 to 1.
    pub strength: f64,
}

/// A limit of the vehicle that changed what was wished for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Limited {
    /// The turning circle.
    pub turning_circle: bool,
    /// The grip of the tyres at the vehicle's speed.
    pub grip: bool,
    /// How fast the wheels can be turned.
    pub steering_rate: bool,
    /// How fast the vehicle may go round such a bend, or at all.
    pub speed: bool,
}

/// How a command came about.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ControlEvidence {
    /// How far left of the path the vehicle is, metres.
    pub offset_m: f64,
    /// Its heading against the path's, radians, positive to the left.
    pub heading_rad: f64,
    /// The place that is steered towards, vehicle frame, metres; none by controllers that aim at none.
    pub aim: Option<Point2<f64>>,
    /// Rules that took part, in the order of their text; none by controllers without rules.
    pub rules: Vec<FiredRule>,
    /// Limits that changed what was wished for.
    pub limited: Limited,
}

impl ControlEvidence {
    /// Forgets all but its memory.
    pub fn clear(&mut self) {
        let mut rules = std::mem::take(&mut self.rules);
        rules.clear();
        *self = Self { rules, ..Self::default() };
    }

    /// Begins that of a situation: where the vehicle is against the path, which is given back.
    pub(crate) fn begin(&mut self, situation: &Situation<'_>) -> Result<Foot, ControlError> {
        situation.check()?;
        self.clear();
        let beside = foot(situation.path, Point2::origin()).ok_or(situation.no_path())?;
        (self.offset_m, self.heading_rad) = (beside.left_m, -beside.on_path.heading_rad);
        Ok(beside)
    }
}
