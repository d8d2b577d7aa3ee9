//! The fuzzy controller: what its rules' variables mean.

use super::FuzzyError;
use super::inference::Inference;
use super::rule_base::RuleBase;
use crate::speed::sureness;
use crate::{
    Command, ControlError, ControlEvidence, Controller, ControllerName, FiredRule, Situation, SpeedPlan,
    VehicleLimits,
};

/// The rules that are taken where no others are given.
pub const DEFAULT_RULES: &str = include_str!("default.fuzzy");

/// A variable that rules may ask for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Input {
    Offset,
    Heading,
    Bend,
    Speed,
    Sight,
    Doubt,
}

impl Input {
    const ALL: [Self; 6] = [Self::Offset, Self::Heading, Self::Bend, Self::Speed, Self::Sight, Self::Doubt];

    const fn name(self) -> &'static str {
        match self {
            Self::Offset => "offset_deg",
            Self::Heading => "heading_deg",
            Self::Bend => "bend_deg",
            Self::Speed => "speed_mps",
            Self::Sight => "sight_m",
            Self::Doubt => "doubt",
        }
    }
}

/// What the rules may say: the turn over the look-ahead distance beside the path's own, degrees.
const TURN: &str = "turn_deg";
/// And the share of the speed that bends and sight allow.
const PACE: &str = "pace";

/// A controller by rules. They are added to the curvature of the path: without an error, there is nothing to decide.
///
/// With l the look-ahead distance, e the offset and h the heading error, a vehicle that turns by `-(e / l + 2 h)` over l comes onto
/// the path without overshooting (critically damped); the shipped rules say about this, and less for large errors.
///
/// Inputs: `offset_deg` (the vehicle is so far left of the path, as an angle at l), `heading_deg` (it points so far to the left of
/// the path), `bend_deg` (the path's own turn over l), `speed_mps`, `sight_m`, `doubt` (0 to 1). Outputs: `turn_deg` (over l,
/// beside the path's own) and `pace` (share of the speed that bends and sight allow).
#[derive(Debug, Clone)]
pub struct FuzzyController {
    limits: VehicleLimits,
    rules: RuleBase,
    texts: Vec<String>,
    /// What each input of the rules is.
    inputs: Vec<Input>,
    /// The outputs' places among those of the rules.
    turn: usize,
    pace: Option<usize>,
    values: Vec<f64>,
    inference: Inference,
}

impl FuzzyController {
    /// A controller by these rules.
    ///
    /// # Errors
    /// [`FuzzyError`] when they ask for or say something that the controller does not know.
    pub fn new(limits: VehicleLimits, rules: RuleBase) -> Result<Self, FuzzyError> {
        let input = |name: &str| {
            let input = Input::ALL.into_iter().find(|input| input.name() == name);
            input.ok_or_else(|| FuzzyError::Meaning {
                what: "input",
                name: name.to_owned(),
                known: Input::ALL.map(Input::name).join(", "),
            })
        };
        let inputs = rules.inputs().map(input).collect::<Result<Vec<_>, _>>()?;
        if let Some(name) = rules.outputs().find(|name| ![TURN, PACE].contains(name)) {
            let known = [TURN, PACE].join(", ");
            return Err(FuzzyError::Meaning { what: "output", name: name.to_owned(), known });
        }
        let place = |name| rules.outputs().position(|output| output == name);
        let turn = place(TURN).ok_or(FuzzyError::Missing { what: "output turn_deg" })?;
        let (pace, texts) = (place(PACE), rules.rules().map(str::to_owned).collect());
        let (values, inference) = (Vec::new(), Inference::default());
        Ok(Self { limits, inputs, turn, pace, rules, texts, values, inference })
    }
}

impl Controller for FuzzyController {
    fn name(&self) -> &'static str {
        ControllerName::Fuzzy.name()
    }

    fn rules(&self) -> &[String] {
        &self.texts
    }

    fn control(
        &mut self,
        situation: &Situation<'_>,
        evidence: &mut ControlEvidence,
    ) -> Result<Command, ControlError> {
        let beside = evidence.begin(situation)?;
        let no_path = situation.no_path();
        let look_ahead_m = self.limits.look_ahead_m(situation.speed_mps);
        let curvature_per_m =
            self.limits.curvature_soon_per_m(situation, beside.on_path.along_m).ok_or(no_path)?;
        let end_m = situation.path.last().map_or(0.0, |point| point.along_m);
        let value = |input: &Input| match input {
            Input::Offset => libm::atan2(evidence.offset_m, look_ahead_m).to_degrees(),
            Input::Heading => evidence.heading_rad.to_degrees(),
            Input::Bend => (curvature_per_m * look_ahead_m).to_degrees(),
            Input::Speed => situation.speed_mps,
            Input::Sight => situation.seen_ahead_m.min(end_m),
            Input::Doubt => 1.0 - sureness(situation),
        };
        self.values.clear();
        self.values.extend(self.inputs.iter().map(value));
        self.rules.infer(&self.values, &mut self.inference);
        let fired = (1..).zip(&self.inference.strengths).filter(|(_, strength)| **strength > 0.0);
        evidence.rules.extend(fired.map(|(number, strength)| FiredRule { number, strength: *strength }));
        let output = |place: usize| self.inference.outputs.get(place).copied().flatten();
        let turn_deg = output(self.turn).ok_or(ControlError::NoRule { output: TURN })?;
        let pace = match self.pace {
            Some(place) => output(place).ok_or(ControlError::NoRule { output: PACE })?.clamp(0.0, 1.0),
            None => 1.0,
        };
        let sure = Situation { present: 1.0, lateral_sigma_m: 0.0, ..*situation };
        Ok(Command {
            steer_rad: self.limits.steer_rad(curvature_per_m + turn_deg.to_radians() / look_ahead_m),
            speed_mps: pace * SpeedPlan::new(&self.limits, &sure).speed_mps,
        })
    }
}
