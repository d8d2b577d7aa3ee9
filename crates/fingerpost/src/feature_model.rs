//! A route feature in metres, in its own frame.
//!
//! The `feature` frame has its origin on the feature's node and its x axis along the direction of travel of the
//! approach there, so that a vehicle that drives straight towards the feature sees it at heading zero (paper 2,
//! section 4: the mask is rotated so that the approach is upright).

use std::sync::Arc;

use fingerpost_geometry::{GeometryError, Polyline, heading_of, wrap_angle};
use fingerpost_map::{ArmRole, FeatureKind, RouteFeature, TangentPlane, leaves_after_m};
use nalgebra::{Isometry2, Point2, Vector2};

/// One arm of a feature.
#[derive(Debug, Clone, PartialEq)]
pub struct ArmModel {
    /// What the route does with the arm.
    pub role: ArmRole,
    /// Name in records and pictures: `approach`, `exit`, `side_1`, ...
    pub label: Arc<str>,
    /// Its course from the node outwards, feature frame, metres.
    pub course: Polyline,
    /// Width of its road, metres.
    pub width_m: f64,
    /// Length from the node that lies on the crossing roads rather than on the arm itself, metres.
    pub mouth_m: f64,
    /// Of a bend's exit, the length from the node that lies on the road that would go straight on, metres; none of other arms.
    pub leaves_after_m: Option<f64>,
}

/// A route feature in its own frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureModel {
    /// OpenStreetMap node.
    pub id: i64,
    /// Name of the place.
    pub name: String,
    /// Junction, side road or bend.
    pub kind: FeatureKind,
    /// Distance along the route, metres.
    pub route_m: f64,
    /// Arms; the approach first, the exit second, then the sides.
    pub arms: Vec<ArmModel>,
    /// Where the feature lies on the map (origin: the route's first node).
    pub map_from_feature: Isometry2<f64>,
}

/// Length over which an arm's direction at the node is measured, metres: long enough to pass the short connecting
/// pieces that maps have within a junction, short enough to stay in view.
const DIRECTION_BASE_M: f64 = 8.0;
/// Two arms that differ by less than this sine run along one another and have no mouth on each other.
const MIN_CROSSING_SINE: f64 = 0.4;
/// An arm that differs from straight on by more than this angle leaves the line of the approach, radians: 25 degrees
/// carry it off a road 6 m wide within 7 m.
const LEAVING_RAD: f64 = 0.436;
/// Longest mouth believed, metres; beyond it nothing of an arm would be left in view.
const MAX_MOUTH_M: f64 = 6.0;

/// Length of a road that goes straight on, metres: farther than any view.
const STRAIGHT_ROAD_M: f64 = 60.0;

impl FeatureModel {
    /// The model of `feature` on the tangent plane `map`.
    ///
    /// # Errors
    /// [`GeometryError`] when an arm has no extent, as in a damaged route file.
    pub fn new(feature: &RouteFeature, map: &TangentPlane) -> Result<Self, GeometryError> {
        let node = map.map_from_wgs84(feature.at);
        let mut arms = Vec::new();
        for role in [ArmRole::Approach, ArmRole::Exit, ArmRole::Side] {
            for arm in feature.arms.iter().filter(|arm| arm.role == role) {
                let points = arm.points.iter().map(|&point| map.map_from_wgs84(point));
                let course_in_map = Polyline::new([node].into_iter().chain(points))?;
                arms.push((role, course_in_map, arm.width_m));
            }
        }
        let approach = arms.iter().find(|(role, ..)| *role == ArmRole::Approach);
        let approach_direction = approach.map_or(0.0, |(_, course, _)| {
            let base = DIRECTION_BASE_M.min(course.length_m());
            heading_of(node - course.at(base).0)
        });
        let approach_width_m = approach.map(|(.., width_m)| *width_m);
        let map_from_feature = Isometry2::new(node.coords, approach_direction);
        let feature_from_map = map_from_feature.inverse();
        let mut sides = 0;
        let mut arms: Vec<ArmModel> = arms
            .into_iter()
            .map(|(role, course, width_m)| ArmModel {
                role,
                label: match role {
                    ArmRole::Approach => "approach".into(),
                    ArmRole::Exit => "exit".into(),
                    ArmRole::Side => {
                        sides += 1;
                        format!("side_{sides}").into()
                    }
                },
                course: course.transformed(&feature_from_map),
                width_m,
                mouth_m: 0.0,
                leaves_after_m: None,
            })
            .collect();
        let directions: Vec<(f64, f64)> = arms.iter().map(|arm| (arm.direction_rad(), arm.width_m)).collect();
        for arm in &mut arms {
            arm.mouth_m = mouth_m(arm.direction_rad(), &directions);
        }
        // The very test by which the route was cut, so that a bend that is listed can be told.
        if feature.kind == FeatureKind::Bend {
            let half_width_m = approach_width_m.map_or(0.0, |width_m| 0.5 * width_m);
            for exit in arms.iter_mut().filter(|arm| arm.role == ArmRole::Exit) {
                exit.leaves_after_m = leaves_after_m(&exit.course, Vector2::x(), half_width_m);
            }
        }
        Ok(Self {
            id: feature.id,
            name: feature.name.clone(),
            kind: feature.kind,
            route_m: feature.route_m,
            arms,
            map_from_feature,
        })
    }

    /// The arm by which the vehicle comes.
    pub fn approach(&self) -> Option<&ArmModel> {
        self.arms.iter().find(|arm| arm.role == ArmRole::Approach)
    }

    /// The arm by which the vehicle leaves.
    pub fn exit(&self) -> Option<&ArmModel> {
        self.arms.iter().find(|arm| arm.role == ArmRole::Exit)
    }

    /// The road if the feature were not there: what stays on the line of the approach, which goes on straight where no arm does. Past a side
    /// road the route's own road goes on as it does, round a curve too, which is no evidence of the side road. Of a bend the approach is
    /// straight too, because it is a part of the bend.
    ///
    /// # Errors
    /// [`GeometryError`] as of [`Polyline::new`].
    pub fn without_feature(&self) -> Result<Self, GeometryError> {
        let straight = |x: f64| Polyline::new([Point2::origin(), Point2::new(x, 0.0)]);
        let is_of_road = |arm: &&ArmModel| {
            !arm.leaves_the_line() || (self.kind == FeatureKind::SideRoad && arm.role == ArmRole::Exit)
        };
        let mut arms: Vec<ArmModel> = self.arms.iter().filter(is_of_road).cloned().collect();
        if self.kind == FeatureKind::Bend {
            for arm in arms.iter_mut().filter(|arm| arm.role == ArmRole::Approach) {
                arm.course = straight(-STRAIGHT_ROAD_M)?;
            }
        }
        if let (true, Some(approach)) = (arms.len() < 2, self.approach()) {
            let straight_on = ArmModel {
                role: ArmRole::Side,
                label: "straight_on".into(),
                course: straight(STRAIGHT_ROAD_M)?,
                leaves_after_m: None,
                ..approach.clone()
            };
            arms.push(straight_on);
        }
        Ok(Self { arms, ..self.clone() })
    }

    /// The pose of the feature for a vehicle on the approach, `before_m` metres before the node along its course,
    /// `left_m` metres to the left of the road's middle, its nose turned left by `heading_rad` against the road.
    pub fn vehicle_from_feature(&self, before_m: f64, left_m: f64, heading_rad: f64) -> Isometry2<f64> {
        let on_course = match self.approach() {
            Some(arm) => {
                let (point, outwards) = arm.course.at(before_m);
                Isometry2::new(point.coords, heading_of(-outwards))
            }
            None => Isometry2::translation(-before_m, 0.0),
        };
        (on_course * Isometry2::new(Point2::new(0.0, left_m).coords, heading_rad)).inverse()
    }
}

impl FeatureModel {
    /// How far left of the middle of the approach the vehicle is, metres, for one that drives towards the node; the inverse of
    /// `left_m` in [`FeatureModel::vehicle_from_feature`].
    pub fn left_of_approach_m(&self, vehicle_from_feature: &Isometry2<f64>) -> f64 {
        let p_in_feature = vehicle_from_feature.inverse() * Point2::origin();
        // The course runs outwards from the node.
        self.approach().map_or(0.0, |arm| -arm.course.nearest(p_in_feature).left_m)
    }

    /// How far before the node the vehicle is along the approach, metres; the inverse of `before_m` in
    /// [`FeatureModel::vehicle_from_feature`].
    pub fn before_m(&self, vehicle_from_feature: &Isometry2<f64>) -> f64 {
        let p_in_feature = vehicle_from_feature.inverse() * Point2::origin();
        self.approach().map_or(-p_in_feature.x, |arm| arm.course.nearest(p_in_feature).along_m)
    }

    /// How far along the route the vehicle is, on the approach or the exit, whichever is nearer, metres; none without an approach.
    pub fn route_m_of_vehicle(&self, vehicle_from_feature: &Isometry2<f64>) -> Option<f64> {
        let p_in_feature = vehicle_from_feature.inverse() * Point2::origin();
        let before = self.approach()?.course.nearest(p_in_feature);
        let behind = self.exit().map(|arm| arm.course.nearest(p_in_feature));
        Some(match behind {
            Some(behind) if behind.left_m.abs() < before.left_m.abs() => self.route_m + behind.along_m,
            _ => self.route_m - before.along_m,
        })
    }

    /// How far the vehicle's nose is turned left of the approach where the vehicle is, radians; the inverse of the heading
    /// in [`FeatureModel::vehicle_from_feature`].
    pub fn heading_off_approach_rad(&self, vehicle_from_feature: &Isometry2<f64>) -> f64 {
        let p_in_feature = vehicle_from_feature.inverse() * Point2::origin();
        let road_rad = self.approach().map_or(0.0, |arm| {
            let (_, outwards) = arm.course.at(arm.course.nearest(p_in_feature).along_m);
            heading_of(-outwards)
        });
        wrap_angle(-vehicle_from_feature.rotation.angle() - road_rad)
    }
}

impl ArmModel {
    /// Whether the arm leaves the line of the approach: without such an arm a plain road would match.
    pub fn leaves_the_line(&self) -> bool {
        let leaves_soon = self.direction_rad().abs() > LEAVING_RAD || self.leaves_after_m.is_some();
        self.role != ArmRole::Approach && leaves_soon
    }

    /// Direction of the arm leaving the node, feature frame, radians.
    pub fn direction_rad(&self) -> f64 {
        heading_of(self.course.at(DIRECTION_BASE_M.min(self.course.length_m())).0.coords)
    }
}

fn mouth_m(direction_rad: f64, arms: &[(f64, f64)]) -> f64 {
    arms.iter()
        .map(|&(other_rad, width_m)| (0.5 * width_m, libm::sin(other_rad - direction_rad).abs()))
        .filter(|&(_, sine)| sine > MIN_CROSSING_SINE)
        .map(|(half_width, sine)| half_width / sine)
        .fold(0.0, f64::max)
        .min(MAX_MOUTH_M)
}
