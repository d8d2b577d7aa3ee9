//! The effective configuration of a run: one table a stage.

mod text;

use std::sync::LazyLock;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

pub use self::text::{ConfigTextError, vehicle_to_toml};

use crate::advice::{AdviceConfig, AdviceSetting};
use crate::centreline::CentrelineConfig;
use crate::declared::{self, ConfigError};
use crate::driving_line::DrivingLineConfig;
use crate::feature_masks::FeatureMaskConfig;
use crate::ground_view::GroundViewConfig;
use crate::lanes::LanesConfig;
use crate::matching::MatchConfig;
use crate::motion::MotionConfig;
use crate::mount::MountConfig;
use crate::progress::RouteProgressConfig;
use crate::road_surface::RoadSurfaceConfig;
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
    /// Advice to a controller.
    pub advice: AdviceConfig,
}

/// The schema of all settings, made when it is first asked for.
static SCHEMA: LazyLock<Value> = LazyLock::new(declared::schema_of::<Config>);

impl Config {
    /// The JSON Schema of all settings: what each means, its unit (`x-unit`), range and default.
    pub fn schema() -> &'static Value {
        &SCHEMA
    }

    /// What the advice goes by.
    pub fn advice_setting(&self) -> AdviceSetting<'_> {
        AdviceSetting {
            advice: &self.advice,
            vehicle: &self.vehicle,
            far_m: self.ground_view.far_m,
            aim_m: self.centreline.look_ahead_m,
        }
    }

    /// Checks every number against the range that its field declares; the stages check what only they know.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        declared::check(&SCHEMA, "", self)?;
        let Self { track, lanes, centreline, .. } = self;
        for (lesser, greater) in [
            (("track.lost_present", track.lost_present), ("track.detect_present", track.detect_present)),
            (("lanes.least_range_m", lanes.least_range_m), ("lanes.most_range_m", lanes.most_range_m)),
            (("lanes.min_width_m", lanes.min_width_m), ("lanes.max_width_m", lanes.max_width_m)),
            (("centreline.edge_low", centreline.edge_low), ("centreline.edge_high", centreline.edge_high)),
        ] {
            if lesser.1 > greater.1 {
                let expected = format!("no more than {} = {}", greater.0, declared::number(greater.1));
                return Err(ConfigError { key: lesser.0.to_owned(), value: lesser.1, expected });
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle_signals::SignalValue;

    fn refused(change: impl FnOnce(&mut Config)) -> ConfigError {
        let mut config = Config::default();
        change(&mut config);
        config.check().unwrap_err()
    }

    #[test]
    fn defaults_are_in_range_and_a_wrong_number_is_named() {
        assert_eq!(Config::default().check(), Ok(()));
        for wrong in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let error = refused(|config| config.track.lost_present = wrong);
            assert_eq!(error.key, "track.lost_present");
            assert!(error.to_string().ends_with("= NaN or infinity cannot be used: give 0 to 1"), "{error}");
        }
        let error = refused(|config| config.vehicle.width_m = -1.0);
        assert!(error.to_string().starts_with("vehicle.width_m = -1 "));
        let error = refused(|config| config.road_surface.onnx.standard_deviation[2] = 0.0);
        assert_eq!(error.key, "road_surface.onnx.standard_deviation");
        let error = refused(|config| config.can.turn_signal_left = SignalValue::Number(f64::NAN));
        assert_eq!(
            (error.key.as_str(), error.expected.as_str()),
            ("can.turn_signal_left", "a finite number")
        );
    }

    #[test]
    fn a_lesser_number_above_its_greater_is_named_with_it() {
        for (error, words) in [
            (refused(|c| c.track.lost_present = 0.9), "no more than track.detect_present = 0.8"),
            (refused(|c| c.lanes.least_range_m = 40.0), "no more than lanes.most_range_m = 35"),
            (refused(|c| (c.lanes.min_width_m, c.lanes.max_width_m) = (3.0, 2.9)), "lanes.max_width_m = 2.9"),
            (refused(|c| c.centreline.edge_high = 50.0), "centreline.edge_high = 50"),
        ] {
            assert!(error.to_string().contains(words), "{error}");
        }
    }
}
