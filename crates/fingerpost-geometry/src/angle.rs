//! Headings and their differences.

use std::f64::consts::{PI, TAU};

use nalgebra::Vector2;

/// The same angle in (-pi, pi], radians.
///
/// ```
/// use std::f64::consts::PI;
/// assert!((fingerpost_geometry::wrap_angle(1.5 * PI) + 0.5 * PI).abs() < 1e-12);
/// ```
pub fn wrap_angle(angle_rad: f64) -> f64 {
    let wrapped = angle_rad.rem_euclid(TAU);
    if wrapped > PI { wrapped - TAU } else { wrapped }
}

/// Heading of a direction: radians anticlockwise from the first axis, in (-pi, pi].
pub fn heading_of(direction: Vector2<f64>) -> f64 {
    libm::atan2(direction.y, direction.x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_wrap_to_the_half_open_circle() {
        assert!((wrap_angle(-PI) - PI).abs() < 1e-12, "minus pi and pi are one heading");
        assert!((wrap_angle(7.0 * TAU + 0.3) - 0.3).abs() < 1e-9);
        assert!((heading_of(Vector2::new(0.0, 2.0)) - PI / 2.0).abs() < 1e-12, "left is positive");
    }
}
