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
    /// Standard deviation, metres.
    pub(crate) sigma_m: f64,
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

impl PoseFilter {
    /// A feature at a pose known to the given standard deviations (metres, metres, radians).
    pub fn new(vehicle_from_feature: Isometry2<f64>, sigmas: [f64; 3]) -> Self {
        let covariance = Matrix3::from_diagonal(&Vector3::from(sigmas.map(|sigma| sigma * sigma)));
        Self { vehicle_from_feature, covariance }
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
        let (cosine, sine) =
            (current_from_previous.rotation.angle().cos(), current_from_previous.rotation.angle().sin());
        let p = self.vehicle_from_feature.translation.vector;
        let by_pose = Matrix3::new(cosine, -sine, 0.0, sine, cosine, 0.0, 0.0, 0.0, 1.0);
        let by_motion = Matrix3::new(-cosine, sine, p.y, -sine, -cosine, -p.x, 0.0, 0.0, -1.0);
        self.covariance = by_pose * self.covariance * by_pose.transpose()
            + by_motion * motion.covariance * by_motion.transpose()
            + Matrix3::from_diagonal(
                &Vector3::new(PROCESS_M, PROCESS_M, PROCESS_RAD).map(|sigma| sigma * sigma),
            );
    }

    /// Takes a measurement in, unless it is too far off.
    pub(crate) fn update(&mut self, measurement: &LineMeasurement) -> Update {
        let turned = self.vehicle_from_feature.rotation * measurement.p_in_feature.coords;
        let n = measurement.normal;
        let h = RowVector3::new(n.x, n.y, n.y * turned.x - n.x * turned.y);
        self.take(h, measurement.innovation_m, measurement.sigma_m)
    }

    /// Takes in how far the feature must turn, radians, unless that is too far off.
    pub(crate) fn update_heading(&mut self, innovation_rad: f64, sigma_rad: f64) -> Update {
        self.take(RowVector3::new(0.0, 0.0, 1.0), innovation_rad, sigma_rad)
    }

    /// Takes in a pose that was found by a search, known to the given standard deviations (metres, metres, radians); each
    /// of its parts unless that is too far off.
    pub(crate) fn update_pose(&mut self, found: &Isometry2<f64>, sigmas: [f64; 3]) {
        let off_forward_m = found.translation.x - self.vehicle_from_feature.translation.x;
        self.take(RowVector3::new(1.0, 0.0, 0.0), off_forward_m, sigmas[0]);
        let off_left_m = found.translation.y - self.vehicle_from_feature.translation.y;
        self.take(RowVector3::new(0.0, 1.0, 0.0), off_left_m, sigmas[1]);
        let turned_rad = self.vehicle_from_feature.rotation.angle_to(&found.rotation);
        self.take(RowVector3::new(0.0, 0.0, 1.0), turned_rad, sigmas[2]);
    }

    fn take(&mut self, h: RowVector3<f64>, innovation: f64, sigma: f64) -> Update {
        let variance = (h * self.covariance * h.transpose())[0] + sigma.powi(2);
        let sigmas = innovation.abs() / variance.sqrt();
        if sigmas > GATE_SIGMAS {
            return Update::Gated(sigmas);
        }
        let gain = self.covariance * h.transpose() / variance;
        let change = gain * innovation;
        self.vehicle_from_feature = Isometry2::new(
            self.vehicle_from_feature.translation.vector + change.xy(),
            wrap_angle(self.vehicle_from_feature.rotation.angle() + change.z),
        );
        // Joseph's form stays symmetric and positive whatever the rounding.
        let keep = Matrix3::identity() - gain * h;
        self.covariance = keep * self.covariance * keep.transpose() + gain * gain.transpose() * sigma.powi(2);
        Update::Accepted
    }

    /// Puts the feature where a search found it, at least as unsure as `sigmas` say.
    pub fn relocate(&mut self, vehicle_from_feature: Isometry2<f64>, sigmas: [f64; 3]) {
        *self = Self::new(vehicle_from_feature, sigmas);
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
        };
        assert!(matches!(filter.update(&outlier), Update::Gated(sigmas) if sigmas > 10.0));
    }
}
