//! A driven line over the road graph: its points and the segment between each two of them.

use nalgebra::Point2;

use crate::search::{Leg, OnStep, node_at};
use crate::{Direction, RoadGraph, RoutePoint};

/// A point of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathPoint {
    /// Index of the node; `None` between nodes.
    pub(crate) node: Option<usize>,
    /// Metres in the graph's plane.
    pub(crate) p_in_map: Point2<f64>,
}

/// A line over the graph: `segments[i]` lies between `points[i]` and `points[i + 1]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Path {
    pub(crate) points: Vec<PathPoint>,
    pub(crate) segments: Vec<usize>,
}

/// Points nearer together than this are one, metres: below the map's resolution of a centimetre.
pub(crate) const SAME_POINT_M: f64 = 0.005;

impl Path {
    /// The line along legs, each of which starts where the one before ended. A leg that sets out in another direction
    /// than the last one came in (turning round at a stop) leaves a point there.
    pub(crate) fn along(graph: &RoadGraph, legs: &[Leg]) -> Self {
        let mut path = Self::default();
        let mut current: Option<OnStep> = None;
        for leg in legs {
            match current {
                None => path.push(graph, leg.from),
                Some(place) if leg.from.step != place.step => path.push(graph, place),
                Some(_) => {}
            }
            for &step in &leg.steps[..leg.steps.len() - 1] {
                path.push(graph, OnStep { step, along_m: graph.segments()[step.segment].length_m });
            }
            current = Some(leg.to);
        }
        if let Some(place) = current {
            path.push(graph, place);
        }
        path
    }

    fn push(&mut self, graph: &RoadGraph, place: OnStep) {
        let segment = place.step.segment;
        let road = graph.segments()[segment];
        let along_m = match place.step.direction {
            Direction::Forward => place.along_m,
            Direction::Backward => road.length_m - place.along_m,
        };
        let node = node_at(graph, segment, along_m);
        let p_in_map = node.map_or_else(
            || {
                let [start, end] = [road.start, road.end].map(|node| graph.nodes()[node].p_in_map);
                start + (end - start) * (along_m / road.length_m)
            },
            |node| graph.nodes()[node].p_in_map,
        );
        let point = PathPoint { node, p_in_map };
        match self.points.last_mut() {
            None => self.points.push(point),
            Some(last) if (last.p_in_map - p_in_map).norm() < SAME_POINT_M => {
                if last.node.is_none() {
                    *last = point;
                }
            }
            Some(_) => {
                self.points.push(point);
                self.segments.push(segment);
            }
        }
    }

    /// The points as a route's line.
    pub(crate) fn route_points(&self, graph: &RoadGraph) -> Vec<RoutePoint> {
        let route_point = |point: &PathPoint| match point.node {
            Some(node) => RoutePoint { node: Some(graph.nodes()[node].id), at: graph.nodes()[node].at },
            None => RoutePoint { node: None, at: graph.plane().wgs84_from_map(point.p_in_map) },
        };
        self.points.iter().map(route_point).collect()
    }
}
