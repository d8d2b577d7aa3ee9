//! What is known of the errors before anything is measured.

use super::RouteProgressConfig;

/// Distance over which the scale error becomes another, metres: it is the road's height under the camera and the mount's pitch
/// on it, which a street keeps and the next may not. A guess; it bounds what many features in a row can teach of the scale.
const SCALE_LENGTH_M: f64 = 2000.0;
/// Time over which the slow error of GPS becomes another, seconds: that of reflections and the ionosphere's correction on a
/// moving receiver is given as one to a few minutes.
const GPS_TIME_S: f64 = 100.0;
/// White part of the error of GPS, share of its standard deviation: fixes of a moving receiver scatter by about a metre about a
/// track that is off by several.
const GPS_WHITE_SHARE: f64 = 0.2;
/// No uncertainty is ever zero, metres or a share.
const LEAST_SIGMA: f64 = 1e-3;

/// Standard deviations and how long errors last, from the configuration.
#[derive(Debug, Clone)]
pub(crate) struct Noise {
    pub(super) start_m: f64,
    pub(super) scale_sigma: f64,
    pub(super) gps_slow_m: f64,
    pub(super) gps_white_m: f64,
    pub(super) gps_gate_m: f64,
}

impl Noise {
    pub(super) fn new(config: &RouteProgressConfig) -> Self {
        let gps_m = config.gps_sigma_m.max(LEAST_SIGMA);
        Self {
            start_m: config.start_sigma_m.max(LEAST_SIGMA),
            scale_sigma: config.drift_share.max(LEAST_SIGMA),
            gps_slow_m: gps_m * (1.0 - GPS_WHITE_SHARE * GPS_WHITE_SHARE).sqrt(),
            gps_white_m: gps_m * GPS_WHITE_SHARE,
            gps_gate_m: config.gps_gate_m.max(LEAST_SIGMA),
        }
    }

    /// Share of the scale error that is left after this distance.
    pub(super) fn scale_kept(&self, forward_m: f64) -> f64 {
        libm::exp(-forward_m.abs() / SCALE_LENGTH_M)
    }

    /// Share of the slow error of GPS that is left after this time.
    pub(super) fn gps_kept(&self, dt_s: f64) -> f64 {
        libm::exp(-dt_s / GPS_TIME_S)
    }
}
