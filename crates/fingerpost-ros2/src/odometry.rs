//! Odometry and the way driven.

use std::collections::VecDeque;

use fingerpost_record::recording::{OdometryEstimate, Velocity};
use nalgebra::{Isometry2, Point2};

use crate::frames::{BASE_LINK, ODOM};
use crate::messages::{
    Covariance, Header, Odometry, Path, Pose, PoseStamped, PoseWithCovariance, TwistWithCovariance, Vector3,
};

/// Standard deviation of a coordinate that is exact by definition, as those of the first frame are, metres and radians: filters that
/// fuse odometry take a variance of zero for one that was left out. A millimetre is the last digit of the program's files.
const EXACT_SIGMA: f64 = 1e-3;
/// Standard deviation of a velocity that is not known, m/s and rad/s: no car is faster, and none turns so fast.
const UNKNOWN_VELOCITY_SIGMA: f64 = 100.0;

/// The distance between poses of the driven path, metres: less than a pixel of a map on a screen.
const PATH_STEP_M: f64 = 1.0;
/// Poses of the path: its message of 50 kB goes in one datagram of the loopback interface.
const PATH_POSES: usize = 500;

/// The estimate as a message.
pub(crate) fn odometry(stamp_ns: u64, estimate: &OdometryEstimate) -> Odometry {
    let unknown = || {
        let mut covariance = [0.0; 36];
        (0..6).for_each(|axis| covariance[axis * 7] = UNKNOWN_VELOCITY_SIGMA * UNKNOWN_VELOCITY_SIGMA);
        Velocity { forward_mps: 0.0, left_mps: 0.0, yaw_rate_rps: 0.0, covariance }
    };
    let velocity = estimate.velocity.clone().unwrap_or_else(unknown);
    Odometry {
        header: Header::new(stamp_ns, ODOM),
        child_frame_id: BASE_LINK.to_owned(),
        pose: PoseWithCovariance {
            pose: Pose::from(&estimate.odom_from_vehicle),
            covariance: doubted(estimate.pose_covariance),
        },
        twist: TwistWithCovariance {
            linear: Vector3 { x: velocity.forward_mps, y: velocity.left_mps, z: 0.0 },
            angular: Vector3 { x: 0.0, y: 0.0, z: velocity.yaw_rate_rps },
            covariance: doubted(velocity.covariance),
        },
    }
}

/// A covariance none of whose variances is zero.
fn doubted(mut covariance: [f64; 36]) -> Covariance {
    for axis in 0..6 {
        covariance[axis * 7] = covariance[axis * 7].max(EXACT_SIGMA * EXACT_SIGMA);
    }
    Covariance(covariance)
}

/// The way driven: a pose every metre, the newest ones.
#[derive(Debug, Default)]
pub(crate) struct DrivenPath {
    poses: VecDeque<(u64, Isometry2<f64>)>,
}

impl DrivenPath {
    /// Goes on to a pose. The path, where it has a new one.
    pub(crate) fn go_on(&mut self, stamp_ns: u64, odom_from_vehicle: &Isometry2<f64>) -> Option<Path> {
        let at = odom_from_vehicle.translation.vector;
        let from = self.poses.back().map(|(_, last)| last.translation.vector);
        if from.is_some_and(|from| (at - from).norm() < PATH_STEP_M) {
            return None;
        }
        if self.poses.len() == PATH_POSES {
            self.poses.pop_front();
        }
        self.poses.push_back((stamp_ns, *odom_from_vehicle));
        let poses = self.poses.iter().map(|(stamp_ns, pose)| PoseStamped {
            header: Header::new(*stamp_ns, ODOM),
            pose: Pose::from(pose),
        });
        Some(Path { header: Header::new(stamp_ns, ODOM), poses: poses.collect() })
    }
}

/// The driving line ahead, each pose towards the next; no poses where there is no line.
pub(crate) fn driving_line(stamp_ns: u64, line: &[Point2<f64>]) -> Path {
    let header = Header::new(stamp_ns, BASE_LINK);
    let along = line.windows(2).map(|ends| {
        let ahead = ends[1] - ends[0];
        Isometry2::new(ends[0].coords, libm::atan2(ahead.y, ahead.x))
    });
    let poses = along.map(|pose| PoseStamped { header: header.clone(), pose: Pose::from(&pose) }).collect();
    Path { header, poses }
}

#[cfg(test)]
mod tests {
    use fingerpost::motion::Motion;
    use fingerpost_record::recording::Odometry as DeadReckoning;
    use nalgebra::{Matrix3, Vector2};

    use super::*;

    /// A motion forward with a turn to the left, each coordinate with a variance of its own.
    fn motion() -> Motion {
        Motion {
            previous_from_current: Isometry2::new(Vector2::new(2.0, 0.1), 0.05),
            covariance: Matrix3::from_diagonal(&nalgebra::Vector3::new(0.04, 0.01, 0.0025)),
            quality: 1.0,
        }
    }

    #[test]
    fn the_first_pose_is_doubted_too() {
        let first = odometry(5, &DeadReckoning::default().estimate());
        assert_eq!((first.header.frame_id.as_str(), first.child_frame_id.as_str()), ("odom", "base_link"));
        for covariance in [first.pose.covariance, first.twist.covariance] {
            assert!((0..6).all(|axis| covariance.0[axis * 7] > 0.0), "{covariance:?}");
        }
        assert!(first.twist.covariance.0[0] > 100.0, "a velocity that nobody knows");
    }

    /// Expected: ROS orders x, y, z, roll, pitch, yaw; the plane's three are the 1st, 2nd and 6th.
    #[test]
    fn covariances_are_in_the_order_of_ros() {
        let mut reckoning = DeadReckoning::default();
        reckoning.go_on(Some(&motion()), Some(0.5));
        let sent = odometry(5, &reckoning.estimate());
        let (pose, twist) = (sent.pose.covariance.0, sent.twist.covariance.0);
        assert!((pose[0] - 0.04).abs() < 1e-9 && (pose[7] - 0.01).abs() < 1e-9);
        assert!((pose[35] - 0.0025).abs() < 1e-9 && pose[14] > 0.0 && pose[21] > 0.0 && pose[28] > 0.0);
        assert!((twist[0] - 0.16).abs() < 1e-9 && (twist[35] - 0.01).abs() < 1e-9);
        assert!((sent.twist.linear.x - 4.0).abs() < 1e-9 && (sent.twist.angular.z - 0.1).abs() < 1e-9);
        assert!(sent.pose.pose.position.y > 0.0 && sent.pose.pose.orientation.z > 0.0, "left is positive");
        for row in 0..6 {
            for column in 0..6 {
                assert!((pose[row * 6 + column] - pose[column * 6 + row]).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_path_has_a_pose_every_metre_and_forgets_the_oldest() {
        let mut path = DrivenPath::default();
        let mut sent = Vec::new();
        for step in 0..1500_u32 {
            let pose = Isometry2::new(Vector2::new(0.5 * f64::from(step), 0.0), 0.0);
            sent.extend(path.go_on(u64::from(step), &pose));
        }
        assert_eq!(sent.len(), 750);
        assert_eq!((sent[0].poses.len(), sent[749].poses.len()), (1, PATH_POSES));
        let last = &sent[749].poses;
        assert!((last[0].pose.position.x - 250.0).abs() < 1e-9);
        assert!((last[PATH_POSES - 1].pose.position.x - 749.0).abs() < 1e-9);
    }

    #[test]
    fn poses_of_the_driving_line_look_along_it() {
        let line = [Point2::new(5.0, 0.0), Point2::new(6.0, 0.0), Point2::new(6.0, 1.0)];
        let path = driving_line(7, &line);
        assert_eq!((path.header.frame_id.as_str(), path.poses.len()), ("base_link", 2));
        assert!(path.poses[0].pose.orientation.z.abs() < 1e-12);
        assert!((path.poses[1].pose.orientation.z - 0.5_f64.sqrt()).abs() < 1e-12, "to the left");
    }
}
