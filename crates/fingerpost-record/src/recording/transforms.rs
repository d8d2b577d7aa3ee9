//! The frames of a recording and how they lie to each other.

use fingerpost_geometry::{Camera, Distortion, View};
use foxglove::messages::{
    CameraCalibration, FrameTransform, FrameTransforms, Pose, Quaternion, Timestamp, Vector3,
};
use nalgebra::{Isometry2, Isometry3, UnitQuaternion};

/// Where the drive began: x ahead, y left.
pub(crate) const ODOM: &str = "odom";
/// The vehicle: on the road below the rear axle's middle, x forward, y left, z up (REP 103).
pub(crate) const VEHICLE: &str = "vehicle";
/// The camera: x right, y down, z forward.
pub(crate) const CAMERA: &str = "camera";
/// The ground view's picture.
pub(crate) const GROUND: &str = "ground";

/// A pose on the road as one in space.
pub(crate) fn planar_pose(pose: &Isometry2<f64>) -> Pose {
    let at = pose.translation.vector;
    Pose {
        position: Some(Vector3 { x: at.x, y: at.y, z: 0.0 }),
        orientation: Some(quaternion(&UnitQuaternion::from_euler_angles(0.0, 0.0, pose.rotation.angle()))),
    }
}

pub(crate) fn quaternion(rotation: &UnitQuaternion<f64>) -> Quaternion {
    Quaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
}

/// The vehicle where it has come, with the camera on it where its mount is known.
pub(crate) fn transforms(
    timestamp: Timestamp,
    odom_from_vehicle: &Isometry2<f64>,
    camera: &Camera,
) -> FrameTransforms {
    let at = odom_from_vehicle.translation.vector;
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, odom_from_vehicle.rotation.angle());
    let vehicle = Isometry3::from_parts(at.push(0.0).into(), turn);
    let mut transforms = vec![transform(timestamp, ODOM, VEHICLE, &vehicle)];
    if let View::Calibrated { vehicle_from_camera, .. } = camera.view() {
        transforms.push(transform(timestamp, VEHICLE, CAMERA, vehicle_from_camera));
    }
    FrameTransforms { transforms }
}

fn transform(
    timestamp: Timestamp,
    parent: &str,
    child: &str,
    parent_from_child: &Isometry3<f64>,
) -> FrameTransform {
    let at = parent_from_child.translation.vector;
    FrameTransform {
        timestamp: Some(timestamp),
        parent_frame_id: parent.to_owned(),
        child_frame_id: child.to_owned(),
        translation: Some(Vector3 { x: at.x, y: at.y, z: at.z }),
        rotation: Some(quaternion(&parent_from_child.rotation)),
    }
}

/// The camera's intrinsics; none where only the road's plane is known.
pub(crate) fn calibration(timestamp: Timestamp, camera: &Camera) -> Option<CameraCalibration> {
    let View::Calibrated { intrinsics, distortion, .. } = camera.view() else { return None };
    let (distortion_model, d) = match distortion {
        Distortion::None => ("", Vec::new()),
        Distortion::BrownConrady { coefficients, .. } => ("rational_polynomial", coefficients.to_vec()),
        Distortion::KannalaBrandt { coefficients, .. } => ("kannala_brandt", coefficients.to_vec()),
    };
    let (fx, fy, cx, cy) = (intrinsics.fx, intrinsics.fy, intrinsics.cx, intrinsics.cy);
    Some(CameraCalibration {
        timestamp: Some(timestamp),
        frame_id: CAMERA.to_owned(),
        width: camera.width() as u32,
        height: camera.height() as u32,
        distortion_model: distortion_model.to_owned(),
        d,
        k: vec![fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: vec![1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: vec![fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
    })
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Intrinsics, Mount};
    use nalgebra::{Point3, Vector2};

    use super::*;

    #[test]
    fn the_camera_looks_ahead_of_a_vehicle_that_has_turned_left() {
        let intrinsics = Intrinsics { fx: 500.0, fy: 500.0, cx: 319.5, cy: 239.5 };
        let camera =
            Camera::calibrated(640, 480, intrinsics, Distortion::None, Mount::level(1.5)).expect("a camera");
        let pose = Isometry2::new(Vector2::new(10.0, 0.0), std::f64::consts::FRAC_PI_2);
        let both = transforms(Timestamp::MIN, &pose, &camera).transforms;
        let chain = both.iter().map(|t| {
            let (at, q) = (t.translation.as_ref().unwrap(), t.rotation.as_ref().unwrap());
            let turn = nalgebra::Quaternion::new(q.w, q.x, q.y, q.z);
            Isometry3::from_parts(
                nalgebra::Vector3::new(at.x, at.y, at.z).into(),
                UnitQuaternion::from_quaternion(turn),
            )
        });
        let odom_from_camera = chain.fold(Isometry3::identity(), |all, next| all * next);
        // 5 m in front of the lens: to the left of where it began, as high as the camera.
        let seen = odom_from_camera * Point3::new(0.0, 0.0, 5.0);
        assert!((seen - Point3::new(10.0, 5.0, 1.5)).norm() < 1e-9, "{seen}");
    }
}
