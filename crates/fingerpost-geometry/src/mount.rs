//! Where the camera sits on the vehicle and where it looks.

use nalgebra::{Isometry3, Matrix3, Rotation3, Translation3, UnitQuaternion};

use crate::error::{GeometryError, check_range};

/// The camera's extrinsics: its place and direction in the vehicle frame.
///
/// The rotation is applied roll, then pitch, then yaw, each about the vehicle's own axes (REP 103, right-handed).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mount {
    /// Height of the optical centre above the road, metres.
    pub height_m: f64,
    /// Positive nose down, radians.
    pub pitch_rad: f64,
    /// Positive to the left, radians.
    pub yaw_rad: f64,
    /// Positive left side up, radians.
    pub roll_rad: f64,
    /// Forward of the rear axle's middle, metres.
    pub x_m: f64,
    /// Left of the vehicle's centre line, metres.
    pub y_m: f64,
}

impl Mount {
    /// A level camera on the vehicle's centre line above the rear axle.
    pub const fn level(height_m: f64) -> Self {
        Self { height_m, pitch_rad: 0.0, yaw_rad: 0.0, roll_rad: 0.0, x_m: 0.0, y_m: 0.0 }
    }

    /// Checks that a road vehicle could carry such a mount.
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] names the first number that is not finite or absurd.
    pub fn check(&self) -> Result<(), GeometryError> {
        // A camera below 5 cm sees no road; above 20 m it is not on a vehicle.
        check_range("mount.height_m", self.height_m, 0.05, 20.0, "0.05 to 20 metres above the road")?;
        check_angle("mount.pitch_deg", self.pitch_rad, "-80 to 80 degrees, positive nose down")?;
        check_angle("mount.yaw_deg", self.yaw_rad, "-80 to 80 degrees, positive left")?;
        check_angle("mount.roll_deg", self.roll_rad, "-80 to 80 degrees, positive left side up")?;
        check_range("mount.x_m", self.x_m, -30.0, 30.0, "-30 to 30 metres forward of the rear axle")?;
        check_range("mount.y_m", self.y_m, -5.0, 5.0, "-5 to 5 metres left of the centre line")
    }

    /// The rigid transform that takes a point in the camera frame (x right, y down, z forward) to the vehicle frame.
    pub fn vehicle_from_camera(&self) -> Isometry3<f64> {
        let vehicle_from_level_camera = Rotation3::from_matrix_unchecked(Matrix3::new(
            0.0, 0.0, 1.0, //
            -1.0, 0.0, 0.0, //
            0.0, -1.0, 0.0,
        ));
        let attitude = Rotation3::from_euler_angles(self.roll_rad, self.pitch_rad, self.yaw_rad);
        Isometry3::from_parts(
            Translation3::new(self.x_m, self.y_m, self.height_m),
            UnitQuaternion::from_rotation_matrix(&(attitude * vehicle_from_level_camera)),
        )
    }
}

/// Largest angle of a mount to either side, degrees: beyond, the camera does not look along the road.
const MAX_ANGLE_DEG: f64 = 80.0;

/// `Ok` when the angle is within [`MAX_ANGLE_DEG`]; the error tells it in degrees, as the files do.
fn check_angle(name: &'static str, angle_rad: f64, expected: &'static str) -> Result<(), GeometryError> {
    if angle_rad.abs() <= MAX_ANGLE_DEG.to_radians() {
        Ok(())
    } else {
        Err(GeometryError::OutOfRange { name, value: angle_rad.to_degrees(), expected })
    }
}

#[cfg(test)]
mod tests {
    use nalgebra::{Point3, Vector3};

    use super::*;

    fn forward(mount: Mount) -> Vector3<f64> {
        mount.vehicle_from_camera() * Vector3::z()
    }

    #[test]
    fn axes_of_a_level_mount() {
        let vehicle_from_camera = Mount::level(1.5).vehicle_from_camera();
        assert!(
            (vehicle_from_camera * Vector3::x() - Vector3::new(0.0, -1.0, 0.0)).norm() < 1e-12,
            "right is -y"
        );
        assert!(
            (vehicle_from_camera * Vector3::y() - Vector3::new(0.0, 0.0, -1.0)).norm() < 1e-12,
            "down is -z"
        );
        assert!((vehicle_from_camera * Point3::origin() - Point3::new(0.0, 0.0, 1.5)).norm() < 1e-12);
    }

    #[test]
    fn signs_of_the_angles() {
        assert!(
            forward(Mount { pitch_rad: 0.1, ..Mount::level(1.5) }).z < -0.09,
            "positive pitch looks down"
        );
        assert!(forward(Mount { yaw_rad: 0.1, ..Mount::level(1.5) }).y > 0.09, "positive yaw looks left");
        let rolled = Mount { roll_rad: 0.1, ..Mount::level(1.5) }.vehicle_from_camera();
        assert!((rolled * Vector3::x()).z < -0.09, "positive roll: left side up, right side down");
    }

    #[test]
    fn absurd_mounts_are_refused() {
        for (bad, name) in [
            (Mount::level(0.0), "mount.height_m"),
            (Mount::level(f64::NAN), "mount.height_m"),
            (Mount { pitch_rad: 1.5, ..Mount::level(1.5) }, "mount.pitch_deg"),
            (Mount { x_m: f64::INFINITY, ..Mount::level(1.5) }, "mount.x_m"),
        ] {
            assert!(bad.check().unwrap_err().to_string().starts_with(name));
        }
        let error = Mount { yaw_rad: 90_f64.to_radians(), ..Mount::level(1.5) }.check().unwrap_err();
        assert!(error.to_string().starts_with("mount.yaw_deg = 90 "), "{error}");
    }
}
