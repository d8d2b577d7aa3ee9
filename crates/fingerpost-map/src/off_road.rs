//! Places that are given: on a road of the map, or off it, and then what may be wrong.

use std::fmt::{self, Display, Formatter};

use thiserror::Error;

use crate::{LatLon, MapBounds, RoadGraph, Snap};

/// A place farther than this from every road is not meant for the map, metres.
pub const PLACE_REACH_M: f64 = 100.0;

/// What is asked where places would be right with latitude and longitude exchanged.
pub const ARE_EXCHANGED: &str = "are latitude and longitude exchanged? The latitude comes first";

/// A place that is on no road of the map.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub struct OffRoad {
    /// The place.
    pub at: LatLon,
    /// Distance to the nearest road, metres; none for a place that is none on earth.
    pub nearest_m: Option<f64>,
    /// What the map's roads cover.
    pub bounds: MapBounds,
}

impl OffRoad {
    /// Whether the place lies within the map with latitude and longitude exchanged.
    pub fn is_exchanged(&self) -> bool {
        self.bounds.contains(self.at.exchanged())
    }
}

impl Display for OffRoad {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let LatLon { lat_deg, lon_deg } = self.at;
        write!(f, "latitude {lat_deg}, longitude {lon_deg} ")?;
        match self.nearest_m {
            Some(nearest_m) if nearest_m < 10_000.0 => {
                write!(f, "is {nearest_m:.0} m from the nearest road of the map")?
            }
            Some(nearest_m) => write!(f, "is {:.0} km from the nearest road of the map", nearest_m / 1000.0)?,
            None => write!(f, "is no place on earth")?,
        }
        write!(f, ", whose roads lie in {}; ", self.bounds)?;
        if self.is_exchanged() {
            f.write_str(ARE_EXCHANGED)
        } else {
            write!(f, "check the place, or take a map that covers it")
        }
    }
}

impl RoadGraph {
    /// The road within [`PLACE_REACH_M`] that is nearest to a place that somebody gave.
    ///
    /// # Errors
    /// [`OffRoad`].
    pub fn place_on_road(&self, at: LatLon) -> Result<Snap, OffRoad> {
        // Through the earth: a place on its other side has its foot in the middle of the map as well.
        let place = |snap: &Snap| self.plane().wgs84_from_map(snap.p_in_map);
        let nearest = self.nearest(self.plane().map_from_wgs84(at), f64::INFINITY);
        let nearest_m = nearest.as_ref().map(|snap| at.chord_m(place(snap)));
        let near = nearest.zip(nearest_m).filter(|(_, nearest_m)| *nearest_m <= PLACE_REACH_M);
        near.map(|(snap, _)| snap).ok_or(OffRoad { at, nearest_m, bounds: *self.bounds() })
    }
}
