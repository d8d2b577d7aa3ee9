//! The road's surface at a feature as a signed distance: where the arms, their widths and the corners between them put the
//! edges.
//!
//! Every arm is a strip about its course; between two neighbouring arms that meet at less than a straight angle the edges are
//! joined by an arc that touches both. A square corner is an arc of no radius, a wide mouth one of a large radius: there is no
//! rule for either. A bend, which has two arms alone, has such an arc on its outer side too. The distance is that to the nearest edge, negative on the road, with its derivatives by everything that
//! is not known.

use std::f64::consts::TAU;

use fingerpost_map::ArmRole;
use nalgebra::{Point2, SVector, Vector2};

use crate::feature_model::{ArmModel, FeatureModel};

/// Most arms of a feature that take part; approach and exit come first, and of more the last sides are left out.
pub(in crate::track) const MOST_ARMS: usize = 6;
/// Length of a stretch of an arm, metres: a parked car, the shade of a tree; and how many an arm has, of which the last goes on.
const STRETCH_M: f64 = 5.0;
const ARM_STRETCHES: usize = 3;
/// How many stretches there are.
pub(in crate::track) const STRETCHES: usize = ARM_STRETCHES * MOST_ARMS;
/// Neighbouring arms at a larger angle than this run straight on, radians (150 degrees).
const STRAIGHT_RAD: f64 = 2.618;

/// The outline is drawn in steps of so many metres along each arm, to this error and so far from its axis, metres.
const OUTLINE_STEP_M: f64 = 0.5;
const OUTLINE_STEPS: u32 = 40;
const OUTLINE_ERROR_M: f64 = 0.02;
const OUTLINE_REACH_M: f64 = 12.0;
const OUTLINE_ROUNDS: usize = 12;

/// Places of the unknowns in a vector: pose, then width, offset and corner of every arm, then the camera's.
pub(in crate::track) const FORWARD: usize = 0;
pub(in crate::track) const LEFT: usize = 1;
pub(in crate::track) const HEADING: usize = 2;
pub(in crate::track) const WIDTHS: usize = 3;
pub(in crate::track) const OFFSETS: usize = WIDTHS + MOST_ARMS;
pub(in crate::track) const CORNERS: usize = OFFSETS + MOST_ARMS;
pub(in crate::track) const PITCH: usize = CORNERS + MOST_ARMS;
pub(in crate::track) const ROLL: usize = PITCH + 1;
pub(in crate::track) const SCALE: usize = PITCH + 2;
/// How many unknowns there are.
pub(in crate::track) const UNKNOWNS: usize = PITCH + 3;

/// Values of the unknowns, or derivatives by them.
pub(in crate::track) type Unknowns = SVector<f64, UNKNOWNS>;

/// The outline of a feature's road.
#[derive(Debug, Clone)]
pub(in crate::track) struct JunctionShape {
    /// Anticlockwise by their direction.
    arms: Vec<Strip>,
}

#[derive(Debug, Clone)]
struct Strip {
    /// Course from the node outwards, feature frame: start, direction and length of every straight piece.
    pieces: Vec<Piece>,
    half_width_m: f64,
    /// Distance from the node up to which it is known, metres: the map's course ends there, or the next feature begins.
    reach_m: f64,
    /// Whether an arc joins its left edge and the right one of the next arm, and the product of the normals of the two.
    corner: Option<f64>,
}

#[derive(Debug, Clone, Copy)]
struct Piece {
    start: Point2<f64>,
    along: Vector2<f64>,
    length_m: f64,
    before_m: f64,
}

/// The outline with its numbers worked out.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct Outline<'a> {
    arms: &'a [Strip],
    half_m: [f64; MOST_ARMS],
    offset_m: [f64; MOST_ARMS],
    radius_m: [f64; MOST_ARMS],
    /// The least half width of all: no arm reaches farther behind the node, where the others' road is.
    end_m: f64,
}

/// Where a place lies beside an arm.
#[derive(Debug, Clone, Copy)]
struct Beside {
    left_m: f64,
    left: Vector2<f64>,
    /// Distance outwards from the node; negative behind it.
    along_m: f64,
}

/// Beside an arm that is not there.
const NOWHERE: Beside = Beside { left_m: f64::INFINITY, left: Vector2::new(0.0, 1.0), along_m: 0.0 };

/// Signed distance of a place from two edges that are joined by an arc, and how it changes.
#[derive(Debug, Clone, Copy)]
struct Arc {
    distance_m: f64,
    /// By how far the place lies beyond each edge.
    by_beyond: [f64; 2],
    by_radius: f64,
}

impl Arc {
    /// Of a place so far beyond each of two edges with this product of their normals, between which the ground is road where the place
    /// is on the road's side of either; none where it lies beside an edge and not beside the arc.
    fn between([u_m, v_m]: [f64; 2], radius_m: f64, product: f64) -> Option<Self> {
        let (du, dv, rest) = (u_m - radius_m, v_m - radius_m, 1.0 - product * product);
        let (a, b) = ((du - product * dv) / rest, (dv - product * du) / rest);
        (a <= 0.0 && b <= 0.0).then(|| {
            let from_centre_m = (du * a + dv * b).max(1e-18).sqrt();
            Self {
                distance_m: radius_m - from_centre_m,
                by_beyond: [-a / from_centre_m, -b / from_centre_m],
                by_radius: 1.0 + (a + b) / from_centre_m,
            }
        })
    }

    /// Of a place beside the first edge, or the second.
    const fn of_edge([u_m, v_m]: [f64; 2], is_first: bool) -> Self {
        let (distance_m, by_beyond) = if is_first { (u_m, [1.0, 0.0]) } else { (v_m, [0.0, 1.0]) };
        Self { distance_m, by_beyond, by_radius: 0.0 }
    }
}

/// Signed distance of a place from the road's edge, negative on the road, and how it changes.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct EdgeDistance {
    pub(in crate::track) distance_m: f64,
    /// The stretch of the nearest arm that it lies beside, of [`STRETCHES`].
    pub(in crate::track) stretch: usize,
    /// By the place, feature frame.
    pub(in crate::track) by_place: Vector2<f64>,
    /// Which arms' left (first) and right (second) edges are concerned, with the derivative of the distance by how far the place lies beyond each.
    pub(in crate::track) edges: [(usize, f64); 2],
    /// The corner concerned and the derivative by its radius.
    pub(in crate::track) corner: Option<(usize, f64)>,
}

impl JunctionShape {
    /// The outline of `model`, of whose route `reach_m` metres before and behind the node are its own.
    pub(in crate::track) fn of(model: &FeatureModel, reach_m: [f64; 2]) -> Self {
        let [before_m, behind_m] = reach_m;
        let mut arms: Vec<&ArmModel> = model.arms.iter().collect();
        arms.truncate(MOST_ARMS);
        arms.sort_by(|a, b| a.direction_rad().rem_euclid(TAU).total_cmp(&b.direction_rad().rem_euclid(TAU)));
        let count = arms.len();
        let corner = |i: usize| {
            let next = arms[(i + 1) % count];
            let between = (next.direction_rad() - arms[i].direction_rad()).rem_euclid(TAU);
            (count > 1 && between < STRAIGHT_RAD && between > 0.2).then(|| -libm::cos(between))
        };
        let strips = (0..count).map(|i| Strip {
            pieces: pieces(arms[i]),
            half_width_m: 0.5 * arms[i].width_m,
            reach_m: arms[i].course.length_m().min(match arms[i].role {
                ArmRole::Approach => before_m,
                ArmRole::Exit => behind_m,
                ArmRole::Side => f64::INFINITY,
            }),
            corner: corner(i),
        });
        Self { arms: strips.collect() }
    }

    /// The outline with these unknowns.
    pub(in crate::track) fn outline(&self, unknowns: &Unknowns) -> Outline<'_> {
        let mut outline = Outline {
            arms: &self.arms,
            half_m: [0.0; MOST_ARMS],
            offset_m: [0.0; MOST_ARMS],
            radius_m: [0.0; MOST_ARMS],
            end_m: f64::INFINITY,
        };
        for (i, arm) in self.arms.iter().enumerate() {
            outline.half_m[i] = arm.half_width_m * libm::exp(unknowns[WIDTHS + i]);
            outline.offset_m[i] = unknowns[OFFSETS + i];
            outline.radius_m[i] = libm::exp(unknowns[CORNERS + i]);
            outline.end_m = outline.end_m.min(outline.half_m[i]);
        }
        outline
    }
}

impl Outline<'_> {
    /// Signed distance of `p_in_feature` from the edge of the road; none where nothing is known of it.
    pub(in crate::track) fn distance(&self, p_in_feature: Point2<f64>) -> Option<EdgeDistance> {
        let count = self.arms.len();
        let mut besides = [NOWHERE; MOST_ARMS];
        let (mut nearest, mut nearest_m) = (0, f64::INFINITY);
        for (i, arm) in self.arms.iter().enumerate() {
            let mut beside = arm.beside(p_in_feature);
            beside.left_m -= self.offset_m[i];
            let distance_m = if beside.along_m >= 0.0 {
                beside.left_m.abs() - self.half_m[i]
            } else {
                self.end(i, &beside).0
            };
            if distance_m < nearest_m {
                (nearest, nearest_m) = (i, distance_m);
            }
            besides[i] = beside;
        }
        let beside = besides[nearest];
        let off_m = beside.left_m;
        if nearest_m == f64::INFINITY {
            return None;
        }
        let along = (beside.along_m / STRETCH_M).clamp(0.0, (ARM_STRETCHES - 1) as f64) as usize;
        let stretch = ARM_STRETCHES * nearest + along;
        if beside.along_m > self.arms[nearest].reach_m {
            return None;
        }
        if let Some(i) = self.bend() {
            return Some(self.distance_from_bend((i, 1 - i), &besides, stretch));
        }
        let is_left = off_m >= 0.0;
        // The corner on the side of the nearest arm on which the place lies.
        let (i, j) =
            if is_left { (nearest, (nearest + 1) % count) } else { ((nearest + count - 1) % count, nearest) };
        let (left_arm, right_arm) = (&besides[i], &besides[j]);
        let is_between = i != j && left_arm.left_m >= 0.0 && right_arm.left_m <= 0.0;
        if let Some(product) = self.arms[i].corner.filter(|_| is_between) {
            let beyond_m = [left_arm.left_m - self.half_m[i], -right_arm.left_m - self.half_m[j]];
            if let Some(arc) = Arc::between(beyond_m, self.radius_m[i], product) {
                let [by_u, by_v] = arc.by_beyond;
                return Some(EdgeDistance {
                    distance_m: arc.distance_m,
                    stretch,
                    by_place: by_u * left_arm.left - by_v * right_arm.left,
                    edges: [(i, by_u), (j, by_v)],
                    corner: Some((i, arc.by_radius * self.radius_m[i])),
                });
            }
        }
        let side = if is_left { 0 } else { 1 };
        let mut edges = [(nearest, 0.0); 2];
        edges[side].1 = 1.0;
        let by_place = if beside.along_m >= 0.0 {
            if is_left { beside.left } else { -beside.left }
        } else {
            self.end(nearest, &beside).1
        };
        Some(EdgeDistance { distance_m: nearest_m, stretch, by_place, edges, corner: None })
    }

    /// The arm after which the corner of a bend comes; none of other features.
    fn bend(&self) -> Option<usize> {
        self.arms.iter().position(|arm| arm.corner.is_some()).filter(|_| self.arms.len() == 2)
    }

    /// Signed distance from the edges of a bend, whose inner edges `i` has on its left and `j` on its right. Either pair of edges ends
    /// in an arc, the outer one with the radius that is otherwise that of the corner after `j`.
    fn distance_from_bend(
        &self,
        (i, j): (usize, usize),
        besides: &[Beside; MOST_ARMS],
        stretch: usize,
    ) -> EdgeDistance {
        let product = self.arms[i].corner.unwrap_or_default();
        let [one, other] = [i, j].map(|arm| (besides[arm].left_m, besides[arm].left, self.half_m[arm]));
        let inner_m = [one.0 - one.2, -other.0 - other.2];
        let inner = Arc::between(inner_m, self.radius_m[i], product)
            .unwrap_or_else(|| Arc::of_edge(inner_m, inner_m[0] <= inner_m[1]));
        // Seen from the ground beside it the outer arc is one that turns the other way.
        let outer_m = [other.0 - other.2, -one.0 - one.2];
        let beside_m = outer_m.map(|m| -m);
        let outer = Arc::between(beside_m, self.radius_m[j], product)
            .unwrap_or_else(|| Arc::of_edge(beside_m, beside_m[0] <= beside_m[1]));
        if inner.distance_m >= -outer.distance_m {
            let [by_left, by_right] = inner.by_beyond;
            EdgeDistance {
                distance_m: inner.distance_m,
                stretch,
                by_place: by_left * one.1 - by_right * other.1,
                edges: [(i, by_left), (j, by_right)],
                corner: Some((i, inner.by_radius * self.radius_m[i])),
            }
        } else {
            let [by_left, by_right] = outer.by_beyond;
            EdgeDistance {
                distance_m: -outer.distance_m,
                stretch,
                by_place: by_left * other.1 - by_right * one.1,
                edges: [(j, by_left), (i, by_right)],
                corner: Some((j, -outer.by_radius * self.radius_m[j])),
            }
        }
    }

    /// Signed distance of a place behind the node from the end of an arm, and how it changes with the place. The end is half of an
    /// ellipse as wide as the arm and as deep as the narrowest arm's half width, so that a wide arm does not reach across a narrow
    /// road; the distance is that of first order (Taubin: Estimation of planar curves, surfaces and nonplanar space curves defined
    /// by implicit equations, 1991).
    fn end(&self, arm: usize, beside: &Beside) -> (f64, Vector2<f64>) {
        let half_m = self.half_m[arm];
        let stretched = half_m / self.end_m;
        let (left_m, along_m) = (beside.left_m, stretched * beside.along_m);
        let from_node_m = libm::hypot(left_m, along_m).max(1e-9);
        let along = Vector2::new(beside.left.y, -beside.left.x);
        let slope = (left_m * beside.left + stretched * along_m * along) / from_node_m;
        let steepness = slope.norm().max(1e-9);
        ((from_node_m - half_m) / steepness, slope / steepness)
    }

    /// Gives the outline, piece by piece from the ends of the arms as far as they go, feature frame, metres.
    pub(in crate::track) fn each_edge(&self, mut give: impl FnMut(Point2<f64>, Point2<f64>)) {
        for (i, arm) in self.arms.iter().enumerate() {
            for side in [1.0, -1.0] {
                let mut before: Option<Point2<f64>> = None;
                for step in 0..OUTLINE_STEPS {
                    let at = arm.at(OUTLINE_STEP_M * f64::from(step));
                    // From the axis outwards to where the road ends.
                    let edge = self.edge_along(i, at, side);
                    if let (Some(from), Some(to)) = (before, edge) {
                        give(from, to);
                    }
                    before = edge;
                }
            }
        }
    }

    /// Where the road ends beside an arm, from a place on its axis to a side; none where it goes on into another arm.
    fn edge_along(
        &self,
        arm: usize,
        (axis, left): (Point2<f64>, Vector2<f64>),
        side: f64,
    ) -> Option<Point2<f64>> {
        let mut out_m = self.half_m.get(arm)? + side * self.offset_m.get(arm)?;
        for _ in 0..OUTLINE_ROUNDS {
            let place = axis + side * out_m * left;
            let distance_m = self.distance(place)?.distance_m;
            if distance_m.abs() < OUTLINE_ERROR_M {
                return Some(place);
            }
            out_m -= distance_m;
            if out_m > OUTLINE_REACH_M {
                return None;
            }
        }
        None
    }

    /// Gives the derivatives of a distance by widths, offsets and the corner that concern it.
    pub(in crate::track) fn each_derivative(&self, edge: &EdgeDistance, mut give: impl FnMut(usize, f64)) {
        for (side, (arm, by_beyond)) in edge.edges.into_iter().enumerate() {
            let Some(half_m) = self.half_m.get(arm).filter(|_| by_beyond != 0.0) else { continue };
            give(WIDTHS + arm, -by_beyond * half_m);
            give(OFFSETS + arm, if side == 0 { -by_beyond } else { by_beyond });
        }
        if let Some((arm, by_radius)) = edge.corner {
            give(CORNERS + arm, by_radius);
        }
    }
}

fn pieces(arm: &ArmModel) -> Vec<Piece> {
    let points = arm.course.points();
    let mut before_m = 0.0;
    let mut pieces = Vec::new();
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        let length_m = step.norm();
        if length_m > 1e-6 {
            pieces.push(Piece { start: pair[0], along: step / length_m, length_m, before_m });
            before_m += length_m;
        }
    }
    pieces
}

impl Piece {
    /// The direction to its left.
    fn left(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }
}

impl Strip {
    /// The place on the axis so far outwards, and what is left there.
    fn at(&self, along_m: f64) -> (Point2<f64>, Vector2<f64>) {
        let piece = self.pieces.iter().rev().find(|piece| piece.before_m <= along_m).or(self.pieces.first());
        piece.map_or((Point2::origin(), Vector2::y()), |piece| {
            (piece.start + (along_m - piece.before_m) * piece.along, piece.left())
        })
    }

    fn beside(&self, p: Point2<f64>) -> Beside {
        let last = self.pieces.len().saturating_sub(1);
        let mut nearest: Option<(f64, f64, f64, f64, &Piece)> = None;
        for (i, piece) in self.pieces.iter().enumerate() {
            let from = p - piece.start;
            let along_m = piece.along.dot(&from);
            // The first piece goes on behind the node and the last one beyond its end.
            let least = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
            let most = if i == last { f64::INFINITY } else { piece.length_m };
            let off_m = along_m - along_m.clamp(least, most);
            let left_m = piece.left().dot(&from);
            let squared = off_m * off_m + left_m * left_m;
            if nearest.is_none_or(|(least, ..)| squared < least) {
                nearest = Some((squared, off_m, left_m, along_m, piece));
            }
        }
        nearest.map_or(NOWHERE, |(squared, off_m, left_m, along_m, piece)| Beside {
            left_m: if off_m == 0.0 { left_m } else { squared.sqrt().copysign(left_m) },
            left: piece.left(),
            along_m: piece.before_m + along_m,
        })
    }
}

#[cfg(test)]
pub(super) mod tests {
    use fingerpost_geometry::Polyline;
    use fingerpost_map::FeatureKind;
    use nalgebra::Isometry2;

    use super::*;

    type Place = (f64, f64);

    /// A T-junction that is left to the right: approach from behind, exit to the right, the other arm to the left.
    pub(in crate::track::belief) fn t_junction() -> JunctionShape {
        let arm = |role, label: &str, x: f64, y: f64| ArmModel {
            role,
            label: label.into(),
            course: Polyline::new([Point2::origin(), Point2::new(x, y)]).unwrap(),
            width_m: 6.0,
            mouth_m: 3.0,
            leaves_after_m: None,
        };
        let model = FeatureModel {
            id: 1,
            name: String::new(),
            kind: FeatureKind::Junction,
            route_m: 50.0,
            arms: vec![
                arm(ArmRole::Approach, "approach", -30.0, 0.0),
                arm(ArmRole::Exit, "exit", 0.0, -30.0),
                arm(ArmRole::Side, "side_1", 0.0, 30.0),
            ],
            map_from_feature: Isometry2::identity(),
        };
        JunctionShape::of(&model, [f64::INFINITY, f64::INFINITY])
    }

    /// Corners of this radius.
    fn unknowns(radius_m: f64) -> Unknowns {
        let mut unknowns = Unknowns::zeros();
        (0..MOST_ARMS).for_each(|arm| unknowns[CORNERS + arm] = libm::log(radius_m));
        unknowns
    }

    fn distance_m(radius_m: f64, x: f64, y: f64) -> f64 {
        t_junction().outline(&unknowns(radius_m)).distance(Point2::new(x, y)).unwrap().distance_m
    }

    #[test]
    fn places_of_a_t_junction_lie_where_they_are_seen_to() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-8, "{a} for {b}");
        near(distance_m(4.0, -15.0, 0.0), -3.0);
        near(distance_m(4.0, -15.0, 4.0), 1.0);
        near(distance_m(4.0, -15.0, -4.5), 1.5);
        near(distance_m(4.0, 3.5, 0.0), 0.5);
        near(distance_m(4.0, 2.0, -12.0), -1.0);
        near(distance_m(4.0, -3.5, 12.0), 0.5);
        // The centre of the arc between the approach and either arm, and the corner that it cuts off.
        for side in [1.0, -1.0] {
            near(distance_m(4.0, -7.0, 7.0 * side), 4.0);
            near(distance_m(4.0, -3.0, 3.0 * side), 4.0 - 4.0 * std::f64::consts::SQRT_2);
            assert!(distance_m(0.3, -3.5, 3.5 * side) > 0.2, "a square corner");
            assert!(distance_m(8.0, -3.5, 3.5 * side) < -1.0, "a wide mouth");
        }
        assert!(t_junction().outline(&unknowns(4.0)).distance(Point2::new(0.0, 31.0)).is_none(), "unknown");
    }

    #[test]
    fn a_wide_arm_does_not_reach_across_a_narrow_road() {
        let shape = t_junction();
        let mut wide = unknowns(4.0);
        wide[WIDTHS + 1] = std::f64::consts::LN_2;
        let distance_m =
            |x: f64, y: f64| shape.outline(&wide).distance(Point2::new(x, y)).unwrap().distance_m;
        for (x, y, is) in
            [(-15.0, 5.0, -1.0), (3.5, 0.0, 0.5), (2.5, 0.0, -0.5), (3.5, 4.0, 0.5), (5.0, 0.0, 2.0)]
        {
            assert!((distance_m(x, y) - is).abs() < 1e-8, "({x}, {y}): {} for {is}", distance_m(x, y));
        }
    }

    /// A bend to the right by a right angle: approach from behind, exit to the right.
    fn bend() -> JunctionShape {
        let mut bend = t_junction();
        bend.arms.retain(|arm| arm.pieces[0].along.y < 0.5);
        bend.arms.iter_mut().for_each(|arm| arm.corner = None);
        // Anticlockwise the exit comes after the approach.
        bend.arms[0].corner = Some(0.0);
        bend
    }

    #[test]
    fn a_bend_has_an_arc_on_either_side() {
        let shape = bend();
        let mut at = unknowns(4.0);
        at[CORNERS + 1] = libm::log(10.0);
        let distance_m = |x: f64, y: f64| shape.outline(&at).distance(Point2::new(x, y)).unwrap().distance_m;
        // Both arcs are about a place 7 m behind the node and 7 m to the right of it.
        let along = std::f64::consts::FRAC_1_SQRT_2;
        let about = |radius_m: f64| [-7.0 + along * radius_m, -7.0 + along * radius_m];
        for (radius_m, is) in [(3.0, 1.0), (4.0, 0.0), (6.0, -2.0), (8.0, -2.0), (10.0, 0.0), (12.0, 2.0)] {
            let [x, y] = about(radius_m);
            assert!((distance_m(x, y) - is).abs() < 1e-8, "{radius_m}: {} for {is}", distance_m(x, y));
        }
        for (x, y, is) in [(-15.0, 2.0, -1.0), (-15.0, -4.0, 1.0), (-1.0, -20.0, -2.0), (3.5, -20.0, 0.5)] {
            assert!((distance_m(x, y) - is).abs() < 1e-8, "({x}, {y}): {} for {is}", distance_m(x, y));
        }
        // A square outer corner.
        at[CORNERS + 1] = libm::log(0.3);
        let square_m = shape.outline(&at).distance(Point2::new(2.5, 2.5)).unwrap().distance_m;
        assert!(square_m < -0.2, "{square_m}");
    }

    #[test]
    fn derivatives_are_those_of_the_distance() {
        check_derivatives(
            &t_junction(),
            &[(-15.0, 2.5), (-12.0, -3.2), (-4.5, 4.0), (-4.0, -5.5), (2.5, 8.0), (3.1, -9.0)],
        );
        check_derivatives(
            &bend(),
            &[(-15.0, 2.5), (-12.0, -3.2), (-4.5, -4.0), (-5.0, -3.9), (1.0, 0.5), (0.5, 1.5), (3.1, -14.0)],
        );
    }

    fn check_derivatives(shape: &JunctionShape, places: &[Place]) {
        let step = 1e-6;
        for &(x, y) in places {
            let mut at = unknowns(5.0);
            (at[WIDTHS], at[OFFSETS + 1], at[CORNERS + 2]) = (0.1, 0.2, 1.2);
            let place = Point2::new(x, y);
            let edge = shape.outline(&at).distance(place).unwrap();
            let mut given = Unknowns::zeros();
            shape.outline(&at).each_derivative(&edge, |index, by| given[index] += by);
            for index in WIDTHS..PITCH {
                let mut moved = at;
                moved[index] += step;
                let by = (shape.outline(&moved).distance(place).unwrap().distance_m - edge.distance_m) / step;
                assert!((by - given[index]).abs() < 1e-4, "({x}, {y}) by {index}: {by} for {}", given[index]);
            }
            for (axis, moved) in [(0, Vector2::x()), (1, Vector2::y())] {
                let moved = shape.outline(&at).distance(place + step * moved).unwrap();
                let by = (moved.distance_m - edge.distance_m) / step;
                assert!((by - edge.by_place[axis]).abs() < 1e-4, "({x}, {y}) along {axis}");
            }
        }
    }

    #[test]
    fn the_outline_lies_on_the_edge() {
        let (shape, at) = (t_junction(), unknowns(5.0));
        let outline = shape.outline(&at);
        let mut pieces = 0;
        outline.each_edge(|from, to| {
            pieces += 1;
            for place in [from, to] {
                let off_m = outline.distance(place).unwrap().distance_m;
                assert!(off_m.abs() < OUTLINE_ERROR_M, "{place}: {off_m}");
            }
        });
        assert!(pieces > 100, "{pieces}");
    }
}
