//! A feature with those before and behind it on the route: where its own road ends theirs begins.
//!
//! The opening of a junction looks like that of the next. Two that stand ten metres apart are told from each other by both: where one
//! is taken for the other, the map puts the other where there is none. How far they are apart is one unknown, which is taken for the softness of
//! the other's edges: what they say of the place along the road is a little too sure where many of them are seen.

use nalgebra::{Isometry2, Point2, Vector2};

use super::{EdgeDistance, JunctionShape, Look, OWN_STRETCHES, Outline, Unknowns};
use crate::feature_model::FeatureModel;

/// Softness of an edge whose place has the standard deviation of the distance of two nodes, each known along the route to 0.7 m
/// (`along_route.rs`): the scale of the logistic distribution that has it, the square root of 6 times 0.7 by pi, metres.
const NODES_APART_SOFT_M: f64 = 0.546;

/// A feature next to another one on the route, as wide as it is believed to be.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct Neighbour<'a> {
    outline: Outline<'a>,
    neighbour_from_feature: Isometry2<f64>,
    /// Along the road that leads there, feature frame.
    outwards: Vector2<f64>,
    /// How far ahead along the route the feature would be by where this one is believed to be, metres; none where it is not believed to be
    /// anywhere.
    pub(in crate::track) feature_before_m: Option<f64>,
}

impl<'a> Neighbour<'a> {
    /// The feature `other` on the `side` before (0) or behind `model` (1), with this outline, and where it is believed to be.
    pub(in crate::track) fn new(
        model: &FeatureModel,
        (other, side): (&FeatureModel, usize),
        outline: Outline<'a>,
        believed: Option<&Isometry2<f64>>,
    ) -> Option<Self> {
        let neighbour_from_feature = other.map_from_feature.inverse() * model.map_from_feature;
        let node = neighbour_from_feature.inverse() * Point2::origin();
        let course = &[model.approach(), model.exit()].into_iter().nth(side)??.course;
        let (_, outwards) = course.at(course.nearest(node).along_m);
        let vehicle_m = believed.and_then(|vehicle_from_other| other.route_m_of_vehicle(vehicle_from_other));
        let feature_before_m = vehicle_m.map(|vehicle_m| model.route_m - vehicle_m);
        Some(Self { outline, neighbour_from_feature, outwards, feature_before_m })
    }

    /// Signed distance from the edge of its road, which lies on the `side` before (0) or behind (1). Along the road it may be off by as much
    /// as the distance of the two nodes.
    fn distance(&self, p_in_feature: Point2<f64>, side: usize) -> Option<EdgeDistance> {
        let edge = self.outline.distance(self.neighbour_from_feature * p_in_feature)?;
        let by_place = self.neighbour_from_feature.rotation.inverse() * edge.by_place;
        Some(EdgeDistance {
            distance_m: edge.distance_m,
            stretch: (1 + side) * OWN_STRETCHES + edge.stretch,
            by_place,
            edges: [(0, 0.0); 2],
            corner: None,
            soft_m: NODES_APART_SOFT_M * by_place.dot(&self.outwards).abs(),
        })
    }
}

/// A feature's shape, and the features before and behind it.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct Surroundings<'a> {
    pub(in crate::track) shape: &'a JunctionShape,
    pub(in crate::track) neighbours: [Option<Neighbour<'a>>; 2],
}

impl<'a> Surroundings<'a> {
    /// Outlines with these unknowns of the feature itself.
    pub(in crate::track) fn outlines(&self, unknowns: &Unknowns) -> Outlines<'a> {
        Outlines { own: self.shape.outline(unknowns), neighbours: self.neighbours }
    }
}

/// Outlines of a feature and of those next to it.
#[derive(Debug, Clone, Copy)]
pub(in crate::track) struct Outlines<'a> {
    own: Outline<'a>,
    neighbours: [Option<Neighbour<'a>>; 2],
}

impl Outlines<'_> {
    /// Signed distance of `p_in_feature` from the edge of the road; none where nothing is known of it.
    pub(in crate::track) fn distance(&self, p_in_feature: Point2<f64>) -> Option<EdgeDistance> {
        let side = match self.own.look(p_in_feature) {
            Look::Edge(edge) => return Some(edge),
            Look::Beyond(side) => side,
            Look::Unknown => return None,
        };
        self.neighbours.get(side)?.as_ref()?.distance(p_in_feature, side)
    }

    /// Gives the derivatives of a distance by widths, offsets and the corner that concern it.
    pub(in crate::track) fn each_derivative(&self, edge: &EdgeDistance, give: impl FnMut(usize, f64)) {
        self.own.each_derivative(edge, give);
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_map::{ArmRole, FeatureKind};

    use super::super::CORNERS;
    use super::super::tests::arm;
    use super::*;

    const APART_M: f64 = 11.0;

    /// A road with a side road to the left, `along_m` metres along a straight route, which its map has turned by `turned_rad`.
    fn side_road(along_m: f64, turned_rad: f64) -> FeatureModel {
        let map_from_route = Isometry2::rotation(turned_rad);
        FeatureModel {
            id: 1,
            name: String::new(),
            kind: FeatureKind::SideRoad,
            route_m: 50.0 + along_m,
            arms: vec![
                arm(ArmRole::Approach, "approach", -40.0, 0.0),
                arm(ArmRole::Exit, "exit", 40.0, 0.0),
                arm(ArmRole::Side, "side_1", 0.0, 30.0),
            ],
            map_from_feature: map_from_route * Isometry2::translation(along_m, 0.0),
        }
    }

    /// Corners of 4 m.
    fn unknowns() -> Unknowns {
        let mut unknowns = Unknowns::zeros();
        (0..3).for_each(|arm| unknowns[CORNERS + arm] = libm::log(4.0));
        unknowns
    }

    /// The feature, and another one next to it that lies so far along the route and is turned by `turned_rad` about its node.
    fn with_other(along_m: f64, turned_rad: f64, look: impl Fn(&Surroundings<'_>)) {
        let (model, mut other) = (side_road(0.0, 0.4), side_road(along_m, 0.4));
        other.map_from_feature *= Isometry2::rotation(turned_rad);
        let [shape, other_shape] = [&model, &other].map(|model| JunctionShape::of(model, [5.0, 5.0]));
        let outline = other_shape.outline(&unknowns());
        let side = usize::from(along_m > 0.0);
        let believed = Isometry2::translation(14.0, 0.0);
        let mut neighbours = [None; 2];
        neighbours[side] = Neighbour::new(&model, (&other, side), outline, Some(&believed));
        look(&Surroundings { shape: &shape, neighbours });
    }

    #[test]
    fn beyond_a_features_own_road_the_next_one_lies() {
        for (along_m, side) in [(APART_M, 1), (-APART_M, 0)] {
            with_other(along_m, 0.0, |around| {
                let edge = |x: f64, y: f64| around.outlines(&unknowns()).distance(Point2::new(x, y));
                let near = |x: f64, y: f64, distance_m: f64, soft_m: f64| {
                    let edge = edge(x, y).unwrap();
                    assert!((edge.distance_m - distance_m).abs() < 1e-9, "{edge:?} for {distance_m}");
                    assert!((edge.soft_m - soft_m).abs() < 1e-9, "{edge:?} for {soft_m}");
                    edge.stretch / OWN_STRETCHES
                };
                // Its own side road, the ground opposite to the other's, and that one, whose place along the road is less sure.
                assert_eq!(near(0.0, 10.0, -3.0, 0.0), 0);
                assert_eq!(near(along_m, -4.0, 1.0, 0.0), 1 + side);
                assert_eq!(near(along_m + along_m.signum(), 8.0, -2.0, NODES_APART_SOFT_M), 1 + side);
                assert!(edge(along_m + 5.5 * along_m.signum(), 0.0).is_none(), "beyond the other's own road");
            });
        }
        let shape = JunctionShape::of(&side_road(0.0, 0.0), [5.0, 5.0]);
        let alone = Surroundings { shape: &shape, neighbours: [None; 2] };
        assert!(alone.outlines(&unknowns()).distance(Point2::new(APART_M, 0.0)).is_none());
    }

    #[test]
    fn derivatives_by_the_place_are_those_of_the_distance() {
        for (along_m, x, y) in [(APART_M, 12.5, 6.0), (APART_M, 8.0, 5.0), (-APART_M, -13.0, 7.0)] {
            with_other(along_m, 0.3, |around| {
                let outlines = around.outlines(&unknowns());
                let distance_m = |x: f64, y: f64| outlines.distance(Point2::new(x, y)).unwrap().distance_m;
                let (edge, step) = (outlines.distance(Point2::new(x, y)).unwrap(), 1e-6);
                assert!(edge.stretch >= OWN_STRETCHES, "({x}, {y}) is the other's");
                let by_x = (distance_m(x + step, y) - distance_m(x - step, y)) / (2.0 * step);
                let by_y = (distance_m(x, y + step) - distance_m(x, y - step)) / (2.0 * step);
                assert!((edge.by_place - Vector2::new(by_x, by_y)).norm() < 1e-5, "({x}, {y}): {edge:?}");
            });
        }
    }

    #[test]
    fn the_other_feature_says_how_far_ahead_this_one_would_be() {
        for (along_m, expected_m) in [(APART_M, 3.0), (-APART_M, 25.0)] {
            with_other(along_m, 0.0, |around| {
                let before_m = around.neighbours.iter().flatten().next().unwrap().feature_before_m;
                assert!(
                    before_m.is_some_and(|before_m| (before_m - expected_m).abs() < 1e-9),
                    "{before_m:?}"
                );
            });
        }
        // The vehicle is 4 m behind the other one, and 15 m behind this one.
        let (model, other) = (side_road(0.0, 0.0), side_road(APART_M, 0.0));
        let shape = JunctionShape::of(&other, [5.0, 5.0]);
        let passed = Isometry2::translation(-4.0, 0.0);
        let neighbour =
            Neighbour::new(&model, (&other, 1), shape.outline(&unknowns()), Some(&passed)).unwrap();
        assert!(neighbour.feature_before_m.is_some_and(|before_m| (before_m + 15.0).abs() < 1e-9));
    }
}
