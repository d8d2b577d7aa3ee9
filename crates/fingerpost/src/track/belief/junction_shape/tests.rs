use fingerpost_geometry::Polyline;
use fingerpost_map::FeatureKind;
use nalgebra::Isometry2;

use super::*;

type Place = (f64, f64);

/// An arm 6 m wide to a place of the feature frame.
pub(super) fn arm(role: ArmRole, label: &str, x: f64, y: f64) -> ArmModel {
    ArmModel {
        role,
        label: label.into(),
        course: Polyline::new([Point2::origin(), Point2::new(x, y)]).unwrap(),
        width_m: 6.0,
        mouth_m: 3.0,
        leaves_after_m: None,
    }
}

/// A T-junction that is left to the right: approach from behind, exit to the right, the other arm to the left.
pub(in crate::track::belief) fn t_junction() -> JunctionShape {
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
    let distance_m = |x: f64, y: f64| shape.outline(&wide).distance(Point2::new(x, y)).unwrap().distance_m;
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

#[test]
fn an_end_is_left_out_only_where_it_is_no_nearer() {
    let shape = t_junction();
    let mut unknowns = Unknowns::zeros();
    (unknowns[WIDTHS], unknowns[WIDTHS + 1]) = (0.5, -0.3);
    let outline = shape.outline(&unknowns);
    let mut left_out = 0;
    for (x, y) in (-20..20).flat_map(|x| (-20..20).map(move |y| (f64::from(x) * 0.7, f64::from(y) * 0.7))) {
        for (arm, strip) in shape.arms.iter().enumerate() {
            let beside = strip.beside(Point2::new(x, y));
            if beside.along_m >= 0.0 {
                continue;
            }
            // The same of first order, by differences: how far beyond the ellipse, by how steeply that grows.
            let beyond_m = |left_m: f64, along_m: f64| {
                libm::hypot(left_m, outline.widened[arm] * along_m) - outline.half_m[arm]
            };
            let (left_m, along_m, step) = (beside.left_m, beside.along_m, 1e-5);
            let by_left = beyond_m(left_m + step, along_m) - beyond_m(left_m - step, along_m);
            let by_along = beyond_m(left_m, along_m + step) - beyond_m(left_m, along_m - step);
            let expected_m = beyond_m(left_m, along_m) / (libm::hypot(by_left, by_along) / (2.0 * step));
            let whole_m = outline.end(arm, &beside).0;
            assert!((whole_m - expected_m).abs() < 1e-3, "{x} {y} {arm}: {whole_m} for {expected_m}");
            for least_m in [-1.0, 0.0, 0.5, 3.0] {
                let is_left_out = outline.end_is_no_nearer(arm, &beside, least_m);
                assert!(!is_left_out || whole_m >= least_m - 1e-9, "{x} {y} {arm}: {whole_m} of {least_m}");
                left_out += usize::from(is_left_out);
            }
        }
    }
    assert!(left_out > 1000, "{left_out}");
}
