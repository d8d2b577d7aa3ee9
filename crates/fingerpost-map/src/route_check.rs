//! Whether the numbers of a route that was read belong together: files are edited by hand, and a feature whose `route_m` is
//! another place's is never found.

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::Point2;

use crate::{Arm, ArmRole, Route, RouteFeature, TangentPlane};

/// Longest route, metres: beyond it the tangent plane of its start is no map any more (the earth falls away by 80 km).
const MOST_ROUTE_M: f64 = 1_000_000.0;
/// How far a feature may lie from the place that its `route_m` says, and an arm's first point from its feature, metres: nodes
/// that were moved by hand by half of a wide junction.
const APART_M: f64 = 15.0;
/// Where an arm's direction is looked at, metres from its first point: mappers round corners off within it.
const DIRECTION_M: f64 = 8.0;
/// How far a bearing may be from its arm's points, and a turn from its arms' bearings, radians (60 degrees): more is another
/// road, whatever was rounded and wherever the direction was taken.
const TURNED_RAD: f64 = 1.05;

/// What contradicts what: the place in `features` where it is one of them, and the words for it.
pub(crate) type Contradiction = (Option<usize>, String);

/// Checks every feature's place along the line, its arms and its turn.
pub(crate) fn check_places(route: &Route) -> Result<(), Contradiction> {
    let line = route.polyline().map_err(|cause| (None, cause.to_string()))?;
    let Some(plane) = route.plane() else { return Ok(()) };
    let length_m = line.length_m();
    if length_m > MOST_ROUTE_M {
        return Err((None, format!("its line is {length_m:.0} m long, more than {MOST_ROUTE_M:.0}")));
    }
    for (place, feature) in route.features.iter().enumerate() {
        check_feature(feature, &line, &plane).map_err(|cause| (Some(place), cause))?;
    }
    Ok(())
}

fn check_feature(feature: &RouteFeature, line: &Polyline, plane: &TangentPlane) -> Result<(), String> {
    let (p_in_map, route_m) = (plane.map_from_wgs84(feature.at), feature.route_m);
    let apart_m = if (0.0..=line.length_m()).contains(&route_m) {
        (line.at(route_m).0 - p_in_map).norm()
    } else {
        f64::INFINITY
    };
    if apart_m > APART_M {
        let nearest = line.nearest(p_in_map);
        return Err(format!(
            "its route_m is {route_m:.1} and its place is at {:.1} m along the line of {:.1} m",
            nearest.along_m,
            line.length_m()
        ));
    }
    for arm in &feature.arms {
        check_arm(arm, p_in_map, plane)?;
    }
    let bearing = |role| feature.arms.iter().find(|arm| arm.role == role).map(|arm| arm.bearing_rad);
    if let Some((approach, exit)) = bearing(ArmRole::Approach).zip(bearing(ArmRole::Exit)) {
        let turn_rad = wrap_angle(exit - approach - std::f64::consts::PI);
        if wrap_angle(turn_rad - feature.turn_rad).abs() > TURNED_RAD {
            return Err(format!(
                "its turn_deg is {:.1} and its arms turn by {:.1}",
                feature.turn_rad.to_degrees(),
                turn_rad.to_degrees()
            ));
        }
    }
    Ok(())
}

fn check_arm(arm: &Arm, node: Point2<f64>, plane: &TangentPlane) -> Result<(), String> {
    let places = arm.points.iter().map(|at| plane.map_from_wgs84(*at));
    let course = Polyline::new(places).map_err(|cause| format!("the points of an arm: {cause}"))?;
    let first_m = (course.points()[0] - node).norm();
    if first_m > APART_M {
        return Err(format!("an arm begins {first_m:.1} m from its place; its first point is the node"));
    }
    let along = course.at(DIRECTION_M.min(course.length_m())).0 - course.points()[0];
    let off_rad = wrap_angle(heading_of(along) - arm.bearing_rad).abs();
    if along.norm() > 0.0 && off_rad > TURNED_RAD {
        let off_deg = off_rad.to_degrees();
        return Err(format!("an arm's points leave it {off_deg:.0} degrees from the arm's bearing_deg"));
    }
    Ok(())
}
