//! `route.geojson`: a route with its features as a GeoJSON FeatureCollection (RFC 7946).
//!
//! One LineString is the route, in the order of driving; a Point is a route feature. Coordinates are longitude and
//! latitude, WGS 84. Of the angles, `turn_deg` is positive to the left; `bearing_deg` is a compass bearing, clockwise from
//! north, of leaving the node along the arm; `left` and `right` of an arm say what lies beside its road, seen from the node,
//! where the map says something. Files written by hand may leave these out, and `name` and `surface`, and may hold whatever else. Widths are 1.5 to 60 m, angles -360 to 360 degrees; a place that contradicts its `route_m`, an arm that does
//! not begin at its feature or leaves it in another direction than its bearing, and a turn that is not that of its arms are
//! refused. Bearings are converted as if north were the same all along the route, which over 10 km errs by
//! about a tenth of a degree.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::value::RawValue;
use serde_json::{Map, Value};
use thiserror::Error;

use crate::feature::MOST_ARMS;
use crate::label::cleaned;
use crate::route_check::check_places;
use crate::width::PLAUSIBLE_WIDTH_M;
use crate::{Arm, ArmRole, FeatureKind, LatLon, Roadside, Route, RouteFeature, RoutePoint};

/// Why text is no route.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum RouteFileError {
    /// Not JSON.
    #[error("the route is not valid JSON: {cause}; write it again with `fingerpost route`")]
    Json {
        /// What the JSON reader says, with line and column.
        cause: String,
    },
    /// Not a FeatureCollection with one LineString.
    #[error(
        "the route file is no route: {cause}; it must be a GeoJSON FeatureCollection with one LineString"
    )]
    Collection {
        /// What is missing or too much.
        cause: String,
    },
    /// A route that would not be read again.
    #[error(
        "the route cannot be written: {cause}; the map is damaged there, or the route too long: take another way"
    )]
    Unreadable {
        /// What the reader would say.
        cause: String,
    },
    /// A member of the collection that cannot be read.
    #[error(
        "feature {index} of the route file: {cause}; correct it, or write it again with `fingerpost route`"
    )]
    Member {
        /// Which member of `features`, counted from 1.
        index: usize,
        /// What is missing or wrong.
        cause: String,
    },
}

impl RouteFileError {
    /// What is wrong, without what to do about a file.
    fn in_short(&self) -> String {
        match self {
            Self::Json { cause } | Self::Collection { cause } | Self::Unreadable { cause } => cause.clone(),
            Self::Member { index, cause } => format!("feature {index}: {cause}"),
        }
    }
}

/// Features of a route: one every ten metres of the longest route.
const MOST_FEATURES: usize = 100_000;
/// Points of a route's line: one every metre of the longest route.
const MOST_POINTS: usize = 1_000_000;
/// Points of an arm: what OpenStreetMap allows a way.
const MOST_ARM_POINTS: usize = 2000;
/// Degrees that an angle may have: a full turn to either side, however it is counted.
const ANGLES_DEG: std::ops::RangeInclusive<f64> = -360.0..=360.0;
/// Digits after the point of degrees of place: a tenth of a millimetre.
const PLACE_DIGITS: i32 = 9;
/// Digits after the point of angles in degrees: a two-hundredth of a microradian.
const ANGLE_DIGITS: i32 = 7;
/// Digits after the point of metres: a tenth of a millimetre.
const METRE_DIGITS: i32 = 4;

/// GeoJSON's longitude and latitude; an elevation behind them is passed over.
#[derive(Clone, Serialize, Deserialize)]
#[serde(try_from = "Vec<f64>", into = "[f64; 2]")]
struct Position(LatLon);

impl TryFrom<Vec<f64>> for Position {
    type Error = String;

    fn try_from(numbers: Vec<f64>) -> Result<Self, String> {
        let [lon_deg, lat_deg, ..] = numbers[..] else {
            return Err("a position needs longitude and latitude".to_owned());
        };
        LatLon::new(lat_deg, lon_deg).map(Self).map_err(|error| error.to_string())
    }
}

impl From<Position> for [f64; 2] {
    fn from(Position(at): Position) -> Self {
        [at.lon_deg, at.lat_deg].map(|degrees| rounded(degrees, PLACE_DIGITS))
    }
}

#[derive(Serialize, Deserialize)]
struct LineProperties {
    #[serde(default)]
    name: String,
    /// OSM's numbers of the line's points, null between nodes.
    #[serde(default)]
    node_ids: Option<Vec<Option<i64>>>,
}

#[derive(Serialize, Deserialize)]
struct FeatureProperties {
    id: i64,
    #[serde(default)]
    name: String,
    kind: FeatureKind,
    turn_deg: f64,
    route_m: f64,
    arms: Vec<ArmRecord>,
}

#[derive(Serialize, Deserialize)]
struct ArmRecord {
    role: ArmRole,
    bearing_deg: f64,
    width_m: f64,
    #[serde(default)]
    surface: Option<String>,
    #[serde(default, skip_serializing_if = "Roadside::is_silent")]
    left: Roadside,
    #[serde(default, skip_serializing_if = "Roadside::is_silent")]
    right: Roadside,
    points: Vec<Position>,
}

/// The route as `route.geojson`, one GeoJSON feature a line, with a newline at the end.
///
/// Rounded to a tenth of a millimetre; reading it back and writing it again gives the same bytes.
///
/// # Errors
/// [`RouteFileError::Json`] for numbers that JSON cannot hold (infinite, not a number), and [`RouteFileError::Unreadable`] for
/// whatever [`read_route`] would refuse.
pub fn write_route(route: &Route) -> Result<String, RouteFileError> {
    let line = LineProperties {
        name: route.name.clone(),
        node_ids: Some(route.line.iter().map(|point| point.node).collect()),
    };
    let positions: Vec<Position> = route.line.iter().map(|point| Position(point.at)).collect();
    let mut members = vec![member("LineString", &positions, &line)?];
    for feature in &route.features {
        members.push(member("Point", &Position(feature.at), &FeatureProperties::of(feature))?);
    }
    let text = format!("{{\"type\":\"FeatureCollection\",\"features\":[\n{}\n]}}\n", members.join(",\n"));
    let unreadable = |cause: RouteFileError| RouteFileError::Unreadable { cause: cause.in_short() };
    read_route(&text).map(|_| text).map_err(unreadable)
}

/// Reads `route.geojson`.
///
/// # Errors
/// Text that is no JSON, no collection with one LineString, or a member with something missing or out of range; the
/// message says which and what.
pub fn read_route(text: &str) -> Result<Route, RouteFileError> {
    let json_error = |error: serde_json::Error| RouteFileError::Json { cause: error.to_string() };
    // Members become trees of values one by one: the tree of a whole file takes ten times its length.
    let root: BTreeMap<String, &RawValue> = match serde_json::from_str(text) {
        Err(error) if error.is_data() => BTreeMap::new(),
        read => read.map_err(json_error)?,
    };
    let collection = |cause: &str| RouteFileError::Collection { cause: cause.to_owned() };
    let kind: Option<String> = root.get("type").and_then(|kind| serde_json::from_str(kind.get()).ok());
    if kind.as_deref() != Some("FeatureCollection") {
        return Err(collection("its \"type\" is not \"FeatureCollection\""));
    }
    let members: Option<Vec<&RawValue>> =
        root.get("features").and_then(|members| serde_json::from_str(members.get()).ok());
    let members = members.ok_or_else(|| collection("it has no list \"features\""))?;
    if members.len() > MOST_FEATURES {
        return Err(collection(&format!("it has {} features, more than {MOST_FEATURES}", members.len())));
    }
    let mut lines = Vec::new();
    let mut features = Vec::new();
    for (index, member) in members.iter().enumerate() {
        let value: Value = serde_json::from_str(member.get()).map_err(json_error)?;
        let in_member = |cause| RouteFileError::Member { index: index + 1, cause };
        let geometry = value.get("geometry").unwrap_or(&Value::Null);
        let coordinates = geometry.get("coordinates").unwrap_or(&Value::Null);
        let properties = value.get("properties").unwrap_or(&Value::Null);
        match geometry.get("type").and_then(Value::as_str) {
            Some("LineString") => lines.push(read_line(coordinates, properties).map_err(in_member)?),
            Some("Point") => {
                features.push((index + 1, read_feature(coordinates, properties).map_err(in_member)?));
            }
            other => {
                let seen = other.unwrap_or("nothing");
                return Err(in_member(format!("its geometry is {seen}, not a LineString or Point")));
            }
        }
    }
    if lines.len() > 1 {
        return Err(collection("it has several LineStrings"));
    }
    let (name, line) = lines.pop().ok_or_else(|| collection("it has no LineString"))?;
    // In the order of driving, and where the file has them, for the messages.
    let mut places: Vec<usize> = (0..features.len()).collect();
    places.sort_by(|&a, &b| features[a].1.route_m.total_cmp(&features[b].1.route_m));
    let indices: Vec<usize> = places.iter().map(|&place| features[place].0).collect();
    features.sort_by(|(_, a), (_, b)| a.route_m.total_cmp(&b.route_m));
    let route = Route { name, line, features: features.into_iter().map(|(_, feature)| feature).collect() };
    check_places(&route).map_err(|(place, cause)| match place.and_then(|place| indices.get(place)) {
        Some(&index) => RouteFileError::Member { index, cause },
        None => RouteFileError::Collection { cause },
    })?;
    Ok(route)
}

fn member<C: Serialize, P: Serialize>(
    geometry: &str,
    coordinates: &C,
    properties: &P,
) -> Result<String, RouteFileError> {
    let json_error = |error: serde_json::Error| RouteFileError::Json { cause: error.to_string() };
    let coordinates = serde_json::to_string(coordinates).map_err(json_error)?;
    let properties = serde_json::to_string(properties).map_err(json_error)?;
    // JSON has no infinite numbers; the writer puts null, which no reader of this file takes.
    if coordinates.contains("null") || properties.contains("_deg\":null") || properties.contains("_m\":null")
    {
        return Err(RouteFileError::Json { cause: "a number of the route is not finite".to_owned() });
    }
    Ok(format!(
        "{{\"type\":\"Feature\",\"geometry\":{{\"type\":\"{geometry}\",\"coordinates\":{coordinates}}},\"properties\":{properties}}}"
    ))
}

fn read_line(coordinates: &Value, properties: &Value) -> Result<(String, Vec<RoutePoint>), String> {
    let places = Vec::<Position>::deserialize(coordinates)
        .map_err(|error| format!("coordinates of the LineString: {error}"))?;
    let properties = match properties {
        Value::Null => Value::Object(Map::new()),
        other => other.clone(),
    };
    let LineProperties { name, node_ids } =
        serde_json::from_value(properties).map_err(|error| error.to_string())?;
    let node_ids = node_ids.unwrap_or_else(|| vec![None; places.len()]);
    if node_ids.len() != places.len() {
        return Err(format!("{} node_ids for {} coordinates", node_ids.len(), places.len()));
    }
    if places.len() < 2 {
        return Err(format!("the LineString has {} coordinates, not two at least", places.len()));
    }
    if places.len() > MOST_POINTS {
        return Err(format!("the LineString has {} coordinates, more than {MOST_POINTS}", places.len()));
    }
    let points = places.into_iter().zip(node_ids).map(|(Position(at), node)| RoutePoint { node, at });
    Ok((cleaned(&name), points.collect()))
}

fn read_feature(coordinates: &Value, properties: &Value) -> Result<RouteFeature, String> {
    let place =
        Position::deserialize(coordinates).map_err(|error| format!("coordinates of the Point: {error}"))?;
    let record = FeatureProperties::deserialize(properties).map_err(|error| error.to_string())?;
    let count = |role: ArmRole| record.arms.iter().filter(|arm| arm.role == role).count();
    if count(ArmRole::Approach) != 1 || count(ArmRole::Exit) != 1 {
        return Err("arms must hold one approach and one exit".to_owned());
    }
    if record.arms.len() > MOST_ARMS {
        return Err(format!("it has {} arms, more than {MOST_ARMS}", record.arms.len()));
    }
    if !ANGLES_DEG.contains(&record.turn_deg) {
        return Err(format!("its turn_deg is {}, not -360 to 360", record.turn_deg));
    }
    Ok(RouteFeature {
        id: record.id,
        at: place.0,
        name: cleaned(&record.name),
        kind: record.kind,
        turn_rad: record.turn_deg.to_radians(),
        arms: record.arms.into_iter().map(ArmRecord::into_arm).collect::<Result<_, String>>()?,
        route_m: record.route_m,
    })
}

impl FeatureProperties {
    fn of(feature: &RouteFeature) -> Self {
        Self {
            id: feature.id,
            name: feature.name.clone(),
            kind: feature.kind,
            turn_deg: rounded(feature.turn_rad.to_degrees(), ANGLE_DIGITS),
            route_m: rounded(feature.route_m, METRE_DIGITS),
            arms: feature.arms.iter().map(ArmRecord::of).collect(),
        }
    }
}

impl ArmRecord {
    fn of(arm: &Arm) -> Self {
        Self {
            role: arm.role,
            bearing_deg: rounded(turned_about(arm.bearing_rad.to_degrees()), ANGLE_DIGITS),
            width_m: rounded(arm.width_m, METRE_DIGITS),
            surface: arm.surface.clone(),
            left: arm.beside[0],
            right: arm.beside[1],
            points: arm.points.iter().map(|&at| Position(at)).collect(),
        }
    }

    fn into_arm(self) -> Result<Arm, String> {
        if self.points.len() < 2 {
            return Err(format!("an arm has {} points, not two at least", self.points.len()));
        }
        if self.points.len() > MOST_ARM_POINTS {
            return Err(format!("an arm has {} points, more than {MOST_ARM_POINTS}", self.points.len()));
        }
        if !PLAUSIBLE_WIDTH_M.contains(&self.width_m) {
            let (least_m, most_m) = (PLAUSIBLE_WIDTH_M.start(), PLAUSIBLE_WIDTH_M.end());
            return Err(format!("an arm's width_m is {}, not {least_m} to {most_m} metres", self.width_m));
        }
        if !ANGLES_DEG.contains(&self.bearing_deg) {
            return Err(format!("an arm's bearing_deg is {}, not -360 to 360", self.bearing_deg));
        }
        Ok(Arm {
            role: self.role,
            bearing_rad: fingerpost_geometry::wrap_angle(turned_about(self.bearing_deg).to_radians()),
            points: self.points.into_iter().map(|Position(at)| at).collect(),
            width_m: self.width_m,
            surface: self.surface.as_deref().map(cleaned),
            beside: [self.left, self.right],
        })
    }
}

/// Degrees clockwise from north of a heading anticlockwise from east, and the other way round: it is its own inverse.
fn turned_about(angle_deg: f64) -> f64 {
    (90.0 - angle_deg).rem_euclid(360.0)
}

fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    (value * scale).round() / scale
}
