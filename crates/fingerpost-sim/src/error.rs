//! What can keep a drive from being simulated.

use fingerpost_geometry::GeometryError;
use fingerpost_map::GraphError;
use thiserror::Error;

/// A simulation that cannot start; the message says what to change.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SimError {
    /// A number of the configuration is not finite or outside what makes sense.
    #[error(
        "{name} = {value} is out of range: expected {expected}; correct it in the simulation's configuration"
    )]
    OutOfRange {
        /// Name of the number.
        name: &'static str,
        /// The value found.
        value: f64,
        /// What would be accepted.
        expected: &'static str,
    },
    /// There are no conditions of that name.
    #[error("there are no conditions named \"{name}\"; choose one of {known}")]
    UnknownConditions {
        /// The name asked for.
        name: String,
        /// The names there are, comma-separated.
        known: String,
    },
    /// The route is too short to drive.
    #[error(
        "the route is {length_m:.1} m long, at least {needed_m:.0} m are needed to drive it; plan a longer one"
    )]
    RouteTooShort {
        /// Length of the route, metres.
        length_m: f64,
        /// Shortest route that can be driven, metres.
        needed_m: f64,
    },
    /// The route is too long to hold its surroundings in memory.
    #[error("the route is {length_m:.0} m long, at most {limit_m:.0} m can be simulated at once; split it")]
    RouteTooLong {
        /// Length of the route, metres.
        length_m: f64,
        /// Longest route that can be simulated, metres.
        limit_m: f64,
    },
    /// The route and the map do not belong together.
    #[error(
        "at {along_m:.0} m the route is {distance_m:.1} m away from every road of the map; \
         give the map from which the route was planned"
    )]
    RouteOffTheMap {
        /// Distance along the route, metres.
        along_m: f64,
        /// Distance to the nearest road, metres.
        distance_m: f64,
    },
    /// A map without a route of the kind asked for.
    #[error(
        "none of {attempts} pairs of places on the map has a route of the wanted length and number of features; \
         give a larger map"
    )]
    NoRandomRoute {
        /// Pairs that were tried.
        attempts: usize,
    },
    /// Pictures of a shape that no drawn camera shows a street with.
    #[error(
        "none of many drawn cameras with pictures of {width} x {height} pixels shows a street from near to far; give a \
         picture that is at most three times as wide as high"
    )]
    NoDrawnCamera {
        /// The picture's width, pixels.
        width: usize,
        /// Its height, pixels.
        height: usize,
    },
    /// The camera is known by four road points, which say nothing of what stands above the road.
    #[error(
        "the camera is known by four picture points only, which cannot show anything above the road; \
         give intrinsics and a mount"
    )]
    CameraWithoutLens,
    /// A made-up map that is none.
    #[error(transparent)]
    Map(#[from] GraphError),
    /// A geometry that cannot be right.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
}

/// `Ok` when `value` is finite and inside `[low, high]`.
pub(crate) fn check_range(
    name: &'static str,
    value: f64,
    low: f64,
    high: f64,
    expected: &'static str,
) -> Result<(), SimError> {
    if value.is_finite() && (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(SimError::OutOfRange { name, value, expected })
    }
}
