//! A corner of the road: the line that leads to it, where it is, and the line that leads away.

use nalgebra::{Isometry2, Point2, Vector2};

use crate::driving_line::ASSUMED_KERB_M;

/// A line on the road, in the vehicle's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadLine {
    /// A place on it, metres.
    pub place: Point2<f64>,
    /// Its direction, radians, positive to the left.
    pub heading_rad: f64,
}

/// A corner of the road's middle, in the vehicle's frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Corner {
    /// The line to it; its place is the corner.
    pub approach: RoadLine,
    /// Direction of the road behind it, radians.
    pub exit_rad: f64,
    /// Standard deviation of where the road behind it lies, metres.
    pub sigma_m: f64,
    /// Standard deviation of its direction, radians.
    pub sigma_rad: f64,
    /// Probability that the road goes on that way, 0 to 1, when the corner was last in sight.
    pub probability: f64,
    /// Probability that another arm leads to the other side, 0 to 1, when the corner was last in sight.
    pub tee_probability: f64,
}

impl RoadLine {
    /// Its direction as a unit vector.
    pub(super) fn direction(&self) -> Vector2<f64> {
        Vector2::new(libm::cos(self.heading_rad), libm::sin(self.heading_rad))
    }

    /// How far left of the rear axle's middle it passes, metres; far away where it runs across the vehicle.
    pub(super) fn offset_m(&self) -> f64 {
        self.place.y - self.place.x * libm::tan(self.heading_rad)
    }

    /// The same after the vehicle moved.
    pub(super) fn moved(&self, current_from_previous: &Isometry2<f64>) -> Self {
        Self {
            place: current_from_previous * self.place,
            heading_rad: self.heading_rad + current_from_previous.rotation.angle(),
        }
    }
}

impl Corner {
    /// How far the road turns, radians, positive to the left.
    pub(super) fn turn_rad(&self) -> f64 {
        fingerpost_geometry::wrap_angle(self.exit_rad - self.approach.heading_rad)
    }

    /// The line behind it.
    pub(super) const fn exit(&self) -> RoadLine {
        RoadLine { place: self.approach.place, heading_rad: self.exit_rad }
    }

    /// The same after the vehicle moved.
    pub(super) fn moved(&self, current_from_previous: &Isometry2<f64>) -> Self {
        Self {
            approach: self.approach.moved(current_from_previous),
            exit_rad: self.exit_rad + current_from_previous.rotation.angle(),
            ..*self
        }
    }

    /// Whether the vehicle's rear axle is on the road behind it rather than on the one before.
    pub(super) fn is_passed(&self) -> bool {
        let bisector = self.approach.direction() + self.exit().direction();
        self.approach.place.coords.dot(&bisector) < 0.0
    }

    /// How far along the vehicle's road the corner's kerbs begin, metres ahead of the rear axle.
    pub(crate) fn begins_m(&self, width_m: f64) -> f64 {
        let ahead_m = self.approach.place.coords.dot(&self.approach.direction());
        ahead_m - tangent_m(self.turn_rad(), width_m)
    }
}

/// Radius of the road's middle round a corner whose kerb is an arc, metres.
pub(super) fn middle_radius_m(width_m: f64) -> f64 {
    ASSUMED_KERB_M + 0.5 * width_m
}

/// Length of the tangents of that arc, metres.
pub(super) fn tangent_m(turn_rad: f64, width_m: f64) -> f64 {
    middle_radius_m(width_m) * libm::tan(0.5 * turn_rad.abs())
}
