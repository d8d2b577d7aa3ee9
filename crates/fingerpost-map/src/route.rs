//! Routes: a line on the map and its features.

use fingerpost_geometry::{GeometryError, Polyline};

use crate::{LatLon, RouteFeature, TangentPlane};

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
