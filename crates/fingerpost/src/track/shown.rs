//! Where the ground view shows the road's features while the camera is turned.
//!
//! The ground view is made for the configured mount. A camera that looks half a degree lower shows a junction 12 m ahead
//! almost a metre too far away. So what lies on the road is looked for where it is *shown*.

use nalgebra::{Isometry2, Matrix3, Point2, Vector2};

use crate::ground_view::{CameraTurn, Viewpoint};

/// Where the ground view shows the places of the road.
#[derive(Debug, Clone, Copy)]
pub(super) struct ShownRoad {
    shown_from_road: Matrix3<f64>,
}

impl ShownRoad {
    /// For a camera that is turned by `turn` against its mount.
    pub(super) fn new(turn: &CameraTurn, viewpoint: Viewpoint) -> Self {
        Self { shown_from_road: turn.shown_from_road(viewpoint) }
    }

    /// The projective map from places on the road to those at which the view shows them, metres.
    pub(super) const fn map(&self) -> &Matrix3<f64> {
        &self.shown_from_road
    }

    /// Where a feature with this pose on the road is shown.
    pub(super) fn shown_from_road(&self, pose: &Isometry2<f64>) -> Isometry2<f64> {
        moved(&self.shown_from_road, pose)
    }
}

/// A place beyond the horizon of the turned camera stays where it is.
fn place(map: &Matrix3<f64>, p: Point2<f64>) -> Point2<f64> {
    let mapped = map * p.to_homogeneous();
    if mapped.z > f64::EPSILON { Point2::from(mapped.xy() / mapped.z) } else { p }
}

fn moved(map: &Matrix3<f64>, pose: &Isometry2<f64>) -> Isometry2<f64> {
    let node = place(map, Point2::from(pose.translation.vector));
    let along = place(map, pose * Point2::new(1.0, 0.0)) - node;
    let heading_rad =
        if along.norm_squared() > 0.0 { libm::atan2(along.y, along.x) } else { pose.rotation.angle() };
    Isometry2::new(Vector2::new(node.x, node.y), heading_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWPOINT: Viewpoint = Viewpoint { foot: Point2::new(1.0, 0.0), height_m: 1.65 };

    #[test]
    fn a_nose_that_is_down_shows_the_road_too_far_away() {
        let turn = CameraTurn { pitch_rad: 0.0122, ..CameraTurn::default() };
        let road = ShownRoad::new(&turn, VIEWPOINT);
        let pose = Isometry2::new(Vector2::new(13.0, -2.0), 0.1);
        let shown = road.shown_from_road(&pose);
        // p (X^2 + h^2) / h to first order, with X counted from below the camera; the second order adds a tenth.
        assert!((shown.translation.x - 13.0 - 1.2).abs() < 0.03, "{shown}");
        // What lies ahead along the feature is shown along it.
        let ahead = shown.inverse() * place(&road.shown_from_road, pose * Point2::new(3.0, 0.0));
        assert!(ahead.x > 0.0 && ahead.y.abs() < 1e-9, "{ahead}");
    }

    #[test]
    fn a_camera_at_rest_changes_nothing() {
        let road = ShownRoad::new(&CameraTurn::default(), VIEWPOINT);
        let pose = Isometry2::new(Vector2::new(-2.0, 3.0), -2.0);
        assert!((road.shown_from_road(&pose).to_homogeneous() - pose.to_homogeneous()).norm() < 1e-12);
    }
}
