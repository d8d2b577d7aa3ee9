//! Routes: a line on the map and its features.

use fingerpost_geometry::{GeometryError, Polyline};
use thiserror::Error;

use crate::{LatLon, OffRoad, RouteFeature, TangentPlane};

/// A point of a route's line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoutePoint {
    /// OSM's number of the node; `None` where the route starts, stops or ends between nodes.
    pub node: Option<i64>,
    /// Where it is.
    pub at: LatLon,
}

/// A route: its line and the features along it. The origin of the map frame is the line's first point.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// Name, empty for none.
    pub name: String,
    /// The line, in the order of driving.
    pub line: Vec<RoutePoint>,
    /// Features, ascending distance along the route.
    pub features: Vec<RouteFeature>,
}

impl Route {
    /// The plane that the map frame's metres are counted in: it touches the earth at the line's first point. `None` for
    /// a route without a line.
    pub fn plane(&self) -> Option<TangentPlane> {
        self.line.first().map(|point| TangentPlane::new(point.at))
    }

    /// The line in the map frame, metres.
    ///
    /// # Errors
    /// A line of fewer than two different points.
    pub fn polyline(&self) -> Result<Polyline, GeometryError> {
        let plane = self.plane().ok_or(GeometryError::TooFewPoints { found: 0 })?;
        Polyline::new(self.line.iter().map(|point| plane.map_from_wgs84(point.at)))
    }
}

/// Why there is no route.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum RouteError {
    /// Fewer than two stops.
    #[error("a route needs at least two stops, not {found}; give where it starts and where it ends")]
    TooFewStops {
        /// How many were given.
        found: usize,
    },
    /// A stop far from every road.
    #[error("stop {stop}: {off}")]
    StopOffRoad {
        /// Which stop, counted from 1.
        stop: usize,
        /// Where it is, and what the map covers.
        off: OffRoad,
    },
    /// No road leads from one stop to the next.
    #[error(
        "no road of the map leads from stop {from_stop} to stop {to_stop}; one-way streets, barriers or the map's edge are in \
         between: move a stop, or take a larger map"
    )]
    Unreachable {
        /// The stop that is left, counted from 1.
        from_stop: usize,
        /// The stop that is not reached.
        to_stop: usize,
    },
    /// All stops are one place.
    #[error("the route has no length: its stops are one place; give different ones")]
    NoLength,
    /// Too little of a track.
    #[error(
        "the track has {found} usable points; matching needs at least two that lie {spacing_m:.0} m apart"
    )]
    TrackTooShort {
        /// How many points were left after thinning.
        found: usize,
        /// Distance that points must lie apart, metres.
        spacing_m: f64,
    },
    /// A stretch of a track where there are no roads.
    #[error(
        "the track leaves the map at its point {point} (latitude {lat_deg}, longitude {lon_deg}): no road within \
         {reach_m:.0} m; cut the track there, or take a map that covers it"
    )]
    TrackOffRoad {
        /// Which point of the track, counted from 1.
        point: usize,
        /// Its latitude, degrees.
        lat_deg: f64,
        /// Its longitude, degrees.
        lon_deg: f64,
        /// How far roads were looked for, metres.
        reach_m: f64,
    },
    /// Roads near the track that do not connect.
    #[error(
        "no connected roads follow the track at its point {point} (latitude {lat_deg}, longitude {lon_deg}): it jumps, \
         goes against a one-way street or through a barrier, or the map lacks a road there; cut the track, or correct the map"
    )]
    TrackBroken {
        /// Which point of the track, counted from 1.
        point: usize,
        /// Its latitude, degrees.
        lat_deg: f64,
        /// Its longitude, degrees.
        lon_deg: f64,
    },
}
