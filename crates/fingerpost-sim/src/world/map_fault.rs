//! One thing at a time that is wrong with a map.

use std::f64::consts::TAU;

use fingerpost_map::{OsmData, RoadAttributes, RoadGraph, Route};
use nalgebra::Vector2;
use serde::{Deserialize, Serialize};

use super::drawn_route;
use crate::noise::{Stream, mix};
use crate::{RandomRouteOptions, SimError};

/// A fault of the map that a drive's owner has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MapFault {
    /// One road in four is not on it.
    RoadMissing,
    /// One junction in three is 5 m from where it is.
    NodeMoved,
    /// Half of the roads are a third narrower than it says, the others half as wide again.
    WrongWidth,
}

/// Share of the roads that are missing, and of the nodes that are off.
const MISSING: f64 = 0.25;
const MOVED: f64 = 1.0 / 3.0;
/// How far these are off, metres.
const MOVED_M: f64 = 5.0;
/// The map's widths by those of the roads.
const WIDTHS: [f64; 2] = [1.5, 0.67];

impl MapFault {
    /// The map with this fault.
    fn on(self, osm: &OsmData, roads: &RoadGraph, seed: u64) -> OsmData {
        let chance = |id: i64| Stream::new(seed ^ 0x4d41_5046, id as u64).unit();
        let mut known = osm.clone();
        match self {
            Self::RoadMissing => known
                .ways
                .retain(|way| RoadAttributes::from_tags(&way.tags).is_none() || chance(way.id) >= MISSING),
            Self::NodeMoved => {
                for node in &mut known.nodes {
                    let arms = roads.node_index(node.id).map(|index| roads.nodes()[index].segments.len());
                    if arms.is_some_and(|arms| arms != 2) && chance(node.id) < MOVED {
                        let (sin, cos) = libm::sincos(TAU * chance(mix(node.id as u64) as i64));
                        let p_in_map = roads.plane().map_from_wgs84(node.at);
                        node.at = roads.plane().wgs84_from_map(p_in_map + MOVED_M * Vector2::new(cos, sin));
                    }
                }
            }
            Self::WrongWidth => {
                for way in &mut known.ways {
                    let Some(attributes) = RoadAttributes::from_tags(&way.tags) else { continue };
                    let factor = WIDTHS[usize::from(chance(way.id) < 0.5)];
                    way.tags.insert("width".to_owned(), format!("{:.2}", factor * attributes.width_m));
                }
            }
        }
        known
    }
}

/// The route that `seed` draws on a map with a fault, and the same as it is driven on the roads that are there.
///
/// # Errors
/// [`SimError::NoRandomRoute`] when no drawn pair fits, [`SimError::Map`] when the fault leaves no road.
pub fn misled_route(
    osm: &OsmData,
    fault: MapFault,
    seed: u64,
    options: &RandomRouteOptions,
) -> Result<(Route, Route), SimError> {
    let roads = RoadGraph::from_osm(osm)?;
    let known = RoadGraph::from_osm(&fault.on(osm, &roads, seed))?;
    drawn_route::drawn(&known, &roads, seed, options)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_fault_is_the_one_that_it_is_called() {
        let osm = OsmData::from_bytes(include_bytes!("../../assets/town.osm")).unwrap();
        let roads = RoadGraph::from_osm(&osm).unwrap();
        let known = |fault: MapFault| RoadGraph::from_osm(&fault.on(&osm, &roads, 3)).unwrap();
        let missing = known(MapFault::RoadMissing);
        assert!(missing.segments().len() < roads.segments().len());
        let moved = known(MapFault::NodeMoved);
        let off_m = moved.nodes().iter().filter_map(|node| {
            let there = &roads.nodes()[roads.node_index(node.id)?];
            let plane = roads.plane();
            Some((plane.map_from_wgs84(node.at) - plane.map_from_wgs84(there.at)).norm())
        });
        let (off, on): (Vec<f64>, Vec<f64>) = off_m.partition(|m| *m > 1e-3);
        assert!(!off.is_empty() && on.len() > off.len());
        assert!(off.iter().all(|m| (m - 5.0).abs() < 1e-3));
        let width = known(MapFault::WrongWidth);
        let widths = |graph: &RoadGraph| {
            (0..graph.segments().len()).map(|i| graph.attributes_of(i).width_m).collect::<Vec<_>>()
        };
        assert!(widths(&width).iter().zip(widths(&roads)).all(|(known, built)| (known - built).abs() > 0.5));
    }

    #[test]
    fn the_driven_route_is_on_the_roads_that_are_there() {
        let osm = OsmData::from_bytes(include_bytes!("../../assets/town.osm")).unwrap();
        let options = RandomRouteOptions::default();
        let (route, driven) = misled_route(&osm, MapFault::NodeMoved, 4, &options).unwrap();
        assert_eq!(route.line.len(), driven.line.len());
        let again = misled_route(&osm, MapFault::NodeMoved, 4, &options).unwrap();
        assert_eq!((route, driven), again);
    }
}
