//! What a map covers, in latitudes and longitudes.

use std::fmt::{self, Display, Formatter};

use crate::LatLon;

/// A box of latitudes and longitudes. Where it lies across the antimeridian, its west is a greater number than its east, as in
/// GeoJSON (RFC 7946, 5.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapBounds {
    /// Least latitude, degrees.
    pub south_deg: f64,
    /// Longitude of the western edge, degrees.
    pub west_deg: f64,
    /// Greatest latitude, degrees.
    pub north_deg: f64,
    /// Longitude of the eastern edge, degrees.
    pub east_deg: f64,
}

impl MapBounds {
    /// The box of these places: of the two ways round the earth the shorter one. `None` for no places.
    pub fn of(places: impl Iterator<Item = LatLon> + Clone) -> Option<Self> {
        let [south_deg, north_deg] = extent(places.clone().map(|at| at.lat_deg))?;
        let [west_deg, east_deg] = extent(places.clone().map(|at| at.lon_deg))?;
        if east_deg - west_deg <= 180.0 {
            return Some(Self { south_deg, west_deg, north_deg, east_deg });
        }
        // Across the antimeridian: counted from 0 to 360 degrees.
        let [west_deg, east_deg] = extent(places.map(|at| at.lon_deg.rem_euclid(360.0)))?;
        let [west_deg, east_deg] = [west_deg, east_deg].map(within_half_turn_deg);
        Some(Self { south_deg, west_deg, north_deg, east_deg })
    }

    /// The middle of the box.
    pub fn middle(&self) -> LatLon {
        let lat_deg = (self.south_deg + self.north_deg) / 2.0;
        let lon_deg = if self.west_deg <= self.east_deg {
            (self.west_deg + self.east_deg) / 2.0
        } else {
            within_half_turn_deg((self.west_deg + self.east_deg + 360.0) / 2.0)
        };
        LatLon { lat_deg, lon_deg }
    }

    /// Whether a place lies in the box.
    pub fn contains(&self, at: LatLon) -> bool {
        let (west_deg, east_deg) = (self.west_deg, self.east_deg);
        let is_between = if west_deg <= east_deg {
            (west_deg..=east_deg).contains(&at.lon_deg)
        } else {
            at.lon_deg >= west_deg || at.lon_deg <= east_deg
        };
        is_between && (self.south_deg..=self.north_deg).contains(&at.lat_deg)
    }
}

impl Display for MapBounds {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { south_deg, west_deg, north_deg, east_deg } = self;
        write!(f, "latitudes {south_deg:.5} to {north_deg:.5}, longitudes {west_deg:.5} to {east_deg:.5}")
    }
}

fn extent(degrees: impl Iterator<Item = f64>) -> Option<[f64; 2]> {
    degrees.fold(None, |extent, deg| {
        Some(extent.map_or([deg, deg], |[least, most]: [f64; 2]| [least.min(deg), most.max(deg)]))
    })
}

/// A longitude of 0 to 360 degrees as one of -180 to 180.
fn within_half_turn_deg(lon_deg: f64) -> f64 {
    if lon_deg > 180.0 { lon_deg - 360.0 } else { lon_deg }
}
