//! The corner that a driving line goes round: how wide it can be taken in the lane, and where its curve begins and ends.

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use fingerpost_map::FeatureKind;

use crate::conic::{Conic, End, crossing, ends};
use crate::feature_model::ArmModel;
use crate::vehicle::VehicleConfig;

/// How far the nodes of a map lie from the middle of a road that bends between them, metres: a bend that is drawn as one
/// corner leaves it by as much.
const MAP_CUT_M: f64 = 0.4;
/// Sharper turns have no arc between two lanes of use, radians (170 degrees).
const SHARPEST_RAD: f64 = 2.97;
/// Distance between the ends that are tried where no arc was found at once, metres.
const STEP_M: f64 = 0.25;
/// Rounds in which the ends are moved until both are as far from the corner as the arc's tangents are long; on straight arms
/// one is enough.
const ROUNDS: usize = 4;

/// The turn from an approach into an exit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Corner {
    /// Radius on the way that is concentric with the kerb, metres.
    lane_radius_m: f64,
    /// Radius at which the vehicle's inner side touches the kerb, metres.
    most_radius_m: f64,
    /// The vehicle's turning circle, metres.
    turning_radius_m: f64,
    /// Farther from the node than this the lanes have not crossed yet, metres.
    beyond_crossing_m: f64,
}

impl Corner {
    /// From an approach into an exit of a feature round a kerb of this radius, metres.
    pub(super) fn of(
        vehicle: &VehicleConfig,
        kind: FeatureKind,
        [approach, exit]: [&ArmModel; 2],
        kerb_m: f64,
    ) -> Self {
        let turn_rad = wrap_angle(exit.direction_rad() - approach.direction_rad() + std::f64::consts::PI);
        let cos = libm::cos(0.5 * turn_rad.abs().min(SHARPEST_RAD));
        // From the lane's middle to the edge on the inside of the turn.
        let to_edge_m =
            |arm: &ArmModel| 0.5 * arm.width_m - turn_rad.signum() * vehicle.traffic.lane_left_m(arm.width_m);
        let to_edge_m = 0.5 * (to_edge_m(approach) + to_edge_m(exit));
        // An arc of radius r leaves the corner of its tangents by r (1 / cos - 1).
        let cut_m = |radius_m: f64| radius_m * (1.0 / cos - 1.0);
        let bend_m = if kind == FeatureKind::Bend { MAP_CUT_M / cut_m(1.0).max(1e-6) } else { 0.0 };
        let side_m = 0.5 * vehicle.width_m + vehicle.margin_m;
        let room_m = to_edge_m / cos + cut_m(kerb_m) - side_m;
        Self {
            lane_radius_m: (kerb_m + to_edge_m).max(bend_m),
            most_radius_m: room_m.max(0.0) / cut_m(1.0).max(1e-6),
            turning_radius_m: vehicle.turning_radius_m,
            beyond_crossing_m: (0.5 * (approach.width_m + exit.width_m)) / cos,
        }
    }

    /// The radius that the curve ought to have, metres.
    fn radius_m(self) -> f64 {
        self.lane_radius_m.max(self.turning_radius_m.min(self.most_radius_m))
    }

    /// The radius that the vehicle needs and the road has room for, metres.
    pub(super) fn needed_m(self) -> f64 {
        self.turning_radius_m.min(self.most_radius_m) * (1.0 - 1e-9)
    }

    /// Makes it a twentieth wider.
    pub(super) fn widen(&mut self) {
        self.lane_radius_m = 1.05 * self.radius_m();
    }

    /// How far before the end of the inbound and behind the start of the outbound line the curve begins and ends, each within the
    /// shortest and the longest that it may be; metres.
    pub(super) fn setbacks_m(
        self,
        [shortest_m, longest_m]: [[f64; 2]; 2],
        inbound: &Polyline,
        outbound: &Polyline,
    ) -> [f64; 2] {
        let within = |i: usize, m: f64| m.min(longest_m[i]).max(shortest_m[i]);
        let mut setbacks_m = [0, 1].map(|i| within(i, self.beyond_crossing_m));
        for _ in 0..ROUNDS {
            let [start, end] = ends(inbound, outbound, setbacks_m);
            let Some(corner) = crossing(start, end) else { break };
            let turn_rad = wrap_angle(heading_of(end.1) - heading_of(start.1)).abs().min(SHARPEST_RAD);
            let legs_m = [(corner - start.0).dot(&start.1), (end.0 - corner).dot(&end.1)];
            let tangent_m = self.radius_m() * libm::tan(0.5 * turn_rad);
            let wanted_m = [0, 1].map(|i| setbacks_m[i] + tangent_m - legs_m[i]);
            // Both legs stay as long as each other, or the curve is no arc.
            let short_m = [0, 1].map(|i| (wanted_m[i] - longest_m[i]).max(0.0));
            let short_m = short_m[0].max(short_m[1]);
            let long_m = [0, 1].map(|i| (shortest_m[i] - wanted_m[i]).max(0.0));
            let long_m = if short_m > 0.0 { 0.0 } else { long_m[0].min(long_m[1]) };
            setbacks_m = wanted_m.map(|m| (m - short_m + long_m).max(0.0));
        }
        let [start, end] = ends(inbound, outbound, setbacks_m);
        if legs_of(start, end).is_some_and(|legs_m| are_equal(legs_m, 2.0 * STEP_M)) {
            return setbacks_m;
        }
        self.searched(longest_m, inbound, outbound).unwrap_or(setbacks_m)
    }

    /// The ends whose arc comes nearest to the radius that the curve ought to have, among all that make one. Arms that bend beside the
    /// node have their corner where the lines along them cross, which may be far from it.
    fn searched(self, longest_m: [f64; 2], inbound: &Polyline, outbound: &Polyline) -> Option<[f64; 2]> {
        let steps = |longest_m: f64| (0..=(longest_m / STEP_M) as usize).map(|i| STEP_M * i as f64);
        let mut best: Option<(f64, [f64; 2])> = None;
        for before_m in steps(longest_m[0]) {
            for behind_m in steps(longest_m[1]) {
                let [start, end] = ends(inbound, outbound, [before_m, behind_m]);
                let Some(legs_m) = legs_of(start, end).filter(|legs_m| are_equal(*legs_m, STEP_M)) else {
                    continue;
                };
                let turn_rad = wrap_angle(heading_of(end.1) - heading_of(start.1)).abs().min(SHARPEST_RAD);
                let radius_m = legs_m[0].min(legs_m[1]) / libm::tan(0.5 * turn_rad);
                let off = libm::log(radius_m / self.radius_m()).abs();
                if best.is_none_or(|(least, _)| off < least) {
                    best = Some((off, [before_m, behind_m]));
                }
            }
        }
        best.map(|(_, setbacks_m)| setbacks_m)
    }

    /// The curve with these ends: the papers' three points, as round as an arc.
    pub(super) fn curve(self, inbound: &Polyline, outbound: &Polyline, setbacks_m: [f64; 2]) -> Conic {
        let mut curve = Conic::between(inbound, outbound, setbacks_m);
        curve.round_up_to(self.radius_m());
        curve
    }
}

/// Lengths of the tangents at both ends up to their crossing, metres; none where they do not cross between them.
fn legs_of(start: End, end: End) -> Option<[f64; 2]> {
    let corner = crossing(start, end)?;
    Some([(corner - start.0).dot(&start.1), (end.0 - corner).dot(&end.1)])
}

/// Whether tangents are as long as each other to some metres, as those of an arc are.
fn are_equal(legs_m: [f64; 2], within_m: f64) -> bool {
    (legs_m[0] - legs_m[1]).abs() <= within_m
}
