//! The sentence that says what the advice goes by.

use std::fmt::{self, Display, Formatter, Write};

use fingerpost_control::{ControlEvidence, ControllerName, SpeedPlan, SpeedReason};

use super::Stop;
use super::expected_turn::ExpectedTurn;
use super::line::{Led, LineKind, RoadEnd};
use crate::track::RouteStop;

/// What the advice of a frame goes by.
#[derive(Debug, Clone, Copy)]
pub(super) struct Because<'a> {
    pub(super) stop: Option<Stop>,
    pub(super) led: Option<&'a Led>,
    pub(super) evidence: &'a ControlEvidence,
    pub(super) plan: &'a SpeedPlan,
    /// Speed that is advised, m/s.
    pub(super) speed_mps: f64,
    pub(super) controller: ControllerName,
    pub(super) stops: &'a [RouteStop],
    pub(super) turn: Option<&'a ExpectedTurn>,
}

impl Because<'_> {
    /// Writes the sentence in place of what `text` was, reusing its memory.
    pub(super) fn write_to(self, text: &mut String) {
        text.clear();
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
    }
}

impl Display for Because<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (self.stop, self.led) {
            (Some(stop), _) => self.write_stop(f, stop),
            (None, Some(led)) => {
                self.write_line(f, led)?;
                f.write_str("; ")?;
                self.write_controller(f)?;
                f.write_str("; ")?;
                self.write_speed(f, led)
            }
            (None, None) => Ok(()),
        }
    }
}

impl Because<'_> {
    fn write_stop(&self, f: &mut Formatter<'_>, stop: Stop) -> fmt::Result {
        f.write_str("stop: ")?;
        match stop {
            Stop::MotionNotBelieved => f.write_str(
                "the motion is not believed, and the bus gives no speed, so nothing is known of where the vehicle goes",
            ),
            Stop::NoLine => f.write_str("lost, neither driving line, lane nor road's middle is known"),
            Stop::Strayed { index } => {
                f.write_str("lost, the route turns at ")?;
                self.write_feature(f, index)?;
                f.write_str(", which lies behind by all that is known and was never seen")
            }
            Stop::LineEnds(end) => write_end(f, end),
            Stop::Control(error) => write!(f, "{error}"),
        }
    }

    fn write_feature(&self, f: &mut Formatter<'_>, index: usize) -> fmt::Result {
        match self.stops.get(index) {
            Some(stop) => write!(f, "{} ({})", stop.model.name, stop.model.id),
            None => write!(f, "feature {index}"),
        }
    }

    fn write_line(&self, f: &mut Formatter<'_>, led: &Led) -> fmt::Result {
        let name = match led.kind {
            LineKind::DrivingLine => "driving line",
            LineKind::Centreline => "road's middle",
            LineKind::Lane => "lane",
        };
        let side = if self.evidence.offset_m > 0.0 { "right" } else { "left" };
        write!(f, "{name} {:.2} m to the {side}", self.evidence.offset_m.abs())?;
        if led.is_seen() { Ok(()) } else { write!(f, ", last seen {:.1} m ago", led.kept_m) }
    }

    fn write_controller(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (self.controller, self.evidence.aim) {
            (ControllerName::PurePursuit, Some(aim)) => {
                write!(f, "pure pursuit of the place {:.1} m ahead and {:.1} m to the left", aim.x, aim.y)
            }
            (ControllerName::Stanley, _) => f.write_str("the front axle steers onto it"),
            _ => {
                f.write_str("rules")?;
                for (i, rule) in self.evidence.rules.iter().enumerate() {
                    write!(f, "{} {} ({:.2})", if i > 0 { "," } else { "" }, rule.number, rule.strength)?;
                }
                Ok(())
            }
        }
    }

    fn write_speed(&self, f: &mut Formatter<'_>, led: &Led) -> fmt::Result {
        // What is written has two digits.
        if self.speed_mps < self.plan.speed_mps - 0.01 {
            return f.write_str(if self.evidence.limited.speed {
                "slower for the turn that is wanted"
            } else {
                "slower by its rules"
            });
        }
        match self.plan.reason {
            SpeedReason::Highest => f.write_str("as fast as is allowed"),
            SpeedReason::Bend { radius_m, ahead_m } => {
                write!(f, "slower for a bend of {radius_m:.0} m {ahead_m:.0} m ahead")
            }
            SpeedReason::Steering { change_per_m, ahead_m } => {
                let side = if change_per_m > 0.0 { "left" } else { "right" };
                write!(f, "slower while the wheels turn to the {side} for what begins {ahead_m:.0} m ahead")
            }
            SpeedReason::Turn { radius_m, ahead_m } => {
                write!(f, "slower for a turn of {radius_m:.0} m that may begin in {ahead_m:.0} m")?;
                let Some(turn) = self.turn else { return Ok(()) };
                f.write_str(": ")?;
                self.write_feature(f, turn.index)?;
                f.write_str(" is not found yet")
            }
            SpeedReason::Sight { seen_m, sure } => {
                write!(f, "slower because {seen_m:.0} m are seen, {sure:.2} sure")?;
                match led.end {
                    Some(end) => {
                        f.write_str(": ")?;
                        write_end(f, end)
                    }
                    None => Ok(()),
                }
            }
        }
    }
}

fn write_end(f: &mut Formatter<'_>, end: RoadEnd) -> fmt::Result {
    match end {
        RoadEnd::Ambiguous => f.write_str("the road ends at another and nothing says which way to take"),
        RoadEnd::TooTight { tightest_radius_m, turning_radius_m } => write!(
            f,
            "the way round this corner turns at {tightest_radius_m:.2} m, the vehicle at no less than {turning_radius_m:.2} m"
        ),
    }
}
