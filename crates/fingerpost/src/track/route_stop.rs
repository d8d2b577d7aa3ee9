//! The features of a route, each with its model, its driving line and its masks.

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::{Route, TangentPlane};

use super::TrackConfig;
use super::alignment::ArmPieces;
use crate::driving_line::{DrivingLine, DrivingLineConfig};
use crate::feature_masks::{FeatureMaskConfig, MaskCache};
use crate::feature_model::FeatureModel;
use crate::route_progress::RouteProgressConfig;
use crate::vehicle::VehicleConfig;

/// A feature of the route, ready to be looked for.
#[derive(Debug)]
pub struct RouteStop {
    /// Its model.
    pub model: FeatureModel,
    /// The driving line through it; none without approach and exit.
    pub line: Option<DrivingLine>,
    pub(super) masks: MaskCache,
    pub(super) arms: Vec<ArmPieces>,
}

/// What the tracker needs to know besides the route.
#[derive(Debug, Clone, Copy)]
pub struct TrackerSetting<'a> {
    /// Search and tracking.
    pub track: &'a TrackConfig,
    /// Masks.
    pub masks: &'a FeatureMaskConfig,
    /// Driving lines.
    pub driving_line: &'a DrivingLineConfig,
    /// The vehicle.
    pub vehicle: &'a VehicleConfig,
    /// Progress along the route.
    pub progress: &'a RouteProgressConfig,
    /// Raster of the ground view.
    pub grid: &'a GroundGrid,
    /// Bottom of what is seen ahead, metres.
    pub nearest_seen_m: f64,
    /// Height of the camera, metres.
    pub camera_height_m: f64,
}

/// The features of `route` in its order, and the route's line in the map frame.
///
/// # Errors
/// [`GeometryError`] when the route or a feature's arm has no extent.
pub(super) fn route_stops(
    setting: TrackerSetting<'_>,
    route: Option<&Route>,
) -> Result<(Vec<RouteStop>, Option<Polyline>), GeometryError> {
    let Some((route, first)) = route.and_then(|route| Some((route, route.line.first()?))) else {
        return Ok((Vec::new(), None));
    };
    let map = TangentPlane::new(first.at);
    let line_in_map = Polyline::new(route.line.iter().map(|point| map.map_from_wgs84(point.at)))?;
    let mut stops = Vec::new();
    for feature in &route.features {
        let model = FeatureModel::new(feature, &map)?;
        let line = DrivingLine::new(setting.driving_line, setting.vehicle, &model)?;
        let masks = MaskCache::new(
            setting.masks,
            setting.track.alignment.kerb_radius_m,
            setting.vehicle,
            setting.grid,
            &model,
            line.as_ref(),
        );
        let arms = ArmPieces::of(&setting.track.alignment, &model);
        stops.push(RouteStop { model, line, masks, arms });
    }
    Ok((stops, Some(line_in_map)))
}
