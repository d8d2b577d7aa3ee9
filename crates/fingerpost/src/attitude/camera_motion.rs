//! How the camera turned and which way it moved, from pairs of rays.
//!
//! What is seen from two places lies in one plane with the way between them (the epipolar constraint; R. Hartley and
//! A. Zisserman, "Multiple view geometry", 2004, section 9): with rotation R and direction t of travel, t . (R p x q) = 0 for
//! the rays p before and q after. Rotation and direction are fitted together, five unknowns, by Gauss-Newton on that
//! product over its gradient (Sampson's distance, an angle here), with weights against what moves by itself (S. Geman and
//! D. McClure, 1985). The direction is where the vehicle moves to: the focus of expansion, with the rotation taken out.
//!
//! Limits: a standing camera has no direction, which its standard deviation says.

use nalgebra::{Matrix5, Rotation3, Unit, UnitQuaternion, Vector3, Vector5};

use super::sparse::RayPair;

/// A camera's motion between two frames, in the camera's own axes (x right, y down, z forward).
#[derive(Debug, Clone, Copy)]
pub struct CameraMotion {
    /// Takes directions of the older camera frame to the newer one.
    pub current_from_previous: UnitQuaternion<f64>,
    /// Direction of travel in the newer camera frame.
    pub travel: Unit<Vector3<f64>>,
    /// Standard deviation of each of the rotation's components, radians.
    pub rotation_sigma_rad: Vector3<f64>,
    /// Standard deviations of the direction up or down, and to the sides, radians.
    pub travel_sigma_rad: [f64; 2],
    /// Mean weight of the pairs: the share that agrees.
    pub agreeing: f64,
    /// Pairs that tell the direction: they agree, and moved away from it by more than the rotation explains. What is far
    /// agrees with every direction.
    pub telling: usize,
}

/// Memory of the fit.
#[derive(Debug, Default)]
pub(super) struct MotionFit {
    /// Residual of each pair and its derivative by rotation and direction.
    rows: Vec<(f64, Vector5<f64>)>,
    sorted: Vec<f64>,
}

const ITERATIONS: usize = 10;
/// Least square of the gradient's length: rays this near the direction of travel say nothing, and are not divided by zero.
const LEAST_GRADIENT: f64 = 1e-12;
/// Fewer pairs than a few for each unknown say too little.
const LEAST_PAIRS: usize = 20;
/// Weights are halved where a residual is this many standard deviations.
const WEIGHT_SIGMAS: f64 = 2.0;
/// A pair that moved by more standard deviations of a residual than this is near enough to tell the direction of travel.
const TELLING_SIGMAS: f64 = 10.0;
/// Median absolute deviation to standard deviation of a Gaussian.
const MAD_TO_SIGMA: f64 = 1.4826;
/// Least standard deviation of a residual, radians: a twentieth of a pixel of most cameras.
const SIGMA_FLOOR_RAD: f64 = 5e-5;
/// Changes smaller than this end the fit, radians.
const SETTLED_RAD: f64 = 1e-5;

impl MotionFit {
    /// Makes room for so many pairs, so that no later fit needs more.
    pub(super) fn reserve(&mut self, pairs: usize) {
        self.rows.clear();
        self.rows.reserve(pairs);
        self.sorted.clear();
        self.sorted.reserve(pairs);
    }

    /// Fits the motion, beginning at the median turn to the side and the direction `ahead`; none for too few pairs.
    pub(super) fn fit(&mut self, pairs: &[RayPair], ahead: Unit<Vector3<f64>>) -> Option<CameraMotion> {
        if pairs.len() < LEAST_PAIRS {
            return None;
        }
        // In a bend a fit that begins at no rotation takes the turn for a way to the side.
        self.sorted.clear();
        self.sorted.extend(pairs.iter().map(|pair| pair.current.x - pair.previous.x));
        let middle = self.sorted.len() / 2;
        let (_, &mut aside, _) = self.sorted.select_nth_unstable_by(middle, f64::total_cmp);
        let (mut rotation, mut travel) = (UnitQuaternion::from_scaled_axis(Vector3::y() * aside), ahead);
        let mut covariance = Matrix5::zeros();
        let (mut agreeing, mut sigma) = (0.0, SIGMA_FLOOR_RAD);
        for _ in 0..ITERATIONS {
            let turn = rotation.to_rotation_matrix();
            let sides = sides(&travel);
            self.rows.clear();
            self.rows.extend(pairs.iter().map(|pair| linearised(pair, &turn, &travel, &sides)));
            self.sorted.clear();
            self.sorted.extend(self.rows.iter().map(|(residual, _)| residual.abs()));
            let middle = self.sorted.len() / 2;
            let (_, median, _) = self.sorted.select_nth_unstable_by(middle, f64::total_cmp);
            sigma = (MAD_TO_SIGMA * *median).max(SIGMA_FLOOR_RAD);
            let mut information = Matrix5::zeros();
            let mut gradient = Vector5::zeros();
            agreeing = 0.0;
            for (residual, jacobian) in &self.rows {
                let x = residual / (WEIGHT_SIGMAS * sigma);
                let weight = (1.0 + x * x).powi(-2);
                information += weight * jacobian * jacobian.transpose();
                gradient += weight * *residual * jacobian;
                agreeing += weight;
            }
            agreeing /= pairs.len() as f64;
            // A weak prior, five degrees, keeps what is not seen where it was.
            let prior = (sigma / 0.1).powi(2);
            for i in 0..5 {
                information[(i, i)] += prior;
            }
            let factors = information.cholesky()?;
            let change = -factors.solve(&gradient);
            covariance = factors.inverse() * (sigma * sigma);
            rotation = UnitQuaternion::from_scaled_axis(change.fixed_rows::<3>(0).into_owned()) * rotation;
            travel = Unit::try_new(travel.into_inner() + sides[0] * change[3] + sides[1] * change[4], 1e-9)?;
            if change.norm() < SETTLED_RAD {
                break;
            }
        }
        let turn = rotation.to_rotation_matrix();
        let tells = |(pair, (residual, _)): &(&RayPair, &(f64, Vector5<f64>))| {
            let turned = turn * pair.previous;
            residual.abs() < WEIGHT_SIGMAS * sigma
                && turned.angle(&pair.current) > TELLING_SIGMAS * sigma
                && travel.dot(&pair.current) < travel.dot(&turned)
        };
        let telling = pairs.iter().zip(&self.rows).filter(tells).count();
        let sigma_of = |i: usize| covariance[(i, i)].max(0.0).sqrt();
        Some(CameraMotion {
            current_from_previous: rotation,
            travel,
            rotation_sigma_rad: Vector3::new(sigma_of(0), sigma_of(1), sigma_of(2)),
            travel_sigma_rad: [sigma_of(3), sigma_of(4)],
            agreeing,
            telling,
        })
    }
}

/// Unit vectors across a direction, the first mostly down the picture, the second mostly to its right.
fn sides(travel: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let right = Vector3::y().cross(travel).try_normalize(1e-9).unwrap_or_else(Vector3::x);
    [travel.cross(&right), right]
}

/// Sampson's distance of a pair from the constraint, radians, and its derivative by the rotation and the direction to both
/// sides.
fn linearised(
    pair: &RayPair,
    turn: &Rotation3<f64>,
    travel: &Unit<Vector3<f64>>,
    sides: &[Vector3<f64>; 2],
) -> (f64, Vector5<f64>) {
    let turned = turn * pair.previous;
    let cross = turned.cross(&pair.current);
    // How the product changes when either ray is turned: its gradients across the rays.
    let across =
        |gradient: Vector3<f64>, ray: &Vector3<f64>| gradient.norm_squared() - gradient.dot(ray).powi(2);
    let by_rays = across(travel.cross(&turned), &pair.current) + across(pair.current.cross(travel), &turned);
    let scale = by_rays.max(LEAST_GRADIENT).sqrt().recip();
    let by_rotation = travel.dot(&turned) * pair.current - turned.dot(&pair.current) * travel.into_inner();
    let jacobian =
        Vector5::new(by_rotation.x, by_rotation.y, by_rotation.z, sides[0].dot(&cross), sides[1].dot(&cross));
    (scale * travel.dot(&cross), scale * jacobian)
}
