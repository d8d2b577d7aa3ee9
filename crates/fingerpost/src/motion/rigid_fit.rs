//! The rigid motion of the plane behind a field of displacements.
//!
//! Weighted orthogonal Procrustes in closed form, re-weighted by Tukey's biweight until the outliers (kerbs, parked
//! cars, shadows that move with the vehicle) have no say.

use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

/// A place on the road before and after, vehicle frame, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    pub(super) previous: Point2<f64>,
    pub(super) current: Point2<f64>,
    pub(super) weight: f64,
}

/// A fitted motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct RigidFit {
    pub(super) current_from_previous: Isometry2<f64>,
    /// Root mean square of the accepted residuals, metres.
    pub(super) residual_m: f64,
    /// Share of the pairs that were accepted.
    pub(super) accepted: f64,
    /// Covariance of the vehicle's new pose in the old frame if `independent` pairs were independent.
    pub(super) covariance: Matrix3<f64>,
}

const ITERATIONS: usize = 8;
/// Tukey's constant: 95 % efficiency on Gaussian residuals.
const TUKEY: f64 = 4.685;
/// Median absolute deviation to standard deviation of a Gaussian.
const MAD_TO_SIGMA: f64 = 1.4826;

/// Fits the motion, leaving each pair's final weight in it; none for fewer than three pairs.
///
/// `scale_floor_m` keeps the re-weighting from rejecting pairs over differences below the flow's own accuracy;
/// `independent` is how many of the pairs count as independent measurements.
pub(super) fn fit(pairs: &mut [Pair], scale_floor_m: f64, independent: f64) -> Option<RigidFit> {
    if pairs.len() < 3 {
        return None;
    }
    let mut motion = procrustes(pairs)?;
    let mut residuals = Vec::with_capacity(pairs.len());
    for _ in 0..ITERATIONS {
        residuals.clear();
        residuals.extend(pairs.iter().map(|pair| (motion * pair.previous - pair.current).norm()));
        let mut sorted = residuals.clone();
        sorted.sort_unstable_by(f64::total_cmp);
        let scale = (MAD_TO_SIGMA * sorted[sorted.len() / 2]).max(scale_floor_m);
        for (pair, residual) in pairs.iter_mut().zip(&residuals) {
            let x = residual / (TUKEY * scale);
            pair.weight = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
        }
        motion = procrustes(pairs)?;
    }
    let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
    let squares: f64 =
        pairs.iter().map(|pair| pair.weight * (motion * pair.previous - pair.current).norm_squared()).sum();
    let residual_m = (squares / total).sqrt();
    let accepted = pairs.iter().filter(|pair| pair.weight > 0.5).count() as f64 / pairs.len() as f64;
    let covariance =
        covariance(pairs, &motion, residual_m.max(scale_floor_m), independent * accepted.max(0.05));
    Some(RigidFit { current_from_previous: motion, residual_m, accepted, covariance })
}

fn procrustes(pairs: &[Pair]) -> Option<Isometry2<f64>> {
    let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
    if total <= 0.0 {
        return None;
    }
    let mean = |place: fn(&Pair) -> Point2<f64>| -> Vector2<f64> {
        pairs.iter().map(|pair| place(pair).coords * pair.weight).sum::<Vector2<f64>>() / total
    };
    let (before, after) = (mean(|pair| pair.previous), mean(|pair| pair.current));
    let (mut cosine, mut sine) = (0.0, 0.0);
    for pair in pairs {
        let (a, b) = (pair.previous.coords - before, pair.current.coords - after);
        cosine += pair.weight * a.dot(&b);
        sine += pair.weight * a.perp(&b);
    }
    let rotation = Isometry2::rotation(sine.atan2(cosine));
    let moved = rotation * before;
    Some(Isometry2::new(after - moved, rotation.rotation.angle()))
}

fn covariance(pairs: &[Pair], motion: &Isometry2<f64>, sigma_m: f64, independent: f64) -> Matrix3<f64> {
    let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
    let middle: Vector2<f64> =
        pairs.iter().map(|pair| pair.previous.coords * pair.weight).sum::<Vector2<f64>>() / total;
    let spread: f64 =
        pairs.iter().map(|pair| pair.weight * (pair.previous.coords - middle).norm_squared()).sum::<f64>()
            / total;
    let per_axis = 0.5 * sigma_m * sigma_m / independent;
    let yaw = sigma_m * sigma_m / (independent * spread.max(1e-6));
    // At the middle of the region translation and rotation are independent; the vehicle's origin is a lever away.
    let lever = motion * Point2::from(middle);
    let origin_from_middle = Matrix3::new(1.0, 0.0, lever.y, 0.0, 1.0, -lever.x, 0.0, 0.0, 1.0);
    let at_middle = Matrix3::from_diagonal(&nalgebra::Vector3::new(per_axis, per_axis, yaw));
    origin_from_middle * at_middle * origin_from_middle.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pairs(motion: Isometry2<f64>) -> Vec<Pair> {
        (0..200)
            .map(|i| {
                let previous = Point2::new(4.0 + 0.05 * f64::from(i), 3.0 * f64::from(i % 7) / 7.0 - 1.5);
                Pair { previous, current: motion * previous, weight: 1.0 }
            })
            .collect()
    }

    #[test]
    fn a_rigid_motion_is_found_among_outliers() {
        let motion = Isometry2::new(Vector2::new(-0.8, 0.05), -0.03);
        let mut pairs = pairs(motion);
        for pair in pairs.iter_mut().step_by(4) {
            pair.current.y += 0.7;
        }
        let fit = fit(&mut pairs, 0.005, 50.0).unwrap();
        assert!((fit.current_from_previous.translation.vector - motion.translation.vector).norm() < 1e-6);
        assert!((fit.current_from_previous.rotation.angle() + 0.03).abs() < 1e-7);
        assert!((fit.accepted - 0.75).abs() < 0.01, "a quarter are outliers: {}", fit.accepted);
        assert!(fit.covariance.symmetric_eigenvalues().min() > 0.0, "never certain");
    }

    #[test]
    fn too_few_pairs_are_no_motion() {
        assert!(fit(&mut pairs(Isometry2::identity())[..2], 0.005, 50.0).is_none());
    }
}
