//! How the vehicle is driven across and along its lane: swaying, drifting off, changing lanes, standing.
//!
//! What the driver does is planned in time, on the clock of a drive that does nothing of it: a manoeuvre begins at a place
//! of the route and takes its seconds there. The lateral place that follows is then driven as any other line.

use std::f64::consts::TAU;

use fingerpost_format::Side;
use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;
use crate::noise::Stream;

/// Periods of the driver's sway, seconds: drivers correct their place in the lane every few seconds.
const SWAY_PERIODS_S: [f64; 3] = [23.0, 14.0, 8.5];
/// Time in which a drift gains or loses its lateral speed, seconds: a slow turn of the wheel.
const ONSET_S: f64 = 0.8;
/// The signal comes on before a lane change begins and goes off after its end, seconds.
const SIGNAL_BEFORE_S: f64 = 2.0;
const SIGNAL_AFTER_S: f64 = 0.5;

/// Something that a driver does at a place of the route.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Manoeuvre {
    /// Leaves the lane's middle without meaning to, and comes back.
    Drift {
        /// Where it begins, metres along the route.
        at_m: f64,
        /// To which side.
        side: Side,
        /// Speed across the lane, m/s, on the way out and back.
        lateral_mps: f64,
        /// How far it goes, metres.
        reach_m: f64,
        /// How long the vehicle stays there, seconds.
        hold_s: f64,
    },
    /// Moves over into the next lane and stays there; the turn signal is on.
    LaneChange {
        /// Where the vehicle begins to move over, metres along the route.
        at_m: f64,
        /// To which side.
        side: Side,
        /// How long it takes, seconds.
        for_s: f64,
    },
    /// Brakes to a standstill and drives on after a while.
    Stop {
        /// Where it stands, metres along the route.
        at_m: f64,
        /// For how long, seconds.
        for_s: f64,
    },
}

/// How a vehicle is driven.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DrivingPlan {
    /// Amplitude of the slow sway about the lane's middle, metres.
    pub sway_m: f64,
    /// What happens on the way.
    pub manoeuvres: Vec<Manoeuvre>,
}

/// A kind of plan to draw.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DrivingManner {
    /// Keeps the lane, swaying a little.
    Keeping,
    /// Drifts out of the lane now and then.
    Drifting,
    /// Changes lanes, with the signal on.
    Changing,
    /// Stands still now and then.
    Stopping,
}

/// Sway of ordinary lane keeping, metres.
const SWAY_M: f64 = 0.2;
/// Speeds of drifts across the lane, m/s.
const DRIFT_MPS: [f64; 2] = [0.2, 0.8];
/// How far drifts go, metres: a wheel is over the line from 0.7 to 0.9 m on, as lanes are wide.
const DRIFT_REACH_M: [f64; 2] = [1.1, 1.5];

impl DrivingPlan {
    /// A plan of that kind from a seed for a road from `from_m` to `to_m` of the route at about `speed_mps`.
    pub fn draw(manner: DrivingManner, seed: u64, from_m: f64, to_m: f64, speed_mps: f64) -> Self {
        let mut stream = Stream::new(seed, 0x4d41_4e4e);
        let mut plan = Self { sway_m: SWAY_M, manoeuvres: Vec::new() };
        let mut at_m = from_m + 5.0 * speed_mps;
        let mut moved_over = false;
        while at_m < to_m && manner != DrivingManner::Keeping {
            let left = stream.unit() < 0.5;
            let side = if left { Side::Left } else { Side::Right };
            let (manoeuvre, takes_s) = match manner {
                DrivingManner::Keeping | DrivingManner::Drifting => {
                    let lateral_mps = stream.between(DRIFT_MPS[0], DRIFT_MPS[1]);
                    let reach_m = stream.between(DRIFT_REACH_M[0], DRIFT_REACH_M[1]);
                    let hold_s = stream.between(0.5, 2.0);
                    let drift = Manoeuvre::Drift { at_m, side, lateral_mps, reach_m, hold_s };
                    (drift, 2.0 * (reach_m / lateral_mps + ONSET_S) + hold_s)
                }
                DrivingManner::Changing => {
                    // Over and back again.
                    let side = if moved_over { Side::Right } else { Side::Left };
                    moved_over = !moved_over;
                    let for_s = stream.between(3.5, 6.0);
                    (Manoeuvre::LaneChange { at_m, side, for_s }, for_s)
                }
                DrivingManner::Stopping => {
                    let for_s = stream.between(4.0, 10.0);
                    // Braking and speeding up take most of the way.
                    (Manoeuvre::Stop { at_m, for_s }, speed_mps)
                }
            };
            plan.manoeuvres.push(manoeuvre);
            at_m += speed_mps * (takes_s + stream.between(6.0, 12.0));
        }
        plan
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.sway_m <= 0.0 && self.manoeuvres.is_empty()
    }

    pub(crate) fn check(&self) -> Result<(), SimError> {
        let seconds = "0 to 3600 seconds";
        let place = "0 or more metres along the route";
        check_range("sway_m", self.sway_m, 0.0, 1.0, "0 to 1 metre")?;
        for manoeuvre in &self.manoeuvres {
            match *manoeuvre {
                Manoeuvre::Drift { at_m, lateral_mps, reach_m, hold_s, .. } => {
                    check_range("at_m", at_m, 0.0, 1e6, place)?;
                    check_range("lateral_mps", lateral_mps, 0.01, 3.0, "0.01 to 3 m/s")?;
                    check_range("reach_m", reach_m, 0.01, 10.0, "0.01 to 10 metres")?;
                    check_range("hold_s", hold_s, 0.0, 3600.0, seconds)?;
                }
                Manoeuvre::LaneChange { at_m, for_s, .. } => {
                    check_range("at_m", at_m, 0.0, 1e6, place)?;
                    check_range("for_s", for_s, 1.0, 60.0, "1 to 60 seconds")?;
                }
                Manoeuvre::Stop { at_m, for_s } => {
                    check_range("at_m", at_m, 0.0, 1e6, place)?;
                    check_range("for_s", for_s, 0.0, 3600.0, seconds)?;
                }
            }
        }
        Ok(())
    }
}

/// A plan on the clock of the drive that does nothing of it.
#[derive(Debug, Clone)]
pub(crate) struct PlannedDriving {
    sway: Vec<(f64, f64)>,
    sway_m: f64,
    lane_width_m: f64,
    /// Manoeuvres with the second in which they begin.
    moves: Vec<(f64, Manoeuvre)>,
    /// Clock: distance along the route, metres, and time, seconds, both ascending.
    clock: Vec<(f64, f64)>,
}

impl PlannedDriving {
    /// The plan on a `clock` of distances along the route, metres, and times, seconds, both ascending.
    pub(crate) fn new(plan: &DrivingPlan, seed: u64, lane_width_m: f64, clock: Vec<(f64, f64)>) -> Self {
        let mut stream = Stream::new(seed, 0x5357_4159);
        let sway = SWAY_PERIODS_S.map(|period_s| (TAU / period_s, stream.between(0.0, TAU)));
        let begins = |manoeuvre: &Manoeuvre| match *manoeuvre {
            Manoeuvre::Drift { at_m, .. }
            | Manoeuvre::LaneChange { at_m, .. }
            | Manoeuvre::Stop { at_m, .. } => time_at(&clock, at_m),
        };
        let moves = plan.manoeuvres.iter().map(|manoeuvre| (begins(manoeuvre), *manoeuvre)).collect();
        Self { sway: sway.to_vec(), sway_m: plan.sway_m, lane_width_m, moves, clock }
    }

    /// How far left of its lane's middle the vehicle is at a place of the route, metres.
    pub(crate) fn aside_m(&self, route_m: f64) -> f64 {
        let t_s = time_at(&self.clock, route_m);
        let waves = self.sway.iter().map(|(rate, phase)| libm::sin(rate * t_s + phase)).sum::<f64>();
        let sway_m = self.sway_m / self.sway.len() as f64 * waves;
        sway_m
            + self
                .moves
                .iter()
                .map(|(begin_s, manoeuvre)| self.moved_m(manoeuvre, t_s - begin_s))
                .sum::<f64>()
    }

    fn moved_m(&self, manoeuvre: &Manoeuvre, t_s: f64) -> f64 {
        match *manoeuvre {
            Manoeuvre::Drift { side, lateral_mps, reach_m, hold_s, .. } => {
                let out = Ramp::new(lateral_mps, reach_m);
                sign(side) * (out.moved_m(t_s) - out.moved_m(t_s - out.duration_s() - hold_s))
            }
            Manoeuvre::LaneChange { side, for_s, .. } => {
                let share = (t_s / for_s).clamp(0.0, 1.0);
                // Starts and ends without speed and without acceleration across the lane.
                let moved = share.powi(3) * (10.0 + share * (6.0 * share - 15.0));
                sign(side) * self.lane_width_m * moved
            }
            Manoeuvre::Stop { .. } => 0.0,
        }
    }

    /// The turn signal that is on at a place of the route.
    pub(crate) fn turn_signal(&self, route_m: f64) -> Option<Side> {
        let t_s = time_at(&self.clock, route_m);
        self.moves.iter().find_map(|(begin_s, manoeuvre)| match *manoeuvre {
            Manoeuvre::LaneChange { side, for_s, .. } => {
                let on_s = begin_s - SIGNAL_BEFORE_S..begin_s + for_s + SIGNAL_AFTER_S;
                on_s.contains(&t_s).then_some(side)
            }
            _ => None,
        })
    }

    /// Where the vehicle stands, metres along the route, and for how long, seconds.
    pub(crate) fn stops(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.moves.iter().filter_map(|(_, manoeuvre)| match *manoeuvre {
            Manoeuvre::Stop { at_m, for_s } => Some((at_m, for_s)),
            _ => None,
        })
    }
}

/// A move over a distance with a speed that is gained and lost evenly.
#[derive(Debug, Clone, Copy)]
struct Ramp {
    speed_mps: f64,
    onset_s: f64,
    reach_m: f64,
}

impl Ramp {
    fn new(speed_mps: f64, reach_m: f64) -> Self {
        Self { speed_mps, onset_s: ONSET_S.min(reach_m / speed_mps), reach_m }
    }

    fn duration_s(&self) -> f64 {
        self.reach_m / self.speed_mps + self.onset_s
    }

    fn moved_m(&self, t_s: f64) -> f64 {
        let t_s = t_s.clamp(0.0, self.duration_s());
        let gaining = |t_s: f64| 0.5 * self.speed_mps * t_s * t_s / self.onset_s;
        let left_s = self.duration_s() - t_s;
        if t_s < self.onset_s {
            gaining(t_s)
        } else if left_s < self.onset_s {
            self.reach_m - gaining(left_s)
        } else {
            self.speed_mps * (t_s - 0.5 * self.onset_s)
        }
    }
}

fn sign(side: Side) -> f64 {
    match side {
        Side::Left => 1.0,
        Side::Right => -1.0,
    }
}

fn time_at(clock: &[(f64, f64)], route_m: f64) -> f64 {
    let after = clock.partition_point(|(at_m, _)| *at_m <= route_m);
    match (after.checked_sub(1).map(|before| clock[before]), clock.get(after)) {
        (Some((a_m, a_s)), Some((b_m, b_s))) => a_s + (b_s - a_s) * (route_m - a_m) / (b_m - a_m),
        (Some((_, last_s)), None) => last_s,
        (None, _) => 0.0,
    }
}
