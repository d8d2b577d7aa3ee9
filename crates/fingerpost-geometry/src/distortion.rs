//! Lens distortion, in OpenCV's parametrisation.
//!
//! Brown-Conrady: D. C. Brown, "Decentering distortion of lenses", 1966, with the rational denominator of eight
//! coefficients. Kannala-Brandt: "A generic camera model and calibration method for conventional, wide-angle, and
//! fish-eye lenses", 2006, equation 6 in OpenCV's form theta_d = theta (1 + k1 theta^2 + ... + k4 theta^8).
//!
//! Limits: beyond the radius at which the radial polynomial turns back two directions would share a pixel; such
//! directions count as unseen.

use nalgebra::{Unit, Vector2, Vector3};

use crate::GeometryError;

/// How a lens bends directions before the intrinsics turn them into pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Distortion {
    /// A pinhole.
    None,
    /// Radial (rational) and tangential distortion.
    BrownConrady {
        /// `k1 k2 p1 p2 k3 k4 k5 k6`, missing ones zero.
        coefficients: [f64; 8],
        /// Largest undistorted radius (tangent of the angle off the axis) at which the model is still one-to-one.
        max_radius: f64,
    },
    /// Equidistant fish-eye polynomial.
    KannalaBrandt {
        /// `k1 k2 k3 k4`.
        coefficients: [f64; 4],
        /// Largest angle off the axis at which the model is still one-to-one, radians.
        max_angle_rad: f64,
    },
}

/// Radius (tangent of 86 degrees off the axis) beyond which no lens described by Brown-Conrady is used.
const BROWN_CONRADY_LIMIT: f64 = 15.0;
/// Step of the scan for the fold of a radial polynomial; far below a pixel of any camera.
const SCAN_STEPS: usize = 3000;

impl Distortion {
    /// Brown-Conrady distortion from 4, 5 or 8 coefficients in OpenCV's order `k1 k2 p1 p2 [k3 [k4 k5 k6]]`.
    ///
    /// # Errors
    /// [`GeometryError::CoefficientCount`] for any other number of them, [`GeometryError::OutOfRange`] for one that
    /// is not finite.
    pub fn brown_conrady(given: &[f64]) -> Result<Self, GeometryError> {
        if ![4, 5, 8].contains(&given.len()) {
            return Err(GeometryError::CoefficientCount {
                model: "brown-conrady",
                expected: "4, 5 or 8",
                found: given.len(),
            });
        }
        let mut coefficients = [0.0; 8];
        coefficients[..given.len()].copy_from_slice(given);
        check_finite(&coefficients)?;
        let max_radius = one_to_one_limit(BROWN_CONRADY_LIMIT, |r| r * radial_factor(&coefficients, r * r));
        Ok(Self::BrownConrady { coefficients, max_radius })
    }

    /// Kannala-Brandt distortion from its 4 coefficients.
    ///
    /// # Errors
    /// [`GeometryError::CoefficientCount`] for any other number of them, [`GeometryError::OutOfRange`] for one that
    /// is not finite.
    pub fn kannala_brandt(given: &[f64]) -> Result<Self, GeometryError> {
        let coefficients: [f64; 4] = given.try_into().map_err(|_| GeometryError::CoefficientCount {
            model: "kannala-brandt",
            expected: "4",
            found: given.len(),
        })?;
        check_finite(&coefficients)?;
        let max_angle_rad =
            one_to_one_limit(std::f64::consts::PI, |theta| theta_distorted(&coefficients, theta));
        Ok(Self::KannalaBrandt { coefficients, max_angle_rad })
    }

    /// Largest distance from the axis that the lens reaches in its picture, before the intrinsics, where a radial polynomial
    /// turns back there; none where it does not, and for a fish-eye lens, whose picture may end inside the frame.
    pub(crate) fn fold_radius(&self) -> Option<f64> {
        match self {
            Self::BrownConrady { coefficients, max_radius } if *max_radius < BROWN_CONRADY_LIMIT => {
                Some(max_radius * radial_factor(coefficients, max_radius * max_radius))
            }
            _ => None,
        }
    }

    /// Normalised picture coordinates (before the intrinsics) of a direction in the camera frame; none where the
    /// lens does not see.
    pub fn distort(&self, direction: Vector3<f64>) -> Option<Vector2<f64>> {
        match *self {
            Self::None => in_front(direction),
            Self::BrownConrady { coefficients, max_radius } => {
                let p = in_front(direction)?;
                (p.norm() < max_radius).then(|| brown_conrady_point(&coefficients, p))
            }
            Self::KannalaBrandt { coefficients, max_angle_rad } => {
                let radius = libm::hypot(direction.x, direction.y);
                let theta = libm::atan2(radius, direction.z);
                if !theta.is_finite() || theta >= max_angle_rad {
                    return None;
                }
                // On the axis the ratio theta_d / r tends to 1 / z and the point to the origin.
                let scale = if radius > 1e-12 { theta_distorted(&coefficients, theta) / radius } else { 0.0 };
                Some(Vector2::new(direction.x * scale, direction.y * scale))
            }
        }
    }

    /// The direction in the camera frame whose distorted point this is; none where no direction is.
    pub fn undistort(&self, distorted: Vector2<f64>) -> Option<Unit<Vector3<f64>>> {
        let direction = match *self {
            Self::None => Vector3::new(distorted.x, distorted.y, 1.0),
            Self::BrownConrady { coefficients, max_radius } => {
                let p = newton(distorted, max_radius, |p| brown_conrady_point(&coefficients, p))?;
                Vector3::new(p.x, p.y, 1.0)
            }
            Self::KannalaBrandt { coefficients, max_angle_rad } => {
                let radius = distorted.norm();
                if radius > theta_distorted(&coefficients, max_angle_rad) {
                    return None;
                }
                let theta = bisect(radius, max_angle_rad, |theta| theta_distorted(&coefficients, theta));
                let along = if radius > 1e-12 { distorted / radius } else { Vector2::zeros() };
                Vector3::new(along.x * libm::sin(theta), along.y * libm::sin(theta), libm::cos(theta))
            }
        };
        Unit::try_new(direction, 1e-12)
    }
}

fn check_finite(coefficients: &[f64]) -> Result<(), GeometryError> {
    match coefficients.iter().find(|value| !value.is_finite()) {
        None => Ok(()),
        Some(&value) => Err(GeometryError::OutOfRange {
            name: "distortion.coefficients",
            value,
            expected: "finite numbers",
        }),
    }
}

fn in_front(direction: Vector3<f64>) -> Option<Vector2<f64>> {
    // Closer than this to the image plane the tangent overflows any picture.
    (direction.z > 1e-6).then(|| Vector2::new(direction.x / direction.z, direction.y / direction.z))
}

fn radial_factor(k: &[f64; 8], r2: f64) -> f64 {
    (1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]))) / (1.0 + r2 * (k[5] + r2 * (k[6] + r2 * k[7])))
}

fn brown_conrady_point(k: &[f64; 8], p: Vector2<f64>) -> Vector2<f64> {
    let (r2, xy) = (p.norm_squared(), p.x * p.y);
    let radial = radial_factor(k, r2);
    Vector2::new(
        p.x * radial + 2.0 * k[2] * xy + k[3] * (r2 + 2.0 * p.x * p.x),
        p.y * radial + k[2] * (r2 + 2.0 * p.y * p.y) + 2.0 * k[3] * xy,
    )
}

fn theta_distorted(k: &[f64; 4], theta: f64) -> f64 {
    let t2 = theta * theta;
    theta * (1.0 + t2 * (k[0] + t2 * (k[1] + t2 * (k[2] + t2 * k[3]))))
}

/// Largest argument up to which `radial` still grows.
fn one_to_one_limit(end: f64, radial: impl Fn(f64) -> f64) -> f64 {
    let step = end / SCAN_STEPS as f64;
    let mut last = 0.0;
    for i in 1..=SCAN_STEPS {
        let value = radial(step * i as f64);
        if value <= last || !value.is_finite() {
            return step * (i - 1) as f64;
        }
        last = value;
    }
    end
}

fn bisect(target: f64, end: f64, growing: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, end);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if growing(middle) < target { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Inverse of `map` near the identity by Newton's method with a numeric Jacobian.
fn newton(
    target: Vector2<f64>,
    max_radius: f64,
    map: impl Fn(Vector2<f64>) -> Vector2<f64>,
) -> Option<Vector2<f64>> {
    const STEP: f64 = 1e-6;
    let mut p = if target.norm() < max_radius { target } else { target * (0.9 * max_radius / target.norm()) };
    for _ in 0..30 {
        let error = map(p) - target;
        if error.norm() < 1e-12 {
            break;
        }
        let column = |d: Vector2<f64>| (map(p + d * STEP) - map(p - d * STEP)) / (2.0 * STEP);
        let jacobian = nalgebra::Matrix2::from_columns(&[column(Vector2::x()), column(Vector2::y())]);
        let mut change = jacobian.try_inverse()? * error;
        // Half a focal length a step keeps the iteration on this side of the polynomial's fold.
        if change.norm() > 0.5 {
            change *= 0.5 / change.norm();
        }
        p -= change;
    }
    (p.norm() < max_radius && (map(p) - target).norm() < 1e-8).then_some(p)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn round_trip(distortion: Distortion, direction: Vector3<f64>) {
        let distorted = distortion.distort(direction).unwrap();
        let back = distortion.undistort(distorted).unwrap();
        assert!(back.cross(&direction.normalize()).norm() < 1e-7, "{direction:?} came back as {back:?}");
    }

    #[test]
    fn directions_survive_the_round_trip() {
        let brown = Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap();
        let rational =
            Distortion::brown_conrady(&[0.1, -0.02, 0.001, -0.001, 0.003, 0.12, 0.01, 0.002]).unwrap();
        let fish_eye = Distortion::kannala_brandt(&[-0.02, 0.004, -0.003, 0.0005]).unwrap();
        for x in [-0.4, -0.1, 0.0, 0.3] {
            for y in [-0.3, 0.0, 0.2] {
                let direction = Vector3::new(x, y, 1.0);
                round_trip(brown, direction);
                round_trip(rational, direction);
                round_trip(fish_eye, direction);
            }
        }
        round_trip(fish_eye, Vector3::new(2.5, 0.3, 0.2));
    }

    /// Reference values: OpenCV 5.0, `projectPoints` and `fisheye.projectPoints`, with unit intrinsics.
    #[test]
    fn agrees_with_opencv() {
        let brown = Distortion::brown_conrady(&[-0.264, 0.075, -0.0003, 0.0004, -0.146]).unwrap();
        let rational =
            Distortion::brown_conrady(&[0.1, -0.02, 0.001, -0.001, 0.003, 0.12, 0.01, 0.002]).unwrap();
        let fish_eye = Distortion::kannala_brandt(&[-0.02, 0.004, -0.003, 0.0005]).unwrap();
        for (distortion, expected) in [
            (brown, Vector2::new(0.2901480214, -0.1934363476)),
            (rational, Vector2::new(0.2986530229404492, -0.19905868196029947)),
            (fish_eye, Vector2::new(0.28725393240006614, -0.1915026216000441)),
        ] {
            let p = distortion.distort(Vector3::new(0.3, -0.2, 1.0)).unwrap();
            assert!((p - expected).norm() < 1e-9, "{distortion:?}: {p:?}");
        }
    }

    #[test]
    fn the_fold_of_a_barrel_lens_is_unseen() {
        let barrel = Distortion::brown_conrady(&[-0.3, 0.0, 0.0, 0.0]).unwrap();
        assert!(barrel.distort(Vector3::new(0.9, 0.0, 1.0)).is_some());
        assert!(
            barrel.distort(Vector3::new(1.2, 0.0, 1.0)).is_none(),
            "r (1 - 0.3 r^2) falls beyond r = 1.054"
        );
        assert!(Distortion::None.distort(Vector3::new(0.1, 0.1, -1.0)).is_none(), "behind the camera");
    }

    #[test]
    fn wrong_coefficients_are_refused() {
        assert!(matches!(
            Distortion::brown_conrady(&[0.1; 6]),
            Err(GeometryError::CoefficientCount { found: 6, .. })
        ));
        assert!(Distortion::kannala_brandt(&[0.1, 0.2, 0.3]).is_err());
        assert!(Distortion::brown_conrady(&[f64::NAN, 0.0, 0.0, 0.0]).is_err());
    }
}
