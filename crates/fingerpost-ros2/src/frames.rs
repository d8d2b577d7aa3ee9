//! Names of the frames of reference (REP 105); all have x forward or east, y left or north and z up (REP 103).

/// The tangent plane of WGS 84 at the route's first node; without a route, at the first fix.
pub(crate) const MAP: &str = "map";
/// Where the drive began; drifts, and never jumps.
pub(crate) const ODOM: &str = "odom";
/// The vehicle: on the road below the rear axle's middle.
pub(crate) const BASE_LINK: &str = "base_link";
