//! A lane's edges on the road.

/// An edge in the vehicle frame, left positive: y(x) = offset + tan(heading) x + curvature x² / 2, from the rear axle on.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EdgeOnRoad {
    /// Where it passes the rear axle, metres to the left.
    pub offset_m: f64,
    /// Its direction there against the vehicle's, radians, positive to the left.
    pub heading_rad: f64,
    /// Its curvature, 1/m, positive to the left.
    pub curvature_per_m: f64,
    /// For how many frames nothing new has been seen of it; 0 in a frame that shows it.
    pub kept_frames: u32,
}

impl EdgeOnRoad {
    /// How far to the left it is at a distance ahead of the rear axle, metres.
    pub fn left_m(&self, forward_m: f64) -> f64 {
        self.offset_m
            + libm::tan(self.heading_rad) * forward_m
            + 0.5 * self.curvature_per_m * forward_m * forward_m
    }
}

/// The edges of the lane in which the vehicle is.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct LaneOnRoad {
    /// Left edge.
    pub left: Option<EdgeOnRoad>,
    /// Right edge.
    pub right: Option<EdgeOnRoad>,
}
