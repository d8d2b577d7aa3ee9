//! Where the vehicle is on earth.

use std::f64::consts::FRAC_PI_2;

use fingerpost::fix::MapFix;
use fingerpost_locate::Status;
use foxglove::messages::location_fix::PositionCovarianceType;
use foxglove::messages::{KeyValuePair, LocationFix, Timestamp};

use super::transforms::VEHICLE;

/// Standard deviation of the height above the ellipsoid, which nothing estimates, metres: that of the earth's surface.
const HEIGHT_SIGMA_M: f64 = 9000.0;

/// Covariance of a fix, east, north and up, row by row, m².
pub fn position_covariance(fix: &MapFix) -> [f64; 9] {
    let variance = fix.sigma_m * fix.sigma_m;
    [variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, HEIGHT_SIGMA_M * HEIGHT_SIGMA_M]
}

/// The fix as a message: heading clockwise from north, the status and the protection level beside it.
pub(crate) fn location_fix(timestamp: Timestamp, fix: &MapFix) -> LocationFix {
    let status = match fix.status {
        Status::Converged => "converged",
        Status::Ambiguous => "ambiguous",
        Status::Coasting => "coasting",
        Status::Lost => "lost",
    };
    let pair = |key: &str, value: String| KeyValuePair { key: key.to_owned(), value };
    let mut metadata = vec![pair("status", status.to_owned())];
    metadata.extend(fix.bound_m.map(|bound_m| pair("bound_m", format!("{bound_m:.2}"))));
    LocationFix {
        timestamp: Some(timestamp),
        frame_id: VEHICLE.to_owned(),
        latitude: fix.at.lat_deg,
        longitude: fix.at.lon_deg,
        altitude: 0.0,
        position_covariance: position_covariance(fix).to_vec(),
        position_covariance_type: PositionCovarianceType::Approximated as i32,
        heading: Some(FRAC_PI_2 - fix.heading_rad),
        velocity: None,
        color: None,
        metadata,
    }
}
