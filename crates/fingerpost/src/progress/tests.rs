//! The belief against drives whose truth is known.

mod features;
mod gps;
mod motion;
mod simulated;

use super::*;

const ROUTE_M: f64 = 2000.0;
/// A feature that is plainly seen.
const PLAIN: f64 = 1000.0;

fn config() -> RouteProgressConfig {
    RouteProgressConfig::default()
}

fn started(start_m: f64) -> Progress {
    Progress::new(&config(), Some(start_m), ROUTE_M)
}

fn unknown() -> Progress {
    Progress::new(&config(), None, ROUTE_M)
}

/// Drives at 10 m/s, by steps of half a metre.
fn drive(progress: &mut Progress, metres: f64) {
    for _ in 0..(metres / 0.5).round() as usize {
        progress.advance(Travel::Measured { forward_m: 0.5, sigma_m: 0.01 }, 0.05);
    }
}

/// Conditions on a feature that is seen `ahead_m` before the vehicle, or not at all, where the ground is seen up to 40 m ahead.
fn look(progress: &Progress, feature_m: f64, ahead_m: Option<f64>) -> Progress {
    let place = ahead_m.map(|ahead_m| FeaturePlace { likelihood: PLAIN, ahead_m, sigma_m: 0.7 });
    let outcome = FeatureOutcome {
        places: place.as_slice(),
        looked_for_m: Some([-20.0, 40.0]),
        map_wrong_share: 0.02,
        log_excess: 0.0,
    };
    progress.conditioned(feature_m, &outcome)
}

/// Probability within 3 m of `route_m`.
fn near(progress: &Progress, route_m: f64) -> f64 {
    progress.probability_between(route_m - 3.0, route_m + 3.0)
}

/// The weights add up to 1, every number is finite, and no uncertainty is zero.
fn assert_sound(progress: &Progress) {
    let parts: Vec<_> = progress.components().collect();
    let total = parts.iter().map(|part| part.weight).sum::<f64>() + progress.elsewhere();
    assert!((total - 1.0).abs() < 1e-9, "{total}");
    assert!(parts.len() <= CAPACITY);
    assert!(parts.iter().all(|part| part.mean_m.is_finite() && part.sigma_m.is_finite()), "{parts:?}");
    assert!(parts.iter().all(|part| part.weight > 0.0 && part.sigma_m > 0.0), "{parts:?}");
    assert!(parts.is_sorted_by(|a, b| a.weight >= b.weight), "{parts:?}");
    let (mean_m, sigma_m) = progress.moments_m();
    assert!(mean_m.is_finite() && sigma_m.is_finite() && sigma_m > 0.0, "{mean_m} {sigma_m}");
}

/// Numbers that follow from a seed (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn uniform(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((bits ^ (bits >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        from + (to - from) * self.uniform()
    }

    fn normal(&mut self) -> f64 {
        (-2.0 * libm::log(1.0 - self.uniform())).sqrt() * libm::cos(std::f64::consts::TAU * self.uniform())
    }
}
