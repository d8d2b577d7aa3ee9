//! Lines on the road as scene entities, in the vehicle frame.

use fingerpost::centreline::Centreline;
use fingerpost::feature_model::FeatureModel;
use fingerpost::lanes::Lane;
use fingerpost::track::Followed;
use fingerpost_geometry::heading_of;
use fingerpost_report::sub_mask_colour;
use foxglove::messages::line_primitive::Type;
use foxglove::messages::{
    LinePrimitive, Point3, Pose, PosesInFrame, Quaternion, SceneEntity, SceneUpdate, SpherePrimitive,
    TextPrimitive, Timestamp, Vector3,
};
use nalgebra::{Isometry2, Point2};

use super::colour::{CENTRELINE, FEATURE, LANE, colour};
use super::transforms::{VEHICLE, planar_pose};

/// How far lines of the road are drawn, metres: the reach of the default ground view.
const REACH_M: f64 = 20.0;
/// How far from the node arms are drawn, metres.
const ARM_LENGTH_M: f64 = 25.0;
/// Height over the road at which lines are drawn, metres: in front of the surface and not in it.
const OVER_ROAD_M: f64 = 0.02;
/// Points of a curve over its length.
const CURVE_POINTS: usize = 21;

/// The followed feature: its arms from the node outwards, and the node with its distance. Without one, what was there goes.
/// Metres in the vehicle frame.
pub fn feature_entities(timestamp: Timestamp, followed: Option<(&Followed, &FeatureModel)>) -> SceneUpdate {
    let Some((followed, model)) = followed else {
        return entity(timestamp, "feature", SceneEntity::default());
    };
    let pose = &followed.vehicle_from_feature;
    let lines = model.arms.iter().map(|arm| {
        let course = arm.course.transformed(pose);
        let length_m = ARM_LENGTH_M.min(course.length_m());
        let along = (0..CURVE_POINTS).map(|i| length_m * i as f64 / (CURVE_POINTS - 1) as f64);
        strip(along.map(|along_m| course.at(along_m).0), sub_mask_colour(&arm.label), arm.width_m, 0.35)
    });
    let at = pose.translation.vector;
    let sigma = |axis: usize| 2.0 * followed.covariance[(axis, axis)].max(0.0).sqrt();
    // As wide as two standard deviations on either side.
    let node = SpherePrimitive {
        pose: Some(pose_at(at.x, at.y)),
        size: Some(Vector3 { x: 2.0 * sigma(0), y: 2.0 * sigma(1), z: 0.1 }),
        color: Some(colour(FEATURE, 0.6)),
    };
    let text = TextPrimitive {
        pose: Some(pose_at(at.x, at.y)),
        billboard: true,
        font_size: 14.0,
        scale_invariant: true,
        color: Some(colour(FEATURE, 1.0)),
        text: format!("{} {:.1} m, present {:.2}", model.id, at.x, followed.present),
    };
    let drawn = SceneEntity {
        lines: lines.collect(),
        spheres: vec![node],
        texts: vec![text],
        ..SceneEntity::default()
    };
    entity(timestamp, "feature", drawn)
}

/// The driving line at the vehicle's width.
pub(crate) fn driving_line(timestamp: Timestamp, line: &[Point2<f64>], vehicle_width_m: f64) -> SceneUpdate {
    let ribbon = strip(line.iter().copied(), sub_mask_colour("driving_line"), vehicle_width_m, 0.4);
    let lines = if line.len() < 2 { Vec::new() } else { vec![ribbon] };
    entity(timestamp, "driving_line", SceneEntity { lines, ..SceneEntity::default() })
}

/// The same as the poses along it, each towards the next, for viewers that draw paths.
pub(crate) fn driving_line_poses(timestamp: Timestamp, line: &[Point2<f64>]) -> PosesInFrame {
    let along = line.windows(2).map(|ends| {
        let heading_rad = heading_of(ends[1] - ends[0]);
        planar_pose(&Isometry2::new(ends[0].coords, heading_rad))
    });
    PosesInFrame { timestamp: Some(timestamp), frame_id: VEHICLE.to_owned(), poses: along.collect() }
}

/// The road's middle.
pub(crate) fn centreline(timestamp: Timestamp, centreline: Option<&Centreline>) -> SceneUpdate {
    let lines = centreline.iter().map(|found| curve(|forward_m| found.left_m(forward_m), CENTRELINE));
    entity(timestamp, "centreline", SceneEntity { lines: lines.collect(), ..SceneEntity::default() })
}

/// The lane's edges.
pub(crate) fn lanes(timestamp: Timestamp, lane: Option<&Lane>) -> SceneUpdate {
    let on_road = lane.map(Lane::on_road);
    let edges = on_road.iter().flat_map(|lane| [lane.left, lane.right]).flatten();
    let lines = edges.map(|edge| curve(|forward_m| edge.left_m(forward_m), LANE)).collect();
    entity(timestamp, "lanes", SceneEntity { lines, ..SceneEntity::default() })
}

fn entity(timestamp: Timestamp, id: &str, drawn: SceneEntity) -> SceneUpdate {
    let entity = SceneEntity {
        timestamp: Some(timestamp),
        frame_id: VEHICLE.to_owned(),
        id: id.to_owned(),
        frame_locked: true,
        ..drawn
    };
    SceneUpdate { deletions: Vec::new(), entities: vec![entity] }
}

/// A line given by how far left it is at a distance ahead.
fn curve(left_m: impl Fn(f64) -> f64, of: [u8; 3]) -> LinePrimitive {
    let ahead = (0..CURVE_POINTS).map(|i| REACH_M * i as f64 / (CURVE_POINTS - 1) as f64);
    strip(ahead.map(|forward_m| Point2::new(forward_m, left_m(forward_m))), of, 0.1, 0.9)
}

fn strip(points: impl Iterator<Item = Point2<f64>>, of: [u8; 3], width_m: f64, alpha: f64) -> LinePrimitive {
    LinePrimitive {
        r#type: Type::LineStrip as i32,
        pose: Some(pose_at(0.0, 0.0)),
        thickness: width_m,
        scale_invariant: false,
        points: points.map(|p| Point3 { x: p.x, y: p.y, z: OVER_ROAD_M }).collect(),
        color: Some(colour(of, alpha)),
        colors: Vec::new(),
        indices: Vec::new(),
    }
}

fn pose_at(x: f64, y: f64) -> Pose {
    Pose {
        position: Some(Vector3 { x, y, z: 0.0 }),
        orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_there_leaves_no_lines() {
        for update in [
            driving_line(Timestamp::MIN, &[], 1.8),
            centreline(Timestamp::MIN, None),
            lanes(Timestamp::MIN, None),
            feature_entities(Timestamp::MIN, None),
        ] {
            // An entity of the same name takes the place of the last frame's.
            assert_eq!(update.entities.len(), 1);
            assert!(update.entities[0].lines.is_empty() && !update.entities[0].id.is_empty());
        }
    }

    #[test]
    fn the_middle_of_the_road_bends_to_the_left() {
        let centreline = Centreline { offset_m: 0.5, curvature_per_m: 0.01, ..Centreline::default() };
        let update = super::centreline(Timestamp::MIN, Some(&centreline));
        let points = &update.entities[0].lines[0].points;
        let last = points.last().unwrap();
        assert!((points[0].y - 0.5).abs() < 1e-9 && (last.x - REACH_M).abs() < 1e-9);
        assert!((last.y - 2.5).abs() < 1e-9, "{last:?}");
    }
}
