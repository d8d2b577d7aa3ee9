//! The rigid motion of the plane behind a field of displacements, and the body's sway beside it.
//!
//! Six unknowns: the motion (forward, left, yaw) and the [sway](super::sway); only the motion is wanted.
//!
//! Gauss-Newton, re-weighted by Tukey's biweight until outliers (kerbs, parked cars, shadows that move with the
//! vehicle) have no say; it starts from the weighted orthogonal Procrustes solution.

use fingerpost::ground_view::Viewpoint;
use nalgebra::{Isometry2, Matrix2x3, Matrix3, Point2, SMatrix, SVector, Vector2};

use super::sway::{SWAY_SIGMA_RAD, sway_field};

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

/// Memory of the residuals' sizes, metres, reused from fit to fit.
#[derive(Debug, Default)]
pub(super) struct Residuals {
    of_pairs_m: Vec<f64>,
    sorted: Vec<f64>,
}

const ITERATIONS: usize = 8;
/// Tukey's constant: 95 % efficiency on Gaussian residuals.
const TUKEY: f64 = 4.685;
/// Median absolute deviation to standard deviation of a Gaussian.
const MAD_TO_SIGMA: f64 = 1.4826;

/// Fits the motion, leaving each pair's final weight in it; none for fewer than six pairs.
///
/// `scale_floor_m` keeps the re-weighting from rejecting pairs over differences below the flow's own accuracy;
/// `independent` is how many of the pairs count as independent measurements.
pub(super) fn fit(
    pairs: &mut [Pair],
    residuals: &mut Residuals,
    viewpoint: Viewpoint,
    scale_floor_m: f64,
    independent: f64,
) -> Option<RigidFit> {
    if pairs.len() < 6 {
        return None;
    }
    let mut motion = procrustes(pairs)?;
    let mut sway = SVector::<f64, 3>::zeros();
    let mut information = SMatrix::<f64, 6, 6>::zeros();
    for _ in 0..ITERATIONS {
        residuals.of_pairs_m.clear();
        let of_pairs_m = pairs.iter().map(|pair| residual(pair, &motion, &sway, viewpoint).norm());
        residuals.of_pairs_m.extend(of_pairs_m);
        let scale = residuals.weigh(pairs, scale_floor_m);
        // Each pair counts for its share of an independent measurement of this standard deviation.
        let per_pair = independent / (pairs.len() as f64 * scale * scale);
        let mut gradient = SVector::<f64, 6>::zeros();
        information.fill(0.0);
        for (i, sigma) in SWAY_SIGMA_RAD.iter().enumerate() {
            information[(3 + i, 3 + i)] = sigma.powi(-2);
            gradient[3 + i] = -sway[i] * sigma.powi(-2);
        }
        for pair in pairs.iter().filter(|pair| pair.weight > 0.0) {
            let jacobian = jacobian(pair, &motion, viewpoint);
            let weight = per_pair * pair.weight;
            information += jacobian.transpose() * jacobian * weight;
            gradient += jacobian.transpose() * residual(pair, &motion, &sway, viewpoint) * weight;
        }
        let change = information.cholesky()?.solve(&gradient);
        motion = Isometry2::new(
            motion.translation.vector + Vector2::new(change[0], change[1]),
            motion.rotation.angle() + change[2],
        );
        sway += change.fixed_rows::<3>(3);
    }
    let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
    let squares: f64 =
        pairs.iter().map(|pair| pair.weight * residual(pair, &motion, &sway, viewpoint).norm_squared()).sum();
    let accepted = pairs.iter().filter(|pair| pair.weight > 0.5).count() as f64 / pairs.len() as f64;
    let of_inverse: Matrix3<f64> = information.try_inverse()?.fixed_view::<3, 3>(0, 0).into();
    let by_fit = previous_from_current_by_fit(&motion);
    Some(RigidFit {
        current_from_previous: motion,
        residual_m: (squares / total).sqrt(),
        accepted,
        covariance: by_fit * of_inverse * by_fit.transpose(),
    })
}

impl Residuals {
    /// Weighs every pair by its residual (Tukey's biweight); returns the residuals' scale, metres, at least `scale_floor_m`.
    fn weigh(&mut self, pairs: &mut [Pair], scale_floor_m: f64) -> f64 {
        let Self { of_pairs_m, sorted } = self;
        sorted.clone_from(of_pairs_m);
        sorted.sort_unstable_by(f64::total_cmp);
        let scale = (MAD_TO_SIGMA * sorted[sorted.len() / 2]).max(scale_floor_m);
        for (pair, residual) in pairs.iter_mut().zip(&*of_pairs_m) {
            let x = residual / (TUKEY * scale);
            pair.weight = if x < 1.0 { (1.0 - x * x).powi(2) } else { 0.0 };
        }
        scale
    }
}

/// The derivative of `previous_from_current` by the fitted `current_from_previous`: the former is -R^T t, so a turn moves it by
/// the lever of the step itself.
fn previous_from_current_by_fit(current_from_previous: &Isometry2<f64>) -> Matrix3<f64> {
    let back = current_from_previous.rotation.inverse().to_rotation_matrix();
    let step_m = current_from_previous.translation.vector;
    let lever = back * Vector2::new(-step_m.y, step_m.x);
    Matrix3::new(
        -back[(0, 0)],
        -back[(0, 1)],
        lever.x, //
        -back[(1, 0)],
        -back[(1, 1)],
        lever.y, //
        0.0,
        0.0,
        -1.0,
    )
}

/// The displacement of a pair that a standing roll explains, per radian.
fn stretch(pair: &Pair, viewpoint: Viewpoint) -> Vector2<f64> {
    sway_field(pair.current, viewpoint).1 - sway_field(pair.previous, viewpoint).1
}

fn residual(
    pair: &Pair,
    motion: &Isometry2<f64>,
    sway: &SVector<f64, 3>,
    viewpoint: Viewpoint,
) -> Vector2<f64> {
    let (by_pitch, by_roll) = sway_field(pair.current, viewpoint);
    pair.current
        - motion * pair.previous
        - by_pitch * sway[0]
        - by_roll * sway[1]
        - stretch(pair, viewpoint) * sway[2]
}

/// Derivative of the explained place by the six unknowns.
fn jacobian(pair: &Pair, motion: &Isometry2<f64>, viewpoint: Viewpoint) -> SMatrix<f64, 2, 6> {
    let turned = motion.rotation * pair.previous.coords;
    let (by_pitch, by_roll) = sway_field(pair.current, viewpoint);
    let by_motion = Matrix2x3::new(1.0, 0.0, -turned.y, 0.0, 1.0, turned.x);
    let mut jacobian = SMatrix::<f64, 2, 6>::zeros();
    jacobian.fixed_view_mut::<2, 3>(0, 0).copy_from(&by_motion);
    jacobian.set_column(3, &by_pitch);
    jacobian.set_column(4, &by_roll);
    jacobian.set_column(5, &stretch(pair, viewpoint));
    jacobian
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
    let rotation = Isometry2::rotation(libm::atan2(sine, cosine));
    let moved = rotation * before;
    Some(Isometry2::new(after - moved, rotation.rotation.angle()))
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWPOINT: Viewpoint = Viewpoint { foot: Point2::new(1.5, 0.0), height_m: 1.5 };

    fn pairs(motion: Isometry2<f64>) -> Vec<Pair> {
        (0..400)
            .map(|i| {
                let previous = Point2::new(5.0 + 0.3 * f64::from(i / 20), 0.3 * f64::from(i % 20) - 2.85);
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
        let fit = fit(&mut pairs, &mut Residuals::default(), VIEWPOINT, 0.005, 50.0).unwrap();
        assert!((fit.current_from_previous.translation.vector - motion.translation.vector).norm() < 1e-6);
        assert!((fit.current_from_previous.rotation.angle() + 0.03).abs() < 1e-7);
        assert!((fit.accepted - 0.75).abs() < 0.01, "a quarter are outliers: {}", fit.accepted);
        assert!(fit.covariance.symmetric_eigenvalues().min() > 0.0, "never certain");
    }

    #[test]
    fn the_body_s_sway_is_not_taken_for_motion() {
        let motion = Isometry2::new(Vector2::new(-0.8, 0.0), 0.01);
        let mut pairs = pairs(motion);
        let (pitch, roll) = (0.003, -0.002);
        for pair in &mut pairs {
            let (by_pitch, by_roll) = sway_field(pair.current, VIEWPOINT);
            pair.current += by_pitch * pitch + by_roll * roll;
        }
        let fit = fit(&mut pairs, &mut Residuals::default(), VIEWPOINT, 0.0025, 100.0).unwrap();
        let error = fit.current_from_previous.translation.vector - motion.translation.vector;
        assert!(error.norm() < 0.03, "{error}: pitch alone moves the road 8 m ahead by 6 cm");
        assert!((fit.current_from_previous.rotation.angle() - 0.01).abs() < 0.001);
    }

    #[test]
    fn too_few_pairs_are_no_motion() {
        assert!(
            fit(&mut pairs(Isometry2::identity())[..5], &mut Residuals::default(), VIEWPOINT, 0.005, 50.0)
                .is_none()
        );
    }
}
