//! The pose of a feature as a Gaussian: moved by ego-motion, made precise by what is seen of its arms.
//!
//! An extended Kalman filter (Thrun, Burgard, Fox: Probabilistic Robotics, 2005, table 3.3) over forward, left and
//! heading of the feature in the vehicle frame.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Isometry2, Matrix3, Point2, RowVector3, Vector2, Vector3};

use crate::motion::Motion;

/// Pose and covariance of a feature in the vehicle frame.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseFilter {
    vehicle_from_feature: Isometry2<f64>,
    covariance: Matrix3<f64>,
    /// Covariance of the pose's error with the camera's pitch, of which one standard deviation is the unit.
    with_pitch: Vector3<f64>,
}

/// A measurement of the distance of a place on the feature from a line in the vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct LineMeasurement {
    /// The place, feature frame, metres.
    pub(crate) p_in_feature: Point2<f64>,
    /// Unit normal of the line, vehicle frame.
    pub(crate) normal: Vector2<f64>,
    /// Measured minus predicted place along the normal, metres.
    pub(crate) innovation_m: f64,
    /// Standard deviation but for the pitch, metres.
    pub(crate) sigma_m: f64,
    /// How far one standard deviation of the camera's pitch moves the measured place along the normal, metres.
    pub(crate) by_pitch_m: f64,
}

/// A measurement of how far an arm's edges are from running along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct SlopeMeasurement {
    /// How the slope changes with the feature's forward, left (metres) and heading.
    pub(crate) by_pose: RowVector3<f64>,
    /// Slope of the edges against the arm, radians.
    pub(crate) innovation_rad: f64,
    /// Its standard deviation, radians.
    pub(crate) sigma_rad: f64,
}

/// What a measurement did.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Update {
    /// It was used.
    Accepted,
    /// It lies this many standard deviations off.
    Gated(f64),
}

/// Innovations beyond this many standard deviations are not believed: 1 in 370 good ones.
const GATE_SIGMAS: f64 = 3.0;
/// Growth of the uncertainty in a frame beyond the motion's own: the road is not quite flat and the map not quite
/// where the road is, so that no number of frames makes a place certain. Metres and radians.
const PROCESS_M: f64 = 0.06;
const PROCESS_RAD: f64 = 0.01;
/// Distance driven after which the camera's pitch about its mount is another one, metres: the body swings within a few, the
/// mount's own error and the waves of the road last longer.
const PITCH_LASTS_M: f64 = 15.0;

impl PoseFilter {
    /// A feature at a pose known to the given standard deviations (metres, metres, radians).
    pub fn new(vehicle_from_feature: Isometry2<f64>, sigmas: [f64; 3]) -> Self {
        let covariance = Matrix3::from_diagonal(&Vector3::from(sigmas.map(|sigma| sigma * sigma)));
        Self { vehicle_from_feature, covariance, with_pitch: Vector3::zeros() }
    }

    /// The pose.
    pub const fn pose(&self) -> &Isometry2<f64> {
        &self.vehicle_from_feature
    }

    /// Covariance of forward (m), left (m) and heading (rad).
    pub const fn covariance(&self) -> &Matrix3<f64> {
        &self.covariance
    }

    /// Puts the feature at another pose, which is as well known.
    pub(crate) fn place(&mut self, vehicle_from_feature: Isometry2<f64>) {
        self.vehicle_from_feature = vehicle_from_feature;
    }

    /// Moves the feature as the vehicle moves.
    pub fn predict(&mut self, motion: &Motion) {
        let current_from_previous = motion.previous_from_current.inverse();
        self.vehicle_from_feature = current_from_previous * self.vehicle_from_feature;
        let (cosine, sine) = (
            libm::cos(current_from_previous.rotation.angle()),
            libm::sin(current_from_previous.rotation.angle()),
        );
        let p = self.vehicle_from_feature.translation.vector;
        let by_pose = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
        let by_motion = Matrix3::new(-cosine, sine, p.y, -sine, -cosine, -p.x, 0.0, 0.0, -1.0);
        self.covariance = by_pose * self.covariance * by_pose.transpose()
            + by_motion * motion.covariance * by_motion.transpose()
            + Matrix3::from_diagonal(
                &Vector3::new(PROCESS_M, PROCESS_M, PROCESS_RAD).map(|sigma| sigma * sigma),
            );
        let driven_m = motion.previous_from_current.translation.vector.norm();
        self.with_pitch = libm::exp(-driven_m / PITCH_LASTS_M) * (by_pose * self.with_pitch);
    }

    /// Takes a measurement in, unless it is too far off.
    pub(crate) fn update(&mut self, measurement: &LineMeasurement) -> Update {
        let turned = self.vehicle_from_feature.rotation * measurement.p_in_feature.coords;
        let n = measurement.normal;
        let h = RowVector3::new(n.x, n.y, n.y * turned.x - n.x * turned.y);
        self.take(h, measurement.innovation_m, (measurement.sigma_m, measurement.by_pitch_m))
    }

    /// Takes in the slope of an arm that was measured with the feature at `believed`, unless it is too far off.
    pub(crate) fn update_slope(&mut self, slope: &SlopeMeasurement, believed: &Isometry2<f64>) -> Update {
        let moved = self.vehicle_from_feature.translation.vector - believed.translation.vector;
        let turned = believed.rotation.angle_to(&self.vehicle_from_feature.rotation);
        let already = (slope.by_pose * Vector3::new(moved.x, moved.y, turned))[0];
        self.take(slope.by_pose, slope.innovation_rad - already, (slope.sigma_rad, 0.0))
    }

    /// Takes in how far the feature must turn, radians, unless that is too far off.
    pub(crate) fn update_heading(&mut self, innovation_rad: f64, sigma_rad: f64) -> Update {
        self.take(RowVector3::new(0.0, 0.0, 1.0), innovation_rad, (sigma_rad, 0.0))
    }

    /// Takes in a pose that was found by a search, known to the given standard deviations (metres, metres, radians); each
    /// of its parts unless that is too far off. One standard deviation of the camera's pitch moves the place by `by_pitch`,
    /// metres.
    pub(crate) fn update_pose(&mut self, found: &Isometry2<f64>, sigmas: [f64; 3], by_pitch: Vector2<f64>) {
        let off_forward_m = found.translation.x - self.vehicle_from_feature.translation.x;
        self.take(RowVector3::new(1.0, 0.0, 0.0), off_forward_m, (sigmas[0], by_pitch.x));
        let off_left_m = found.translation.y - self.vehicle_from_feature.translation.y;
        self.take(RowVector3::new(0.0, 1.0, 0.0), off_left_m, (sigmas[1], by_pitch.y));
        let turned_rad = self.vehicle_from_feature.rotation.angle_to(&found.rotation);
        self.take(RowVector3::new(0.0, 0.0, 1.0), turned_rad, (sigmas[2], 0.0));
    }

    /// Takes in what was measured with this standard deviation, and moved by so much by one of the camera's pitch. The pitch
    /// is the same in many frames, so it is considered, not averaged out (Schmidt, Application of state-space methods to
    /// navigation problems, 1966).
    fn take(&mut self, h: RowVector3<f64>, innovation: f64, (sigma, by_pitch): (f64, f64)) -> Update {
        let noise = sigma.powi(2) + by_pitch.powi(2);
        let variance =
            (h * self.covariance * h.transpose())[0] + 2.0 * by_pitch * (h * self.with_pitch)[0] + noise;
        let sigmas = innovation.abs() / variance.max(f64::MIN_POSITIVE).sqrt();
        if sigmas > GATE_SIGMAS {
            return Update::Gated(sigmas);
        }
        let gain = (self.covariance * h.transpose() + by_pitch * self.with_pitch) / variance;
        let change = gain * innovation;
        self.vehicle_from_feature = Isometry2::new(
            self.vehicle_from_feature.translation.vector + change.xy(),
            wrap_angle(self.vehicle_from_feature.rotation.angle() + change.z),
        );
        // Joseph's form stays symmetric and positive whatever the rounding.
        let keep = Matrix3::identity() - gain * h;
        let across = keep * self.with_pitch * (by_pitch * gain.transpose());
        self.covariance = keep * self.covariance * keep.transpose() + gain * gain.transpose() * noise
            - across
            - across.transpose();
        self.with_pitch = keep * self.with_pitch - gain * by_pitch;
        Update::Accepted
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn motion(forward: f64, left: f64, yaw: f64) -> Motion {
        Motion {
            previous_from_current: Isometry2::new(Vector2::new(forward, left), yaw),
            covariance: Matrix3::identity() * 1e-4,
            quality: 1.0,
        }
    }

    #[test]
    fn driving_brings_the_feature_nearer_and_turning_left_moves_it_right() {
        let mut filter = PoseFilter::new(Isometry2::new(Vector2::new(10.0, 0.0), 0.0), [0.3, 0.3, 0.02]);
        filter.predict(&motion(1.0, 0.0, 0.1));
        let p = filter.pose().translation.vector;
        assert!((p.norm() - 9.0).abs() < 1e-9 && p.y < -0.8, "{p:?}");
        assert!((filter.pose().rotation.angle() + 0.1).abs() < 1e-12);
    }

    /// The Jacobians of the prediction and of a measurement against differences.
    #[test]
    fn jacobians_are_the_derivatives() {
        let pose = [9.0, 1.0, 0.2];
        let step = 1e-6;
        let predicted = |pose: [f64; 3], m: [f64; 3]| {
            let mut filter =
                PoseFilter::new(Isometry2::new(Vector2::new(pose[0], pose[1]), pose[2]), [0.1; 3]);
            filter.predict(&motion(m[0], m[1], m[2]));
            let p = filter.pose();
            Vector3::new(p.translation.x, p.translation.y, p.rotation.angle())
        };
        let moved = [0.8, 0.1, 0.05];
        let mut numeric_covariance = Matrix3::zeros();
        for axis in 0..3 {
            let (mut a, mut b) = (pose, moved);
            a[axis] += step;
            b[axis] += step;
            let by_pose = (predicted(a, moved) - predicted(pose, moved)) / step;
            let by_motion = (predicted(pose, b) - predicted(pose, moved)) / step;
            numeric_covariance +=
                by_pose * by_pose.transpose() * 0.01 + by_motion * by_motion.transpose() * 1e-4;
        }
        let mut filter = PoseFilter::new(Isometry2::new(Vector2::new(pose[0], pose[1]), pose[2]), [0.1; 3]);
        filter.predict(&motion(moved[0], moved[1], moved[2]));
        let process = Vector3::new(PROCESS_M, PROCESS_M, PROCESS_RAD).map(|sigma| sigma * sigma);
        let analytic = filter.covariance() - Matrix3::from_diagonal(&process);
        assert!((analytic - numeric_covariance).norm() < 1e-5, "{analytic} {numeric_covariance}");
    }

    /// Approaches in which the camera looks a constant bit too low or too high: the error must be as large as the filter says.
    #[test]
    fn what_the_cameras_pitch_moves_is_not_averaged_out() {
        let (runs, by_pitch_at) = (60, |x: f64| 0.0035 * x * x / 1.5);
        let (mut squared, mut sigma_far_m, mut sigma_near_m) = (0.0, 0.0, 0.0);
        for run in 0..runs {
            // Evenly over the quantiles of a uniform distribution of variance 1.
            let pitch = 3.0_f64.sqrt() * (2.0 * (f64::from(run) + 0.5) / f64::from(runs) - 1.0);
            let mut x = 18.0;
            let place = |x| Isometry2::new(Vector2::new(x, 0.0), 0.0);
            let mut filter = PoseFilter::new(place(x + pitch * by_pitch_at(x)), [1.2, 0.8, 0.1]);
            for frame in 0..20 {
                let innovation_m = x + pitch * by_pitch_at(x) - filter.pose().translation.x;
                let update = filter.update(&LineMeasurement {
                    p_in_feature: Point2::origin(),
                    normal: Vector2::x(),
                    innovation_m,
                    sigma_m: 0.2,
                    by_pitch_m: by_pitch_at(x),
                });
                assert_eq!(update, Update::Accepted);
                let sigma_m = filter.covariance()[(0, 0)].sqrt();
                if frame == 5 {
                    sigma_far_m = sigma_m;
                }
                sigma_near_m = sigma_m;
                squared += ((filter.pose().translation.x - x) / sigma_m).powi(2);
                filter.predict(&motion(0.5, 0.0, 0.0));
                x -= 0.5;
            }
        }
        let normalised = squared / f64::from(20 * runs);
        assert!((0.4..1.5).contains(&normalised), "{normalised}");
        assert!(sigma_far_m > 0.35 && sigma_near_m < 0.6 * sigma_far_m, "{sigma_far_m} {sigma_near_m}");
    }

    #[test]
    fn measurements_along_two_normals_fix_the_place() {
        let truth = Isometry2::new(Vector2::new(10.4, -0.3), 0.03);
        let mut filter = PoseFilter::new(Isometry2::new(Vector2::new(10.0, 0.0), 0.0), [1.0, 1.0, 0.1]);
        for _ in 0..20 {
            for (place, normal) in [
                (Point2::new(-5.0, 0.0), Vector2::y()),
                (Point2::new(-2.0, 0.0), Vector2::y()),
                (Point2::new(0.0, 6.0), Vector2::x()),
            ] {
                let innovation_m = normal.dot(&(truth * place - filter.pose() * place));
                let update = filter.update(&LineMeasurement {
                    p_in_feature: place,
                    normal,
                    innovation_m,
                    sigma_m: 0.1,
                    by_pitch_m: 0.0,
                });
                assert_eq!(update, Update::Accepted);
            }
        }
        assert!((filter.pose().translation.vector - truth.translation.vector).norm() < 0.02);
        assert!(filter.covariance().symmetric_eigenvalues().min() > 0.0, "never certain");
        let outlier = LineMeasurement {
            p_in_feature: Point2::origin(),
            normal: Vector2::x(),
            innovation_m: 2.0,
            sigma_m: 0.1,
            by_pitch_m: 0.0,
        };
        assert!(matches!(filter.update(&outlier), Update::Gated(sigmas) if sigmas > 10.0));
    }
}
