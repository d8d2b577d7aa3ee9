//! Road maps and routes: OpenStreetMap, GPX and `route.geojson` in; a road graph, routes and route features out.
//!
//! The way of the data: [`OsmData`] (what the file holds) -> [`RoadGraph`] (drivable ways, metres) -> [`Route`] (by
//! [`plan`] from places or [`match_track`] from a GPX track), cut into [`RouteFeature`]s: junctions, side roads and
//! bends with the course of every arm, which is what the method looks for in the picture (paper 1, sections V and VII;
//! paper 2, section 5). Takes bytes and text, never paths; the same input gives the same bytes.
//!
//! What of a map was not understood is counted ([`MapNotice`]).
//!
//! Limits: no turn restrictions, none that hold at times, no ferries, heights left out, maps of up to about 100 km across.

mod access;
mod bounds;
mod course;
mod cut;
mod elements;
mod feature;
mod gps_log;
mod gpx;
mod graph;
mod label;
mod leaving;
mod match_track;
mod notice;
mod off_road;
mod osm;
mod osm_budget;
mod osm_pbf;
mod osm_xml;
mod passed_over;
mod path;
mod pbf_block;
mod pbf_fields;
mod plan;
mod road;
mod roads;
mod roadside;
mod route;
mod route_check;
mod route_file;
mod search;
mod tangent_plane;
mod text_encoding;
mod width;
mod xml_attributes;

pub use bounds::MapBounds;
pub use feature::{Arm, ArmRole, FeatureKind, FeatureOptions, RouteFeature};
pub use gps_log::{GpsClock, GpsLog, GpsLogError, parse_gps_log_within};
pub use gpx::{GpxError, GpxPoint, GpxTrack, parse_gpx, parse_gpx_within};
pub use graph::{Direction, GraphError, RoadGraph, RoadNode, RoadSegment, RoadWay, Snap};
pub use label::escaped;
pub use leaving::{LEAVES_WITHIN_M, leaves_after_m};
pub use match_track::match_track;
pub use notice::{MapNotice, MapNoticeKind};
pub use off_road::{ARE_EXCHANGED, OffRoad, PLACE_REACH_M};
pub use osm::{OsmBarrier, OsmData, OsmError, OsmNode, OsmWay};
pub use passed_over::{PassedOver, UnreadPlace};
pub use plan::plan;
pub use road::{RoadAttributes, RoadClass, Travel};
pub use roadside::{Kerb, Parking, Roadside};
pub use route::{Route, RouteError, RoutePoint};
pub use route_file::{RouteFileError, read_route, write_route};
pub use tangent_plane::{LatLon, LatLonError, TangentPlane};
pub use width::parse_width_m;
