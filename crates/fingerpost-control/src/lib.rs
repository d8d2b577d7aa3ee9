//! Controllers: from a line on the road to a steering angle and a speed.
//!
//! Paper 1, section VII-B, and paper 2, section 7.3, leave the controller open and propose fuzzy control, because a person can
//! read it. Here are three, behind one trait: [`PurePursuit`], [`Stanley`] and the [`FuzzyController`] of a Mamdani rule base that
//! is text. Each is a plain function of the [`Situation`]: a path in the vehicle frame (x forward, y left, from the rear axle's
//! middle), the vehicle's speed, and the doubt about the path. Lengths in metres, angles in radians, positive to the left, seconds.
//!
//! ```text
//! Situation ──► Controller::control ──► Command (wished) ──► VehicleLimits::limited ──► Command (possible)
//!                      │                                             ▲
//!                      └─► Evidence: aim, errors, rules fired        └ speed: bends, what is seen, doubt (speed_plan)
//! ```
//!
//! A [`Steersman`] does both steps with whichever controller was chosen. Nothing here reads a picture, a file or a clock. What all
//! who guide the vehicle know of it is here too: its size and manners ([`vehicle`]), and how it moves ([`VehicleState`]).

mod command;
mod fuzzy;
mod limits;
mod path;
mod pure_pursuit;
mod speed;
mod stanley;
mod steersman;
pub mod vehicle;
mod vehicle_state;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use command::{Command, ControlEvidence, FiredRule, Limited};
pub use fuzzy::{DEFAULT_RULES, FuzzyController, FuzzyError, Inference, Membership, RuleBase};
pub use limits::{Moving, VehicleLimits};
pub use path::{Foot, PathPoint, arc, at, foot, lay, seen_from};
pub use pure_pursuit::PurePursuit;
pub use speed::{SpeedPlan, SpeedReason};
pub use stanley::Stanley;
pub use steersman::Steersman;
pub use vehicle_state::{TurnSignal, VehicleState};

/// What a controller steers along, and what is known of the vehicle.
#[derive(Debug, Clone, Copy)]
pub struct Situation<'a> {
    /// The line for the rear axle's middle, vehicle frame, in the order in which it is driven; from beside or behind the vehicle on.
    pub path: &'a [PathPoint],
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Steering angle of the front wheels that was asked for last, radians, positive to the left.
    pub steer_rad: f64,
    /// Standard deviation of the path across itself, metres.
    pub lateral_sigma_m: f64,
    /// How far the vehicle may be from the path before its side leaves the road or lane, metres.
    pub room_m: f64,
    /// Probability that the path is what it is taken for, 0 to 1.
    pub present: f64,
    /// How far ahead of the rear axle the road is seen, metres.
    pub seen_ahead_m: f64,
    /// A turn that is expected and not part of the path yet; none where none is near.
    pub turn_ahead: Option<TurnAhead>,
}

/// A turn that is expected ahead and has not been found: the path leads past it still.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TurnAhead {
    /// The least distance at which it may well begin, metres; negative once that lies behind.
    pub ahead_m: f64,
    /// Its curvature, 1/m, positive to the left.
    pub curvature_per_m: f64,
}

/// A way to steer along a path.
pub trait Controller: Send {
    /// Its name, as it stands in files.
    fn name(&self) -> &'static str;

    /// The texts of its rules, in their order; none of a controller without rules.
    fn rules(&self) -> &[String] {
        &[]
    }

    /// Steering angle and speed that it wishes for; how it came to them goes into `evidence`, whose memory is reused.
    ///
    /// # Errors
    /// [`ControlError`] when the situation cannot be steered in.
    fn control(
        &mut self,
        situation: &Situation<'_>,
        evidence: &mut ControlEvidence,
    ) -> Result<Command, ControlError>;
}

/// The controllers there are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ControllerName {
    /// An arc to a point of the line ahead (Coulter 1992).
    #[default]
    PurePursuit,
    /// The front axle onto the line (Thrun et al. 2006).
    Stanley,
    /// Mamdani rules, which are text.
    Fuzzy,
}

impl ControllerName {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::PurePursuit, Self::Stanley, Self::Fuzzy];

    /// The name, as it stands in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::PurePursuit => "pure_pursuit",
            Self::Stanley => "stanley",
            Self::Fuzzy => "fuzzy",
        }
    }
}

/// A situation that cannot be steered in.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum ControlError {
    /// There is too little of a path.
    #[error("a path of {points} points leads nowhere; give two or more")]
    NoPath {
        /// Points that it has.
        points: usize,
    },
    /// No rule says anything of an output.
    #[error("no rule holds that says anything of {output}; add one for this case")]
    NoRule {
        /// The output.
        output: &'static str,
    },
    /// A number is none.
    #[error("{what} is no finite number; give a situation without NaN and infinity")]
    NotFinite {
        /// Which number.
        what: &'static str,
    },
}

impl Situation<'_> {
    /// What is wrong where the path leads nowhere.
    const fn no_path(&self) -> ControlError {
        ControlError::NoPath { points: self.path.len() }
    }

    /// Refuses what no controller can steer in.
    ///
    /// # Errors
    /// [`ControlError`] names the first thing that is wrong.
    pub fn check(&self) -> Result<(), ControlError> {
        if self.path.len() < 2 {
            return Err(self.no_path());
        }
        let of_path = |p: &PathPoint| {
            [p.x_m, p.y_m, p.heading_rad, p.curvature_per_m, p.along_m].into_iter().all(f64::is_finite)
        };
        for (what, finite) in [
            ("a point of the path", self.path.iter().all(of_path)),
            ("the speed", self.speed_mps.is_finite()),
            ("the steering angle", self.steer_rad.is_finite()),
            ("the path's standard deviation", self.lateral_sigma_m.is_finite()),
            ("the room beside the path", self.room_m.is_finite()),
            ("the probability of the path", self.present.is_finite()),
            ("the distance that is seen", self.seen_ahead_m.is_finite()),
            (
                "the turn ahead",
                self.turn_ahead
                    .is_none_or(|turn| turn.ahead_m.is_finite() && turn.curvature_per_m.is_finite()),
            ),
        ] {
            if !finite {
                return Err(ControlError::NotFinite { what });
            }
        }
        Ok(())
    }
}
