//! How fast: no faster than bends allow, than what is seen allows to stop in, and the less the less sure it is.
//!
//! Paper 2, section 6: a controller of a system that sees 15 to 20 m ahead has to anticipate. A vehicle stops within what it sees
//! when v² / (2 a) + v t <= d, with deceleration a and reaction time t. What is seen but not sure counts as less: d is the
//! distance seen times the probability that the path is what it is taken for and keeps the vehicle on the road.

use std::f64::consts::FRAC_1_SQRT_2;

use crate::{PathPoint, Situation, TurnAhead, VehicleLimits};

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
    /// A change of the path's curvature to which the wheels need time to turn.
    Steering {
        /// The change, 1/m.
        change_per_m: f64,
        /// How far ahead it is, metres.
        ahead_m: f64,
    },
    /// A turn that is expected and has not been found yet.
    Turn {
        /// Its radius, metres.
        radius_m: f64,
        /// The least distance at which it may well begin, metres.
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
            let speed_mps = limits.bend_ahead_mps(point.along_m, point.curvature_per_m);
            if speed_mps < plan.speed_mps {
                let (radius_m, ahead_m) = (1.0 / point.curvature_per_m.abs(), point.along_m);
                plan = Self { speed_mps, reason: SpeedReason::Bend { radius_m, ahead_m } };
            }
        }
        for (i, point) in situation.path.iter().enumerate().filter(|(_, point)| point.along_m >= 0.0) {
            let before = before(situation.path, i);
            let there_mps = limits.turning_mps(before.curvature_per_m, point.curvature_per_m);
            let speed_mps = limits.slower_ahead_mps(before.along_m, there_mps);
            if speed_mps < plan.speed_mps {
                let (change_per_m, ahead_m) =
                    (point.curvature_per_m - before.curvature_per_m, before.along_m);
                plan = Self {
                    speed_mps,
                    reason: SpeedReason::Steering { change_per_m, ahead_m: ahead_m.max(0.0) },
                };
            }
        }
        if let Some(TurnAhead { ahead_m, curvature_per_m }) = situation.turn_ahead {
            let speed_mps = limits.bend_ahead_mps(ahead_m, curvature_per_m);
            if speed_mps < plan.speed_mps {
                let (radius_m, ahead_m) = (1.0 / curvature_per_m.abs(), ahead_m.max(0.0));
                plan = Self { speed_mps, reason: SpeedReason::Turn { radius_m, ahead_m } };
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

/// Length over which a change of curvature is taken for one step, metres: over less the clothoid of a slow vehicle is as long.
const STEP_M: f64 = 2.0;

/// The point of a path so far before another.
fn before(path: &[PathPoint], i: usize) -> PathPoint {
    let from_m = path[i].along_m - STEP_M;
    path[..=i].iter().rev().find(|point| point.along_m <= from_m).copied().unwrap_or(path[0])
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

    /// Speed at which it still comes to a bend of a curvature (1/m) slow enough for it that begins so far ahead, metres; m/s.
    fn bend_ahead_mps(&self, ahead_m: f64, curvature_per_m: f64) -> f64 {
        self.slower_ahead_mps(ahead_m, self.bend_speed_mps(curvature_per_m))
    }

    /// Speed at which it still comes to a place so far ahead, metres, no faster than `there_mps`; m/s.
    fn slower_ahead_mps(&self, ahead_m: f64, there_mps: f64) -> f64 {
        // Braking begins after the reaction time.
        let brakes_m = (ahead_m - there_mps * self.reaction_s).max(0.0);
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
            turn_ahead: None,
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
    fn a_turn_that_is_not_found_yet_is_braked_for_and_driven_past_slowly() {
        let limits = VehicleLimits { lateral_acceleration_mps2: 2.0, ..VehicleLimits::default() };
        let mut path = Vec::new();
        arc(0.0, 0.0, 0.0, [50.0, 0.5], &mut path);
        let plan = |ahead_m| {
            let turn_ahead = Some(TurnAhead { ahead_m, curvature_per_m: -1.0 / 8.0 });
            SpeedPlan::new(&limits, &Situation { turn_ahead, seen_ahead_m: 200.0, ..situation(&path) })
        };
        // 4 m/s in the turn, from 8 m of braking with 2 m/s².
        assert!((plan(10.0).speed_mps - 48.0_f64.sqrt()).abs() < 1e-6);
        assert!(
            matches!(plan(10.0).reason, SpeedReason::Turn { radius_m, .. } if (radius_m - 8.0).abs() < 1e-9)
        );
        assert!((plan(-3.0).speed_mps - 4.0).abs() < 1e-9);
        assert_eq!(plan(80.0).reason, SpeedReason::Highest);
    }

    #[test]
    fn a_bend_to_the_other_side_at_once_is_driven_as_slowly_as_the_wheels_turn() {
        let limits = VehicleLimits { lateral_acceleration_mps2: 9.0, ..VehicleLimits::default() };
        let mut path = Vec::new();
        arc(0.0, 0.0, -0.19, [12.0, 0.5], &mut path);
        for point in path.iter_mut().filter(|point| point.along_m >= 5.0) {
            point.curvature_per_m = 0.12;
        }
        let plan = SpeedPlan::new(&limits, &Situation { seen_ahead_m: 200.0, ..situation(&path) });
        assert!(
            matches!(plan.reason, SpeedReason::Steering { change_per_m, .. } if (change_per_m - 0.31).abs() < 1e-9)
        );
        // The clothoid at the speed for which it has time, L = v t, lies beside the step by 0.1 m.
        let there_mps = limits.turning_mps(-0.19, 0.12);
        let time_s = (limits.steer_rad(0.12) - limits.steer_rad(-0.19)) / limits.steering_rate_radps;
        assert!(((there_mps * time_s).powi(2) * 0.31 / 24.0 - limits.clearance_m).abs() < 1e-9);
        assert!(plan.speed_mps > there_mps && plan.speed_mps < 4.5, "{plan:?}");
        let touching = VehicleLimits { clearance_m: 0.0, ..limits };
        assert!(touching.turning_mps(-0.19, 0.12) > 0.5, "without clearance it still drives");
        assert!(touching.turning_mps(0.1, 0.1) >= limits.speed_max_mps, "a steady bend asks for no turning");
    }

    #[test]
    fn a_bend_ahead_is_braked_for() {
        let limits =
            VehicleLimits { speed_max_mps: 20.0, lateral_acceleration_mps2: 2.0, ..VehicleLimits::default() };
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
