//! The kerbs at the mouths of a junction's arms.
//!
//! Where two roads meet their edges do not cross but are joined by an arc, within which a road is wider than itself,
//! often to one side only. Limits: one radius for all corners, and the map's widths.

use std::f64::consts::TAU;

use crate::feature_model::{ArmModel, FeatureModel};

/// Arms that differ by more than this run straight on along their outer side, radians (150 degrees).
const STRAIGHT_RAD: f64 = 2.618;
/// Sharper forks are taken as this sharp, radians (25 degrees): their kerbs never end in view.
const SHARPEST_RAD: f64 = 0.436;

/// Distances from the node at which the kerbs at an arm's mouth end, for its left and its right edge, metres: arcs of the given
/// radius into the neighbouring arms of `feature`.
pub(crate) fn kerb_ends_m(feature: &FeatureModel, arm: &ArmModel, radius_m: f64) -> [f64; 2] {
    let direction = arm.direction_rad();
    let others = || feature.arms.iter().filter(|other| other.label != arm.label);
    // The neighbour on a side is the arm at the smallest angle that way.
    [1.0, -1.0].map(|side| {
        others()
            .map(|other| ((side * (other.direction_rad() - direction)).rem_euclid(TAU), other.width_m))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(0.0, |(angle, width_m)| kerb_end_m(angle, arm.width_m, width_m, radius_m))
    })
}

/// Where the kerb between two arms ends on the first, metres from the node: their edges cross at
/// (w_b/2 + w_a/2 cos a) / sin a, and an arc of radius r that touches both ends r / tan(a/2) beyond.
fn kerb_end_m(angle_rad: f64, width_m: f64, other_width_m: f64, radius_m: f64) -> f64 {
    if angle_rad > STRAIGHT_RAD {
        return 0.0;
    }
    let angle_rad = angle_rad.max(SHARPEST_RAD);
    let crossing = 0.5 * (other_width_m + width_m * libm::cos(angle_rad)) / libm::sin(angle_rad);
    crossing.max(0.0) + radius_m / libm::tan(0.5 * angle_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kerb_ends_where_its_arc_touches_the_edge() {
        // Right angle: half the other road and one radius. At 60 degrees: (3 + 3 * 0.5) / 0.866 + 4 / tan 30 deg.
        assert!((kerb_end_m(TAU / 4.0, 6.0, 6.0, 4.0) - 7.0).abs() < 1e-9);
        assert!((kerb_end_m(TAU / 6.0, 6.0, 6.0, 4.0) - 12.124).abs() < 1e-3);
        assert!(kerb_end_m(3.0, 6.0, 6.0, 4.0).abs() < 1e-9, "straight on there is none");
    }
}
