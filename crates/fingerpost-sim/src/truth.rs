//! Where the edges of the vehicle's lane are.

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::{Point2, Vector2};

use crate::TrafficSide;
use crate::conditions::Markings;
use crate::ground::GroundMap;
use crate::roads::RoadNetwork;
use crate::surface::{EDGE_LINE_M, Lines};

/// Spacing of the points of a lane's edge, metres.
const SPACING_M: f64 = 1.5;
/// Nearest and farthest point of a lane's edge ahead of the rear axle, metres along the route.
const FROM_M: f64 = 3.0;
const TO_M: f64 = 40.0;
/// A lane ends where the route turns away from the vehicle's heading by more than this, radians (40 degrees).
const TURNED_AWAY_RAD: f64 = 0.7;

/// Markings on the two sides of a lane, metres to the left of the route's line; none where there is no marking.
#[derive(Debug, Clone, Copy)]
struct Offsets {
    left_m: Option<f64>,
    right_m: Option<f64>,
}

/// The lane's edges along the route.
#[derive(Debug, Clone)]
pub(crate) struct LaneEdges {
    route: Polyline,
    /// Every [`SPACING_M`] along the route.
    offsets: Vec<Offsets>,
}

impl LaneEdges {
    pub(crate) fn new(
        route: Polyline,
        roads: &RoadNetwork,
        markings: Markings,
        traffic: TrafficSide,
    ) -> Self {
        let count = (route.length_m() / SPACING_M) as usize;
        let offsets = (0..=count)
            .map(|i| {
                let (place, direction) = route.at(i as f64 * SPACING_M);
                let none = Offsets { left_m: None, right_m: None };
                let Some((stroke, _)) = roads.along(place, direction) else { return none };
                let lines = Lines::of(stroke, markings);
                let edge_m = lines.edges.then_some(stroke.half_width_m - EDGE_LINE_M);
                let centre_m = lines.centre.then_some(0.0);
                match traffic {
                    _ if !stroke.two_way => Offsets { left_m: edge_m, right_m: edge_m.map(|m| -m) },
                    TrafficSide::Right => Offsets { left_m: centre_m, right_m: edge_m.map(|m| -m) },
                    TrafficSide::Left => Offsets { left_m: edge_m, right_m: centre_m },
                    TrafficSide::Centre => Offsets { left_m: edge_m, right_m: edge_m.map(|m| -m) },
                }
            })
            .collect();
        Self { route, offsets }
    }

    /// Points of the left and the right edge ahead of a vehicle, near to far, map frame, metres.
    pub(crate) fn ahead(&self, ground: &GroundMap, route_m: f64, heading_rad: f64) -> [Vec<Point2<f64>>; 2] {
        let mut edges = [Vec::new(), Vec::new()];
        let (from, to) = ((route_m + FROM_M) / SPACING_M, (route_m + TO_M) / SPACING_M);
        for i in from.ceil() as usize..=to as usize {
            let Some(offsets) = self.offsets.get(i) else { break };
            let (place, direction) = self.route.at(i as f64 * SPACING_M);
            if wrap_angle(heading_of(direction) - heading_rad).abs() > TURNED_AWAY_RAD {
                break;
            }
            let left = Vector2::new(-direction.y, direction.x);
            for (edge, offset_m) in edges.iter_mut().zip([offsets.left_m, offsets.right_m]) {
                let point = offset_m.map(|offset_m| place + left * offset_m);
                edge.extend(point.filter(|p| !Lines::interrupted(ground.at(p.x as f32, p.y as f32).other_m)));
            }
        }
        edges
    }
}
