//! The route of a drive that is set up, on its map.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use fingerpost_look::{RouteMap, RoutePlace};
use fingerpost_map::{FeatureKind, LatLon, Route, RouteFeature, write_route};

use super::SetUpArgs;
use crate::{inputs, start_check};

/// Where the route of a drive is saved where nothing else is said.
const SAVED_ROUTE: &str = "set_up_route.geojson";

/// A route as it is saved.
pub(super) struct RouteToSave {
    /// The map that it was shown on.
    pub(super) map: Option<PathBuf>,
    /// The file that it is saved in.
    pub(super) path: PathBuf,
    /// What that holds.
    pub(super) text: String,
    route: Route,
}

impl RouteToSave {
    /// The place so far along the route, which tells a run where on the map it begins.
    pub(super) fn place(&self, start_m: f64) -> Option<LatLon> {
        let start = self.route.polyline().ok()?.frame_at(start_m).translation.vector;
        Some(self.route.plane()?.wgs84_from_map(start.into()))
    }
}

/// A route as the page shows it, and as it is saved.
pub(super) struct DrivenRoute {
    pub(super) map: RouteMap,
    /// Where the drive begins before anybody has moved it, metres along the route.
    pub(super) start_m: f64,
    pub(super) to_save: RouteToSave,
}

impl DrivenRoute {
    /// Reads route and map; none where there is no route.
    pub(super) fn open(route_path: Option<&Path>, args: &SetUpArgs) -> Result<Option<Self>> {
        let Some(route_path) = route_path else { return Ok(None) };
        let route = inputs::route(route_path)?;
        let start_m = args.start_m.unwrap_or(0.0);
        start_check::check_on_route(&route.polyline()?, start_m)?;
        let path = args.save_route.clone().unwrap_or_else(|| SAVED_ROUTE.into());
        let map = route_map(&route, args)?;
        let text = write_route(&route).with_context(|| route_path.display().to_string())?;
        Ok(Some(Self { map, start_m, to_save: RouteToSave { map: args.map.clone(), path, text, route } }))
    }
}

/// A route with its features, and the roads of the map about it.
pub(in crate::look) fn route_map(route: &Route, args: &SetUpArgs) -> Result<RouteMap> {
    Ok(RouteMap::new(route.polyline()?, roads(args, route)?, places(route)))
}

/// The roads of the map in the route's plane.
fn roads(args: &SetUpArgs, route: &Route) -> Result<Vec<Vec<nalgebra::Point2<f64>>>> {
    let (Some(path), Some(plane)) = (&args.map, route.plane()) else { return Ok(Vec::new()) };
    let graph = inputs::road_graph(path, args.limit)?;
    let place = |node: &usize| plane.map_from_wgs84(graph.nodes()[*node].at);
    Ok(graph.ways().iter().map(|way| way.nodes.iter().map(place).collect()).collect())
}

/// The features of the route, by which a person finds the start.
fn places(route: &Route) -> Vec<RoutePlace> {
    let Some(plane) = route.plane() else { return Vec::new() };
    let place = |feature: &RouteFeature| {
        let kind = match feature.kind {
            FeatureKind::Junction => "junction",
            FeatureKind::SideRoad => "side road",
            FeatureKind::Bend => "bend",
        };
        let name = if feature.name.is_empty() { String::new() } else { format!(" {}", feature.name) };
        let label = format!("{kind}{name} at {:.0} m", feature.route_m);
        RoutePlace { p_in_map: plane.map_from_wgs84(feature.at), label }
    };
    route.features.iter().map(place).collect()
}
