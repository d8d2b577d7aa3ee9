//! From a motion log to a fix a row.

use fingerpost_map::RoadGraph;
use nalgebra::Point2;
use thiserror::Error;

use crate::belief::{Belief, OFFSET_MODEL};
use crate::fix::{Estimate, Fix, RISK, Rival, Status};
use crate::gps::{GpsEvidence, Receiver};
use crate::landmark::{Landmarks, Sighting, SightingEvidence};
use crate::odometry::{Motion, MotionInterval, MotionSample, YAW_RATE_NOISE};
use crate::roads::Traffic;
use crate::speedometer::Speedometer;
use crate::start::Start;
use crate::state::{HEADING, SCALE};

/// Distance driven between two looks at the road, metres: less than the lines' bends, and about the length of a row at town speeds.
const LOOK_EVERY_M: f64 = 2.5;
/// Longest time between two rows over which the motion is taken to go on, seconds: a corner takes three.
pub const LONGEST_GAP_S: f64 = 1.0;
/// What no car does, metres a second and radians a second: 360 km/h, and once round in a second.
const FASTEST_MPS: f64 = 100.0;
const FASTEST_RPS: f64 = std::f64::consts::TAU;
/// Places handed out beside the fix.
const MOST_RIVALS: usize = 10;

/// A row that cannot be used.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum MotionError {
    /// A number that is none.
    #[error(
        "the row at {t_s} s has a time, speed or yaw rate that is no number; leave such rows out of the log"
    )]
    NotFinite {
        /// Its time, seconds.
        t_s: f64,
    },
    /// A motion that no car can make.
    #[error(
        "the row at {t_s} s has {speed_mps} m/s and {yaw_rate_rps} rad/s, which no car drives; check the units and leave such rows out"
    )]
    Impossible {
        /// Its time, seconds.
        t_s: f64,
        /// Its speed, metres a second.
        speed_mps: f64,
        /// Its yaw rate, radians a second.
        yaw_rate_rps: f64,
    },
}

/// Finds the vehicle on the map from its motion.
#[derive(Debug, Clone)]
pub struct Locator {
    belief: Belief,
    pending: Motion,
    /// Distance driven up to the last look at the road, metres.
    looked_m: f64,
    before: Option<MotionSample>,
    now_s: Option<f64>,
    estimate: Option<Estimate>,
    speedometer: Speedometer,
    receiver: Receiver,
    landmarks: Landmarks,
}

impl Locator {
    /// A vehicle that may be on any road of the map, either way. The seed draws where on them the hypotheses start.
    pub fn new(graph: &RoadGraph, traffic: Traffic, seed: u64) -> Self {
        Self::with(Belief::anywhere(graph, traffic, seed))
    }

    /// A vehicle whose place at the start is known to some extent.
    pub fn near(graph: &RoadGraph, traffic: Traffic, seed: u64, start: &Start) -> Self {
        Self::with(Belief::near(graph, traffic, seed, start))
    }

    fn with(mut belief: Belief) -> Self {
        let estimate = belief.estimate(Status::Ambiguous);
        Self {
            belief,
            pending: Motion::default(),
            looked_m: 0.0,
            before: None,
            now_s: None,
            estimate,
            speedometer: Speedometer::default(),
            receiver: Receiver::default(),
            landmarks: Landmarks::default(),
        }
    }

    /// The fix as of the last motion, place and landmark; none on a map without roads.
    pub fn now(&self) -> Option<Fix> {
        self.fix(self.now_s.unwrap_or_default())
    }

    /// Takes in the motion over a time, as a camera measures it from picture to picture. Times of no length and numbers that are none
    /// change nothing.
    pub fn go_on(&mut self, interval: &MotionInterval) -> Option<Fix> {
        let MotionInterval { time_s, speed_mps, yaw_rate_rps, turn_variance_rad2, distance_variance_m2 } =
            *interval;
        let now_s = self.now_s.unwrap_or_default();
        let numbers = [time_s, speed_mps, yaw_rate_rps, turn_variance_rad2, distance_variance_m2];
        if numbers.iter().all(|number| number.is_finite()) && time_s > 0.0 {
            self.pending.go_on_by(&MotionInterval {
                turn_variance_rad2: turn_variance_rad2.max(0.0),
                distance_variance_m2: distance_variance_m2.max(0.0),
                ..*interval
            });
            self.now_s = Some(now_s + time_s);
            if self.pending.driven_m >= LOOK_EVERY_M {
                self.look();
            }
        }
        self.now()
    }

    /// Takes in one row. Rows that are no later than the one before change nothing. What the vehicle did in a gap longer than
    /// [`LONGEST_GAP_S`] is not known: it has gone on along the roads by every exit, or elsewhere. No fix comes from a map without roads.
    ///
    /// # Errors
    /// [`MotionError`]; the row is passed over then.
    pub fn step(&mut self, row: MotionSample) -> Result<Option<Fix>, MotionError> {
        if ![row.t_s, row.speed_mps, row.yaw_rate_rps].iter().all(|number| number.is_finite()) {
            return Err(MotionError::NotFinite { t_s: row.t_s });
        }
        if row.speed_mps.abs() > FASTEST_MPS || row.yaw_rate_rps.abs() > FASTEST_RPS {
            let MotionSample { t_s, speed_mps, yaw_rate_rps } = row;
            return Err(MotionError::Impossible { t_s, speed_mps, yaw_rate_rps });
        }
        let mut speed_mps = row.speed_mps;
        if let Some(before) = self.before {
            let time_s = row.t_s - before.t_s;
            if time_s <= 0.0 {
                return Ok(self.fix(row.t_s));
            }
            if time_s > LONGEST_GAP_S {
                self.speedometer.go_on_after_gap(&row);
                self.go_unseen(0.5 * (before.speed_mps.abs() + row.speed_mps.abs()) * time_s);
            } else {
                let speed = self.speedometer.take(&row, time_s);
                self.pending.go_on_by(&MotionInterval {
                    time_s,
                    speed_mps: 0.5 * (before.speed_mps + speed.mps),
                    yaw_rate_rps: 0.5 * (before.yaw_rate_rps + row.yaw_rate_rps),
                    turn_variance_rad2: YAW_RATE_NOISE.powi(2) * time_s,
                    distance_variance_m2: speed.distance_variance_m2,
                });
                speed_mps = speed.mps;
            }
        } else {
            self.speedometer.go_on_after_gap(&row);
        }
        self.before = Some(MotionSample { speed_mps, ..row });
        self.now_s = Some(row.t_s);
        if self.pending.driven_m >= LOOK_EVERY_M {
            self.look();
        }
        Ok(self.fix(row.t_s))
    }

    /// Takes in a place by GPS, metres in the plane of the map's graph, measured at the time of the last row: where it lies from the
    /// fix, and whether that believed it. None where there is no fix, for a place that is no number, and for a fix of GPS that is
    /// no later than the one before.
    pub fn gps(&mut self, place_m: Point2<f64>) -> Option<GpsEvidence> {
        let t_s = self.now_s.unwrap_or_default();
        if !(place_m.x.is_finite() && place_m.y.is_finite()) {
            return None;
        }
        let weight = self.receiver.weight(t_s)?;
        if self.pending.driven_m > 0.0 {
            self.look();
        }
        let evidence = self.belief.take_gps(place_m, weight, self.estimate.as_ref()?);
        self.estimate_again();
        Some(evidence)
    }

    /// Takes in a landmark as it is seen at the time of the last row or interval. It is used behind each look at the road, and what is
    /// made of it is given then; none in between, where there is no fix, and for numbers that are none.
    pub fn sight(&mut self, sighting: &Sighting) -> Option<SightingEvidence> {
        self.estimate.as_ref()?;
        if self.pending.driven_m > 0.0 || !sighting.is_sound() {
            return None;
        }
        if let Some(other) = self.landmarks.see(sighting) {
            self.belief.take_seen(&other);
        }
        self.estimate_again();
        self.landmarks.in_sight.as_ref().map(|seen| self.belief.evidence(seen))
    }

    /// Every place that is possible, the heaviest first, as of the last look at the road.
    pub fn rivals(&self) -> impl Iterator<Item = Rival> {
        self.belief.hypotheses.iter().map(|hypothesis| Rival {
            place_m: hypothesis.state.place(),
            heading_rad: hypothesis.state.mean[HEADING],
            weight: libm::exp(hypothesis.log_weight),
        })
    }

    fn look(&mut self) {
        let out_of_sight = self.landmarks.go(&self.pending);
        self.belief.go(&self.pending);
        if self.speedometer.lies() > 0.5 {
            // Only roads that agree from now on can say where it is.
            self.belief.agreed_m = 0.0;
        }
        if let Some(seen) = out_of_sight {
            self.belief.take_seen(&seen);
        }
        self.looked_m += self.pending.driven_m;
        self.pending = Motion::default();
        self.estimate_again();
    }

    /// Goes on for about a distance of which nothing was measured, metres.
    fn go_unseen(&mut self, driven_m: f64) {
        if self.pending.driven_m > 0.0 {
            self.look();
        }
        self.belief.go_unseen(driven_m);
        self.looked_m += driven_m;
        self.pending = Motion::default();
        self.estimate_again();
    }

    fn estimate_again(&mut self) {
        let status = self.estimate.as_ref().map_or(Status::Ambiguous, |estimate| estimate.status);
        self.estimate = match &self.landmarks.in_sight {
            Some(seen) => self.belief.estimate_seeing(seen, status),
            None => self.belief.estimate(status),
        };
    }

    /// The fix at a time (seconds) after the last row's motion.
    fn fix(&self, t_s: f64) -> Option<Fix> {
        let Estimate { mut state, mass, rivals, mut level_m, mut status } = self.estimate.clone()?;
        // Where the speed may lie, the vehicle may be anywhere else on its road.
        if self.speedometer.lies() > RISK {
            level_m = None;
            status = if status == Status::Converged { Status::Coasting } else { status };
        }
        state.go(&self.pending, &OFFSET_MODEL);
        Some(Fix {
            t_s,
            driven_m: self.looked_m + self.pending.driven_m,
            place_m: state.place(),
            heading_rad: fingerpost_geometry::wrap_angle(state.mean[HEADING]),
            covariance_m2: rivals.with(mass, state.place_covariance()),
            speed_scale: [state.mean[SCALE], state.covariance[(SCALE, SCALE)].sqrt()],
            level_m,
            status,
            mass,
            off_map: self.belief.off_map(),
            rivals: self.rivals().take(MOST_RIVALS).collect(),
            hypotheses: self.belief.hypotheses.len(),
        })
    }
}
