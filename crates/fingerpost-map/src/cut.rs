//! Cutting a path into route features (paper 1, section V; paper 2, section 5).
//!
//! A node is a feature for the roads that leave it: four and more, or three of which the route takes one that turns,
//! are a junction; three with the route going about straight are a side road; two with a sharp turn are a bend,
//! where the one that leaves is soon off the road that would go straight on (`leaving.rs`): a match could not tell it else.
//! Limits: a crossing of divided roads is as many features as it has nodes, a roundabout as many as it has arms.

use std::f64::consts::{PI, TAU};

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::Vector2;

use crate::course::Courses;
use crate::leaving::leaves_after_m;
use crate::path::Path;
use crate::{
    Arm, ArmRole, Direction, FeatureKind, FeatureOptions, LatLon, RoadGraph, Route, RouteError, RouteFeature,
};

/// What a node of a bend loses in sharpness for each metre farther along, radians: 2 degrees. The turn about a node grows by that
/// and more from where a bend begins, and by less than the 4 degrees by which nodes 3 m apart make it uneven behind.
const LATER_RAD_PER_M: f64 = 0.035;

/// The route along a path, with its features.
pub(crate) fn cut(graph: &RoadGraph, path: &Path, options: &FeatureOptions) -> Result<Route, RouteError> {
    let line = path.route_points(graph);
    let mut route = Route { name: String::new(), line, features: Vec::new() };
    let plane = route.plane().ok_or(RouteError::NoLength)?;
    let polyline = route.polyline().map_err(|_| RouteError::NoLength)?;
    let cutter = Cutter { graph, path, options, courses: Courses::new(graph, plane, options), polyline };
    let mut along_m = 0.0;
    let mut bends = Vec::new();
    for index in 1..path.segments.len() {
        let step = cutter.polyline.points()[index] - cutter.polyline.points()[index - 1];
        along_m += step.norm();
        let Some(feature) = cutter.feature(index, along_m) else { continue };
        if feature.kind == FeatureKind::Bend {
            let sharpness_rad = cutter.turn_around(along_m);
            if sharpness_rad >= options.bend_turn_rad {
                bends.push((sharpness_rad, feature));
            }
        } else {
            route.features.push(feature);
        }
    }
    // The sharpest place of a bend first, so that its other nodes find it taken; of about equals the first, at which the
    // straight road before the bend can still be seen: an arc alone looks the same from wherever one is on it.
    let worth = |(sharpness_rad, bend): &(f64, RouteFeature)| sharpness_rad - LATER_RAD_PER_M * bend.route_m;
    bends.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    for (_, bend) in bends {
        let is_near = |other: &RouteFeature| (other.route_m - bend.route_m).abs() < options.bend_clearance_m;
        if !route.features.iter().any(is_near) {
            route.features.push(bend);
        }
    }
    route.features.sort_by(|a, b| a.route_m.total_cmp(&b.route_m));
    Ok(route)
}

struct Cutter<'a> {
    graph: &'a RoadGraph,
    path: &'a Path,
    options: &'a FeatureOptions,
    courses: Courses<'a>,
    polyline: Polyline,
}

impl Cutter<'_> {
    /// The feature at an inner point of the path by its arms; a bend for any node with two arms of which one leaves the
    /// line of the other.
    fn feature(&self, index: usize, route_m: f64) -> Option<RouteFeature> {
        let node = self.path.points[index].node?;
        let (came_by, leaves_by) = (self.path.segments[index - 1], self.path.segments[index]);
        if came_by == leaves_by {
            return None;
        }
        let before = self.path.segments[..index].iter().rev().copied();
        let after = self.path.segments[index..].iter().copied();
        let approach = self.arm(ArmRole::Approach, node, came_by, self.courses.along(node, before))?;
        let exit = self.arm(ArmRole::Exit, node, leaves_by, self.courses.along(node, after))?;
        let mut sides: Vec<(Arm, usize)> = self
            .courses
            .side_segments(node, [came_by, leaves_by])
            .into_iter()
            .filter_map(|segment| {
                let course = self.courses.along(node, std::iter::once(segment));
                Some((self.arm(ArmRole::Side, node, segment, course)?, segment))
            })
            .collect();
        let from_exit = |arm: &Arm| (arm.bearing_rad - exit.bearing_rad).rem_euclid(TAU);
        sides.sort_by(|(a, _), (b, _)| from_exit(a).total_cmp(&from_exit(b)));

        let turn_rad = wrap_angle(exit.bearing_rad - approach.bearing_rad - PI);
        if sides.is_empty() && !self.leaves_straight_on([&approach, &exit]) {
            return None;
        }
        let kind = match sides.len() {
            0 => FeatureKind::Bend,
            1 if turn_rad.abs() <= self.options.junction_turn_rad => FeatureKind::SideRoad,
            _ => FeatureKind::Junction,
        };
        let name =
            self.name([came_by, leaves_by].into_iter().chain(sides.iter().map(|(_, segment)| *segment)));
        let arms = [approach, exit].into_iter().chain(sides.into_iter().map(|(arm, _)| arm)).collect();
        let road_node = &self.graph.nodes()[node];
        Some(RouteFeature { id: road_node.id, at: road_node.at, name, kind, turn_rad, arms, route_m })
    }

    fn arm(&self, role: ArmRole, node: usize, segment: usize, course: Vec<usize>) -> Option<Arm> {
        let attributes = self.graph.attributes_of(segment);
        let mut beside = attributes.beside;
        if self.graph.away_from(segment, node) == Direction::Backward {
            beside.reverse();
        }
        let course_line = Polyline::new(course.iter().map(|&node| self.courses.place(node))).ok()?;
        let reach_m = self.options.direction_m.min(course_line.length_m());
        Some(Arm {
            role,
            bearing_rad: heading_of(course_line.at(reach_m).0 - self.courses.place(node)),
            points: course.iter().map(|&node| self.graph.nodes()[node].at).collect(),
            width_m: attributes.width_m,
            surface: attributes.surface.clone(),
            beside,
        })
    }

    /// Whether the exit leaves the road that would go straight on from the approach near enough for a picture to tell.
    fn leaves_straight_on(&self, [approach, exit]: [&Arm; 2]) -> bool {
        let place = |at: &LatLon| self.courses.plane().map_from_wgs84(*at);
        let (sine, cosine) = libm::sincos(approach.bearing_rad);
        let course = Polyline::new(exit.points.iter().map(place));
        course.is_ok_and(|course| {
            leaves_after_m(&course, -Vector2::new(cosine, sine), 0.5 * approach.width_m).is_some()
        })
    }

    /// How much the route's heading changes from the reach before a place to the reach behind it, radians.
    fn turn_around(&self, along_m: f64) -> f64 {
        let heading = |at_m: f64| -> Vector2<f64> { self.polyline.at(at_m).1 };
        let before = heading(along_m - self.options.bend_reach_m);
        let after = heading(along_m + self.options.bend_reach_m);
        before.angle(&after)
    }

    /// The different names of the segments' roads; the class of the first where none has a name.
    fn name(&self, segments: impl Iterator<Item = usize> + Clone) -> String {
        let mut names: Vec<&str> = Vec::new();
        for name in segments.clone().filter_map(|segment| self.graph.attributes_of(segment).name.as_deref()) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        let class = |segment: usize| self.graph.attributes_of(segment).class.as_str();
        match (names.is_empty(), segments.map(class).next()) {
            (true, Some(class)) => format!("unnamed {class}"),
            _ => names.join(" x "),
        }
    }
}
