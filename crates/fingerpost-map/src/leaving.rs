//! Where a road leaves the line of another: what tells a bend from a road that goes straight on.

use fingerpost_geometry::Polyline;
use nalgebra::Vector2;

/// Within this distance of its node a bend must have left the road that would go straight on, metres: half of a view of
/// 20 m (paper 2, section 6), so that a vehicle half a view before the node sees both.
pub const LEAVES_WITHIN_M: f64 = 10.0;

/// How far from its first point a road, whose course is `course` (metres), stays on another that goes from there along
/// `straight_on` (any length but zero) and is `2 * half_width_m` metres wide; none where that is farther than
/// [`LEAVES_WITHIN_M`].
pub fn leaves_after_m(course: &Polyline, straight_on: Vector2<f64>, half_width_m: f64) -> Option<f64> {
    let forward = straight_on.try_normalize(f64::EPSILON)?;
    let node = *course.points().first()?;
    let beside_m = |along_m: f64| forward.perp(&(course.at(along_m).0 - node)).abs();
    let most_m = LEAVES_WITHIN_M.min(course.length_m());
    let steps = (most_m / STEP_M).floor() as usize;
    (1..=steps).map(|step| STEP_M * step as f64).find(|&along_m| beside_m(along_m) > half_width_m)
}

/// Step at which a course is looked at, metres: a fifth of the road's edge's own uncertainty on the ground.
const STEP_M: f64 = 0.1;

#[cfg(test)]
mod tests {
    use nalgebra::Point2;

    use super::*;

    /// A circle of this radius that begins along x and turns left.
    fn arc(radius_m: f64) -> Polyline {
        let at = |i: i32| {
            let turned = 0.05 * f64::from(i);
            Point2::new(radius_m * libm::sin(turned), radius_m * (1.0 - libm::cos(turned)))
        };
        Polyline::new((0..30).map(at)).unwrap()
    }

    #[test]
    fn a_bend_leaves_where_it_has_turned_off_the_road_and_a_straight_road_does_not() {
        // 3 m aside of a circle of 15 m: after 15 acos(1 - 3 / 15).
        let left = leaves_after_m(&arc(15.0), Vector2::x(), 3.0).unwrap();
        assert!((left - 9.65).abs() < 0.15, "{left}");
        assert_eq!(leaves_after_m(&arc(15.0), Vector2::x(), 4.0), None, "too wide a road");
        assert_eq!(leaves_after_m(&arc(80.0), Vector2::x(), 3.0), None, "too smooth a bend");
        let straight = Polyline::new([Point2::origin(), Point2::new(50.0, 0.0)]).unwrap();
        assert_eq!(leaves_after_m(&straight, Vector2::x(), 3.0), None);
        assert_eq!(leaves_after_m(&straight, Vector2::zeros(), 3.0), None, "no direction");
        assert!(leaves_after_m(&straight, Vector2::y(), 3.0).is_some_and(|m| (m - 3.0).abs() < 0.2));
    }
}
