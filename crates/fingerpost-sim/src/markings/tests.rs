//! Layouts by hand.

use nalgebra::{Point2, Vector2};

use super::*;
use crate::conditions::LinePattern;
use crate::street_paint::StreetPaint;

fn stroke(half_width_m: f64) -> Stroke {
    Stroke {
        start: Point2::origin(),
        direction: Vector2::new(1.0, 0.0),
        length_m: 50.0,
        half_width_m,
        along_m: 0.0,
        chain: 0,
        two_way: true,
        surface: Surface::Paved,
        paint: StreetPaint::USUAL,
    }
}

#[test]
fn a_lane_lies_between_the_inner_edges_of_its_lines() {
    let layout = Layout::of(&stroke(3.0), &Conditions::CLEAR, TrafficSide::Right);
    let [left, right] = layout.around(-1.5).map(|marking| *marking.unwrap());
    assert!((left.right_m + 0.07).abs() < 1e-6 && left.look.kind == MarkingKind::Broken);
    assert!((right.left_m + 2.68).abs() < 1e-6 && right.look.kind == MarkingKind::Continuous);
    let [left, _] = layout.around(2.9);
    assert!(left.is_none(), "nothing beyond the edge line");
    assert!(Layout::of(&stroke(2.0), &Conditions::CLEAR, TrafficSide::Right).lines().is_empty());
    assert!(Layout::of(&stroke(3.0), &Conditions::UNMARKED, TrafficSide::Right).lines().is_empty());
}

#[test]
fn against_the_road_left_and_right_change_places() {
    let layout = Layout::of(&stroke(3.0), &Conditions::CLEAR, TrafficSide::Right);
    assert_eq!(layout.mirrored().mirrored(), layout);
    let without = layout.without_centre();
    let [left, right] = without.around(0.3);
    assert!(left.unwrap().right_m > 2.0 && right.unwrap().left_m < -2.0);
}

#[test]
fn a_wide_road_has_lanes_and_the_vehicle_keeps_to_the_outermost() {
    let lanes = |lanes: LaneMarkings| Conditions { markings: Markings::Lanes, lanes, ..Conditions::CLEAR };
    let wide = lanes(LaneMarkings::WHITE);
    let layout = Layout::of(&stroke(7.3), &wide, TrafficSide::Right);
    let home_m = lane_middle_m(&stroke(7.3), &wide, TrafficSide::Right);
    assert!((home_m + 5.25).abs() < 1e-9, "two lanes of 3.5 m a direction");
    let [left, right] = layout.around(home_m).map(|marking| *marking.unwrap());
    assert!((left.right_m + 3.575).abs() < 1e-5 && (right.left_m + 6.925).abs() < 1e-5);
    assert!(left.look.kind == MarkingKind::Broken && right.look.kind == MarkingKind::Continuous);
    let one_way = Stroke { two_way: false, ..stroke(4.7) };
    assert!((lane_middle_m(&one_way, &wide, TrafficSide::Left) - 1.75).abs() < 1e-9);
    assert_eq!(Layout::of(&one_way, &wide, TrafficSide::Right).lines().len(), 3);
}

#[test]
fn the_inner_line_of_a_double_one_is_the_nearer() {
    let double = LineStyle::yellow(LinePattern::DoubleInnerBroken);
    let lanes = LaneMarkings { between: double, edge: double, ..LaneMarkings::WHITE };
    let conditions = Conditions { markings: Markings::Lanes, lanes, ..Conditions::CLEAR };
    for (traffic, home_m) in [(TrafficSide::Right, -1.7), (TrafficSide::Left, 1.7)] {
        let layout = Layout::of(&stroke(3.9), &conditions, traffic);
        let [left, right] = layout.around(home_m).map(|marking| *marking.unwrap());
        for inner_m in [left.right_m + 0.075, right.left_m - 0.075] {
            let near = |line: &&Line| (f64::from(line.middle_m) - inner_m).abs() < 1e-5;
            assert!(layout.lines().iter().find(near).unwrap().dash_m.is_some(), "{traffic:?}");
        }
        assert!((left.left_m - left.right_m - 0.42).abs() < 1e-5);
        assert_eq!(left.look, MarkingRecord { kind: MarkingKind::Double, colour: MarkingColour::Yellow });
    }
}
