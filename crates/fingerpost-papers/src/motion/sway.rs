//! The body's sway on its springs, as the ground view shows it.
//!
//! The ground view is made for the camera at rest. A camera turned by a small rotation (pitch p, roll r) shows the place
//! (X, Y), seen from height h, at (X + p (X^2 + h^2)/h - r XY/h, Y + p XY/h - r (Y^2 + h^2)/h). Left out, a tenth of a
//! degree of roll between two frames would read as half a degree of turn. So the fit to a flow carries three unknowns
//! beside the motion: the change of pitch, the change of roll, and a standing roll, as in a bend, which shears the
//! displacement. They are held small by priors and thrown away.
//!
//! A standing pitch is left out here: it stretches the displacement much as distance does, and is only told from it over
//! many frames, as the method's own alignment does.

use fingerpost::ground_view::Viewpoint;
use nalgebra::{Point2, Vector2};

/// Standard deviations of the change of pitch and of roll between frames, and of a standing roll, radians; a car on its
/// springs moves by a few tenths of a degree and leans by half a degree in a bend.
pub(super) const SWAY_SIGMA_RAD: [f64; 3] = [0.005, 0.005, 0.01];

/// How a place moves in the ground view for a unit of pitch and of roll.
pub(super) fn sway_field(p: Point2<f64>, viewpoint: Viewpoint) -> (Vector2<f64>, Vector2<f64>) {
    let (d, h) = (p - viewpoint.foot, viewpoint.height_m);
    let by_pitch = Vector2::new((d.x * d.x + h * h) / h, d.x * d.y / h);
    let by_roll = -Vector2::new(d.x * d.y / h, (d.y * d.y + h * h) / h);
    (by_pitch, by_roll)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The field of a small rotation against a camera that is really turned.
    #[test]
    fn the_sway_field_is_that_of_a_turned_camera() {
        use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
        let mount = Mount { x_m: 1.5, ..Mount::level(1.5) };
        let intrinsics = Intrinsics { fx: 400.0, fy: 400.0, cx: 320.0, cy: 100.0 };
        let camera = |mount| Camera::calibrated(640, 480, intrinsics, Distortion::None, mount).unwrap();
        let viewpoint = Viewpoint { foot: Point2::new(1.5, 0.0), height_m: 1.5 };
        let place = Point2::new(8.0, 2.0);
        let shown = |mount| {
            let pixel = camera(mount).pixel_of_ground(place).unwrap();
            camera(Mount { x_m: 1.5, ..Mount::level(1.5) }).ground_of_pixel(pixel).unwrap() - place
        };
        let (by_pitch, by_roll) = sway_field(place, viewpoint);
        let angle = 1e-5;
        assert!((shown(Mount { pitch_rad: angle, ..mount }) / angle - by_pitch).norm() < 0.01);
        let roll = shown(Mount { roll_rad: angle, ..mount }) / angle;
        assert!((roll - by_roll).norm() < 0.01, "{roll} {by_roll}");
    }
}
