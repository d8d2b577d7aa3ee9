//! The local tangent plane of WGS 84: where latitude and longitude become metres.
//!
//! The map frame of CONVENTIONS: x east, y north, origin at a chosen place, heights left out (every place lies on the
//! ellipsoid). Exact formulas through earth-centred coordinates, not the spherical approximation, so that places agree
//! with survey software to the micrometre. Meant for places within about 100 km of the origin: farther out the plane
//! leaves the earth, and distances in it fall short of distances on the ground (by 1 in 80 000 at 50 km).

use nalgebra::{Matrix2, Point2, Vector2, Vector3};
use thiserror::Error;

/// Semi-major axis of WGS 84, metres (its defining parameter).
const SEMI_MAJOR_M: f64 = 6_378_137.0;
/// Flattening of WGS 84 (its defining parameter).
const FLATTENING: f64 = 1.0 / 298.257_223_563;
/// First eccentricity squared, from the flattening.
const ECCENTRICITY_SQUARED: f64 = FLATTENING * (2.0 - FLATTENING);
/// Newton steps of the inverse: each doubles the number of right digits, so six from 1 % are past what f64 holds.
const NEWTON_STEPS: usize = 6;

/// A place on the WGS 84 ellipsoid, degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LatLon {
    /// Geodetic latitude, degrees, positive north.
    pub lat_deg: f64,
    /// Longitude, degrees, positive east.
    pub lon_deg: f64,
}

/// A latitude or longitude that is none.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error(
    "latitude {lat_deg}, longitude {lon_deg} is no place on earth: latitudes go from -90 to 90, longitudes from -180 \
     to 180 degrees; check their order and the decimal point"
)]
pub struct LatLonError {
    /// The latitude given, degrees.
    pub lat_deg: f64,
    /// The longitude given, degrees.
    pub lon_deg: f64,
}

impl LatLon {
    /// A place from degrees.
    ///
    /// # Errors
    /// Not finite, or beyond 90 degrees of latitude or 180 of longitude.
    pub fn new(lat_deg: f64, lon_deg: f64) -> Result<Self, LatLonError> {
        if (-90.0..=90.0).contains(&lat_deg) && (-180.0..=180.0).contains(&lon_deg) {
            Ok(Self { lat_deg, lon_deg })
        } else {
            Err(LatLonError { lat_deg, lon_deg })
        }
    }

    /// The place with latitude and longitude exchanged, which may be none on earth.
    #[must_use]
    pub const fn exchanged(self) -> Self {
        Self { lat_deg: self.lon_deg, lon_deg: self.lat_deg }
    }

    /// Distance to another place, metres: straight, through the earth.
    pub fn chord_m(self, other: Self) -> f64 {
        (LocalFrame::at(self).position - LocalFrame::at(other).position).norm()
    }
}

/// The plane that touches the ellipsoid at its origin; x east, y north, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TangentPlane {
    origin: LatLon,
    earth_from_origin: Vector3<f64>,
    east: Vector3<f64>,
    north: Vector3<f64>,
}

impl TangentPlane {
    /// The plane that touches the ellipsoid at `origin`.
    pub fn new(origin: LatLon) -> Self {
        let frame = LocalFrame::at(origin);
        Self { origin, earth_from_origin: frame.position, east: frame.east, north: frame.north }
    }

    /// The place where the plane touches.
    pub fn origin(&self) -> LatLon {
        self.origin
    }

    /// The place's foot on the plane, metres east and north of the origin.
    ///
    /// ```
    /// use fingerpost_map::{LatLon, TangentPlane};
    /// let plane = TangentPlane::new(LatLon::new(49.0, 8.4).unwrap());
    /// let p_in_map = plane.map_from_wgs84(LatLon::new(49.001, 8.4).unwrap());
    /// assert!(p_in_map.x.abs() < 1e-9 && (p_in_map.y - 111.2).abs() < 0.1);
    /// ```
    pub fn map_from_wgs84(&self, place: LatLon) -> Point2<f64> {
        let offset = LocalFrame::at(place).position - self.earth_from_origin;
        Point2::new(self.east.dot(&offset), self.north.dot(&offset))
    }

    /// The place on the ellipsoid whose foot is `p_in_map` (metres); the inverse of [`Self::map_from_wgs84`].
    ///
    /// Newton's method on the forward formula. Beyond the reach that the module names the answer means nothing and may
    /// not be finite.
    pub fn wgs84_from_map(&self, p_in_map: Point2<f64>) -> LatLon {
        let mut place = self.origin;
        for _ in 0..NEWTON_STEPS {
            let frame = LocalFrame::at(place);
            let offset = frame.position - self.earth_from_origin;
            let missing = p_in_map.coords - Vector2::new(self.east.dot(&offset), self.north.dot(&offset));
            let by_lon = frame.east * frame.metres_per_lon_rad;
            let by_lat = frame.north * frame.metres_per_lat_rad;
            let jacobian = Matrix2::new(
                self.east.dot(&by_lon),
                self.east.dot(&by_lat),
                self.north.dot(&by_lon),
                self.north.dot(&by_lat),
            );
            let Some(inverse) = jacobian.try_inverse() else { break };
            let step_rad = inverse * missing;
            place.lon_deg += step_rad.x.to_degrees();
            place.lat_deg += step_rad.y.to_degrees();
        }
        if place.lon_deg.abs() > 180.0 {
            place.lon_deg = (place.lon_deg + 180.0).rem_euclid(360.0) - 180.0;
        }
        place
    }
}

/// Earth-centred position and directions of a place on the ellipsoid.
struct LocalFrame {
    position: Vector3<f64>,
    east: Vector3<f64>,
    north: Vector3<f64>,
    metres_per_lon_rad: f64,
    metres_per_lat_rad: f64,
}

impl LocalFrame {
    fn at(place: LatLon) -> Self {
        let (sin_lat, cos_lat) = libm::sincos(place.lat_deg.to_radians());
        let (sin_lon, cos_lon) = libm::sincos(place.lon_deg.to_radians());
        let squeeze = 1.0 - ECCENTRICITY_SQUARED * sin_lat * sin_lat;
        let prime_vertical_m = SEMI_MAJOR_M / squeeze.sqrt();
        Self {
            position: Vector3::new(
                prime_vertical_m * cos_lat * cos_lon,
                prime_vertical_m * cos_lat * sin_lon,
                prime_vertical_m * (1.0 - ECCENTRICITY_SQUARED) * sin_lat,
            ),
            east: Vector3::new(-sin_lon, cos_lon, 0.0),
            north: Vector3::new(-sin_lat * cos_lon, -sin_lat * sin_lon, cos_lat),
            metres_per_lon_rad: prime_vertical_m * cos_lat,
            metres_per_lat_rad: prime_vertical_m * (1.0 - ECCENTRICITY_SQUARED) / squeeze,
        }
    }
}
