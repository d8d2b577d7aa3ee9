//! The vehicle's pose since the first frame, by its own motion from frame to frame, with the covariance that has added up.

use fingerpost::motion::Motion;
use foxglove::messages::{Odometry as OdometryMessage, Timestamp, Vector3 as VectorMessage};
use nalgebra::{Isometry2, Matrix3};

use super::transforms::{ODOM, VEHICLE, planar_pose};

/// Standard deviation of what a motion over the road's plane does not estimate (height, roll and pitch), metres and radians: a
/// vehicle's springs and the road's waves.
const OFF_PLANE_SIGMA: f64 = 0.05;

/// Dead reckoning.
#[derive(Debug, Clone)]
pub struct Odometry {
    /// The vehicle in the frame where it began.
    odom_from_vehicle: Isometry2<f64>,
    /// Covariance of x (m), y (m) in `odom` and heading (rad).
    covariance: Matrix3<f64>,
    /// The last motion and the time that it took, seconds.
    last: Option<(Motion, f64)>,
}

/// Pose and velocity, with covariances over x, y, z (metres) and the turns about them (radians), row by row.
#[derive(Debug, Clone, PartialEq)]
pub struct OdometryEstimate {
    /// The vehicle in the frame where it began.
    pub odom_from_vehicle: Isometry2<f64>,
    /// Covariance of the pose, in the frame where it began; zero in the plane at the first frame, which is that frame.
    pub pose_covariance: [f64; 36],
    /// How it moves; none where the last motion is not known.
    pub velocity: Option<Velocity>,
}

/// How the vehicle moves, in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Velocity {
    /// Forward, m/s.
    pub forward_mps: f64,
    /// To the left, m/s.
    pub left_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: f64,
    /// Covariance, per second squared.
    pub covariance: [f64; 36],
}

impl Default for Odometry {
    fn default() -> Self {
        Self { odom_from_vehicle: Isometry2::identity(), covariance: Matrix3::zeros(), last: None }
    }
}

impl Odometry {
    /// Goes on by a motion that took `dt_s`.
    pub fn go_on(&mut self, motion: Option<&Motion>, dt_s: Option<f64>) {
        self.last = motion.zip(dt_s).filter(|(_, dt_s)| *dt_s > 0.0).map(|(motion, dt_s)| (*motion, dt_s));
        let Some(motion) = motion else { return };
        let rotation = self.odom_from_vehicle.rotation;
        let moved = rotation * motion.previous_from_current.translation.vector;
        // Barfoot, "State Estimation for Robotics", 2017, section 7.3, for poses composed in the plane.
        let mut by_pose = Matrix3::identity();
        by_pose[(0, 2)] = -moved.y;
        by_pose[(1, 2)] = moved.x;
        let mut by_motion = Matrix3::identity();
        by_motion.fixed_view_mut::<2, 2>(0, 0).copy_from(rotation.to_rotation_matrix().matrix());
        self.covariance = by_pose * self.covariance * by_pose.transpose()
            + by_motion * motion.covariance * by_motion.transpose();
        self.odom_from_vehicle *= motion.previous_from_current;
    }

    /// Where the vehicle is by now, and how it moves.
    pub fn estimate(&self) -> OdometryEstimate {
        let velocity = self.last.map(|(motion, dt_s)| {
            let moved = motion.previous_from_current;
            let linear = moved.translation.vector / dt_s;
            Velocity {
                forward_mps: linear.x,
                left_mps: linear.y,
                yaw_rate_rps: moved.rotation.angle() / dt_s,
                covariance: spatial(&(motion.covariance / (dt_s * dt_s))),
            }
        });
        let pose_covariance = spatial(&self.covariance);
        OdometryEstimate { odom_from_vehicle: self.odom_from_vehicle, pose_covariance, velocity }
    }

    /// The same as a message.
    pub(crate) fn message(&self, timestamp: Timestamp) -> OdometryMessage {
        let OdometryEstimate { odom_from_vehicle, pose_covariance, velocity } = self.estimate();
        let linear = |v: &Velocity| VectorMessage { x: v.forward_mps, y: v.left_mps, z: 0.0 };
        let angular = |v: &Velocity| VectorMessage { x: 0.0, y: 0.0, z: v.yaw_rate_rps };
        OdometryMessage {
            timestamp: Some(timestamp),
            frame_id: ODOM.to_owned(),
            body_frame_id: VEHICLE.to_owned(),
            pose: Some(planar_pose(&odom_from_vehicle)),
            linear_velocity: velocity.as_ref().map(linear),
            angular_velocity: velocity.as_ref().map(angular),
            pose_covariance: pose_covariance.to_vec(),
            velocity_covariance: velocity.map_or([0.0; 36], |velocity| velocity.covariance).to_vec(),
            metadata: Vec::new(),
        }
    }
}

/// A covariance of x, y and yaw among six of x, y, z and the turns about them, row by row.
fn spatial(planar: &Matrix3<f64>) -> [f64; 36] {
    const PLACES: [usize; 3] = [0, 1, 5];
    let mut full = [0.0; 36];
    for off_plane in [2, 3, 4] {
        full[off_plane * 7] = OFF_PLANE_SIGMA * OFF_PLANE_SIGMA;
    }
    for (row, &to_row) in PLACES.iter().enumerate() {
        for (column, &to_column) in PLACES.iter().enumerate() {
            full[to_row * 6 + to_column] = planar[(row, column)];
        }
    }
    full
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector2;

    use super::*;

    fn motion(forward_m: f64, yaw_rad: f64) -> Motion {
        Motion {
            previous_from_current: Isometry2::new(Vector2::new(forward_m, 0.0), yaw_rad),
            covariance: Matrix3::from_diagonal_element(1e-4),
            quality: 1.0,
        }
    }

    #[test]
    fn four_quarter_turns_to_the_left_lead_back() {
        let mut odometry = Odometry::default();
        odometry.go_on(Some(&motion(5.0, std::f64::consts::FRAC_PI_2)), Some(1.0));
        odometry.go_on(Some(&motion(5.0, 0.0)), Some(1.0));
        let place = odometry.odom_from_vehicle.translation.vector;
        assert!((place - Vector2::new(5.0, 5.0)).norm() < 1e-9, "left is positive: {place}");
    }

    #[test]
    fn doubt_of_the_heading_becomes_doubt_across() {
        let mut odometry = Odometry::default();
        odometry.go_on(Some(&motion(0.0, 0.0)), Some(1.0));
        odometry.go_on(Some(&motion(100.0, 0.0)), Some(1.0));
        let message = odometry.message(Timestamp::MIN);
        let variance = |axis: usize| message.pose_covariance[axis * 7];
        // Twice 1e-4 along, and across that and the first heading's 1e-4 over 100 m.
        assert!((variance(0) - 2e-4).abs() < 1e-12 && (variance(1) - (2e-4 + 1.0)).abs() < 1e-9);
        assert!(message.pose_covariance.iter().enumerate().all(|(i, v)| i % 7 != 0 || *v > 0.0));
        assert!((message.linear_velocity.unwrap().x - 100.0).abs() < 1e-9);
    }
}
