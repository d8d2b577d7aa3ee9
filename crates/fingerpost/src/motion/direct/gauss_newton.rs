//! Gauss-Newton on one level of the patch, with priors.

use fingerpost_vision::alignment::{Brightness, Residuals, UNKNOWNS};
use nalgebra::{Isometry2, Matrix3, Matrix4, SMatrix, SVector, Vector2, Vector3, Vector4};

use super::patch::Level;
use super::plane_warp::{Displacement, Views};
use crate::motion::camera_turn::SeenTurn;

/// Matrix over all unknowns: forward, left, yaw, change of pitch and of roll, pitch and roll before.
type Matrix7 = SMatrix<f64, UNKNOWNS, UNKNOWNS>;
type Vector7 = SVector<f64, UNKNOWNS>;

/// What is known before the pictures are looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    pub(super) current_from_previous: Isometry2<f64>,
    /// Inverse of its covariance: forward, left, yaw in the older frame.
    pub(super) information: Matrix3<f64>,
    /// The camera's turning: change of pitch and of roll, pitch and roll before.
    pub(super) turn: SeenTurn,
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
    /// What the pictures alone say of the camera's turning, whatever the motion.
    pub(super) seen_turn: SeenTurn,
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
    pub(super) fn at(displacement: Displacement) -> Self {
        Self {
            displacement,
            brightness: Brightness::default(),
            scale: FIRST_SCALE,
            covariance: Matrix3::identity(),
            seen_turn: SeenTurn::default(),
            residual_m: 0.0,
            seen: 0.0,
            agreeing: 0.0,
            has_converged: false,
        }
    }
}

/// Standard deviation of residuals that a start is given, levels of the flattened picture: a road's texture.
pub(super) const FIRST_SCALE: f64 = 8.0;
/// Least standard deviation of residuals, levels of the flattened picture: rounding leaves as much.
const SCALE_FLOOR: f64 = 1.0;
/// Share of the points that count as independent measurements: what is left of a good alignment is not noise but a road
/// that is not quite flat, alike over metres. Found from the errors of simulated drives (`tests/drives/motion_accuracy.rs`).
const INDEPENDENT: f64 = 0.06;
/// Distance at which a turn is counted as a displacement, metres: the far end of the patch.
const REACH_M: f64 = 10.0;
/// A step below this ends a level, pixels.
const SMALL_STEP_PX: f64 = 0.02;

/// Aligns the level's template with its target; `None` where nothing is seen of it.
pub(super) fn align(
    level: &mut Level,
    residuals: &mut Residuals,
    (prior, views): (&Prior, &Views),
    iterations: usize,
    mut estimate: Estimate,
) -> Option<Estimate> {
    let raster = level.raster;
    level.template.set_directions(&raster.directions(&estimate.displacement));
    for left in (0..iterations).rev() {
        let warp = raster.warp(&estimate.displacement, views);
        residuals.measure(&level.template, &level.target, &warp, estimate.brightness, estimate.scale as f32);
        if residuals.seen < 1.0 {
            return None;
        }
        let sums = residuals.sums(&level.template);
        estimate.scale = f64::from(residuals.square_sum / residuals.seen).sqrt().max(SCALE_FLOOR);
        let weight = INDEPENDENT / (estimate.scale * estimate.scale);
        let mut information = Matrix7::from_fn(|row, column| weight * f64::from(sums.hessian[row][column]));
        let mut gradient = Vector7::from_fn(|row, _| weight * f64::from(sums.gradient[row]));
        add_motion_prior(&mut information, &mut gradient, prior, &estimate.displacement);
        let seen_turn = seen_turn(&information, &gradient, &estimate.displacement)?;
        add_turn_prior(&mut information, &mut gradient, prior, &estimate.displacement);
        let factors = information.cholesky()?;
        let change = factors.solve(&gradient);
        estimate.displacement = changed(&estimate.displacement, &change);
        estimate.agreeing = f64::from(sums.hessian[0][0] / sums.unweighted.max(f32::MIN_POSITIVE));
        estimate.brightness = brightness(residuals, estimate.brightness);
        let step_m = libm::hypot(change[0], change[1]) + REACH_M * change[2].abs();
        estimate.has_converged = step_m < SMALL_STEP_PX * raster.metres_per_pixel;
        if estimate.has_converged || left == 0 {
            estimate.seen_turn = seen_turn;
            estimate.covariance = factors.inverse().fixed_view::<3, 3>(0, 0).into();
            let slope = f64::from(sums.hessian[0][0] + sums.hessian[1][1]).max(f64::MIN_POSITIVE);
            estimate.residual_m = (f64::from(residuals.square_sum) / slope).sqrt();
            break;
        }
    }
    estimate.seen = f64::from(residuals.seen) / level.template.len() as f64;
    Some(estimate)
}

fn add_motion_prior(information: &mut Matrix7, gradient: &mut Vector7, prior: &Prior, now: &Displacement) {
    let off = prior.current_from_previous.inverse() * now.current_from_previous;
    let off = Vector3::new(off.translation.x, off.translation.y, off.rotation.angle());
    let mut motion = information.fixed_view_mut::<3, 3>(0, 0);
    motion += prior.information;
    let mut pull = gradient.fixed_rows_mut::<3>(0);
    pull += prior.information * off;
}

fn add_turn_prior(information: &mut Matrix7, gradient: &mut Vector7, prior: &Prior, now: &Displacement) {
    let mut turn = information.fixed_view_mut::<4, 4>(3, 3);
    turn += prior.turn.information;
    let mut pull = gradient.fixed_rows_mut::<4>(3);
    pull += prior.turn.information * turn_of(now) - prior.turn.vector;
}

fn turn_of(displacement: &Displacement) -> Vector4<f64> {
    let ([pitch, roll], [pitch_change, roll_change]) =
        (displacement.turn_before_rad, displacement.turn_change_rad);
    Vector4::new(pitch_change, roll_change, pitch, roll)
}

/// What is left for the turning when every motion is allowed for as likely as it is (the Schur complement).
fn seen_turn(information: &Matrix7, gradient: &Vector7, now: &Displacement) -> Option<SeenTurn> {
    let of_motion = information.fixed_view::<3, 3>(0, 0).into_owned().cholesky()?;
    let both = information.fixed_view::<3, 4>(0, 3);
    let explained = both.transpose() * of_motion.solve(&both.into_owned());
    let of_turn: Matrix4<f64> = information.fixed_view::<4, 4>(3, 3) - explained;
    let pulled = both.transpose() * of_motion.solve(&gradient.fixed_rows::<3>(0).into_owned());
    let pull: Vector4<f64> = gradient.fixed_rows::<4>(3) - pulled;
    Some(SeenTurn { information: of_turn, vector: of_turn * turn_of(now) - pull })
}

/// The inverse compositional update: what would have moved the older picture is taken off the warp.
fn changed(now: &Displacement, change: &Vector7) -> Displacement {
    let moved = Isometry2::new(Vector2::new(change[0], change[1]), change[2]);
    Displacement {
        current_from_previous: now.current_from_previous * moved.inverse(),
        turn_before_rad: std::array::from_fn(|i| now.turn_before_rad[i] - change[5 + i]),
        turn_change_rad: std::array::from_fn(|i| now.turn_change_rad[i] - change[3 + i]),
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
