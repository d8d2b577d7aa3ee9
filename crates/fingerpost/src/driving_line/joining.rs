//! Driving lines of all features of a route: where two are near each other they share the road between them, and what leads out of one
//! goes through the other.

use fingerpost_geometry::GeometryError;
use nalgebra::{Isometry2, Point2};

use super::{CornerSetting, DrivingLine, DrivingLineConfig};
use crate::feature_model::{ArmModel, FeatureModel};
use crate::vehicle::VehicleConfig;

/// Lines of two features on the road between them are at most so far apart where one goes on as the other, metres: both are in its
/// lane, and each spreads the map's corners for itself.
const MOST_APART_M: f64 = 1.0;

/// The driving line of each of a route's features, round kerbs of this radius, metres.
///
/// # Errors
/// [`GeometryError`] when the arms of a feature leave no room for a curve.
pub(crate) fn driving_lines(
    config: &DrivingLineConfig,
    vehicle: &VehicleConfig,
    kerb_radius_m: f64,
    features: &[FeatureModel],
) -> Result<Vec<Option<DrivingLine>>, GeometryError> {
    let line = |feature: &FeatureModel, own_m| {
        DrivingLine::new(config, vehicle, feature, &CornerSetting { kerb_radius_m, own_m })
    };
    let mut alone = Vec::with_capacity(features.len());
    for feature in features {
        alone.push(line(feature, [f64::INFINITY; 2])?);
    }
    let mut own_m = vec![[f64::INFINITY; 2]; features.len()];
    for (i, pair) in features.windows(2).enumerate() {
        let turns = |feature: &FeatureModel| feature.exit().is_some_and(ArmModel::leaves_the_line);
        let (Some(one), Some(next)) = (&alone[i], &alone[i + 1]) else { continue };
        if turns(&pair[0])
            && turns(&pair[1])
            && let Some([behind_m, before_m]) = one.share(&from_next(&pair[0], &pair[1]), next)
        {
            (own_m[i][1], own_m[i + 1][0]) = (behind_m, before_m);
        }
    }
    for ((feature, own_m), alone) in features.iter().zip(own_m).zip(&mut alone) {
        if own_m.iter().any(|m| m.is_finite()) {
            *alone = line(feature, own_m)?;
        }
    }
    let mut joined = alone.clone();
    for (i, pair) in features.windows(2).enumerate() {
        let from_next = from_next(&pair[0], &pair[1]);
        if let (Some(one), Some(next)) = (&alone[i], &alone[i + 1]) {
            if let Some(line) = &mut joined[i] {
                line.lead_into(config, &from_next, next);
            }
            if let Some(line) = &mut joined[i + 1] {
                line.lead_from(config, &from_next.inverse(), one);
            }
        }
    }
    Ok(joined)
}

/// Where the next feature lies in the frame of one.
fn from_next(feature: &FeatureModel, next: &FeatureModel) -> Isometry2<f64> {
    feature.map_from_feature.inv_mul(&next.map_from_feature)
}

impl DrivingLine {
    /// How far behind the node its curve may end, and how far before the next node that of the next feature may begin, metres; none where
    /// there is room for both. What one has more than the turning circle asks for it gives first.
    fn share(&self, from_next: &Isometry2<f64>, next: &Self) -> Option<[f64; 2]> {
        let room_m = (from_next * next.control[1] - self.control[1]).norm();
        let legs_m = [(self.control[2] - self.control[1]).norm(), (next.control[1] - next.control[0]).norm()];
        let short_m = legs_m[0] + legs_m[1] - room_m;
        if short_m <= 0.0 {
            return None;
        }
        let spare_m = [self.spare_m(legs_m[0]), next.spare_m(legs_m[1])];
        let spares_m = spare_m[0] + spare_m[1];
        let shares = if short_m < spares_m { spare_m.map(|m| m / spares_m) } else { [0.5; 2] };
        let setbacks_m = [self.setbacks_m[1], next.setbacks_m[0]];
        Some([0, 1].map(|i| (setbacks_m[i] - short_m * shares[i]).max(0.0)))
    }

    /// How much shorter a leg of its curve may be, metres.
    fn spare_m(&self, leg_m: f64) -> f64 {
        let [start, corner, end] = self.control;
        let turn_rad = (corner - start).angle(&(end - corner));
        (leg_m - self.turning_radius_m * libm::tan(0.5 * turn_rad)).max(0.0)
    }

    /// Goes on through the curve of the next feature.
    fn lead_into(&mut self, config: &DrivingLineConfig, from_next: &Isometry2<f64>, next: &Self) {
        let (leads_at, next_at) = (self.index_near(self.end()), next.index_near(next.start()));
        let Some(joint) = self.meets(leads_at..self.points.len(), from_next * next.start()) else { return };
        let count = (config.lead_points() + leads_at).saturating_sub(joint);
        let taken = next_at..next.points.len().min(next_at + count);
        self.points.truncate(joint);
        self.curvature_per_m.truncate(joint);
        self.points.extend(next.points[taken.clone()].iter().map(|point| from_next * point));
        self.curvature_per_m.extend_from_slice(&next.curvature_per_m[taken]);
    }

    /// Comes from the curve of the last feature.
    fn lead_from(&mut self, config: &DrivingLineConfig, from_last: &Isometry2<f64>, last: &Self) {
        let (leads_to, last_at) = (self.index_near(self.start()), last.index_near(last.end()));
        let Some(joint) = self.meets(0..leads_to + 1, from_last * last.end()) else { return };
        let count = config.lead_points().saturating_sub(leads_to - joint);
        let taken = (last_at + 1).saturating_sub(count)..last_at + 1;
        let points = last.points[taken.clone()].iter().map(|point| from_last * point);
        self.points.splice(..=joint, points);
        self.curvature_per_m.splice(..=joint, last.curvature_per_m[taken].iter().copied());
    }

    /// The point among those of a lead at which it comes to a place of another line; none where it does not.
    fn meets(&self, lead: std::ops::Range<usize>, place: Point2<f64>) -> Option<usize> {
        let apart_m = |i: usize| (self.points[i] - place).norm();
        let nearest = lead.min_by(|&a, &b| apart_m(a).total_cmp(&apart_m(b)))?;
        (apart_m(nearest) < MOST_APART_M).then_some(nearest)
    }

    /// The point nearest to a place.
    fn index_near(&self, place: Point2<f64>) -> usize {
        let apart_m = |i: &usize| (self.points[*i] - place).norm();
        (0..self.points.len()).min_by(|a, b| apart_m(a).total_cmp(&apart_m(b))).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;
    use std::sync::Arc;

    use fingerpost_geometry::Polyline;
    use fingerpost_map::{ArmRole, FeatureKind};
    use nalgebra::Vector2;

    use super::*;

    const APART_M: f64 = 12.0;

    fn model(
        arms: [(ArmRole, &[[f64; 2]]); 2],
        route_m: f64,
        map_from_feature: Isometry2<f64>,
    ) -> FeatureModel {
        let arms = arms.map(|(role, course)| ArmModel {
            role,
            label: Arc::from("arm"),
            course: Polyline::new(course.iter().map(|&[x, y]| Point2::new(x, y))).unwrap(),
            width_m: 6.0,
            mouth_m: 3.0,
            leaves_after_m: None,
        });
        let (name, kind) = (String::new(), FeatureKind::Junction);
        FeatureModel { id: 1, name, kind, route_m, arms: arms.into(), map_from_feature }
    }

    /// A left turn, and after 12 m a right one: the road jumps 12 m to the left.
    fn jog() -> Vec<(FeatureModel, Option<DrivingLine>)> {
        let config = DrivingLineConfig::default();
        let first = model(
            [
                (ArmRole::Approach, &[[0.0, 0.0], [-60.0, 0.0]]),
                (ArmRole::Exit, &[[0.0, 0.0], [0.0, APART_M], [60.0, APART_M]]),
            ],
            60.0,
            Isometry2::identity(),
        );
        // Its frame is turned left by a right angle.
        let second = model(
            [
                (ArmRole::Approach, &[[0.0, 0.0], [-APART_M, 0.0], [-APART_M, 60.0]]),
                (ArmRole::Exit, &[[0.0, 0.0], [0.0, -60.0]]),
            ],
            60.0 + APART_M,
            Isometry2::new(Vector2::new(0.0, APART_M), FRAC_PI_2),
        );
        let features = vec![first, second];
        let lines = driving_lines(&config, &VehicleConfig::default(), 4.0, &features).unwrap();
        features.into_iter().zip(lines).collect()
    }

    /// Radius at the tightest place of a line's points, by the turn over 2 m of it, metres.
    fn tightest_m(points: &[Point2<f64>]) -> f64 {
        let turn_rad = |of: &[Point2<f64>]| (of[2] - of[0]).angle(&(of[6] - of[4]));
        points.windows(7).map(|of| (of[4] - of[0]).norm() / turn_rad(of)).fold(f64::INFINITY, f64::min)
    }

    #[test]
    fn two_turns_near_each_other_are_one_line_that_can_be_driven() {
        let features = jog();
        for (model, line) in &features {
            let line = line.as_ref().unwrap();
            assert!(line.within_turning_circle(), "{} m", line.tightest_radius_m);
            assert!(tightest_m(&line.points) > 4.0, "{} m", tightest_m(&line.points));
            assert_eq!(line.points.len(), line.curvature_per_m.len());
            let steps_m = line.points.windows(2).map(|of| (of[1] - of[0]).norm());
            assert!(steps_m.clone().all(|m| (0.2..0.8).contains(&m)), "{:?}", steps_m.collect::<Vec<_>>());
            // Both lead through both corners, in the lane.
            let on_map = |p: &Point2<f64>| model.map_from_feature * p;
            let (start, end) = (on_map(&line.points[0]), on_map(line.points.last().unwrap()));
            assert!(start.x < -8.0 && (start.y + 1.5).abs() < 0.1, "{start}");
            assert!(end.x > 8.0 && (end.y - APART_M + 1.5).abs() < 0.1, "{end}");
        }
    }

    #[test]
    fn the_curvature_goes_from_left_to_right() {
        for (_, line) in jog() {
            let curvature = line.unwrap().curvature_per_m;
            let left = curvature.iter().position(|&c| c > 0.1).unwrap();
            let right = curvature.iter().rposition(|&c| c < -0.1).unwrap();
            assert!(left < right);
        }
    }
}
