//! Maps and routes.

use std::path::PathBuf;

use fingerpost::map::{
    self, FeatureOptions, LatLon, OsmData, RoadGraph, TangentPlane, match_track, plan, read_route,
    write_route,
};
use fingerpost_io::{read_bytes, read_text};
use fingerpost_record::kind_name;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::errors::{MapError, exception};

/// The roads of an OpenStreetMap extract.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct RoadMap(pub(crate) RoadGraph);

/// A route with the features that are looked for on it.
#[pyclass(frozen, module = "fingerpost")]
pub(crate) struct Route(pub(crate) map::Route);

fn roads_of(bytes: &[u8]) -> PyResult<RoadMap> {
    let osm = OsmData::from_bytes(bytes).map_err(exception!(MapError))?;
    RoadGraph::from_osm(&osm).map(RoadMap).map_err(exception!(MapError))
}

fn route_of(text: &str) -> PyResult<Route> {
    let route = read_route(text).map_err(exception!(MapError))?;
    route.polyline().map_err(exception!(MapError))?;
    Ok(Route(route))
}

pub(crate) fn place((lat_deg, lon_deg): (f64, f64)) -> PyResult<LatLon> {
    LatLon::new(lat_deg, lon_deg).map_err(exception!(MapError))
}

#[pymethods]
impl RoadMap {
    /// Reads .osm (XML) or .osm.pbf.
    #[staticmethod]
    fn from_file(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        py.detach(|| roads_of(&read_bytes(&path).map_err(exception!(MapError))?))
    }

    /// The shortest route through places, latitude and longitude in degrees.
    fn plan(&self, py: Python<'_>, places: Vec<(f64, f64)>) -> PyResult<Route> {
        let stops = places.into_iter().map(place).collect::<PyResult<Vec<_>>>()?;
        py.detach(|| plan(&self.0, &stops, &FeatureOptions::default()))
            .map(Route)
            .map_err(exception!(MapError))
    }

    /// The route that was driven along a track, latitude and longitude in degrees.
    fn match_track(&self, py: Python<'_>, track: Vec<(f64, f64)>) -> PyResult<Route> {
        let track = track.into_iter().map(place).collect::<PyResult<Vec<_>>>()?;
        py.detach(|| match_track(&self.0, &track, &FeatureOptions::default()))
            .map(Route)
            .map_err(exception!(MapError))
    }
}

#[pymethods]
impl Route {
    /// Reads a route file, as `fingerpost route` writes it.
    #[staticmethod]
    fn from_file(path: PathBuf) -> PyResult<Self> {
        route_of(&read_text(&path).map_err(exception!(MapError))?)
    }

    /// The route of a text as in route.geojson.
    #[staticmethod]
    fn from_geojson(text: &str) -> PyResult<Self> {
        route_of(text)
    }

    /// The text of its route.geojson.
    fn to_geojson(&self) -> PyResult<String> {
        write_route(&self.0).map_err(exception!(MapError))
    }

    /// Its length, metres.
    #[getter]
    fn length_m(&self) -> PyResult<f64> {
        self.0.polyline().map(|line| line.length_m()).map_err(exception!(MapError))
    }

    /// Its features in their order.
    #[getter]
    fn features<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        let features = self.0.features.iter().map(|feature| {
            let dict = PyDict::new(py);
            dict.set_item("id", feature.id)?;
            dict.set_item("name", &feature.name)?;
            dict.set_item("kind", kind_name(feature.kind))?;
            dict.set_item("route_m", feature.route_m)?;
            dict.set_item("turn_deg", feature.turn_rad.to_degrees())?;
            Ok(dict)
        });
        features.collect()
    }

    /// Its points, metres east and north of the first.
    #[getter]
    fn line_m(&self) -> Vec<(f64, f64)> {
        let Some(first) = self.0.line.first() else { return Vec::new() };
        let plane = TangentPlane::new(first.at);
        self.0.line.iter().map(|point| plane.map_from_wgs84(point.at)).map(|p| (p.x, p.y)).collect()
    }
}

/// The town of the demonstration and a kilometre through it. Map data (c) OpenStreetMap contributors, ODbL 1.0.
#[pyfunction]
pub(crate) fn demo_town() -> PyResult<(RoadMap, Route)> {
    Ok((roads_of(fingerpost_sim::TOWN_OSM)?, route_of(fingerpost_sim::TOWN_ROUTE)?))
}
