//! Where a vehicle is against the line that it should be on: the middle of its lane, rounded at the corners as a vehicle
//! drives them.

use fingerpost_geometry::wrap_angle;
use nalgebra::{Point2, Vector2};

use crate::path::PathPoint;

/// How far ahead of and behind the last place the next one is looked for, metres: more than a frame's way at the lowest rate
/// that is simulated in a town, and less than a block, so that a route that comes by twice is not mixed up.
const SEARCH_AHEAD_M: f64 = 12.0;
const SEARCH_BEHIND_M: f64 = 4.0;

/// A vehicle's place along and across the line.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct LinePlace {
    /// Distance along the route, metres.
    pub(crate) route_m: f64,
    /// Left of the line, metres.
    pub(crate) left_m: f64,
    /// Direction against the line's, radians, positive to the left.
    pub(crate) heading_rad: f64,
}

/// The middle of the lane along a route.
#[derive(Debug, Clone)]
pub(crate) struct LaneMiddle {
    path: Vec<PathPoint>,
}

impl LaneMiddle {
    /// The line through these points, in the order of the route.
    pub(crate) const fn new(path: Vec<PathPoint>) -> Self {
        Self { path }
    }

    /// The points of the line.
    pub(crate) fn points(&self) -> &[PathPoint] {
        &self.path
    }

    /// Where a vehicle is that was near `from_m` of the route, metres, a moment ago.
    pub(crate) fn place(&self, p_in_map: Point2<f64>, heading_rad: f64, from_m: f64) -> LinePlace {
        let index = |route_m: f64| self.path.partition_point(|point| point.route_m < route_m);
        let first = index(from_m - SEARCH_BEHIND_M).min(self.path.len().saturating_sub(2));
        let last = index(from_m + SEARCH_AHEAD_M).clamp(first + 1, self.path.len());
        let near = &self.path[first..last];
        let distance = |point: &PathPoint| (point.p_in_map - p_in_map).norm_squared();
        let nearest = near.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        nearest.map_or_else(LinePlace::default, |point| {
            let (sin, cos) = libm::sincos(point.heading_rad);
            let offset = p_in_map - point.p_in_map;
            LinePlace {
                route_m: point.route_m + offset.dot(&Vector2::new(cos, sin)),
                left_m: offset.dot(&Vector2::new(-sin, cos)),
                heading_rad: wrap_angle(heading_rad - point.heading_rad),
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    /// 30 m to the east and then 30 m to the north.
    fn corner() -> LaneMiddle {
        let east = (0..300).map(|i| (Point2::new(0.1 * f64::from(i), 0.0), 0.0));
        let north = (0..300).map(|i| (Point2::new(30.0, 0.1 * f64::from(i)), FRAC_PI_2));
        let points = east.chain(north).enumerate().map(|(i, (p_in_map, heading_rad))| PathPoint {
            p_in_map,
            heading_rad,
            curvature_per_m: 0.0,
            route_m: 0.1 * i as f64,
        });
        LaneMiddle::new(points.collect())
    }

    #[test]
    fn left_of_the_line_is_positive_whichever_way_it_runs() {
        let place = corner().place(Point2::new(10.04, 0.3), 0.1, 9.0);
        assert!((place.route_m - 10.04).abs() < 1e-9 && (place.left_m - 0.3).abs() < 1e-9);
        assert!((place.heading_rad - 0.1).abs() < 1e-12);
        let place = corner().place(Point2::new(30.5, 10.0), FRAC_PI_2, 39.0);
        assert!((place.left_m + 0.5).abs() < 1e-9 && (place.route_m - 40.0).abs() < 1e-9);
    }

    #[test]
    fn a_line_that_comes_by_again_is_not_mixed_up() {
        // Nearer to the second leg, but a moment ago it was far from that.
        let place = corner().place(Point2::new(25.5, 5.0), 0.0, 14.0);
        assert!((place.left_m - 5.0).abs() < 1e-9 && (place.route_m - 25.5).abs() < 1e-9);
    }
}
