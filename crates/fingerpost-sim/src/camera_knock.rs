//! A camera that is knocked out of place on the way.

use std::f64::consts::TAU;

use fingerpost_geometry::Mount;

use crate::noise::Stream;

/// Where on the drive it happens, shares of its length.
const WHERE: [f64; 2] = [0.2, 0.6];

/// When and how a camera is turned.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CameraKnock {
    /// Where along the route it happens, metres.
    at_m: f64,
    /// By how much the camera then looks lower, and farther to the left, radians.
    pitch_rad: f64,
    yaw_rad: f64,
}

impl CameraKnock {
    /// A knock by this angle somewhere between two places of the route, metres; none by no angle.
    pub(crate) fn new(seed: u64, angle_rad: f64, [from_m, to_m]: [f64; 2]) -> Option<Self> {
        let mut stream = Stream::new(seed, 0x4b4e_4f43);
        let at_m = from_m + (to_m - from_m) * stream.between(WHERE[0], WHERE[1]);
        let (sin, cos) = libm::sincos(stream.between(0.0, TAU));
        (angle_rad > 0.0).then_some(Self { at_m, pitch_rad: angle_rad * sin, yaw_rad: angle_rad * cos })
    }

    /// The mount at a place of the route, metres.
    pub(crate) fn on(&self, mount: Mount, route_m: f64) -> Mount {
        if route_m < self.at_m {
            return mount;
        }
        Mount { pitch_rad: mount.pitch_rad + self.pitch_rad, yaw_rad: mount.yaw_rad + self.yaw_rad, ..mount }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_camera_is_turned_by_the_angle_from_somewhere_on() {
        let mount = Mount::level(1.5);
        for seed in 0..20 {
            let knock = CameraKnock::new(seed, 0.03, [10.0, 110.0]).unwrap();
            assert_eq!(knock.on(mount, 29.0), mount);
            let after = knock.on(mount, 71.0);
            let turned_rad = libm::hypot(after.pitch_rad - mount.pitch_rad, after.yaw_rad - mount.yaw_rad);
            assert!((turned_rad - 0.03).abs() < 1e-12);
        }
        assert_eq!(CameraKnock::new(1, 0.0, [10.0, 110.0]), None);
    }
}
