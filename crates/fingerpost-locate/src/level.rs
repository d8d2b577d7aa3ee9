//! Protection levels: how far from a place the vehicle is with no more than a stated probability.

use std::f64::consts::{FRAC_1_SQRT_2, TAU};

use nalgebra::{Matrix2, Vector2};

/// A part of a mixture about a place.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// Its probability.
    pub(crate) mass: f64,
    /// Its mean, from the place, metres.
    pub(crate) off_m: Vector2<f64>,
    /// Its covariance, square metres.
    pub(crate) covariance: Matrix2<f64>,
}

/// Steps of the integral along a part's lesser axis.
const STEPS: usize = 48;
/// Reach of the integral, standard deviations; 1e-9 of a normal distribution lie beyond.
const REACH_SIGMAS: f64 = 6.0;
/// Halvings of the search for the level: a kilometre down to less than a centimetre.
const HALVINGS: usize = 17;
/// Greatest level that is looked for, metres.
const FARTHEST_M: f64 = 1000.0;

/// The radius outside which the parts, and what is `elsewhere`, have the probability `risk`; `None` where that is more than a
/// kilometre.
pub(crate) fn protection_level_m(parts: &[Part], elsewhere: f64, risk: f64) -> Option<f64> {
    let outside = |radius_m: f64| parts.iter().map(|part| part.mass * part.outside(radius_m)).sum::<f64>();
    if elsewhere + outside(FARTHEST_M) > risk {
        return None;
    }
    let (mut low_m, mut high_m) = (0.0, FARTHEST_M);
    for _ in 0..HALVINGS {
        let middle_m = 0.5 * (low_m + high_m);
        if elsewhere + outside(middle_m) > risk { low_m = middle_m } else { high_m = middle_m }
    }
    Some(high_m)
}

impl Part {
    /// The probability of being farther than a radius from the place, given this part.
    fn outside(&self, radius_m: f64) -> f64 {
        let axes = self.covariance.symmetric_eigen();
        let greater = usize::from(axes.eigenvalues[1] > axes.eigenvalues[0]);
        let sigmas_m = axes.eigenvalues.map(|variance| variance.max(1e-12).sqrt());
        let (along_m, across_m) = (sigmas_m[greater], sigmas_m[1 - greater]);
        let along = axes.eigenvectors.column(greater).dot(&self.off_m);
        let across = axes.eigenvectors.column(1 - greater).dot(&self.off_m);
        let step = 2.0 * REACH_SIGMAS / STEPS as f64;
        let mut inside = 0.0;
        for i in 0..STEPS {
            let unit = -REACH_SIGMAS + (i as f64 + 0.5) * step;
            let at_m = across + unit * across_m;
            let squared_m2 = radius_m * radius_m - at_m * at_m;
            if squared_m2 > 0.0 {
                let half_m = squared_m2.sqrt();
                let tails = [-half_m, half_m].map(|end_m| upper_tail((end_m - along) / along_m));
                inside += libm::exp(-0.5 * unit * unit) * (tails[0] - tails[1]);
            }
        }
        // The midpoint rule's sum of the density alone, so that all of it inside is exactly one.
        let whole: f64 = (0..STEPS)
            .map(|i| (-REACH_SIGMAS + (i as f64 + 0.5) * step).powi(2))
            .map(|u| libm::exp(-0.5 * u))
            .sum();
        debug_assert!((whole * step - TAU.sqrt()).abs() < 1e-3);
        (1.0 - inside / whole).max(0.0)
    }
}

/// The probability that a standard normal number exceeds `x`.
fn upper_tail(x: f64) -> f64 {
    0.5 * libm::erfc(x * FRAC_1_SQRT_2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_round_part_has_rayleighs_level() {
        let part = Part { mass: 1.0, off_m: Vector2::zeros(), covariance: Matrix2::identity() * 4.0 };
        let level_m = protection_level_m(&[part], 0.0, 1e-3).unwrap();
        assert!((level_m - 2.0 * (2.0 * libm::log(1000.0)).sqrt()).abs() < 0.03, "{level_m}");
    }

    #[test]
    fn a_long_part_has_the_level_of_its_axis() {
        let part = Part { mass: 1.0, off_m: Vector2::zeros(), covariance: Matrix2::new(1e-4, 0.0, 0.0, 9.0) };
        let level_m = protection_level_m(&[part], 0.0, 1e-3).unwrap();
        assert!((level_m - 3.0 * 3.2905).abs() < 0.05, "{level_m}");
    }

    #[test]
    fn mass_elsewhere_makes_the_level_larger_and_then_none() {
        let part = Part { mass: 0.9995, off_m: Vector2::zeros(), covariance: Matrix2::identity() };
        let level_m = protection_level_m(&[part], 5e-4, 1e-3).unwrap();
        assert!((level_m - (2.0 * libm::log(2000.0)).sqrt()).abs() < 0.03, "{level_m}");
        assert_eq!(protection_level_m(&[part], 1.1e-3, 1e-3), None);
    }

    #[test]
    fn a_rival_beside_is_inside_when_the_level_reaches_it() {
        let part = |mass: f64, x: f64| Part {
            mass,
            off_m: Vector2::new(x, 0.0),
            covariance: Matrix2::identity() * 0.01,
        };
        let level_m = protection_level_m(&[part(0.9, 0.0), part(0.1, 12.0)], 0.0, 1e-3).unwrap();
        assert!((12.0..12.4).contains(&level_m), "{level_m}");
    }
}
