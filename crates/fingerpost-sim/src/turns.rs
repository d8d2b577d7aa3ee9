//! How a route turns at corners that are drawn one by one: along the kerb that is there, and wide where it is square.

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::{Point2, Vector2};

use crate::corners::{Corner, EdgeAt};
use crate::junctions::{Arm, Junction};
use crate::roads::{RoadNetwork, Stroke};
use crate::{SimConfig, TrafficSide};

/// The roads before and behind a turn are told by the route's direction so far from it, metres: on the very piece of road.
const AIM_M: f64 = 0.5;
/// Cosine of the largest angle between the route there and the arm that it takes (60 degrees: roads bend near junctions).
const SAME_WAY_COS: f64 = 0.5;
/// Half of the distance from the node at which a place is inside of the turn, metres.
const INSIDE_M: f64 = 6.0;
/// Kerbs of this radius and more are followed in the lane, those of the other are passed from the road's middle, metres.
const FOLLOWED_M: f64 = 4.0;
const SQUARE_M: f64 = 0.5;
/// Length over which a driver moves out before a square corner and back behind it, metres.
const SWING_M: f64 = 8.0;

/// A turn of a route from one road into another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    /// Distance of the corner along the route, metres.
    along_m: f64,
    /// Turn of the route, radians, positive to the left.
    turn_rad: f64,
    /// Radius of the axis' turn, metres.
    radius_m: f64,
    /// Share of its distance from the road's axis that a vehicle on the inner side keeps.
    kept: f64,
}

impl Turn {
    /// The turns of a route at the corners that the configuration's seed draws.
    pub(crate) fn of_route(route: &Polyline, roads: &RoadNetwork, config: &SimConfig) -> Vec<Self> {
        let mut along_m = 0.0;
        let mut turns = Vec::new();
        for pair in route.points().windows(2) {
            along_m += (pair[1] - pair[0]).norm();
            turns.extend(Self::at(route, roads, config, pair[1], along_m));
        }
        turns
    }

    fn at(
        route: &Polyline,
        roads: &RoadNetwork,
        config: &SimConfig,
        vertex: Point2<f64>,
        along_m: f64,
    ) -> Option<Self> {
        let junction = roads.junctions().iter().find(|j| (j.p_in_map - vertex).norm() < 0.01)?;
        let (before, after) = (route.at(along_m - AIM_M).1, route.at(along_m + AIM_M).1);
        let arms = [arm_along(junction, -before)?, arm_along(junction, after)?];
        let [one, other] = arms.map(|arm| &roads.strokes()[arm.stroke as usize]);
        let [came, leaves] = arms.map(|arm| arm.away);
        if one.chain == other.chain {
            return None;
        }
        let turn_rad = wrap_angle(heading_of(leaves) - heading_of(-came));
        let inside = vertex + (came + leaves) * INSIDE_M;
        let side = |stroke: &Stroke| (stroke.chain, EdgeAt::of(stroke, inside).is_left);
        let corner = Corner::drawn(config.seed, junction.id, side(one), side(other));
        let corner = corner.between([(arms[0], one.half_width_m), (arms[1], other.half_width_m)], turn_rad);
        let kerb_m = corner.radius_m(turn_rad);
        let half_width_m = 0.5 * (one.half_width_m + other.half_width_m);
        let kept = ((kerb_m - SQUARE_M) / (FOLLOWED_M - SQUARE_M)).clamp(0.0, 1.0);
        // Who turns along the kerb has no room to cut; who turns across the other lane has.
        let across = match config.traffic {
            TrafficSide::Left => turn_rad < 0.0,
            TrafficSide::Right => turn_rad > 0.0,
            TrafficSide::Centre => false,
        };
        let cutting = if across { config.habits.corner_cutting } else { 0.0 };
        let followed_m = (kerb_m + half_width_m) * (1.0 + cutting);
        let radius_m = followed_m.max(config.vehicle.turning_radius_m);
        Some(Self { along_m, turn_rad, radius_m, kept })
    }

    /// Length of the arc's tangents, metres.
    fn tangent_m(&self) -> f64 {
        self.radius_m * libm::tan(0.5 * self.turn_rad.abs()).min(3.0)
    }

    /// The radius to which the route is rounded at a distance along it, metres; none away from the turn.
    pub(crate) fn radius_at_m(&self, along_m: f64) -> Option<f64> {
        ((along_m - self.along_m).abs() <= self.tangent_m()).then_some(self.radius_m)
    }

    /// Share that is left of a shift to the left of the road's axis at a distance along the route.
    pub(crate) fn kept_shift(&self, along_m: f64, shift_m: f64) -> f64 {
        let is_inner = shift_m * self.turn_rad > 0.0;
        let beyond_m = ((along_m - self.along_m).abs() - self.tangent_m()).max(0.0);
        let away = if is_inner { (beyond_m / SWING_M).min(1.0) } else { 1.0 };
        self.kept + (1.0 - self.kept) * away
    }
}

/// The arm of a junction that leads in a direction.
fn arm_along(junction: &Junction, direction: Vector2<f64>) -> Option<Arm> {
    let arms = junction.chains.iter().flat_map(|met| met.arms).flatten();
    let best = arms.max_by(|a: &Arm, b: &Arm| a.away.dot(&direction).total_cmp(&b.away.dot(&direction)))?;
    (best.away.dot(&direction) > SAME_WAY_COS).then_some(best)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turn(kept: f64) -> Turn {
        Turn { along_m: 100.0, turn_rad: -1.57, radius_m: 5.2, kept }
    }

    #[test]
    fn a_square_corner_is_passed_from_the_middle_by_who_is_on_its_side() {
        assert!(turn(0.0).kept_shift(100.0, -1.4) < 1e-9, "a right turn in the right lane");
        assert!((turn(0.0).kept_shift(100.0, 1.4) - 1.0).abs() < 1e-9, "the other lane");
        assert!((turn(0.0).kept_shift(80.0, -1.4) - 1.0).abs() < 1e-9, "before the corner");
        assert!((turn(1.0).kept_shift(100.0, -1.4) - 1.0).abs() < 1e-9, "a wide corner");
    }

    #[test]
    fn the_radius_holds_along_the_arc() {
        assert_eq!(turn(1.0).radius_at_m(103.0), Some(5.2));
        assert_eq!(turn(1.0).radius_at_m(107.0), None);
    }
}
