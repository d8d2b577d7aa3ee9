//! Where a run has the vehicle on the map.

use anyhow::Result;
use fingerpost_look::RunMap;
use fingerpost_map::{LatLon, TangentPlane};

use super::LookArgs;
use super::set_up::route::route_map;
use crate::inputs;

/// The places of a run's fixes, with its route where that is known; none where no frame has a fix.
pub(super) fn run_map(args: &LookArgs, fixes: &[Option<LatLon>]) -> Result<Option<RunMap>> {
    let Some(first) = fixes.iter().flatten().next() else { return Ok(None) };
    let route_path = args.beside_drive(args.route.as_deref(), "route.geojson");
    let route = route_path.map(|path| inputs::route(&path)).transpose()?;
    let plane =
        route.as_ref().and_then(fingerpost_map::Route::plane).unwrap_or_else(|| TangentPlane::new(*first));
    let fixes = fixes.iter().map(|fix| fix.map(|at| plane.map_from_wgs84(at))).collect();
    let route = route.map(|route| route_map(&route, &args.set_up)).transpose()?;
    Ok(Some(RunMap { route, fixes }))
}
