//! The course of a road away from a node: along the route where the route goes, else straight on.

use std::f64::consts::FRAC_PI_3;

use nalgebra::Point2;

use crate::{FeatureOptions, RoadGraph, TangentPlane};

/// Where several roads go on and the straightest turns more than this (radians), the road ends there.
const STRAIGHT_ON_RAD: f64 = FRAC_PI_3;

/// Follows roads of a graph in a route's map frame.
pub(crate) struct Courses<'a> {
    graph: &'a RoadGraph,
    plane: TangentPlane,
    options: &'a FeatureOptions,
}

impl<'a> Courses<'a> {
    pub(crate) fn new(graph: &'a RoadGraph, plane: TangentPlane, options: &'a FeatureOptions) -> Self {
        Self { graph, plane, options }
    }

    /// The route's map frame.
    pub(crate) const fn plane(&self) -> &TangentPlane {
        &self.plane
    }

    /// Where a node is, metres in the route's map frame.
    pub(crate) fn place(&self, node: usize) -> Point2<f64> {
        self.plane.map_from_wgs84(self.graph.nodes()[node].at)
    }

    /// The segments that leave a node besides the route's two; of several to one neighbour the first.
    pub(crate) fn side_segments(&self, node: usize, route: [usize; 2]) -> Vec<usize> {
        let mut neighbours: Vec<usize> = route.iter().map(|&segment| self.other_end(segment, node)).collect();
        let mut sides = Vec::new();
        for &segment in &self.graph.nodes()[node].segments {
            let neighbour = self.other_end(segment, node);
            if !neighbours.contains(&neighbour) && !self.is_excluded(segment) {
                neighbours.push(neighbour);
                sides.push(segment);
            }
        }
        sides
    }

    /// The nodes of a road's course from a node on, as far as the options ask or the road goes: along `guide` first, then
    /// by the straightest road at each further node.
    pub(crate) fn along(&self, node: usize, mut guide: impl Iterator<Item = usize>) -> Vec<usize> {
        let mut course = vec![node];
        let mut here = node;
        let mut came_by = None;
        let mut length_m = 0.0;
        let mut is_guided = true;
        while length_m < self.options.course_m {
            let is_next = |segment: &usize| self.touches(*segment, here) && came_by != Some(*segment);
            let guided = guide.next().filter(|segment| is_guided && is_next(segment));
            is_guided = guided.is_some();
            let Some(segment) = guided.or_else(|| self.straight_on(here, came_by?)) else { break };
            let next = self.other_end(segment, here);
            if course.contains(&next) {
                break;
            }
            length_m += (self.place(next) - self.place(here)).norm();
            course.push(next);
            (here, came_by) = (next, Some(segment));
        }
        course
    }

    fn straight_on(&self, node: usize, came_by: usize) -> Option<usize> {
        let here = self.place(node);
        let incoming = here - self.place(self.other_end(came_by, node));
        let onwards: Vec<usize> = self.graph.nodes()[node]
            .segments
            .iter()
            .copied()
            .filter(|&segment| segment != came_by && !self.is_excluded(segment))
            .collect();
        let turn_rad = |segment: usize| incoming.angle(&(self.place(self.other_end(segment, node)) - here));
        let straightest = onwards.iter().copied().min_by(|&a, &b| turn_rad(a).total_cmp(&turn_rad(b)))?;
        (onwards.len() == 1 || turn_rad(straightest) <= STRAIGHT_ON_RAD).then_some(straightest)
    }

    fn other_end(&self, segment: usize, node: usize) -> usize {
        self.graph.head(segment, self.graph.away_from(segment, node))
    }

    fn touches(&self, segment: usize, node: usize) -> bool {
        let road = self.graph.segments()[segment];
        road.start == node || road.end == node
    }

    fn is_excluded(&self, segment: usize) -> bool {
        self.options.excluded.contains(&self.graph.attributes_of(segment).class)
    }
}
