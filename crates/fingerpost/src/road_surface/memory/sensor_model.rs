//! What a frame says about the cells of the road map.

use super::MemoryConfig;

/// Units of log-odds in a cell: 1/256, so that sums of many small pieces of evidence lose nothing that matters.
const UNIT: f64 = 256.0;
/// Largest log-odds of a cell: 3.5 is a probability of 0.97. More could not be unlearned within a few frames.
const MAX_LOG_ODDS: f64 = 3.5;
pub(super) const MAX_UNITS: i32 = (MAX_LOG_ODDS * UNIT) as i32;
/// What a frame says about cells.
#[derive(Debug)]
pub(super) struct SensorModel {
    /// Log-odds of every 8-bit probability, in units.
    pub(super) log_odds: [i16; 256],
    /// Prior of log-odds from -`MAX_UNITS` on, every other unit; 256 would be 1.
    pub(super) prior: Vec<u8>,
    /// Least log-odds of a known cell, in units.
    pub(super) min_known: i32,
    pub(super) keep_seen: f64,
    half_trust_m: f64,
}

impl SensorModel {
    pub(super) fn new(config: &MemoryConfig) -> Self {
        let log_odds = |p: f64| libm::log(p / (1.0 - p));
        let limited = |p: usize| (p as f64 / 255.0).clamp(config.doubt, 1.0 - config.doubt);
        let prior = (-MAX_UNITS..=MAX_UNITS).step_by(2);
        Self {
            log_odds: std::array::from_fn(|p| (UNIT * log_odds(limited(p))).round() as i16),
            prior: prior
                .map(|units| (256.0 / (1.0 + libm::exp(f64::from(-units) / UNIT))).round() as u8)
                .collect(),
            min_known: (UNIT * log_odds(config.min_known)).round() as i32,
            keep_seen: config.keep_seen,
            half_trust_m: config.half_trust_m,
        }
    }

    /// Share of a frame's evidence that is taken at `distance_m` from the camera.
    pub(super) fn trust(&self, distance_m: f64) -> f64 {
        1.0 / (1.0 + (distance_m / self.half_trust_m).powi(2))
    }
}
