//! The messages that are sent, field by field as ROS 2 defines them (from Humble on), for CDR.
//!
//! Source: the `.msg` files of `std_msgs`, `geometry_msgs`, `nav_msgs`, `sensor_msgs`, `visualization_msgs`, `diagnostic_msgs`,
//! `tf2_msgs` and `ackermann_msgs`.

use nalgebra::{Isometry2, UnitQuaternion};
use serde::ser::SerializeTuple;
use serde::{Serialize, Serializer};

/// Nanoseconds in a second.
const SECOND_NS: u64 = 1_000_000_000;

/// `builtin_interfaces/Time`
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Time {
    pub(crate) sec: i32,
    pub(crate) nanosec: u32,
}

impl Time {
    /// A time in nanoseconds; of one beyond 2038, which ROS does not have, the last second that it has.
    pub(crate) fn of(stamp_ns: u64) -> Self {
        let sec = i32::try_from(stamp_ns / SECOND_NS).unwrap_or(i32::MAX);
        Self { sec, nanosec: (stamp_ns % SECOND_NS) as u32 }
    }
}

/// `builtin_interfaces/Duration`; zero is without end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Lifetime {
    pub(crate) sec: i32,
    pub(crate) nanosec: u32,
}

/// `std_msgs/Header`
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub(crate) struct Header {
    pub(crate) stamp: Time,
    pub(crate) frame_id: String,
}

impl Header {
    pub(crate) fn new(stamp_ns: u64, frame_id: &str) -> Self {
        Self { stamp: Time::of(stamp_ns), frame_id: frame_id.to_owned() }
    }
}

/// `geometry_msgs/Point` and `geometry_msgs/Vector3`, which have the same fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Vector3 {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
}

/// `geometry_msgs/Quaternion`
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Quaternion {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) z: f64,
    pub(crate) w: f64,
}

impl Default for Quaternion {
    fn default() -> Self {
        Self { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }
    }
}

/// `geometry_msgs/Pose`, and `geometry_msgs/Transform`, which has the same fields.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Pose {
    pub(crate) position: Vector3,
    pub(crate) orientation: Quaternion,
}

impl From<&Isometry2<f64>> for Pose {
    /// A pose on the road's plane, turned about z.
    fn from(pose: &Isometry2<f64>) -> Self {
        let at = pose.translation.vector;
        let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, pose.rotation.angle());
        Self {
            position: Vector3 { x: at.x, y: at.y, z: 0.0 },
            orientation: Quaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w },
        }
    }
}

/// A `float64[36]`: over x, y, z and the turns about them, row by row.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Covariance(pub(crate) [f64; 36]);

impl Serialize for Covariance {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut numbers = serializer.serialize_tuple(self.0.len())?;
        self.0.iter().try_for_each(|number| numbers.serialize_element(number))?;
        numbers.end()
    }
}

/// `geometry_msgs/PoseWithCovariance`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct PoseWithCovariance {
    pub(crate) pose: Pose,
    pub(crate) covariance: Covariance,
}

/// `geometry_msgs/TwistWithCovariance`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TwistWithCovariance {
    pub(crate) linear: Vector3,
    pub(crate) angular: Vector3,
    pub(crate) covariance: Covariance,
}

/// `nav_msgs/Odometry`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Odometry {
    pub(crate) header: Header,
    pub(crate) child_frame_id: String,
    pub(crate) pose: PoseWithCovariance,
    pub(crate) twist: TwistWithCovariance,
}

/// `geometry_msgs/PoseStamped`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct PoseStamped {
    pub(crate) header: Header,
    pub(crate) pose: Pose,
}

/// `nav_msgs/Path`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Path {
    pub(crate) header: Header,
    pub(crate) poses: Vec<PoseStamped>,
}

/// `geometry_msgs/TransformStamped`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TransformStamped {
    pub(crate) header: Header,
    pub(crate) child_frame_id: String,
    pub(crate) transform: Pose,
}

/// `tf2_msgs/TFMessage`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct TfMessage {
    pub(crate) transforms: Vec<TransformStamped>,
}

/// `sensor_msgs/NavSatFix`, its status with it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct NavSatFix {
    pub(crate) header: Header,
    pub(crate) status: i8,
    pub(crate) service: u16,
    pub(crate) latitude: f64,
    pub(crate) longitude: f64,
    pub(crate) altitude: f64,
    pub(crate) position_covariance: [f64; 9],
    pub(crate) position_covariance_type: u8,
}

/// `ackermann_msgs/AckermannDrive`; rates of zero are as fast as possible.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct AckermannDrive {
    /// Yaw of a wheel in the middle of the front axle, radians, positive to the left.
    pub(crate) steering_angle: f32,
    pub(crate) steering_angle_velocity: f32,
    /// Of the rear axle's middle, m/s, positive forward.
    pub(crate) speed: f32,
    pub(crate) acceleration: f32,
    pub(crate) jerk: f32,
}

/// `ackermann_msgs/AckermannDriveStamped`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct AckermannDriveStamped {
    pub(crate) header: Header,
    pub(crate) drive: AckermannDrive,
}

/// `std_msgs/ColorRGBA`
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct Colour {
    pub(crate) r: f32,
    pub(crate) g: f32,
    pub(crate) b: f32,
    pub(crate) a: f32,
}

/// `sensor_msgs/CompressedImage`
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub(crate) struct CompressedImage {
    pub(crate) header: Header,
    pub(crate) format: String,
    pub(crate) data: Vec<u8>,
}

/// `visualization_msgs/MeshFile`
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub(crate) struct MeshFile {
    pub(crate) filename: String,
    pub(crate) data: Vec<u8>,
}

/// `visualization_msgs/Marker`
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct Marker {
    pub(crate) header: Header,
    pub(crate) ns: String,
    pub(crate) id: i32,
    pub(crate) kind: i32,
    pub(crate) action: i32,
    pub(crate) pose: Pose,
    pub(crate) scale: Vector3,
    pub(crate) colour: Colour,
    pub(crate) lifetime: Lifetime,
    pub(crate) frame_locked: bool,
    pub(crate) points: Vec<Vector3>,
    pub(crate) colours: Vec<Colour>,
    pub(crate) texture_resource: String,
    pub(crate) texture: CompressedImage,
    pub(crate) uv_coordinates: Vec<[f32; 2]>,
    pub(crate) text: String,
    pub(crate) mesh_resource: String,
    pub(crate) mesh_file: MeshFile,
    pub(crate) mesh_use_embedded_materials: bool,
}

/// `visualization_msgs/MarkerArray`
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct MarkerArray {
    pub(crate) markers: Vec<Marker>,
}

/// `diagnostic_msgs/KeyValue`
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct KeyValue {
    pub(crate) key: String,
    pub(crate) value: String,
}

/// `diagnostic_msgs/DiagnosticStatus`
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct DiagnosticStatus {
    pub(crate) level: u8,
    pub(crate) name: String,
    pub(crate) message: String,
    pub(crate) hardware_id: String,
    pub(crate) values: Vec<KeyValue>,
}

/// `diagnostic_msgs/DiagnosticArray`
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(crate) struct DiagnosticArray {
    pub(crate) header: Header,
    pub(crate) status: Vec<DiagnosticStatus>,
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use nalgebra::Vector2;

    use super::*;

    #[test]
    fn times_are_seconds_and_nanoseconds() {
        assert_eq!(Time::of(1_700_000_123_456_789_001), Time { sec: 1_700_000_123, nanosec: 456_789_001 });
        assert_eq!(Time::of(u64::MAX).sec, i32::MAX);
    }

    /// Expected: a quarter turn to the left is a quarter turn about z, which points up (REP 103).
    #[test]
    fn a_turn_to_the_left_is_about_z() {
        let pose = Pose::from(&Isometry2::new(Vector2::new(3.0, 2.0), FRAC_PI_2));
        assert_eq!((pose.position.x, pose.position.y, pose.position.z), (3.0, 2.0, 0.0));
        let half = 0.5_f64.sqrt();
        assert!((pose.orientation.z - half).abs() < 1e-12 && (pose.orientation.w - half).abs() < 1e-12);
        assert!(pose.orientation.x.abs() < 1e-12 && pose.orientation.y.abs() < 1e-12);
    }
}
