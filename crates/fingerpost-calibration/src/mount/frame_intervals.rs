//! How long each frame of a drive took, as well as its stamps say.

/// Intervals that differ by less are the same: files state times in microseconds at the finest.
const SAME_S: f64 = 1e-6;

/// Seconds from each frame to the next, of which there is one less than of frames.
///
/// Stamps of a coarse clock jump about the times that they stand for: 0.12 s and 0.08 s are tenths of a second in ticks of 0.04 s. Each
/// stamp is moved by at most half a tick towards the middle of its neighbours, which is where an even drive has it; stamps of a fine
/// clock stay where they are.
pub(super) fn frame_intervals_s(stamps_s: &[f64]) -> Vec<f64> {
    let half_tick_s = 0.5 * tick_s(stamps_s);
    let mut times_s = stamps_s.to_vec();
    for (time_s, near) in times_s.iter_mut().skip(1).zip(stamps_s.windows(3)) {
        let change_s = 0.25 * (near[0] - 2.0 * near[1] + near[2]);
        *time_s += change_s.clamp(-half_tick_s, half_tick_s);
    }
    times_s.windows(2).map(|pair| (pair[1] - pair[0]).max(0.0)).collect()
}

/// Tick of the clock that the stamps are of, seconds, zero where all intervals are the same: intervals differ by whole ticks, and of
/// many that differ some do so by a single one.
fn tick_s(stamps_s: &[f64]) -> f64 {
    let mut intervals_s: Vec<f64> = stamps_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals_s.sort_unstable_by(f64::total_cmp);
    let differences_s = intervals_s.windows(2).map(|pair| pair[1] - pair[0]);
    differences_s.filter(|difference_s| *difference_s > SAME_S).min_by(f64::total_cmp).unwrap_or(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Stamps of frames that lie so many seconds apart, by a clock of such ticks.
    fn stamps_s(intervals_s: &[f64], tick_s: f64) -> Vec<f64> {
        let mut at_s = 0.0;
        let rest = intervals_s.iter().map(|interval_s| {
            at_s += interval_s;
            tick_s * libm::floor(at_s / tick_s + 0.5)
        });
        std::iter::once(0.0).chain(rest).collect()
    }

    #[test]
    fn stamps_of_a_coarse_clock_give_the_intervals_that_they_stand_for() {
        // Ten frames a second, a third as many for a while, and ten again.
        let intervals_s = [[0.1; 30], [0.3; 30], [0.1; 30]].concat();
        for tick_s in [0.04, 0.03, 0.01, 1e-3, 1.0 / 90_000.0] {
            let found_s = frame_intervals_s(&stamps_s(&intervals_s, tick_s));
            let far = found_s
                .iter()
                .zip(&intervals_s)
                .filter(|(found, wanted)| (*found / *wanted - 1.0).abs() > 0.15);
            // Where the rate changes, and at both ends, half a tick is left.
            assert!(far.count() <= 6, "{tick_s}: {found_s:?}");
            let whole_s: f64 = found_s.iter().sum();
            assert!((whole_s - 15.0).abs() <= tick_s, "{tick_s}: {whole_s} s");
        }
    }

    #[test]
    fn stamps_of_a_fine_clock_are_kept() {
        let uneven_s: Vec<f64> = (0..200).map(|i| 0.05 + 1e-4 * f64::from(i * i % 997)).collect();
        let found_s = frame_intervals_s(&stamps_s(&uneven_s, 1e-5));
        for (found_s, wanted_s) in found_s.iter().zip(&uneven_s) {
            assert!((found_s - wanted_s).abs() < 2e-4, "{found_s} s for {wanted_s}");
        }
        assert!(frame_intervals_s(&[]).is_empty() && frame_intervals_s(&[1.0]).is_empty());
        assert_eq!(frame_intervals_s(&[1.0, 1.0, 0.5]), [0.0, 0.0]);
    }
}
