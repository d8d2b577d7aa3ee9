//! How fast: no faster than bends allow, than what is seen allows to stop in, and the less the less sure it is.
//!
//! Paper 2, section 6: a controller of a system that sees 15 to 20 m ahead has to anticipate. A vehicle stops within what it sees
//! when v² / (2 a) + v t <= d, with deceleration a and reaction time t. What is seen but not sure counts as less: d is the
//! distance seen times the probability that the path is what it is taken for and keeps the vehicle on the road.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::{PathPoint, Situation, VehicleLimits};

/// What decides the speed.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum SpeedReason {
    /// Nothing but the highest speed.
    #[default]
    Highest,
    /// A bend of the path.
    Bend {
        /// Its radius, metres.
        radius_m: f64,
        /// How far ahead it is, metres.
        ahead_m: f64,
    },
    /// How far the road or the path is seen.
    Sight {
        /// The distance, metres.
        seen_m: f64,
        /// How sure it is, 0 to 1.
        sure: f64,
    },
}

/// A speed with its reason.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SpeedPlan {
    /// The highest speed that is sound, m/s.
    pub speed_mps: f64,
    /// What decides it.
    pub reason: SpeedReason,
}

impl SpeedPlan {
    /// The highest sound speed in a situation.
    pub fn new(limits: &VehicleLimits, situation: &Situation<'_>) -> Self {
        let mut plan = Self { speed_mps: limits.speed_max_mps, reason: SpeedReason::Highest };
        for point in situation.path.iter().filter(|point| point.along_m >= 0.0) {
            let speed_mps = limits.bend_ahead_mps(point);
            if speed_mps < plan.speed_mps {
                let (radius_m, ahead_m) = (1.0 / point.curvature_per_m.abs(), point.along_m);
                plan = Self { speed_mps, reason: SpeedReason::Bend { radius_m, ahead_m } };
            }
        }
        let end_m = situation.path.last().map_or(0.0, |point| point.along_m);
        let seen_m = situation.seen_ahead_m.min(end_m).max(0.0);
        let sure = sureness(situation);
        let speed_mps = limits.stopping_mps(sure * seen_m);
        if speed_mps < plan.speed_mps {
            plan = Self { speed_mps, reason: SpeedReason::Sight { seen_m, sure } };
        }
        plan
    }
}

/// Probability that the path is what it is taken for and that along it the vehicle stays on the road, 0 to 1.
pub(crate) fn sureness(situation: &Situation<'_>) -> f64 {
    let sigmas = situation.room_m.max(0.0) / situation.lateral_sigma_m.max(1e-6);
    situation.present.clamp(0.0, 1.0) * libm::erf(sigmas * FRAC_1_SQRT_2)
}

impl VehicleLimits {
    /// Speed from which the vehicle stops within a distance, m/s.
    pub fn stopping_mps(&self, distance_m: f64) -> f64 {
        let (a, at) = (self.deceleration_mps2, self.deceleration_mps2 * self.reaction_s);
        ((at * at + 2.0 * a * distance_m.max(0.0)).sqrt() - at).clamp(0.0, self.speed_max_mps)
    }

    /// Speed at which it still comes to a point of the path slow enough for its bend, m/s.
    fn bend_ahead_mps(&self, point: &PathPoint) -> f64 {
        let there_mps = self.bend_speed_mps(point.curvature_per_m);
        // Braking begins after the reaction time.
        let brakes_m = (point.along_m - there_mps * self.reaction_s).max(0.0);
        (there_mps * there_mps + 2.0 * self.deceleration_mps2 * brakes_m).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arc;

    fn situation(path: &[PathPoint]) -> Situation<'_> {
        Situation {
            path,
            speed_mps: 5.0,
            steer_rad: 0.0,
            lateral_sigma_m: 0.05,
            room_m: 1.0,
            present: 1.0,
            seen_ahead_m: 20.0,
        }
    }

    #[test]
    fn a_vehicle_stops_within_what_it_sees() {
        let limits = VehicleLimits { speed_max_mps: 30.0, ..VehicleLimits::default() };
        let mut path = Vec::new();
        arc(0.0, 0.0, 0.0, [50.0, 0.5], &mut path);
        for seen_m in [0.0, 1.0, 5.0, 12.0, 20.0] {
            let plan = SpeedPlan::new(&limits, &Situation { seen_ahead_m: seen_m, ..situation(&path) });
            let v = plan.speed_mps;
            let stops_m = v * v / (2.0 * limits.deceleration_mps2) + v * limits.reaction_s;
            assert!((stops_m - seen_m).abs() < 1e-6, "{seen_m}: {plan:?}");
        }
    }

    #[test]
    fn what_is_not_sure_is_slower() {
        let limits = VehicleLimits::default();
        let mut path = Vec::new();
        arc(0.0, 0.0, 0.0, [50.0, 0.5], &mut path);
        let speed = |present, lateral_sigma_m| {
            SpeedPlan::new(&limits, &Situation { present, lateral_sigma_m, ..situation(&path) }).speed_mps
        };
        assert!(speed(0.5, 0.1) < speed(0.9, 0.1) && speed(0.9, 1.0) < speed(0.9, 0.3));
        assert!(speed(0.0, 0.1) < 1e-9);
    }

    #[test]
    fn a_bend_ahead_is_braked_for() {
        let limits = VehicleLimits { speed_max_mps: 20.0, ..VehicleLimits::default() };
        let mut path = Vec::new();
        arc(0.0, 0.0, 0.0, [50.0, 0.5], &mut path);
        for point in path.iter_mut().filter(|point| point.along_m >= 10.0) {
            point.curvature_per_m = -1.0 / 8.0;
        }
        let plan = SpeedPlan::new(&limits, &Situation { seen_ahead_m: 200.0, ..situation(&path) });
        // 4 m/s in the bend, from 8 m of braking with 2 m/s².
        assert!((plan.speed_mps - 48.0_f64.sqrt()).abs() < 1e-6, "{plan:?}");
        assert!(matches!(plan.reason, SpeedReason::Bend { ahead_m, .. } if (ahead_m - 10.0).abs() < 1e-9));
    }
}
