//! What the route's feature ahead says of the road: where it turns, and the line through it.

use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use super::band::Keeping;
use super::turn::{Corner, RoadLine};
use crate::feature_model::FeatureModel;

/// Turns under this, radians (20 degrees), are curves of the road.
const LEAST_TURN_RAD: f64 = 0.35;
/// How far a road's direction is from the map's, one standard deviation, radians: nodes half a metre off, 10 m apart.
const MAP_SIGMA_RAD: f64 = 0.07;
/// How far from the vehicle the driving line may be to be followed, metres: within half a wide road.
const MOST_BESIDE_M: f64 = 5.0;

/// The feature that is followed.
#[derive(Debug, Clone, Copy)]
pub struct Guide<'a> {
    /// Its corner on the road's middle, where the route turns there.
    pub(super) corner: Option<Corner>,
    /// The driving line from beside the vehicle on, vehicle frame, metres.
    line: &'a [Point2<f64>],
    /// Covariance of its forward (m), left (m) and heading (rad).
    covariance: Matrix3<f64>,
}

impl<'a> Guide<'a> {
    /// The guide of a followed feature by its pose, the covariance of its forward (m), left (m) and heading (rad), and its driving
    /// line in the vehicle frame, metres.
    pub fn new(
        model: &FeatureModel,
        (pose, covariance): (&Isometry2<f64>, &Matrix3<f64>),
        line: &'a [Point2<f64>],
    ) -> Self {
        let corner = model.approach().zip(model.exit()).map(|(approach, exit)| {
            let place = pose * Point2::origin();
            let of = |direction_rad: f64| pose.rotation.angle() + direction_rad;
            let heading_rad = of(approach.direction_rad() + std::f64::consts::PI);
            let sigma_m = covariance.fixed_view::<2, 2>(0, 0).trace().sqrt();
            let approach = RoadLine { place, heading_rad };
            let sigma_rad = covariance[(2, 2)].sqrt() + MAP_SIGMA_RAD;
            // The route says which arm is taken: the other is no way on.
            Corner {
                approach,
                exit_rad: of(exit.direction_rad()),
                sigma_m,
                sigma_rad,
                probability: 1.0,
                tee_probability: 0.0,
            }
        });
        let corner = corner.filter(|corner| corner.turn_rad().abs() > LEAST_TURN_RAD);
        Self { corner, line, covariance: *covariance }
    }

    /// Direction to steer in along the driving line and its standard deviation, radians; none where the line does not lead past
    /// the vehicle.
    pub(super) fn direction(&self, keeping: &Keeping) -> Option<(f64, f64)> {
        let nearest = |a: &(usize, &Point2<f64>), b: &(usize, &Point2<f64>)| {
            a.1.coords.norm_squared().total_cmp(&b.1.coords.norm_squared())
        };
        let (first, place) = self.line.iter().enumerate().min_by(nearest)?;
        if place.coords.norm() > MOST_BESIDE_M {
            return None;
        }
        let left = |i: usize| {
            let ends = self.line.get(i..i + 2).or_else(|| self.line.get(i.checked_sub(1)?..=i))?;
            let along = (ends[1] - ends[0]).try_normalize(0.0)?;
            Some(Vector2::new(-along.y, along.x))
        };
        let beside_m = -place.coords.dot(&left(first)?) * (1.0 - keeping.share);
        let aim = |i: usize| Some(self.line[i] + left(i)? * beside_m);
        let aim = (first..self.line.len())
            .filter_map(aim)
            .find(|place| place.coords.norm() >= keeping.look_ahead_m)?;
        let variance = self.covariance.fixed_view::<2, 2>(0, 0).trace() / aim.coords.norm_squared();
        Some((libm::atan2(aim.y, aim.x), (variance + self.covariance[(2, 2)]).sqrt()))
    }
}
