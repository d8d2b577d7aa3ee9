//! When the vehicle is where: speed along the driven line, and the body's motion on its springs.
//!
//! The speed profile obeys the limits of lateral acceleration in bends and of braking and accelerating along the line
//! (a forward and a backward pass); times follow from it in closed form, so that a frame's pose depends on its time
//! alone and not on the frame rate.

use std::f64::consts::TAU;

use fingerpost_geometry::wrap_angle;
use nalgebra::Point2;

use crate::noise::Stream;
use crate::path::PathPoint;
use crate::{Conditions, SimError};

/// Most lateral acceleration in a bend, m/s2: brisk but comfortable.
const LATERAL_MPS2: f64 = 2.3;
/// Acceleration along the line, m/s2.
const SPEED_UP_MPS2: f64 = 1.2;
/// Braking along the line, m/s2.
const BRAKE_MPS2: f64 = 1.5;
/// Slowest speed in a bend, m/s.
const CRAWL_MPS: f64 = 1.5;
/// Frequencies of the body's motion on its springs, Hz.
const SPRING_HZ: [f64; 3] = [0.9, 1.3, 1.9];
/// Length over which accelerations reach the body, metres: springs do not follow a jump.
const SOFTNESS_M: f64 = 4.0;

/// State of the vehicle at a time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct VehicleState {
    /// Place of the rear axle's middle, map frame, metres.
    pub(crate) p_in_map: Point2<f64>,
    /// Direction of the body, radians anticlockwise from east.
    pub(crate) heading_rad: f64,
    /// Speed, m/s.
    pub(crate) speed_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub(crate) yaw_rate_rps: f64,
    /// Distance along the route, metres.
    pub(crate) route_m: f64,
    /// Pitch of the body about the road's plane, radians, nose down.
    pub(crate) pitch_rad: f64,
    /// Roll of the body about the road's plane, radians, left side up.
    pub(crate) roll_rad: f64,
}

/// A drive along a line.
#[derive(Debug, Clone)]
pub(crate) struct Drive {
    path: Vec<PathPoint>,
    along_m: Vec<f64>,
    speeds_mps: Vec<f64>,
    times_s: Vec<f64>,
    /// How long the vehicle has stood before each point.
    stood_s: Vec<f64>,
    lengthwise_mps2: Vec<f64>,
    lateral_mps2: Vec<f64>,
    springs: [Spring; 2],
    rad_per_mps2: f64,
}

/// Pitch or roll from the road's unevenness.
#[derive(Debug, Clone, Copy)]
struct Spring {
    rms_rad: f64,
    phases_rad: [f64; 3],
}

impl Spring {
    fn new(stream: &mut Stream, rms_rad: f64) -> Self {
        Self { rms_rad, phases_rad: std::array::from_fn(|_| stream.between(0.0, TAU)) }
    }

    fn angle_rad(&self, t_s: f64) -> f64 {
        // Each sine has a mean square of a half.
        let scale = self.rms_rad * (2.0 / SPRING_HZ.len() as f64).sqrt();
        let waves = SPRING_HZ.iter().zip(self.phases_rad);
        scale * waves.map(|(hz, phase)| libm::sin(TAU * hz * t_s + phase)).sum::<f64>()
    }
}

impl Drive {
    /// The drive along `path`, at least two points of it, with `stops`: where, metres along the route, and how long, seconds.
    pub(crate) fn new(
        mut path: Vec<PathPoint>,
        stops: &[(f64, f64)],
        cruise_mps: f64,
        conditions: &Conditions,
        seed: u64,
    ) -> Result<Self, SimError> {
        if path.len() < 2 {
            return Err(SimError::RouteTooShort { length_m: 0.0, needed_m: crate::simulator::MIN_ROUTE_M });
        }
        let stands_s = insert_stops(&mut path, stops);
        let mut along_m = vec![0.0; path.len()];
        for i in 1..path.len() {
            along_m[i] = along_m[i - 1] + (path[i].p_in_map - path[i - 1].p_in_map).norm();
        }
        let speeds_mps = speed_profile(&path, &along_m, &stands_s, cruise_mps);
        let mut times_s = vec![0.0; path.len()];
        let mut stood_s = vec![0.0; path.len()];
        let mut accelerations = vec![0.0; path.len()];
        for i in 1..path.len() {
            let step_m = along_m[i] - along_m[i - 1];
            stood_s[i] = stood_s[i - 1] + stands_s[i].unwrap_or(0.0);
            let moves_s = 2.0 * step_m / (speeds_mps[i] + speeds_mps[i - 1]);
            times_s[i] = times_s[i - 1] + stands_s[i].unwrap_or(moves_s);
            accelerations[i] = (speeds_mps[i].powi(2) - speeds_mps[i - 1].powi(2)) / (2.0 * step_m.max(1e-9));
        }
        let spacing_m = along_m[along_m.len() - 1] / (along_m.len() - 1) as f64;
        let half = (0.5 * SOFTNESS_M / spacing_m) as usize;
        let lateral: Vec<f64> = path
            .iter()
            .zip(&speeds_mps)
            .map(|(point, speed)| point.curvature_per_m * speed * speed)
            .collect();
        let mut stream = Stream::new(seed, 0x5355_5350);
        let rms_rad = conditions.suspension_rms_rad;
        Ok(Self {
            lengthwise_mps2: running_mean(&accelerations, half),
            lateral_mps2: running_mean(&lateral, half),
            path,
            along_m,
            speeds_mps,
            times_s,
            stood_s,
            springs: [Spring::new(&mut stream, rms_rad), Spring::new(&mut stream, rms_rad)],
            rad_per_mps2: conditions.suspension_rad_per_mps2,
        })
    }

    /// How long the drive takes, seconds.
    pub(crate) fn duration_s(&self) -> f64 {
        self.times_s[self.times_s.len() - 1]
    }

    /// Distances along the route, metres, with the times at which they are reached, seconds.
    pub(crate) fn clock(&self) -> Vec<(f64, f64)> {
        self.path.iter().zip(&self.times_s).map(|(point, t_s)| (point.route_m, *t_s)).collect()
    }

    /// How far along the route one that drives alike is `t_s` seconds after its start, metres; after the drive it goes on.
    pub(crate) fn route_m_at(&self, t_s: f64) -> f64 {
        let state = self.at(t_s);
        state.route_m + state.speed_mps * (t_s - self.duration_s()).max(0.0)
    }

    /// The vehicle `t_s` seconds after its start; clamped to the drive.
    pub(crate) fn at(&self, t_s: f64) -> VehicleState {
        let t_s = t_s.clamp(0.0, self.duration_s());
        let i = self.times_s.partition_point(|&time| time <= t_s).clamp(1, self.path.len() - 1) - 1;
        let (elapsed_s, step_s) = (t_s - self.times_s[i], self.times_s[i + 1] - self.times_s[i]);
        let acceleration = (self.speeds_mps[i + 1] - self.speeds_mps[i]) / step_s;
        let gone_m = self.speeds_mps[i] * elapsed_s + 0.5 * acceleration * elapsed_s * elapsed_s;
        let piece_m = self.along_m[i + 1] - self.along_m[i];
        let share = if piece_m > 0.0 { (gone_m / piece_m).clamp(0.0, 1.0) } else { 0.0 };
        let (a, b) = (&self.path[i], &self.path[i + 1]);
        let blend = |from: f64, to: f64| from + (to - from) * share;
        let speed_mps = self.speeds_mps[i] + acceleration * elapsed_s;
        // No road shakes a vehicle that stands.
        let stands = self.stood_s[i + 1] > self.stood_s[i];
        let moved_s = t_s - self.stood_s[i] - if stands { elapsed_s } else { 0.0 };
        let lengthwise = blend(self.lengthwise_mps2[i], self.lengthwise_mps2[i + 1]);
        let lateral = blend(self.lateral_mps2[i], self.lateral_mps2[i + 1]);
        let [pitch_rad, roll_rad] = self.body_rad(moved_s, lengthwise, lateral);
        VehicleState {
            p_in_map: a.p_in_map + (b.p_in_map - a.p_in_map) * share,
            heading_rad: wrap_angle(a.heading_rad + wrap_angle(b.heading_rad - a.heading_rad) * share),
            speed_mps,
            yaw_rate_rps: speed_mps * blend(a.curvature_per_m, b.curvature_per_m),
            route_m: blend(a.route_m, b.route_m),
            pitch_rad,
            roll_rad,
        }
    }

    /// Pitch and roll of the body, radians, after `moved_s` seconds of driving, at these accelerations along and across it
    /// (to the left), m/s2.
    pub(crate) fn body_rad(&self, moved_s: f64, lengthwise_mps2: f64, lateral_mps2: f64) -> [f64; 2] {
        let [pitch_spring, roll_spring] = self.springs.map(|spring| spring.angle_rad(moved_s));
        // Braking dips the nose; in a left bend the body leans right, its left side up.
        [pitch_spring - self.rad_per_mps2 * lengthwise_mps2, roll_spring + self.rad_per_mps2 * lateral_mps2]
    }

    /// Where along the route the drive begins, metres.
    pub(crate) fn start_m(&self) -> f64 {
        self.path[0].route_m
    }

    /// Where along the route the drive ends, metres.
    pub(crate) fn end_m(&self) -> f64 {
        self.path[self.path.len() - 1].route_m
    }
}

/// Doubles the points at which the vehicle stands. For each point of the path the seconds of standing that lead to it.
fn insert_stops(path: &mut Vec<PathPoint>, stops: &[(f64, f64)]) -> Vec<Option<f64>> {
    let mut stands_s = vec![None; path.len()];
    for &(at_m, for_s) in stops {
        let i = path.partition_point(|point| point.route_m < at_m);
        // A stop at either end is a drive that starts later or ends sooner.
        if (1..path.len() - 1).contains(&i) && stands_s[i].is_none() && for_s > 0.0 {
            path.insert(i, path[i]);
            stands_s.insert(i + 1, Some(for_s));
        }
    }
    stands_s
}

fn speed_profile(path: &[PathPoint], along_m: &[f64], stands_s: &[Option<f64>], cruise_mps: f64) -> Vec<f64> {
    let slowest = CRAWL_MPS.min(cruise_mps);
    let mut speeds: Vec<f64> = path
        .iter()
        .map(|point| {
            let curvature = point.curvature_per_m.abs().max(1e-6);
            (LATERAL_MPS2 / curvature).sqrt().clamp(slowest, cruise_mps)
        })
        .collect();
    for i in (1..speeds.len()).filter(|&i| stands_s[i].is_some()) {
        (speeds[i - 1], speeds[i]) = (0.0, 0.0);
    }
    for i in 1..speeds.len() {
        let step_m = along_m[i] - along_m[i - 1];
        speeds[i] = speeds[i].min((speeds[i - 1].powi(2) + 2.0 * SPEED_UP_MPS2 * step_m).sqrt());
    }
    for i in (1..speeds.len()).rev() {
        let step_m = along_m[i] - along_m[i - 1];
        speeds[i - 1] = speeds[i - 1].min((speeds[i].powi(2) + 2.0 * BRAKE_MPS2 * step_m).sqrt());
    }
    speeds
}

fn running_mean(values: &[f64], half: usize) -> Vec<f64> {
    (0..values.len())
        .map(|i| {
            let window = &values[i.saturating_sub(half)..(i + half + 1).min(values.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 60 m straight on, then a left bend of 7 m radius.
    fn path() -> Vec<PathPoint> {
        (0..900)
            .map(|i| {
                let s = 0.1 * f64::from(i);
                let turned = ((s - 60.0) / 7.0).max(0.0);
                let p_in_map = if s < 60.0 {
                    Point2::new(s, 0.0)
                } else {
                    Point2::new(60.0 + 7.0 * libm::sin(turned), 7.0 * (1.0 - libm::cos(turned)))
                };
                let curvature_per_m = if s < 60.0 { 0.0 } else { 1.0 / 7.0 };
                PathPoint { p_in_map, heading_rad: turned, curvature_per_m, route_m: s }
            })
            .collect()
    }

    #[test]
    fn slow_in_bends_and_within_all_limits() {
        let drive = Drive::new(path(), &[], 8.0, &Conditions::CLEAR, 1).unwrap();
        let mut last: Option<VehicleState> = None;
        for i in 0..(drive.duration_s() * 100.0) as usize {
            let state = drive.at(i as f64 * 0.01);
            assert!(state.speed_mps * state.yaw_rate_rps <= 2.5);
            if let Some(last) = last {
                assert!((state.speed_mps - last.speed_mps).abs() <= 0.0151, "within 1.5 m/s2");
                let mean = 0.5 * (state.speed_mps + last.speed_mps);
                assert!(((state.p_in_map - last.p_in_map).norm() - 0.01 * mean).abs() < 2e-4);
            }
            last = Some(state);
        }
        assert!(drive.at(drive.duration_s()).speed_mps < 4.1);
    }

    #[test]
    fn one_that_drives_ahead_is_never_reached() {
        let drive = Drive::new(path(), &[], 8.0, &Conditions::CLEAR, 1).unwrap();
        let end_s = drive.duration_s();
        for t_s in [0.0, 0.5 * end_s, end_s - 1.0, end_s] {
            let between_m = drive.route_m_at(t_s + 2.0) - drive.route_m_at(t_s);
            assert!(between_m > 7.0, "{between_m} m at {t_s} s");
        }
    }

    #[test]
    fn signs_of_the_body_motion() {
        let conditions = Conditions { suspension_rms_rad: 0.0, ..Conditions::ROUGH };
        let drive = Drive::new(path(), &[], 8.0, &conditions, 1).unwrap();
        let when = |route_m: f64| {
            (0..20_000).map(|i| drive.at(f64::from(i) * 0.001)).find(|s| s.route_m >= route_m).unwrap()
        };
        assert!(when(52.0).pitch_rad > 0.003, "braking before the bend dips the nose");
        assert!(when(70.0).roll_rad > 0.003, "a left bend lifts the left side");
    }

    #[test]
    fn a_rigid_body_keeps_still() {
        let drive = Drive::new(path(), &[], 8.0, &Conditions::IDEAL, 1).unwrap();
        let state = drive.at(7.0);
        assert!(state.pitch_rad.abs() < 1e-12 && state.roll_rad.abs() < 1e-12);
    }

    #[test]
    fn a_stop_is_a_standstill_of_its_length_at_its_place() {
        let drive = Drive::new(path(), &[(30.0, 4.0)], 8.0, &Conditions::IDEAL, 1).unwrap();
        let without = Drive::new(path(), &[], 8.0, &Conditions::IDEAL, 1).unwrap();
        let states: Vec<VehicleState> =
            (0..(drive.duration_s() * 100.0) as usize).map(|i| drive.at(i as f64 * 0.01)).collect();
        let standing: Vec<&VehicleState> = states.iter().filter(|state| state.speed_mps < 1e-9).collect();
        assert!((398..=402).contains(&standing.len()), "{} hundredths of a second", standing.len());
        assert!(standing.iter().all(|state| (state.route_m - 30.0).abs() < 0.11));
        for pair in states.windows(2) {
            assert!((pair[1].speed_mps - pair[0].speed_mps).abs() <= 0.0151, "within 1.5 m/s2");
        }
        assert!(drive.duration_s() > without.duration_s() + 4.0);
        assert!(states.iter().all(|state| state.p_in_map.x.is_finite()));
    }
}
