//! The effective configuration of a run: one table a stage.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::centreline::CentrelineConfig;
use crate::driving_line::DrivingLineConfig;
use crate::feature_masks::FeatureMaskConfig;
use crate::ground_view::GroundViewConfig;
use crate::lanes::LanesConfig;
use crate::matching::MatchConfig;
use crate::motion::MotionConfig;
use crate::mount::MountConfig;
use crate::road_surface::RoadSurfaceConfig;
use crate::route_progress::RouteProgressConfig;
use crate::track::TrackConfig;
use crate::vehicle::VehicleConfig;
use crate::vehicle_signals::CanConfig;

/// All settings; every key has a default, so that an empty file is a valid one.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Config {
    /// The vehicle.
    pub vehicle: VehicleConfig,
    /// Signals of the vehicle's bus.
    pub can: CanConfig,
    /// The part of the road seen from above.
    pub ground_view: GroundViewConfig,
    /// Road surface detection.
    pub road_surface: RoadSurfaceConfig,
    /// The road's middle without markings.
    pub centreline: CentrelineConfig,
    /// Ego-motion.
    pub motion: MotionConfig,
    /// Estimate of the camera's mount while driving.
    pub mount: MountConfig,
    /// Masks of the route features.
    pub feature_mask: FeatureMaskConfig,
    /// Driving line through a feature.
    pub driving_line: DrivingLineConfig,
    /// Match of masks and road surface.
    #[serde(rename = "match")]
    pub matching: MatchConfig,
    /// Search and tracking.
    pub track: TrackConfig,
    /// Progress along the route.
    pub route_progress: RouteProgressConfig,
    /// Lanes.
    pub lanes: LanesConfig,
}

/// A setting that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{key} = {} cannot be used: give {expected}", short(*.value))]
pub struct ConfigError {
    /// Key, with its table.
    pub key: &'static str,
    /// Value found.
    pub value: f64,
    /// What would be accepted.
    pub expected: &'static str,
}

/// A number in a few digits, with an exponent where it is very large or small.
fn short(value: f64) -> String {
    if value == 0.0 || (1e-4..1e7).contains(&value.abs()) { value.to_string() } else { format!("{value:e}") }
}

impl Config {
    /// Checks every number against its range; the stages check what only they know.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        let checks: &[(&'static str, f64, f64, f64, &'static str)] = &[
            ("vehicle.width_m", self.vehicle.width_m, 0.3, 6.0, "0.3 to 6 metres"),
            ("vehicle.margin_m", self.vehicle.margin_m, 0.0, 2.0, "0 to 2 metres"),
            ("vehicle.turning_radius_m", self.vehicle.turning_radius_m, 0.5, 50.0, "0.5 to 50 metres"),
            (
                "road_surface.sample_length_m",
                self.road_surface.sample_length_m,
                0.5,
                20.0,
                "0.5 to 20 metres",
            ),
            ("road_surface.sample_width_m", self.road_surface.sample_width_m, 0.2, 10.0, "0.2 to 10 metres"),
            (
                "road_surface.backprojection.hue_bins",
                f64::from(self.road_surface.backprojection.hue_bins),
                2.0,
                180.0,
                "2 to 180 bins",
            ),
            (
                "road_surface.backprojection.saturation_bins",
                f64::from(self.road_surface.backprojection.saturation_bins),
                2.0,
                256.0,
                "2 to 256 bins",
            ),
            (
                "road_surface.backprojection.prior",
                self.road_surface.backprojection.prior,
                0.01,
                1.0,
                "a share, 0.01 to 1",
            ),
            (
                "road_surface.backprojection.smoothing_bins",
                self.road_surface.backprojection.smoothing_bins,
                0.0,
                60.0,
                "0 (none) to 60 bins",
            ),
            (
                "road_surface.backprojection.disc_radius_px",
                f64::from(self.road_surface.backprojection.disc_radius_px),
                0.0,
                32.0,
                "0 (none) to 32 pixels",
            ),
            (
                "road_surface.backprojection.frames",
                self.road_surface.backprojection.frames as f64,
                1.0,
                1000.0,
                "1 to 1000 frames",
            ),
            (
                "road_surface.backprojection.min_sample_probability",
                self.road_surface.backprojection.min_sample_probability,
                0.0,
                1.0,
                "a probability, 0 to 1",
            ),
            (
                "road_surface.bank.surfaces",
                self.road_surface.bank.surfaces as f64,
                1.0,
                64.0,
                "1 to 64 surfaces",
            ),
            (
                "road_surface.bank.min_likeness",
                self.road_surface.bank.min_likeness,
                0.0,
                1.0,
                "a likeness, 0 to 1",
            ),
            (
                "road_surface.bank.patience_frames",
                self.road_surface.bank.patience_frames as f64,
                1.0,
                1000.0,
                "1 to 1000 frames",
            ),
            (
                "road_surface.bank.turning_per_m",
                self.road_surface.bank.turning_per_m,
                0.0,
                1e3,
                "0 to 1000 per metre",
            ),
            (
                "road_surface.bank.frames",
                self.road_surface.bank.frames as f64,
                1.0,
                1000.0,
                "1 to 1000 frames",
            ),
            ("road_surface.bank.prior", self.road_surface.bank.prior, 0.01, 1.0, "a share, 0.01 to 1"),
            (
                "road_surface.bank.stale_weight",
                self.road_surface.bank.stale_weight,
                0.0,
                1.0,
                "a weight, 0 to 1",
            ),
            (
                "road_surface.bank.stale_frames",
                self.road_surface.bank.stale_frames,
                1.0,
                1e9,
                "1 to 1000000000 frames",
            ),
            ("road_surface.memory.cell_m", self.road_surface.memory.cell_m, 0.02, 2.0, "0.02 to 2 metres"),
            ("road_surface.memory.doubt", self.road_surface.memory.doubt, 0.01, 0.4, "0.01 to 0.4"),
            (
                "road_surface.memory.half_trust_m",
                self.road_surface.memory.half_trust_m,
                1.0,
                1e3,
                "1 to 1000 metres",
            ),
            (
                "road_surface.memory.keep_seen",
                self.road_surface.memory.keep_seen,
                0.0,
                0.95,
                "a share, 0 to 0.95",
            ),
            ("road_surface.memory.fade_m", self.road_surface.memory.fade_m, 1.0, 1e3, "1 to 1000 metres"),
            ("road_surface.memory.min_known", self.road_surface.memory.min_known, 0.5, 0.95, "0.5 to 0.95"),
            (
                "road_surface.online.columns",
                self.road_surface.online.columns as f64,
                16.0,
                2048.0,
                "16 to 2048 columns",
            ),
            (
                "road_surface.online.rows",
                self.road_surface.online.rows as f64,
                16.0,
                2048.0,
                "16 to 2048 rows",
            ),
            (
                "road_surface.online.surfaces",
                self.road_surface.online.surfaces as f64,
                1.0,
                16.0,
                "1 to 16 surfaces",
            ),
            (
                "road_surface.online.marking_width_heights",
                self.road_surface.online.marking_width_heights,
                0.0,
                1.0,
                "0 to 1 camera heights",
            ),
            (
                "road_surface.online.half_step",
                self.road_surface.online.half_step,
                0.05,
                10.0,
                "a step in log-brightness, 0.05 to 10",
            ),
            (
                "road_surface.online.known_step",
                self.road_surface.online.known_step,
                0.0,
                1.0,
                "a share, 0 to 1",
            ),
            (
                "road_surface.online.edges_along",
                self.road_surface.online.edges_along,
                0.0,
                1.0,
                "a share, 0 to 1",
            ),
            ("motion.direct.width_m", self.motion.direct.width_m, 1.0, 40.0, "1 to 40 metres"),
            ("motion.direct.length_m", self.motion.direct.length_m, 1.0, 40.0, "1 to 40 metres"),
            (
                "motion.direct.iterations",
                self.motion.direct.iterations as f64,
                1.0,
                50.0,
                "1 to 50 iterations",
            ),
            (
                "motion.farneback.region_width_m",
                self.motion.farneback.region_width_m,
                1.0,
                20.0,
                "1 to 20 metres",
            ),
            (
                "motion.farneback.region_length_m",
                self.motion.farneback.region_length_m,
                1.0,
                20.0,
                "1 to 20 metres",
            ),
            ("mount.prior_sigma_deg", self.mount.prior_sigma_deg, 0.05, 10.0, "0.05 to 10 degrees"),
            ("mount.drift_sigma_deg", self.mount.drift_sigma_deg, 0.0, 1.0, "0 to 1 degrees"),
            ("mount.suspension_sigma_deg", self.mount.suspension_sigma_deg, 0.01, 5.0, "0.01 to 5 degrees"),
            ("mount.valid_sigma_deg", self.mount.valid_sigma_deg, 0.02, 5.0, "0.02 to 5 degrees"),
            ("mount.moved_deg", self.mount.moved_deg, 0.5, 45.0, "0.5 to 45 degrees"),
            ("feature_mask.arm_width_share", self.feature_mask.arm_width_share, 0.05, 2.0, "0.05 to 2"),
            (
                "feature_mask.heading_step_deg",
                self.feature_mask.heading_step_deg,
                0.1,
                5.0,
                "0.1 to 5 degrees",
            ),
            ("feature_mask.verge_width_m", self.feature_mask.verge_width_m, 0.1, 2.0, "0.1 to 2 metres"),
            ("feature_mask.verge_from_share", self.feature_mask.verge_from_share, 0.2, 1.0, "0.2 to 1"),
            ("feature_mask.verge_reach_m", self.feature_mask.verge_reach_m, 0.5, 10.0, "0.5 to 10 metres"),
            ("driving_line.min_setback_m", self.driving_line.min_setback_m, 0.5, 20.0, "0.5 to 20 metres"),
            ("driving_line.max_setback_m", self.driving_line.max_setback_m, 0.5, 40.0, "0.5 to 40 metres"),
            ("driving_line.step_m", self.driving_line.step_m, 0.1, 5.0, "0.1 to 5 metres"),
            ("driving_line.lead_m", self.driving_line.lead_m, 0.0, 200.0, "0 to 200 metres"),
            ("match.binary_threshold", self.matching.binary_threshold, 0.0, 1.0, "a probability, 0 to 1"),
            ("match.min_seen_share", self.matching.min_seen_share, 0.0, 1.0, "a share, 0 to 1"),
            ("match.min_seen_length_m", self.matching.min_seen_length_m, 0.0, 20.0, "0 to 20 metres"),
            ("track.detect_threshold", self.track.detect_threshold, 0.0, 1.0, "a probability, 0 to 1"),
            (
                "track.detect_threshold_at_verge",
                self.track.detect_threshold_at_verge,
                0.0,
                self.track.detect_threshold,
                "a probability, 0 to track.detect_threshold",
            ),
            ("track.detect_contrast", self.track.detect_contrast, 0.01, 1.0, "0.01 to 1"),
            (
                "track.confirm_threshold",
                self.track.confirm_threshold,
                0.0,
                self.track.detect_threshold,
                "a probability, 0 to track.detect_threshold",
            ),
            ("track.detect_frames", self.track.detect_frames as f64, 1.0, 100.0, "1 to 100 frames"),
            ("track.lost_frames", self.track.lost_frames as f64, 1.0, 1000.0, "1 to 1000 frames"),
            ("track.search_forward_step_m", self.track.search_forward_step_m, 0.05, 5.0, "0.05 to 5 metres"),
            ("track.search_left_step_m", self.track.search_left_step_m, 0.05, 5.0, "0.05 to 5 metres"),
            ("track.search_heading_deg", self.track.search_heading_deg, 0.0, 45.0, "0 to 45 degrees"),
            (
                "track.search_heading_step_deg",
                self.track.search_heading_step_deg,
                0.2,
                45.0,
                "0.2 to 45 degrees",
            ),
            ("track.bracket_forward_m", self.track.bracket_forward_m, 0.0, 10.0, "0 to 10 metres"),
            ("track.bracket_left_m", self.track.bracket_left_m, 0.0, 10.0, "0 to 10 metres"),
            ("track.bracket_heading_deg", self.track.bracket_heading_deg, 0.0, 45.0, "0 to 45 degrees"),
            (
                "track.alignment.piece_length_m",
                self.track.alignment.piece_length_m,
                0.5,
                10.0,
                "0.5 to 10 metres",
            ),
            (
                "track.alignment.piece_width_m",
                self.track.alignment.piece_width_m,
                0.1,
                2.0,
                "0.1 to 2 metres",
            ),
            (
                "track.alignment.slide_beyond_m",
                self.track.alignment.slide_beyond_m,
                0.2,
                10.0,
                "0.2 to 10 metres",
            ),
            ("track.alignment.slide_step_m", self.track.alignment.slide_step_m, 0.02, 1.0, "0.02 to 1 metre"),
            ("track.alignment.min_edge_step", self.track.alignment.min_edge_step, 0.01, 1.0, "0.01 to 1"),
            (
                "track.alignment.kerb_radius_m",
                self.track.alignment.kerb_radius_m,
                0.0,
                50.0,
                "0 to 50 metres",
            ),
            ("track.alignment.max_wider_m", self.track.alignment.max_wider_m, 0.0, 50.0, "0 to 50 metres"),
            (
                "track.alignment.min_width_share",
                self.track.alignment.min_width_share,
                0.0,
                1.0,
                "a share, 0 to 1",
            ),
            (
                "track.alignment.width_sigma_share",
                self.track.alignment.width_sigma_share,
                0.0,
                1.0,
                "a share, 0 to 1",
            ),
            ("track.alignment.sigma_m", self.track.alignment.sigma_m, 0.01, 5.0, "0.01 to 5 metres"),
            (
                "track.alignment.pitch_sigma_deg",
                self.track.alignment.pitch_sigma_deg,
                0.0,
                10.0,
                "0 to 10 degrees",
            ),
            (
                "track.belief.detect_present",
                self.track.belief.detect_present,
                0.5,
                1.0,
                "a probability, 0.5 to 1",
            ),
            (
                "track.belief.lost_present",
                self.track.belief.lost_present,
                0.0,
                self.track.belief.detect_present,
                "a probability, 0 to track.belief.detect_present",
            ),
            ("track.belief.detect_sigma_m", self.track.belief.detect_sigma_m, 0.1, 10.0, "0.1 to 10 metres"),
            (
                "route_progress.start_sigma_m",
                self.route_progress.start_sigma_m,
                0.1,
                1e4,
                "0.1 to 10000 metres",
            ),
            ("route_progress.drift_share", self.route_progress.drift_share, 0.0, 1.0, "a share, 0 to 1"),
            ("route_progress.gps_sigma_m", self.route_progress.gps_sigma_m, 0.1, 1e4, "0.1 to 10000 metres"),
            ("route_progress.gps_gate_m", self.route_progress.gps_gate_m, 1.0, 1e4, "1 to 10000 metres"),
        ];
        check_ranges(checks)?;
        self.lanes.check()?;
        self.can.check()?;
        self.centreline.check()?;
        self.road_surface.onnx.check()
    }
}

/// Checks numbers, each with its key, range and the words for it.
pub(crate) fn check_ranges(
    checks: &[(&'static str, f64, f64, f64, &'static str)],
) -> Result<(), ConfigError> {
    match checks.iter().find(|(_, value, low, high, _)| !(*low..=*high).contains(value)) {
        None => Ok(()),
        Some(&(key, value, _, _, expected)) => Err(ConfigError { key, value, expected }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_in_range_and_a_wrong_number_is_named() {
        assert_eq!(Config::default().check(), Ok(()));
        let mut config = Config::default();
        config.track.detect_threshold = f64::NAN;
        assert_eq!(config.check().unwrap_err().key, "track.detect_threshold");
        config = Config::default();
        config.vehicle.width_m = -1.0;
        assert!(config.check().unwrap_err().to_string().starts_with("vehicle.width_m = -1"));
        config = Config::default();
        config.road_surface.onnx.standard_deviation[2] = 0.0;
        assert_eq!(config.check().unwrap_err().key, "road_surface.onnx.standard_deviation");
    }
}
