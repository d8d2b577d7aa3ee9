//! Corners: how the edges of two roads are joined where the roads meet.
//!
//! Beside a corner both edges are straight lines, so that a join follows from a place's distances to them and the angle
//! between them: a circle that touches both (a rounded kerb), or a line across (a chamfer). Limits: a join is as long as
//! [`MAX_TANGENT_M`] along an edge, and roads that meet at less than 20 degrees have none.

use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use crate::junctions::Arm;
use crate::noise::Stream;
use crate::roads::Stroke;

/// How the corners of a drive's roads look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CornerStyle {
    /// All of them rounded by about 4 m.
    #[default]
    Alike,
    /// Each for itself: radii from 0.3 to 15 m, some square, some chamfered.
    Drawn,
}

/// Longest part of an edge that a corner takes away, metres: beyond it the next junction may begin.
const MAX_TANGENT_M: f64 = 14.0;
/// Cosine of the least angle between two roads that have a corner (20 degrees).
const PARALLEL_COS: f64 = 0.94;
/// Radii of rounded corners, metres: from farm tracks to what lorries need.
const RADII_M: [f64; 2] = [1.0, 15.0];
/// Radius of a square corner: kerb stones are no sharper, metres.
const SQUARE_M: f64 = 0.3;
/// Length that a chamfer takes of either edge, metres.
const LEGS_M: [f64; 2] = [1.5, 8.0];
/// Shares of the corners that are square, and square or chamfered.
const SQUARE_SHARE: f64 = 0.15;
const NOT_ROUND_SHARE: f64 = 0.27;

/// A corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Corner {
    /// A circle of this radius touches both edges, metres.
    Round(f64),
    /// A straight cut that takes this much of either edge, metres.
    Chamfer(f64),
}

/// A side of a road: its chain and whether it is the left one in the chain's direction.
pub(crate) type RoadSide = (u32, bool);

impl Corner {
    /// The corner of a junction between two sides of roads; their order does not matter.
    pub(crate) fn drawn(seed: u64, junction: i64, one: RoadSide, other: RoadSide) -> Self {
        let number = |(chain, left): RoadSide| 2 * u64::from(chain) + u64::from(left);
        let (low, high) = (number(one).min(number(other)), number(one).max(number(other)));
        let topic = (junction as u64).rotate_left(32) ^ (low << 20) ^ high;
        let mut stream = Stream::new(seed ^ 0x434f_524e, topic);
        let kind = stream.unit();
        if kind < SQUARE_SHARE {
            return Self::Round(SQUARE_M);
        }
        if kind < NOT_ROUND_SHARE {
            return Self::Chamfer(stream.between(LEGS_M[0], LEGS_M[1]));
        }
        // As many between 1 and 4 m as between 4 and 15 m.
        Self::Round(libm::exp(stream.between(libm::log(RADII_M[0]), libm::log(RADII_M[1]))))
    }

    /// The same where there is less room for it: `arms` with half of their widths, metres, and `turn_rad` from one into the other.
    pub(crate) fn between(self, arms: [(Arm, f64); 2], turn_rad: f64) -> Self {
        let tangent = libm::tan(0.5 * turn_rad.abs()).max(1e-3);
        let rooms_m = arms.map(|(arm, half_width_m)| arm.straight_m - half_width_m * tangent);
        let room_m = rooms_m[0].min(rooms_m[1]);
        match self {
            Self::Round(radius_m) => Self::Round(radius_m.min((room_m / tangent).max(SQUARE_M))),
            Self::Chamfer(leg_m) => Self::Chamfer(leg_m.min(room_m.max(SQUARE_M))),
        }
    }

    /// Radius of the largest circle that touches both edges and stays on the road, metres; `turn_rad` from one road into the
    /// other.
    pub(crate) fn radius_m(self, turn_rad: f64) -> f64 {
        let tangent = libm::tan(0.5 * turn_rad.abs()).max(1e-3);
        let asked_m = match self {
            Self::Round(radius_m) => radius_m,
            // The circle that touches the edges where the cut begins and ends.
            Self::Chamfer(leg_m) => leg_m / tangent,
        };
        asked_m.min(MAX_TANGENT_M / tangent)
    }

    /// Distance to the join of two edges, metres, negative on the road; infinite where the join does not reach.
    pub(crate) fn edge_m(self, one: &EdgeAt, other: &EdgeAt) -> f64 {
        let cos = one.outwards.dot(&other.outwards);
        if cos.abs() > PARALLEL_COS {
            return f64::INFINITY;
        }
        // From one road into the other the way turns by the angle between the edges' normals.
        let radius_m = self.radius_m(libm::acos(cos));
        match self {
            Self::Round(_) => {
                let (u, v) = (radius_m - one.distance_m, radius_m - other.distance_m);
                if u < v * cos || v < u * cos {
                    return f64::INFINITY;
                }
                radius_m - ((u * u + v * v - 2.0 * u * v * cos) / (1.0 - cos * cos)).max(0.0).sqrt()
            }
            Self::Chamfer(leg_m) => {
                let leg_m = leg_m.min(MAX_TANGENT_M);
                let cut_m = leg_m * (1.0 - cos * cos).sqrt();
                (one.distance_m + other.distance_m - cut_m) / (2.0 + 2.0 * cos).sqrt()
            }
        }
    }
}

/// A straight edge as seen from a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct EdgeAt {
    /// Distance from it, metres, negative on the road's side.
    pub(crate) distance_m: f64,
    /// Unit vector away from the road.
    pub(crate) outwards: Vector2<f64>,
    /// Whether it is the road's left edge in the stroke's direction.
    pub(crate) is_left: bool,
}

impl EdgeAt {
    /// The edge of an endless road along `stroke`, on the side of the axis where the place is.
    pub(crate) fn of(stroke: &Stroke, p_in_map: nalgebra::Point2<f64>) -> Self {
        let left_m = stroke.direction.perp(&(p_in_map - stroke.start));
        let is_left = left_m > 0.0;
        let sign = if is_left { 1.0 } else { -1.0 };
        let to_the_left = Vector2::new(-stroke.direction.y, stroke.direction.x);
        Self { distance_m: left_m.abs() - stroke.half_width_m, outwards: to_the_left * sign, is_left }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Edges along both axes of the plane, with the road where either coordinate is negative, turned so that the angle
    /// between their normals is `angle_rad`.
    fn edges(x: f64, y: f64, angle_rad: f64) -> (EdgeAt, EdgeAt) {
        let normals = [Vector2::new(1.0, 0.0), Vector2::new(libm::cos(angle_rad), libm::sin(angle_rad))];
        let at = |normal: Vector2<f64>| EdgeAt {
            distance_m: normal.dot(&Vector2::new(x, y)),
            outwards: normal,
            is_left: true,
        };
        (at(normals[0]), at(normals[1]))
    }

    #[test]
    fn a_round_corner_is_a_circle_that_touches_both_edges() {
        for angle_deg in [40.0_f64, 90.0, 130.0] {
            let angle_rad = angle_deg.to_radians();
            let radius_m: f64 = 5.0;
            // The middle is a radius away from both edges, half-way between their normals.
            let away_m = radius_m / libm::cos(0.5 * angle_rad);
            let middle = Vector2::new(libm::cos(0.5 * angle_rad), libm::sin(0.5 * angle_rad)) * away_m;
            for turn in [0.1, 0.5, 0.9] {
                let direction_rad = std::f64::consts::PI + turn * angle_rad;
                let on_arc =
                    middle + Vector2::new(libm::cos(direction_rad), libm::sin(direction_rad)) * radius_m;
                let (one, other) = edges(on_arc.x, on_arc.y, angle_rad);
                let edge_m = Corner::Round(radius_m).edge_m(&one, &other);
                assert!(edge_m.abs() < 1e-9, "{edge_m} m at {angle_deg} degrees");
            }
            let (one, other) = edges(0.9 * middle.x, 0.9 * middle.y, angle_rad);
            assert!(Corner::Round(radius_m).edge_m(&one, &other) > 0.0, "beside the road");
            let (one, other) = edges(0.02, 0.02, angle_rad);
            assert!(Corner::Round(radius_m).edge_m(&one, &other) < 0.0, "the corner itself is road");
        }
    }

    #[test]
    fn joins_go_over_into_the_edges() {
        // Along the circle's last radius the distance is that from the nearer edge.
        for y in [0.5, 2.0, 4.0] {
            let (one, other) = edges(5.0 - 1e-9, y, std::f64::consts::FRAC_PI_2);
            assert!((Corner::Round(5.0).edge_m(&one, &other) - y).abs() < 1e-6);
        }
        let (one, other) = edges(7.0, 1.0, std::f64::consts::FRAC_PI_2);
        assert!(Corner::Round(5.0).edge_m(&one, &other).is_infinite(), "beyond the join");
    }

    #[test]
    fn a_chamfer_takes_its_length_of_both_edges() {
        let place = |x: f64, y: f64| {
            let (one, other) = edges(x, y, std::f64::consts::FRAC_PI_2);
            Corner::Chamfer(3.0).edge_m(&one, &other)
        };
        assert!(place(3.0, 0.0).abs() < 1e-9 && place(0.0, 3.0).abs() < 1e-9);
        assert!(place(1.0, 1.0) < 0.0 && place(2.0, 2.0) > 0.0);
    }

    #[test]
    fn a_corner_ends_where_its_road_bends() {
        let arm = |straight_m: f64| (Arm { stroke: 0, away: Vector2::x(), straight_m }, 3.0);
        let right_angle = std::f64::consts::FRAC_PI_2;
        let between = |corner: Corner, short_m: f64| corner.between([arm(40.0), arm(short_m)], right_angle);
        assert_eq!(between(Corner::Round(12.0), 30.0), Corner::Round(12.0));
        let Corner::Round(radius_m) = between(Corner::Round(12.0), 8.0) else { panic!("still round") };
        assert!((radius_m - 5.0).abs() < 1e-9, "8 m less half of the other road's width: {radius_m} m");
        assert_eq!(between(Corner::Round(12.0), 1.0), Corner::Round(SQUARE_M));
        let Corner::Chamfer(leg_m) = between(Corner::Chamfer(7.0), 8.0) else { panic!("still a cut") };
        assert!((leg_m - 5.0).abs() < 1e-9);
    }

    #[test]
    fn corners_differ_and_cover_their_range() {
        let corners: Vec<Corner> =
            (0..400).map(|junction| Corner::drawn(7, junction, (1, true), (2, false))).collect();
        let radii: Vec<f64> = corners
            .iter()
            .filter_map(|corner| if let Corner::Round(radius_m) = corner { Some(*radius_m) } else { None })
            .collect();
        assert!(radii.iter().any(|&m| m < 0.4) && radii.iter().any(|&m| m > 12.0));
        assert!(
            (20..120).contains(&(corners.len() - radii.len())),
            "{} chamfers",
            corners.len() - radii.len()
        );
        assert_eq!(Corner::drawn(7, 3, (1, true), (2, false)), Corner::drawn(7, 3, (2, false), (1, true)));
        assert_ne!(Corner::drawn(7, 3, (1, true), (2, false)), Corner::drawn(7, 3, (1, false), (2, false)));
    }

    #[test]
    fn wide_corners_of_sharp_turns_are_no_longer_than_the_roads() {
        let turn_rad = 2.4_f64;
        let radius_m = Corner::Round(15.0).radius_m(turn_rad);
        assert!((radius_m * libm::tan(0.5 * turn_rad) - MAX_TANGENT_M).abs() < 1e-9);
        assert!((Corner::Round(5.0).radius_m(std::f64::consts::FRAC_PI_2) - 5.0).abs() < 1e-9);
        let cut_m = Corner::Chamfer(3.0).radius_m(turn_rad) * libm::tan(0.5 * turn_rad);
        assert!((cut_m - 3.0).abs() < 1e-9, "a cut is touched where it begins");
    }
}
