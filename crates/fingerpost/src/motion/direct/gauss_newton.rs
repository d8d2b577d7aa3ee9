//! Gauss-Newton on one level of the patch, with priors.

use fingerpost_vision::alignment::{Brightness, Residuals, UNKNOWNS};
use nalgebra::{Isometry2, Matrix3, SMatrix, SVector, Vector3};

use super::patch::Level;
use super::plane_warp::Displacement;
use crate::motion::sway::SWAY_SIGMA_RAD;

/// Matrix over all unknowns.
type Matrix6 = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Vector6 = SVector<f64, UNKNOWNS>;

/// What is known of the motion before the pictures are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub(super) current_from_previous: Isometry2<f64>,
    /// Inverse of its covariance: forward, left, yaw in the older frame.
    pub(super) information: Matrix3<f64>,
}

impl Prior {
    /// `None` for a covariance that has no inverse.
    pub(super) fn new(current_from_previous: Isometry2<f64>, covariance: Matrix3<f64>) -> Option<Self> {
        Some(Self { current_from_previous, information: covariance.try_inverse()? })
    }
}

/// What is carried from iteration to iteration and from level to level.
#[derive(Debug, Clone, Copy)]
pub(super) struct Estimate {
    pub(super) displacement: Displacement,
    pub(super) brightness: Brightness,
    /// Standard deviation of the residuals, grey levels.
    pub(super) scale: f64,
    /// Covariance of the motion: forward, left, yaw in the older frame.
    pub(super) covariance: Matrix3<f64>,
    /// Root mean square of the residuals, as a displacement of the road, metres.
    pub(super) residual_m: f64,
    /// Share of the points that were led to seen pixels.
    pub(super) seen: f64,
    /// Share of what the older picture shows across the direction of travel that the newer one agrees with.
    pub(super) agreeing: f64,
    /// Whether the last step was small.
    pub(super) has_converged: bool,
}

impl Estimate {
    pub(super) fn at(current_from_previous: Isometry2<f64>) -> Self {
        Self {
            displacement: Displacement::of(current_from_previous),
            brightness: Brightness::default(),
            scale: FIRST_SCALE,
            covariance: Matrix3::identity(),
            residual_m: 0.0,
            seen: 0.0,
            agreeing: 0.0,
            has_converged: false,
        }
    }
}

/// Standard deviation of residuals that a start is given, grey levels: a road's texture.
pub(super) const FIRST_SCALE: f64 = 4.0;
/// Least standard deviation of residuals, grey levels: rounding leaves as much.
const SCALE_FLOOR: f64 = 0.5;
/// Share of the points that count as independent measurements: what is left of a good alignment is not noise but a road
/// that is not quite flat, alike over metres. Found from the errors of simulated drives (`tests/motion_accuracy.rs`).
const INDEPENDENT: f64 = 0.03;
/// Distance at which a turn is counted as a displacement, metres: the far end of the patch.
const REACH_M: f64 = 10.0;
/// A step below this ends a level, pixels.
const SMALL_STEP_PX: f64 = 0.02;

/// Aligns the level's template with its target; `None` where nothing is seen of it.
pub(super) fn align(
    level: &mut Level,
    residuals: &mut Residuals,
    prior: &Prior,
    iterations: usize,
    mut estimate: Estimate,
) -> Option<Estimate> {
    let raster = level.raster;
    level.template.set_directions(&raster.directions(&estimate.displacement));
    for left in (0..iterations).rev() {
        let warp = raster.warp(&estimate.displacement);
        residuals.measure(&level.template, &level.target, &warp, estimate.brightness, estimate.scale as f32);
        if residuals.seen < 1.0 {
            return None;
        }
        let sums = residuals.sums(&level.template);
        estimate.scale = f64::from(residuals.square_sum / residuals.seen).sqrt().max(SCALE_FLOOR);
        let weight = INDEPENDENT / (estimate.scale * estimate.scale);
        let mut information = Matrix6::from_fn(|row, column| weight * f64::from(sums.hessian[row][column]));
        let mut gradient = Vector6::from_fn(|row, _| weight * f64::from(sums.gradient[row]));
        add_priors(&mut information, &mut gradient, prior, &estimate.displacement);
        let factors = information.cholesky()?;
        let change = factors.solve(&gradient);
        estimate.displacement = changed(&estimate.displacement, &change);
        estimate.agreeing = f64::from(sums.hessian[0][0] / sums.unweighted[0].max(f32::MIN_POSITIVE));
        estimate.brightness = brightness(residuals, estimate.brightness);
        let step_m = change.x.hypot(change.y) + REACH_M * change.z.abs();
        estimate.has_converged = step_m < SMALL_STEP_PX * raster.metres_per_pixel;
        if estimate.has_converged || left == 0 {
            estimate.covariance = factors.inverse().fixed_view::<3, 3>(0, 0).into();
            let slope = f64::from(sums.hessian[0][0] + sums.hessian[1][1]).max(f64::MIN_POSITIVE);
            estimate.residual_m = (f64::from(residuals.square_sum) / slope).sqrt();
            break;
        }
    }
    estimate.seen = f64::from(residuals.seen) / level.template.len() as f64;
    Some(estimate)
}

fn add_priors(information: &mut Matrix6, gradient: &mut Vector6, prior: &Prior, now: &Displacement) {
    let off = prior.current_from_previous.inverse() * now.current_from_previous;
    let off = Vector3::new(off.translation.x, off.translation.y, off.rotation.angle());
    let mut motion = information.fixed_view_mut::<3, 3>(0, 0);
    motion += prior.information;
    let mut pull = gradient.fixed_rows_mut::<3>(0);
    pull += prior.information * off;
    for (i, sigma) in SWAY_SIGMA_RAD.iter().enumerate() {
        information[(3 + i, 3 + i)] += sigma.powi(-2);
        gradient[3 + i] += now.sway_rad[i] * sigma.powi(-2);
    }
}

/// The inverse compositional update: what would have moved the older picture is taken off the warp.
fn changed(now: &Displacement, change: &Vector6) -> Displacement {
    let moved = Isometry2::new(change.xy(), change.z);
    Displacement {
        current_from_previous: now.current_from_previous * moved.inverse(),
        sway_rad: std::array::from_fn(|i| now.sway_rad[i] - change[3 + i]),
    }
}

/// Gain and offset after a least-squares step on what is left.
fn brightness(sums: &Residuals, now: Brightness) -> Brightness {
    let determinant = sums.weight_sum * sums.grey_square_sum - sums.grey_sum * sums.grey_sum;
    // Grey of about one level alone cannot tell a gain from an offset.
    if determinant <= sums.weight_sum * sums.weight_sum {
        return now;
    }
    let gain = (sums.weight_sum * sums.grey_residual_sum - sums.grey_sum * sums.residual_sum) / determinant;
    let offset =
        (sums.grey_square_sum * sums.residual_sum - sums.grey_sum * sums.grey_residual_sum) / determinant;
    Brightness { gain: now.gain + gain, offset: now.offset + offset }
}
