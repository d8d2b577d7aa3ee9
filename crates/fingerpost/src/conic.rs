//! A rational quadratic Bezier curve from one road into another: the papers' curve, an arc of a circle, and all that is between.

use fingerpost_geometry::{GeometryError, Polyline};
use nalgebra::{Point2, Vector2};

/// Pieces into which the curve is cut; at 25 m of curve a piece is shorter than a pixel of steering.
const CURVE_PIECES: usize = 64;
/// Tangents under this angle, radians (6 degrees), cross somewhere along the road.
const STRAIGHT_RAD: f64 = 0.1;
/// Weights that are tried between those of the Bezier curve and of the arc.
const WEIGHTS: usize = 16;

/// The curve of three control points, whose middle one has a weight of its own.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conic {
    pub(crate) control: [Point2<f64>; 3],
    weight: f64,
}

impl Conic {
    /// The plain quadratic Bezier curve.
    const fn bezier(control: [Point2<f64>; 3]) -> Self {
        Self { control, weight: 1.0 }
    }

    /// The papers' curve with its ends so far before the end of the inbound and behind the start of the outbound line, metres.
    pub(crate) fn between(inbound: &Polyline, outbound: &Polyline, setbacks_m: [f64; 2]) -> Self {
        let [start, end] = ends(inbound, outbound, setbacks_m);
        // Else between the ends of the offset lines, which lie beside the node.
        let corner = crossing(start, end).unwrap_or_else(|| {
            let (before, after) = (inbound.at(inbound.length_m()).0, outbound.at(0.0).0);
            Point2::from(0.5 * (before.coords + after.coords))
        });
        Self::bezier([start.0, corner, end.0])
    }

    /// The curve in [`CURVE_PIECES`].
    ///
    /// # Errors
    /// [`GeometryError`] when it has no extent.
    pub(crate) fn sampled(&self) -> Result<Polyline, GeometryError> {
        Polyline::new((0..=CURVE_PIECES).map(|i| self.at(i as f64 / CURVE_PIECES as f64)))
    }

    /// The place at a parameter from 0 to 1.
    pub(crate) fn at(&self, t: f64) -> Point2<f64> {
        let ([place, ..], [weight, ..]) = self.homogeneous(t);
        Point2::from(place / weight)
    }

    /// Signed curvature there, 1/m, positive to the left; zero where the curve stands still.
    pub(crate) fn curvature_per_m(&self, t: f64) -> f64 {
        let ([place, first, second], [weight, by_first, by_second]) = self.homogeneous(t);
        let here = place / weight;
        let speed = (first - here * by_first) / weight;
        let change = (second - here * by_second - speed * (2.0 * by_first)) / weight;
        let cubed = speed.norm().powi(3);
        if cubed > 0.0 { speed.perp(&change) / cubed } else { 0.0 }
    }

    /// Radius at the tightest place, metres; infinite on a straight curve.
    pub(crate) fn tightest_radius_m(&self) -> f64 {
        let curvature = |i: usize| self.curvature_per_m(i as f64 / CURVE_PIECES as f64).abs();
        let tightest_per_m = (0..=CURVE_PIECES).map(curvature).fold(0.0, f64::max);
        if tightest_per_m > 0.0 { 1.0 / tightest_per_m } else { f64::INFINITY }
    }

    /// Takes weight from the corner until the curve is nowhere tighter than this, or as round as it can be.
    pub(crate) fn round_up_to(&mut self, radius_m: f64) {
        let [start, corner, end] = self.control;
        let turn_rad = (corner - start).angle(&(end - corner));
        let arc = libm::cos(0.5 * turn_rad);
        let mut roundest = (self.tightest_radius_m(), *self);
        for i in 1..=WEIGHTS {
            if roundest.0 >= radius_m {
                break;
            }
            let share = i as f64 / WEIGHTS as f64;
            let rounder = Self { weight: 1.0 + share * (arc - 1.0), ..*self };
            let rounder_m = rounder.tightest_radius_m();
            if rounder_m > roundest.0 {
                roundest = (rounder_m, rounder);
            }
        }
        *self = roundest.1;
    }

    /// Weighted place and weight with their first and second derivatives by the parameter.
    fn homogeneous(&self, t: f64) -> ([Vector2<f64>; 3], [f64; 3]) {
        let [a, b, c] = self.control.map(|p| p.coords);
        let (w, s) = (self.weight, 1.0 - t);
        let of = |[a, b, c]: [f64; 3]| {
            [
                s * s * a + 2.0 * s * t * b + t * t * c,
                2.0 * (s * (b - a) + t * (c - b)),
                2.0 * (a - 2.0 * b + c),
            ]
        };
        let (x, y) = (of([a.x, w * b.x, c.x]), of([a.y, w * b.y, c.y]));
        ([0, 1, 2].map(|i| Vector2::new(x[i], y[i])), of([1.0, w, 1.0]))
    }
}

/// Place and direction of a line's end.
pub(crate) type End = (Point2<f64>, Vector2<f64>);

/// The ends so far before the end of the inbound and behind the start of the outbound line, metres.
pub(crate) fn ends(inbound: &Polyline, outbound: &Polyline, [before_m, behind_m]: [f64; 2]) -> [End; 2] {
    [inbound.at(inbound.length_m() - before_m), outbound.at(behind_m)]
}

/// Where the tangents meet, if they do so ahead of the start and behind the end; the curve then leaves and enters
/// the roads along their own direction.
pub(crate) fn crossing((start, inward): End, (end, outward): End) -> Option<Point2<f64>> {
    let sine = inward.perp(&outward);
    // Under this angle the crossing runs away along the road.
    if sine.abs() < STRAIGHT_RAD {
        return None;
    }
    let gap = end - start;
    let (along, back) = (gap.perp(&outward) / sine, gap.perp(&inward) / sine);
    (along > 0.0 && back < 0.0).then(|| start + inward * along)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A turn to the right by `turn_rad` with legs of `leg_m`.
    fn turn(turn_rad: f64, leg_m: f64) -> Conic {
        let end = Point2::new(leg_m * (1.0 + libm::cos(turn_rad)), -leg_m * libm::sin(turn_rad));
        Conic::bezier([Point2::origin(), Point2::new(leg_m, 0.0), end])
    }

    #[test]
    fn a_bezier_curve_has_the_papers_radius() {
        for turn_rad in [0.6, 1.2, std::f64::consts::FRAC_PI_2, 2.2_f64] {
            let half = 0.5 * turn_rad;
            let expected_m = 8.0 * libm::cos(half).powi(2) / libm::sin(half);
            let curve = turn(turn_rad, 8.0);
            assert!((curve.tightest_radius_m() - expected_m).abs() < 1e-9, "{turn_rad}");
            assert!((curve.curvature_per_m(0.5) + 1.0 / expected_m).abs() < 1e-9, "to the right");
        }
    }

    #[test]
    fn the_roundest_curve_is_the_arc_of_a_circle() {
        for turn_rad in [0.6, std::f64::consts::FRAC_PI_2, 2.4_f64] {
            let mut curve = turn(turn_rad, 8.0);
            curve.round_up_to(f64::INFINITY);
            let radius_m = 8.0 / libm::tan(0.5 * turn_rad);
            let centre = Point2::new(0.0, -radius_m);
            for i in 0..=10 {
                let from_centre_m = (curve.at(0.1 * f64::from(i)) - centre).norm();
                assert!((from_centre_m - radius_m).abs() < 1e-9, "{turn_rad}: {from_centre_m} of {radius_m}");
            }
        }
    }

    #[test]
    fn a_curve_is_only_as_round_as_it_must_be() {
        let (plain, mut curve) = (turn(1.5, 10.0), turn(1.5, 10.0));
        curve.round_up_to(plain.tightest_radius_m());
        assert_eq!(curve, plain);
        curve.round_up_to(9.0);
        let arc_m = 10.0 / libm::tan(0.75_f64);
        assert!(curve.tightest_radius_m() >= 9.0 && curve.tightest_radius_m() < arc_m - 0.1);
    }
}
