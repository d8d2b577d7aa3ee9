//! The advice of a frame: what a controller makes of the line that leads.

use serde::{Deserialize, Serialize};

/// Steering angle and speed, and why.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct AdviceRecord {
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Speed to have, m/s; 0 to stop.
    pub speed_mps: f64,
    /// `pure_pursuit`, `stanley` or `fuzzy`.
    pub controller: String,
    /// What is steered along: `driving_line`, `lane` or `centreline`; none where nothing leads.
    pub line: Option<String>,
    /// How far left of it the vehicle is, metres; none where nothing leads.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset_m: Option<f64>,
    /// Why the vehicle is to stop: `no_line`, `strayed`, `line_ends`, `no_rule`, `motion_not_believed`, `broken_frame` or, in a
    /// [`SilenceRecord`], `no_picture`; none while it is to drive.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<String>,
    /// Rules that took part; of the fuzzy controller alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rules: Vec<FiredRuleRecord>,
    /// One sentence: what is steered along, by what, and what decides the speed.
    pub because: String,
}

/// The line that `fingerpost advise` writes when no new picture comes. It answers no picture: it has no `frame`, as answers have.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SilenceRecord {
    /// Time since the answer to the last picture that could be used, seconds.
    pub silent_s: f64,
    /// What the vehicle is to do: stop, wheels as they are.
    pub advice: AdviceRecord,
}

/// A rule that took part.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FiredRuleRecord {
    /// Its number in the rule text, from one.
    pub rule: usize,
    /// How far its conditions hold, 0 to 1.
    pub strength: f64,
}
