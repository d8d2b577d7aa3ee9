//! The places of the route that a position may belong to: one for each pass.

use fingerpost_geometry::Polyline;
use nalgebra::Point2;

use super::super::component::{Component, GPS};
use super::super::noise::Noise;

/// Most passes of one place that are told apart.
const MOST_FEET: usize = 8;

/// A place of the route beside which a position lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Foot {
    /// Distance along the route, metres.
    pub(super) along_m: f64,
    /// Distance from the route, metres.
    pub(super) beside_m: f64,
    /// How likely this pass is by that distance, against the nearest, 0 to 1.
    pub(super) weight: f64,
}

/// Every pass of the route by a position, in their order.
#[derive(Debug, Clone)]
pub(super) struct Feet {
    feet: [Foot; MOST_FEET],
    len: usize,
    nearest_m: f64,
}

impl Feet {
    /// The passes within the gate: where the route comes nearest, and has been farther by what GPS errs between two of them.
    pub(super) fn of(route: &Polyline, p_in_map: Point2<f64>, noise: &Noise) -> Self {
        let none = Foot { along_m: 0.0, beside_m: f64::INFINITY, weight: 0.0 };
        let mut feet = Self { feet: [none; MOST_FEET], len: 0, nearest_m: f64::INFINITY };
        let sigma_m = libm::hypot(noise.gps_slow_m, noise.gps_white_m);
        let (mut nearest, mut farthest_m) = (none, f64::INFINITY);
        for foot in distances(route, p_in_map) {
            feet.nearest_m = feet.nearest_m.min(foot.beside_m);
            farthest_m = farthest_m.max(foot.beside_m);
            if foot.beside_m < nearest.beside_m && foot.beside_m < farthest_m - sigma_m {
                nearest = foot;
            }
            if foot.beside_m > nearest.beside_m + sigma_m {
                feet.add(nearest, noise);
                (nearest, farthest_m) = (none, foot.beside_m);
            }
        }
        feet.add(nearest, noise);
        let nearest_m = feet.nearest_m;
        for foot in &mut feet.feet {
            let more_m2 = foot.beside_m * foot.beside_m - nearest_m * nearest_m;
            foot.weight = libm::exp(-0.5 * more_m2 / (sigma_m * sigma_m));
        }
        feet
    }

    pub(super) fn as_slice(&self) -> &[Foot] {
        self.feet.get(..self.len).unwrap_or_default()
    }

    /// Distance from the route, metres.
    pub(super) const fn nearest_m(&self) -> f64 {
        self.nearest_m
    }

    /// Measured minus expected, metres, by the pass that `component` expects.
    pub(super) fn innovation_m(&self, component: &Component) -> Option<f64> {
        let (expected_m, _) = component.predicted(&GPS);
        self.innovations_m(expected_m).min_by(|a, b| a.abs().total_cmp(&b.abs()))
    }

    /// Distance from `route_m` to the nearest pass, along the route, metres.
    pub(super) fn apart_m(&self, route_m: f64) -> f64 {
        self.innovations_m(route_m).map(f64::abs).fold(f64::INFINITY, f64::min)
    }

    fn innovations_m(&self, expected_m: f64) -> impl Iterator<Item = f64> {
        self.as_slice().iter().map(move |foot| foot.along_m - expected_m)
    }

    /// Adds a pass within the gate; where there is no room for it, the farthest gives way.
    fn add(&mut self, foot: Foot, noise: &Noise) {
        if foot.beside_m > noise.gps_gate_m {
            return;
        }
        if let Some(place) = self.feet.get_mut(self.len) {
            *place = foot;
            self.len += 1;
        } else if let Some(farthest) = self.feet.iter_mut().max_by(|a, b| a.beside_m.total_cmp(&b.beside_m))
            && foot.beside_m < farthest.beside_m
        {
            *farthest = foot;
        }
    }
}

/// The distance from the route where it can be least or greatest: at each point, and at the foot within each piece.
fn distances(route: &Polyline, p_in_map: Point2<f64>) -> impl Iterator<Item = Foot> + '_ {
    let mut start_m = 0.0;
    route.points().windows(2).flat_map(move |ends| {
        let [start, end] = [ends[0], ends[1]];
        let (piece, to_point) = (end - start, p_in_map - start);
        let length_m = piece.norm();
        let share = (to_point.dot(&piece) / (length_m * length_m)).clamp(0.0, 1.0);
        let piece_start_m = start_m;
        start_m += length_m;
        [0.0, share, 1.0].map(|share| Foot {
            along_m: piece_start_m + share * length_m,
            beside_m: (p_in_map - (start + piece * share)).norm(),
            weight: 0.0,
        })
    })
}
