//! Where the road's middle beside the vehicle puts a feature, and so the driving line through it.
//!
//! A feature's place comes from its whole outline, metres ahead; how far beside the vehicle its approach runs, the
//! centreline measures where the vehicle is. That is one scalar measurement of the feature's pose, and a Kalman update
//! (Bar-Shalom, Li, Kirubarajan: Estimation with Applications to Tracking and Navigation, 2001, section 5.2.3) joins both, each as sure as it
//! is: the line then begins where the road does and bends where the feature is.

use nalgebra::{Isometry2, Matrix3, Point2, RowVector3, Vector2};

use crate::centreline::Centreline;
use crate::feature_model::FeatureModel;

/// An innovation of more standard deviations than this is of two different roads.
pub(super) const GATE_SIGMAS: f64 = 3.0;

/// A feature's pose, by the tracker or with the road's middle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FeaturePlace {
    pub(super) vehicle_from_feature: Isometry2<f64>,
    /// Covariance of its forward (m), left (m) and heading (rad).
    pub(super) covariance: Matrix3<f64>,
}

impl FeaturePlace {
    /// The same with the road's middle, where this frame shows an edge of it and it is the feature's road.
    pub(super) fn with_road(self, model: &FeatureModel, road: &Centreline) -> Self {
        if !road.is_shown {
            return self;
        }
        let Some((middle, direction)) = approach_beside(&self.vehicle_from_feature, model) else {
            return self;
        };
        let left = Vector2::new(-direction.y, direction.x);
        let by_pose = self.across_by_pose(middle, left);
        let across = libm::cos(road.heading_rad);
        let innovation_m = road.offset_m * across - left.dot(&middle.coords);
        let to_innovation = self.covariance * by_pose.transpose();
        let variance = (by_pose * to_innovation).x + (road.sigma_m * across).powi(2);
        if innovation_m * innovation_m > GATE_SIGMAS * GATE_SIGMAS * variance {
            return self;
        }
        let by = to_innovation * (innovation_m / variance);
        let Isometry2 { rotation, translation } = self.vehicle_from_feature;
        Self {
            vehicle_from_feature: Isometry2::new(translation.vector + by.xy(), rotation.angle() + by.z),
            covariance: self.covariance - to_innovation * to_innovation.transpose() / variance,
        }
    }

    /// How a place that belongs to the feature moves in a direction, by the feature's forward, left and heading.
    fn across_by_pose(&self, place: Point2<f64>, direction: Vector2<f64>) -> RowVector3<f64> {
        let lever = place.coords - self.vehicle_from_feature.translation.vector;
        RowVector3::new(direction.x, direction.y, direction.dot(&Vector2::new(-lever.y, lever.x)))
    }

    /// Standard deviation across a line through the feature at a place of it with a direction of length one, vehicle frame, metres.
    pub(super) fn sigma_across_m(&self, place: Point2<f64>, direction: Vector2<f64>) -> f64 {
        let by_pose = self.across_by_pose(place, Vector2::new(-direction.y, direction.x));
        (by_pose * self.covariance * by_pose.transpose()).x.max(0.0).sqrt()
    }
}

/// The place of the feature's approach that is nearest to the vehicle, and its direction as it is driven; vehicle frame. None where the
/// vehicle is nearer to the exit: behind a corner few edges tell the road's middle, and the line through the corner is surer.
fn approach_beside(
    vehicle_from_feature: &Isometry2<f64>,
    model: &FeatureModel,
) -> Option<(Point2<f64>, Vector2<f64>)> {
    let vehicle = vehicle_from_feature.inverse() * Point2::origin();
    let approach = model.approach()?;
    let foot = approach.course.nearest(vehicle);
    let beside_exit_m = model.exit().map(|exit| exit.course.nearest(vehicle).left_m.abs());
    let on_approach = foot.along_m > 0.0 && beside_exit_m.is_none_or(|m| m > foot.left_m.abs());
    let (place, outwards) = approach.course.at(foot.along_m);
    on_approach.then(|| (vehicle_from_feature * place, -(vehicle_from_feature * outwards)))
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::Polyline;
    use fingerpost_map::{ArmRole, FeatureKind};
    use nalgebra::Vector3;

    use super::*;
    use crate::feature_model::ArmModel;

    /// A junction at which the route turns left by a right angle.
    fn junction() -> FeatureModel {
        let arm = |role, label: &str, end: Point2<f64>| ArmModel {
            role,
            label: label.into(),
            course: Polyline::new([Point2::origin(), end]).unwrap(),
            width_m: 6.0,
            mouth_m: 3.0,
            leaves_after_m: None,
        };
        FeatureModel {
            id: 1,
            name: "A x B".to_owned(),
            kind: FeatureKind::Junction,
            route_m: 60.0,
            arms: vec![
                arm(ArmRole::Approach, "approach", Point2::new(-50.0, 0.0)),
                arm(ArmRole::Exit, "exit", Point2::new(0.0, 50.0)),
            ],
            map_from_feature: Isometry2::identity(),
        }
    }

    fn tracked(vehicle_from_feature: Isometry2<f64>) -> FeaturePlace {
        let covariance = Matrix3::from_diagonal(&Vector3::new(0.25, 0.25, 0.0004));
        FeaturePlace { vehicle_from_feature, covariance }
    }

    /// A road's middle that the frame shows.
    fn road(offset_m: f64) -> Centreline {
        Centreline { offset_m, sigma_m: 0.1, width_m: 6.0, is_shown: true, ..Centreline::default() }
    }

    #[test]
    fn the_approach_comes_to_lie_where_the_road_is_and_the_distance_stays() {
        let place = tracked(Isometry2::translation(20.0, 0.5));
        let aligned = place.with_road(&junction(), &road(0.1));
        let (middle, direction) = approach_beside(&aligned.vehicle_from_feature, &junction()).unwrap();
        // Across the vehicle the approach was known to the root of 0.5² + (20 x 0.02)² m: the road is surer.
        let gain = 0.41 / (0.41 + 0.01);
        let left_m = Vector2::new(-direction.y, direction.x).dot(&middle.coords);
        assert!((left_m - (0.5 - 0.4 * gain)).abs() < 0.01, "{left_m}");
        assert!((aligned.vehicle_from_feature.translation.x - 20.0).abs() < 1e-9);
        assert!(aligned.vehicle_from_feature.translation.y < 0.3, "to the right, as the road is");
        let sigma_m = |of: &FeaturePlace| of.sigma_across_m(Point2::new(0.0, 0.3), Vector2::x());
        assert!(sigma_m(&place) > 0.6 && sigma_m(&aligned) < 0.11);
    }

    #[test]
    fn another_road_and_one_that_is_not_seen_move_nothing() {
        let place = tracked(Isometry2::translation(20.0, 0.5));
        assert_eq!(place.with_road(&junction(), &road(4.0)), place);
        assert_eq!(place.with_road(&junction(), &road(0.1).unseen()), place);
    }

    #[test]
    fn behind_the_corner_the_feature_stays_where_it_is() {
        // 10 m on along the exit, and headed so.
        let place = tracked(Isometry2::new(Vector2::new(-10.0, 0.5), -std::f64::consts::FRAC_PI_2));
        assert_eq!(place.with_road(&junction(), &road(0.1)), place);
    }

    #[test]
    fn an_unsure_distance_is_across_the_exit() {
        let covariance = Matrix3::from_diagonal(&Vector3::new(1.0, 0.01, 0.0));
        let place = FeaturePlace { vehicle_from_feature: Isometry2::translation(10.0, 0.0), covariance };
        assert!((place.sigma_across_m(Point2::new(10.0, 8.0), Vector2::y()) - 1.0).abs() < 1e-9);
        assert!((place.sigma_across_m(Point2::new(2.0, 0.0), Vector2::x()) - 0.1).abs() < 1e-9);
    }
}
