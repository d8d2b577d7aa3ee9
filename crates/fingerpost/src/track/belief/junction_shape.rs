//! The road's surface at a feature as a signed distance: where the arms, their widths and the corners between them put the
//! edges.
//!
//! Every arm is a strip about its course; between two neighbouring arms that meet at less than a straight angle the edges are
//! joined by an arc that touches both. A square corner is an arc of no radius, a wide mouth one of a large radius: there is no
//! rule for either. A bend, which has two arms alone, has such an arc on its outer side too. The distance is that to the nearest edge,
//! negative on the road, with its derivatives by everything that is not known.

mod arc;
mod strip;
mod surroundings;
mod unknowns;

use std::f64::consts::TAU;

use fingerpost_map::ArmRole;
use nalgebra::{Point2, Vector2};

use arc::Arc;
use strip::{Beside, NOWHERE, Strip, pieces};

pub(in crate::track) use surroundings::{Neighbour, Surroundings};
pub(in crate::track) use unknowns::{
    CORNERS, FORWARD, HEADING, LEFT, OFFSETS, PITCH, ROLL, SCALE, UNKNOWNS, Unknowns, WIDTHS,
};

use crate::feature_model::{ArmModel, FeatureModel};

/// Most arms of a feature that take part; approach and exit come first, and of more the last sides are left out.
pub(in crate::track) const MOST_ARMS: usize = 6;
/// Length of a stretch of an arm, metres: a parked car, the shade of a tree; and how many an arm has, of which the last goes on.
const STRETCH_M: f64 = 5.0;
const ARM_STRETCHES: usize = 3;
/// Stretches of a feature's arms.
const OWN_STRETCHES: usize = ARM_STRETCHES * MOST_ARMS;
/// How many stretches there are: its own, then those of the features before and behind it.
pub(in crate::track) const STRETCHES: usize = 3 * OWN_STRETCHES;
/// Neighbouring arms at a larger angle than this run straight on, radians (150 degrees).
const STRAIGHT_RAD: f64 = 2.618;

/// What is shorter has no direction, metres.
const LEAST_LENGTH: f64 = 1e-9;

/// The outline is drawn in steps of so many metres along each arm, to this error and so far from its axis, metres.
const OUTLINE_STEP_M: f64 = 0.5;
const OUTLINE_STEPS: u32 = 40;
const OUTLINE_ERROR_M: f64 = 0.02;
const OUTLINE_REACH_M: f64 = 12.0;
const OUTLINE_ROUNDS: usize = 12;

/// The outline of a feature's road.
#[derive(Debug, Clone)]
pub(in crate::track) struct JunctionShape {
    /// Anticlockwise by their direction.
    arms: Vec<Strip>,
}

/// The outline with its numbers worked out.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct Outline<'a> {
    arms: &'a [Strip],
    half_m: [f64; MOST_ARMS],
    offset_m: [f64; MOST_ARMS],
    radius_m: [f64; MOST_ARMS],
    /// How much wider each arm is than the narrowest: no arm reaches farther behind the node than that one's half width, where the
    /// others' road is.
    widened: [f64; MOST_ARMS],
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
    /// How soft the edge is because nobody knows better where it lies, metres.
    pub(in crate::track) soft_m: f64,
}

/// What lies at a place, by the outline of a feature.
enum Look {
    /// Road or ground beside it, so far from the edge.
    Edge(EdgeDistance),
    /// It lies on the route beyond what is the feature's own, before it (0) or behind (1).
    Beyond(usize),
    /// Nothing is known of it.
    Unknown,
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
            leads_to: match arms[i].role {
                ArmRole::Approach => Some(0),
                ArmRole::Exit => Some(1),
                ArmRole::Side => None,
            },
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
            widened: [1.0; MOST_ARMS],
        };
        let mut narrowest_m = f64::INFINITY;
        for (i, arm) in self.arms.iter().enumerate() {
            outline.half_m[i] = arm.half_width_m * libm::exp(unknowns[WIDTHS + i]);
            outline.offset_m[i] = unknowns[OFFSETS + i];
            outline.radius_m[i] = libm::exp(unknowns[CORNERS + i]);
            narrowest_m = narrowest_m.min(outline.half_m[i]);
        }
        for (widened, half_m) in outline.widened.iter_mut().zip(outline.half_m).take(self.arms.len()) {
            *widened = half_m / narrowest_m;
        }
        outline
    }
}

impl Outline<'_> {
    /// Signed distance of `p_in_feature` from the edge of the road; none where nothing is known of it.
    pub(in crate::track) fn distance(&self, p_in_feature: Point2<f64>) -> Option<EdgeDistance> {
        match self.look(p_in_feature) {
            Look::Edge(edge) => Some(edge),
            Look::Beyond(_) | Look::Unknown => None,
        }
    }

    /// What lies at `p_in_feature`.
    fn look(&self, p_in_feature: Point2<f64>) -> Look {
        let count = self.arms.len();
        let mut besides = [NOWHERE; MOST_ARMS];
        let (mut nearest, mut nearest_m) = (0, f64::INFINITY);
        for (i, arm) in self.arms.iter().enumerate() {
            let mut beside = arm.beside(p_in_feature);
            beside.left_m -= self.offset_m[i];
            let distance_m = if beside.along_m >= 0.0 {
                beside.left_m.abs() - self.half_m[i]
            } else if self.end_is_no_nearer(i, &beside, nearest_m) {
                f64::INFINITY
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
            return Look::Unknown;
        }
        let along = (beside.along_m / STRETCH_M).clamp(0.0, (ARM_STRETCHES - 1) as f64) as usize;
        let stretch = ARM_STRETCHES * nearest + along;
        if beside.along_m > self.arms[nearest].reach_m {
            return self.arms[nearest].leads_to.map_or(Look::Unknown, Look::Beyond);
        }
        if let Some(i) = self.bend() {
            return Look::Edge(self.distance_from_bend((i, 1 - i), &besides, stretch));
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
                return Look::Edge(EdgeDistance {
                    distance_m: arc.distance_m,
                    stretch,
                    by_place: by_u * left_arm.left - by_v * right_arm.left,
                    edges: [(i, by_u), (j, by_v)],
                    corner: Some((i, arc.by_radius * self.radius_m[i])),
                    soft_m: 0.0,
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
        Look::Edge(EdgeDistance {
            distance_m: nearest_m,
            stretch,
            by_place,
            edges,
            corner: None,
            soft_m: 0.0,
        })
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
                soft_m: 0.0,
            }
        } else {
            let [by_left, by_right] = outer.by_beyond;
            EdgeDistance {
                distance_m: -outer.distance_m,
                stretch,
                by_place: by_left * other.1 - by_right * one.1,
                edges: [(j, by_left), (i, by_right)],
                corner: Some((j, -outer.by_radius * self.radius_m[j])),
                soft_m: 0.0,
            }
        }
    }

    /// Signed distance of a place behind the node from the end of an arm, and how it changes with the place. The end is half of an
    /// ellipse as wide as the arm and as deep as the narrowest arm's half width, so that a wide arm does not reach across a narrow
    /// road; the distance is that of first order (Taubin: Estimation of planar curves, surfaces and nonplanar space curves defined
    /// by implicit equations, 1991).
    fn end(&self, arm: usize, beside: &Beside) -> (f64, Vector2<f64>) {
        let (half_m, widened) = (self.half_m[arm], self.widened[arm]);
        let (left_m, along_m) = (beside.left_m, widened * beside.along_m);
        let from_node_m = libm::hypot(left_m, along_m).max(LEAST_LENGTH);
        let along = Vector2::new(beside.left.y, -beside.left.x);
        let slope = (left_m * beside.left + widened * along_m * along) / from_node_m;
        let steepness = slope.norm().max(LEAST_LENGTH);
        ((from_node_m - half_m) / steepness, slope / steepness)
    }

    /// Whether that distance is no less than `least_m`, as far as it shows without working it out: the ellipse is nowhere steeper than it
    /// is widened.
    fn end_is_no_nearer(&self, arm: usize, beside: &Beside, least_m: f64) -> bool {
        let widened = self.widened[arm];
        let (left_m, along_m) = (beside.left_m, widened * beside.along_m);
        let from_node_m = self.half_m[arm] + least_m.max(0.0) * widened;
        left_m * left_m + along_m * along_m >= from_node_m * from_node_m
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

#[cfg(test)]
pub(super) mod tests;
