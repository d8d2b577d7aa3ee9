//! The town of the demonstration.

/// Mauren in Liechtenstein, OpenStreetMap XML. Map data © OpenStreetMap contributors, ODbL 1.0; `assets/ATTRIBUTION.md` says more.
pub const TOWN_OSM: &[u8] = include_bytes!("../assets/town.osm");
/// A kilometre over junctions, side roads and bends of it, as a route file.
pub const TOWN_ROUTE: &str = include_str!("../assets/town_route.geojson");
