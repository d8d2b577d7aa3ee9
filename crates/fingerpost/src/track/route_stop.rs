//! The features of a route, each with its model, its driving line and its masks.

use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::{Route, RouteFeature, TangentPlane};

use super::TrackConfig;
use super::belief::junction_shape::JunctionShape;
use crate::driving_line::{DrivingLine, DrivingLineConfig, driving_lines};
use crate::feature_masks::{FeatureMaskConfig, MaskCache, MaskCurve};
use crate::feature_model::FeatureModel;
use crate::ground_view::Viewpoint;
use crate::progress::RouteProgressConfig;
use crate::vehicle::VehicleConfig;

/// A feature of the route, ready to be looked for.
#[derive(Debug)]
pub struct RouteStop {
    /// Its model.
    pub model: FeatureModel,
    /// The driving line through it, to steer along; none without approach and exit.
    pub line: Option<DrivingLine>,
    /// The papers' curve through it, by which it is found and arrived at; none without approach and exit.
    pub mask_curve: Option<MaskCurve>,
    pub(super) masks: MaskCache,
    /// Outline of its road.
    pub(super) shape: JunctionShape,
    /// The road if the feature were not there, and its outline.
    pub(super) plain: FeatureModel,
    pub(super) plain_shape: JunctionShape,
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
    /// Where the camera looks from.
    pub viewpoint: Viewpoint,
    /// Angle that a row of its picture spans, radians.
    pub row_rad: f64,
}

/// How far from its node another feature's road is its own, metres: a half width of 4 m and corners of as much.
pub(in crate::track) const MOUTH_M: f64 = 8.0;
/// However near the next feature is, so much of the route is a feature's own, metres.
const LEAST_OWN_M: f64 = 5.0;

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
    let models: Result<Vec<_>, _> =
        route.features.iter().map(|feature| FeatureModel::new(feature, &map)).collect();
    let models = models?;
    let kerb_radius_m = setting.track.kerb_radius_m;
    let lines = driving_lines(setting.driving_line, setting.vehicle, kerb_radius_m, &models)?;
    let mut stops = Vec::new();
    for (i, (model, line)) in models.into_iter().zip(lines).enumerate() {
        let feature = &route.features[i];
        let own_m = |other: Option<&RouteFeature>| {
            let apart_m = other.map_or(f64::INFINITY, |other| (other.route_m - feature.route_m).abs());
            (apart_m - MOUTH_M).max(LEAST_OWN_M)
        };
        let before = i.checked_sub(1).and_then(|before| route.features.get(before));
        let reach_m = [own_m(before), own_m(route.features.get(i + 1))];
        let mask_curve = MaskCurve::new(setting.masks, setting.vehicle, &model)?;
        let masks = MaskCache::new(
            setting.masks,
            kerb_radius_m,
            setting.vehicle,
            setting.grid,
            &model,
            mask_curve.as_ref(),
        );
        let shape = JunctionShape::of(&model, reach_m);
        let plain = model.without_feature()?;
        let plain_shape = JunctionShape::of(&plain, reach_m);
        stops.push(RouteStop { model, line, mask_curve, masks, shape, plain, plain_shape });
    }
    Ok((stops, Some(line_in_map)))
}
