//! Advice: steering angle and speed along the line that leads.
//!
//! Paper 1, section VII-B, and paper 2, sections 6 and 7.3, hand the driving line to a controller. At a feature its driving line leads,
//! where the road's middle beside the vehicle has it (`alignment`), elsewhere the road's middle, or else the lane (`line`). Where a frame
//! shows none, the last one is kept where it lies, while the vehicle drives over what it saw of it, ever slower, and then stops. To a
//! feature at which the route turns the vehicle comes slowly enough to turn before it is found (`expected_turn`), and where only its
//! distance is not sure enough to follow it, its driving line leads already. A [`Steersman`] of `fingerpost-control` steers along the line
//! within the vehicle's limits. The advice is the vehicle's only where it is followed: it knows no obstacles and no traffic rules.

mod alignment;
mod config;
mod expected_turn;
mod line;
mod words;

use fingerpost_control::PathPoint;
use fingerpost_control::{
    Command, ControlError, FiredRule, FuzzyError, Moving, Situation, SpeedPlan, SpeedReason, Steersman,
    seen_from,
};
use nalgebra::{Isometry2, Point2};

pub use config::AdviceConfig;
pub use fingerpost_control::{ControllerName, DEFAULT_RULES, VehicleLimits};
pub use line::{LineKind, RoadEnd};

use self::expected_turn::ExpectedTurn;
use self::line::{Led, LineFinder, turns};
use self::words::Because;
use crate::centreline::Centreline;
use crate::lanes::Lane;
use crate::motion::{Motion, MotionDoubt};
use crate::track::{RouteStop, TrackOutput};
use crate::vehicle::VehicleConfig;

/// What the vehicle is advised to do.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Advice {
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Speed to have, m/s; 0 to stop.
    pub speed_mps: f64,
    /// Who steers.
    pub controller: ControllerName,
    /// What is steered along; none where nothing leads.
    pub line: Option<LineKind>,
    /// How far left of it the vehicle is, metres.
    pub offset_m: f64,
    /// The vehicle's heading against it, radians, positive to the left.
    pub heading_rad: f64,
    /// The place that is steered towards, vehicle frame, metres; none by controllers that aim at none.
    pub aim: Option<Point2<f64>>,
    /// Why the vehicle is to stop; none while it is to drive.
    pub stop: Option<Stop>,
    /// Rules that took part; of the fuzzy controller alone.
    pub rules: Vec<FiredRule>,
    /// One sentence: what is steered along, by what, and what decides the speed.
    pub because: String,
}

/// Why the vehicle is to stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Stop {
    /// The vehicle's own motion is wrong by what else the picture shows, and its bus does not say how fast it drives: nothing can be kept
    /// where it lies.
    MotionNotBelieved,
    /// Neither driving line, lane nor road's middle is known, nor was one a moment ago.
    NoLine,
    /// A feature at which the route turns was passed without being seen: the vehicle is not where the route leads.
    Strayed {
        /// Its index in the route.
        index: usize,
    },
    /// The line ends where the vehicle is, and nothing leads on.
    LineEnds(RoadEnd),
    /// The controller cannot say anything.
    Control(ControlError),
}

/// What the stage goes by.
#[derive(Debug, Clone, Copy)]
pub struct AdviceSetting<'a> {
    /// How to drive.
    pub advice: &'a AdviceConfig,
    /// The vehicle.
    pub vehicle: &'a VehicleConfig,
    /// How far ahead the ground view shows the road, metres.
    pub far_m: f64,
    /// How far ahead the centreline aims, metres.
    pub aim_m: f64,
}

/// What a frame says.
#[derive(Debug, Clone, Copy)]
pub struct AdviceInput<'a> {
    /// The vehicle's motion since the frame before; none where there is none.
    pub motion: Option<&'a Motion>,
    /// Why nothing is known of that motion although it was measured; none where it is believed.
    pub motion_doubt: Option<MotionDoubt>,
    /// The vehicle's speed, m/s; none where it is not known.
    pub speed_mps: Option<f64>,
    /// Where the tracker has the feature at hand.
    pub track: &'a TrackOutput,
    /// The features of the route.
    pub stops: &'a [RouteStop],
    /// The road's middle; none where it is not known.
    pub centreline: Option<&'a Centreline>,
    /// The lane; none where it is not known.
    pub lane: Option<&'a Lane>,
    /// Seconds since the frame before; none in the first one and where frames have no times.
    pub dt_s: Option<f64>,
}

/// How much less sure a line is that is kept, metres for each metre driven: that of motion.
const KEPT_SIGMA: f64 = 0.015;
/// The same where no motion is known, and the vehicle is taken to drive as it was asked to: a wheel 3 degrees off on 2 m.
const BLIND_SIGMA: f64 = 0.1;
/// A vehicle advised to be slower than this stands, m/s: it would take minutes to the end of what it sees.
const STANDS_MPS: f64 = 0.2;

/// The stage with the line that it keeps.
#[derive(Debug)]
pub struct AdviceStage {
    steersman: Steersman,
    finder: LineFinder,
    led: Option<Led>,
    path: Vec<PathPoint>,
    moved: Vec<PathPoint>,
    /// What was advised last.
    last: Command,
    /// The feature that was passed without being seen.
    strayed: Option<usize>,
    /// The turn that is expected next.
    turn: Option<ExpectedTurn>,
}

impl AdviceStage {
    /// The stage of a configuration.
    ///
    /// # Errors
    /// [`FuzzyError`] when the fuzzy controller is chosen and its rules cannot be used.
    pub fn new(setting: &AdviceSetting<'_>) -> Result<Self, FuzzyError> {
        let AdviceSetting { advice, vehicle, .. } = *setting;
        let rules = advice.rules.as_deref().unwrap_or(DEFAULT_RULES);
        let steersman = Steersman::new(advice.controller, advice.limits(vehicle), rules)?;
        Ok(Self::with(setting, steersman))
    }

    /// The same with a steersman of the program's own.
    pub fn with(setting: &AdviceSetting<'_>, steersman: Steersman) -> Self {
        Self {
            steersman,
            finder: LineFinder::new(setting),
            led: None,
            path: Vec::new(),
            moved: Vec::new(),
            last: Command::default(),
            strayed: None,
            turn: None,
        }
    }

    /// The vehicle's limits.
    pub const fn limits(&self) -> &VehicleLimits {
        self.steersman.limits()
    }

    /// The texts of the controller's rules, in their order; none of controllers without rules.
    pub fn rules(&self) -> impl Iterator<Item = &str> {
        self.steersman.rules().iter().map(String::as_str)
    }

    /// Advice for a frame, in place of the one before in `advice`.
    pub fn advise(&mut self, input: &AdviceInput<'_>, advice: &mut Advice) {
        let is_lost_in_motion = input.motion_doubt.is_some() && input.speed_mps.is_none();
        if is_lost_in_motion {
            self.led = None;
        } else {
            self.drive_on(input);
            if let Some(led) = self.finder.find(input, self.led.as_ref(), &mut self.path) {
                self.led = Some(led);
            }
        }
        self.watch_route(input);
        self.turn = ExpectedTurn::next(input.track, input.stops);
        let advised = match self.strayed {
            _ if is_lost_in_motion => Err(Stop::MotionNotBelieved),
            Some(index) => Err(Stop::Strayed { index }),
            None => self.steer(input),
        };
        let (command, stop) = match advised {
            Ok(command) => (command, None),
            Err(stop) => (Command { speed_mps: 0.0, ..self.last }, Some(stop)),
        };
        self.last = command;
        let evidence = self.steersman.evidence();
        advice.steer_rad = command.steer_rad;
        advice.speed_mps = command.speed_mps;
        advice.controller = self.finder.controller();
        advice.line = self.led.as_ref().filter(|_| stop != Some(Stop::NoLine)).map(|led| led.kind);
        (advice.offset_m, advice.heading_rad) = (evidence.offset_m, evidence.heading_rad);
        advice.aim = evidence.aim.filter(|_| stop.is_none());
        advice.stop = stop;
        advice.rules.clear();
        if stop.is_none() {
            advice.rules.extend_from_slice(&evidence.rules);
        }
        let Advice { because, .. } = advice;
        Because {
            stop,
            led: self.led.as_ref(),
            evidence,
            plan: self.steersman.speed_plan(),
            speed_mps: command.speed_mps,
            controller: self.finder.controller(),
            stops: input.stops,
            turn: self.turn.as_ref(),
        }
        .write_to(because);
    }

    /// Moves the line that is kept with the vehicle.
    fn drive_on(&mut self, input: &AdviceInput<'_>) {
        let Some(led) = &mut self.led else { return };
        let seen = input.motion.filter(|motion| motion.quality > 0.0);
        let (previous_from_current, sigma) = match (seen, input.dt_s) {
            (Some(motion), _) => (motion.previous_from_current, KEPT_SIGMA),
            (None, Some(dt_s)) => {
                let speed_mps = input.speed_mps.unwrap_or(self.last.speed_mps);
                (
                    self.steersman
                        .limits()
                        .driven(Moving { speed_mps, steer_rad: self.last.steer_rad }, dt_s),
                    BLIND_SIGMA,
                )
            }
            (None, None) => (Isometry2::identity(), BLIND_SIGMA),
        };
        seen_from(&previous_from_current, &self.path, &mut self.moved);
        std::mem::swap(&mut self.path, &mut self.moved);
        led.drive_on(&previous_from_current, sigma);
    }

    /// Notices that the vehicle is not where the route leads, and that it is again.
    fn watch_route(&mut self, input: &AdviceInput<'_>) {
        if let Some(index) = input.track.skipped {
            let turns = input.stops.get(index).is_some_and(turns);
            self.strayed = self.strayed.or(turns.then_some(index));
        }
        if input.track.followed.is_some() {
            self.strayed = None;
        }
    }

    /// Steers along the line that leads.
    fn steer(&mut self, input: &AdviceInput<'_>) -> Result<Command, Stop> {
        let led = self.led.as_ref().ok_or(Stop::NoLine)?;
        let situation = Situation {
            path: &self.path,
            speed_mps: input.speed_mps.unwrap_or(self.last.speed_mps),
            steer_rad: self.last.steer_rad,
            lateral_sigma_m: led.sigma_m,
            room_m: led.room_m,
            present: led.present,
            seen_ahead_m: led.seen_m,
            turn_ahead: self.turn.map(|turn| turn.ahead),
        };
        let command = self.steersman.steer(&situation, input.dt_s).map_err(Stop::Control)?;
        let SpeedPlan { speed_mps, reason } = *self.steersman.speed_plan();
        if speed_mps >= STANDS_MPS || !matches!(reason, SpeedReason::Sight { .. }) {
            return Ok(command);
        }
        Err(match led.end {
            Some(end) if led.is_seen() => Stop::LineEnds(end),
            _ => {
                self.led = None;
                Stop::NoLine
            }
        })
    }
}
