//! Whether the measured speed is to be believed.
//!
//! A speed that sticks at a value, or drops to zero, while the vehicle drives on is a hypothesis beside that of a sensor that lives:
//! a hidden Markov model of two states. A sensor that lives repeats a value to the last digit as often as it has done so far, and
//! its values change no faster than tyres hold; one at zero says that the vehicle does not turn. One that lies repeats itself, and may
//! say anything else. Where it lies, the vehicle goes on about as fast as it last was.

use std::f64::consts::TAU;

use crate::odometry::MotionSample;

/// Rate at which a sensor that lives begins to lie, 1/s: once in ten hours of driving; and at which one that lies lives again, as
/// after ten seconds of a lost bus. Judgements.
const BEGINS_PER_S: f64 = 1.0 / 36_000.0;
const ENDS_PER_S: f64 = 0.1;
/// Standard deviation of the acceleration, m/s²: full braking on a dry road, 8 to 10, is three of it.
const ACCELERATION_MPS2: f64 = 3.0;
/// White noise of a speed, m/s.
const NOISE_MPS: f64 = 0.2;
/// Probability that a sensor that lies repeats its value.
const STUCK_REPEATS: f64 = 0.98;
/// Range over which what it says otherwise lies, m/s: what cars drive.
const ANY_MPS: f64 = 60.0;
/// Standard deviation of a speed that is not measured, as a part of what it last was, or of a town's: that of anything from standing to
/// twice as much.
const UNKNOWN_SIGMA: f64 = 0.58;
const TOWN_MPS: f64 = 10.0;
/// Standard deviation of a yaw rate at standstill, rad/s: bias and noise of a MEMS gyroscope, 0.2 degrees a second.
const STANDING_RPS: f64 = 3.5e-3;
/// And that of a vehicle in traffic: a bend of 100 m at 10 m/s.
const MOVING_RPS: f64 = 0.1;
/// Weight of the first guess of how often a value repeats, rows.
const GUESS_ROWS: f64 = 2.0;

/// The speed that the vehicle has by all that is believed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Speed {
    /// Mean, m/s.
    pub(crate) mps: f64,
    /// Variance of the distance of this row beside the scale's, square metres.
    pub(crate) distance_variance_m2: f64,
}

/// A speed sensor's history.
#[derive(Debug, Clone, Default)]
pub(crate) struct Speedometer {
    before_mps: f64,
    has_repeated: bool,
    /// Rows after a value that changed and after one that repeated, and those of them that repeated, while the sensor lived.
    rows: [f64; 2],
    repeats: [f64; 2],
    /// Probability that it lies.
    lies: f64,
    lies_for_s: f64,
    /// Speed that was last believed, m/s.
    believed_mps: f64,
    /// Standard deviation of the distance driven while it lied, metres.
    unknown_m: f64,
}

impl Speedometer {
    /// Probability that the sensor lies.
    pub(crate) const fn lies(&self) -> f64 {
        self.lies
    }

    /// Begins with a row, or goes on after a gap, in which the vehicle may have done anything.
    pub(crate) fn go_on_after_gap(&mut self, row: &MotionSample) {
        (self.before_mps, self.believed_mps) = (row.speed_mps, row.speed_mps);
        (self.has_repeated, self.lies, self.lies_for_s, self.unknown_m) = (false, 0.0, 0.0, 0.0);
    }

    /// Takes in a row, `time_s` after the one before.
    pub(crate) fn take(&mut self, row: &MotionSample, time_s: f64) -> Speed {
        let mps = row.speed_mps;
        let before_mps = std::mem::replace(&mut self.before_mps, mps);
        let repeats = mps.total_cmp(&before_mps).is_eq();
        let stands = mps.abs() <= f64::MIN_POSITIVE;
        let repeats_alive = self.repeats_alive();
        let alive = |about_mps: f64, variance: f64| {
            let fit = libm::exp(-0.5 * (mps - about_mps).powi(2) / variance);
            let value = match (repeats, stands) {
                (true, true) => fit,
                (true, false) => repeats_alive * fit,
                (false, _) => (1.0 - repeats_alive) * fit / (TAU * variance).sqrt(),
            };
            if stands { value * stands_by_yaw(row.yaw_rate_rps) } else { value }
        };
        let unknown_mps =
            (ACCELERATION_MPS2 * self.lies_for_s).min(UNKNOWN_SIGMA * self.believed_mps.abs().max(TOWN_MPS));
        let change = (ACCELERATION_MPS2 * time_s).powi(2) + 2.0 * NOISE_MPS.powi(2);
        let goes_on = alive(before_mps, change);
        let comes_back = alive(self.believed_mps, change + unknown_mps.powi(2));
        let lying = if repeats { STUCK_REPEATS } else { (1.0 - STUCK_REPEATS) / ANY_MPS };
        let (begins, ends) = ((BEGINS_PER_S * time_s).min(0.5), (ENDS_PER_S * time_s).min(0.5));
        let lives = (1.0 - self.lies) * (1.0 - begins) * goes_on + self.lies * ends * comes_back;
        let lies = ((1.0 - self.lies) * begins + self.lies * (1.0 - ends)) * lying;
        self.lies = lies / (lives + lies).max(f64::MIN_POSITIVE);

        if !stands {
            let after = usize::from(self.has_repeated);
            self.rows[after] += 1.0 - self.lies;
            self.repeats[after] += f64::from(u8::from(repeats)) * (1.0 - self.lies);
        }
        self.has_repeated = repeats;
        self.lies_for_s = self.lies * (self.lies_for_s + time_s);
        self.believed_mps = mps + self.lies * (self.believed_mps - mps);
        let more_m = self.unknown_m + self.lies * unknown_mps * time_s;
        let distance_variance_m2 = more_m.powi(2) - self.unknown_m.powi(2);
        self.unknown_m = self.lies * more_m;
        Speed { mps: self.believed_mps, distance_variance_m2 }
    }

    /// Probability that the next value of a sensor that lives repeats the last one.
    fn repeats_alive(&self) -> f64 {
        let after_change = (self.repeats[0] + 1.0) / (self.rows[0] + GUESS_ROWS);
        if self.has_repeated {
            (self.repeats[1] + GUESS_ROWS * after_change) / (self.rows[1] + GUESS_ROWS)
        } else {
            after_change
        }
    }
}

/// How probable a yaw rate is at standstill against that of a vehicle that moves; at most 1, as many drive straight on.
fn stands_by_yaw(yaw_rate_rps: f64) -> f64 {
    let per_rps = |sigma_rps: f64| libm::exp(-0.5 * (yaw_rate_rps / sigma_rps).powi(2)) / sigma_rps;
    (per_rps(STANDING_RPS) / per_rps(MOVING_RPS).max(f64::MIN_POSITIVE)).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    const ROW_S: f64 = 0.1;

    /// Drives through rows of speed and yaw rate, gives the probability of a lie after each, and the distances by what is believed.
    fn lies(rows: impl IntoIterator<Item = (f64, f64)>) -> (Vec<f64>, f64) {
        let mut speedometer = Speedometer::default();
        let (mut lies, mut driven_m) = (Vec::new(), 0.0);
        for (speed_mps, yaw_rate_rps) in rows {
            let row = MotionSample { t_s: 0.0, speed_mps, yaw_rate_rps };
            if lies.is_empty() {
                speedometer.go_on_after_gap(&row);
            } else {
                driven_m += ROW_S * speedometer.take(&row, ROW_S).mps;
            }
            lies.push(speedometer.lies());
        }
        (lies, driven_m)
    }

    /// A drive of two minutes at 5 to 15 m/s whose speed is rounded to a step, with noise of 0.1 m/s before it.
    fn rounded(step_mps: f64) -> Vec<(f64, f64)> {
        let mut random = Random::new(1);
        (0..1200)
            .map(|row| {
                10.0 + 5.0 * libm::sin(f64::from(row) / 150.0) + 0.2 * (random.unit() + random.unit() - 1.0)
            })
            .map(|mps| ((mps / step_mps).round() * step_mps, 0.01))
            .collect()
    }

    fn share_in_doubt(lies: &[f64]) -> f64 {
        lies.iter().filter(|lies| **lies > 1e-3).count() as f64 / lies.len() as f64
    }

    #[test]
    fn a_speed_that_lives_is_believed_whatever_its_digits() {
        for step_mps in [1e-6, 0.01, 0.03, 0.1] {
            let (lies, _) = lies(rounded(step_mps));
            assert!(lies.iter().all(|lies| *lies < 0.5), "{step_mps}");
            assert!(share_in_doubt(&lies) < 0.05, "{step_mps}: {}", share_in_doubt(&lies));
        }
        // A log with ten rows for each value of its bus.
        let ten_times = rounded(1e-6).into_iter().step_by(10).flat_map(|row| std::iter::repeat_n(row, 10));
        let (lies, _) = lies(ten_times);
        assert!(lies.iter().skip(200).all(|lies| *lies < 0.5));
    }

    #[test]
    fn a_speed_that_sticks_is_noticed_within_three_rows_and_believed_again_once_it_lives() {
        let mut rows = rounded(1e-6);
        let stuck_mps = rows[600].0;
        rows[600..800].iter_mut().for_each(|row| row.0 = stuck_mps);
        let (lies, _) = lies(rows);
        assert!(lies[599] < 1e-3 && lies[603] > 0.5, "{} {}", lies[599], lies[603]);
        assert!(lies[603..800].iter().all(|lies| *lies > 0.5));
        assert!(lies[810] < 1e-3, "{}", lies[810]);
    }

    #[test]
    fn a_speed_that_drops_to_zero_is_passed_over() {
        let mut rows: Vec<(f64, f64)> = rounded(1e-6);
        rows[600..650].iter_mut().for_each(|row| row.0 = 0.0);
        let true_m: f64 = ROW_S * rounded(1e-6)[1..].iter().map(|row| row.0).sum::<f64>();
        let (lies, driven_m) = lies(rows);
        assert!(lies[600..650].iter().all(|lies| *lies > 0.5) && lies[660] < 1e-3);
        assert!((driven_m - true_m).abs() < 15.0, "{driven_m} {true_m}");
    }

    #[test]
    fn a_vehicle_that_brakes_and_stands_is_believed_unless_it_turns() {
        // At 8 m/s² to a standstill, and a minute there.
        let speeds = (0..700)
            .map(|row| (10.0 + 1e-3 * f64::from(row % 7) - 0.8 * f64::from((row - 60).max(0))).max(0.0));
        let (standing, driven_m) = lies(speeds.clone().map(|mps| (mps, 0.002)));
        assert!(
            standing.iter().all(|lies| *lies < 1e-3),
            "{:?}",
            standing.iter().copied().fold(0.0, f64::max)
        );
        assert!((driven_m - 65.8).abs() < 1.0, "{driven_m}");
        let (turning, _) =
            lies(speeds.enumerate().map(|(row, mps)| (mps, if row > 300 { 0.1 } else { 0.002 })));
        assert!(turning[310] > 0.5);
    }
}
