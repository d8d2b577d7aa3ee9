//! Configurations and known surfaces.

use fingerpost::Config;
use fingerpost::advice::{AdviceStage, ControllerName, DEFAULT_RULES};
use fingerpost::road_surface::{RoadMethod, RoadSurfaceConfig, SurfaceFile};

use crate::must;

/// A configuration that is accepted reads back and is accepted again.
pub(crate) fn config(bytes: &[u8]) -> bool {
    if let Ok(text) = str::from_utf8(bytes)
        && let Ok(config) = Config::from_toml(text)
        && config.check().is_ok()
    {
        let written = must(config.to_toml(), "a configuration that was read");
        let again = must(Config::from_toml(&written), "a configuration that was written");
        assert_eq!(again, config);
        return true;
    }
    false
}

pub(crate) fn config_seeds() -> Vec<Vec<u8>> {
    let all = must(Config::default().to_toml(), "a seed");
    vec![all.into_bytes(), include_bytes!("../../fingerpost-sim/src/bus/can.toml").to_vec()]
}

/// Rules that are accepted make a controller, which has them all.
pub(crate) fn fuzzy_rules(bytes: &[u8]) -> bool {
    let Ok(text) = str::from_utf8(bytes) else { return false };
    let mut config = Config::default();
    (config.advice.controller, config.advice.rules) = (ControllerName::Fuzzy, Some(text.to_owned()));
    let Ok(stage) = AdviceStage::new(&config.advice_setting()) else { return false };
    let written = text.lines().filter(|line| line.split_whitespace().next() == Some("rule")).count();
    assert_eq!(stage.rules().count(), written);
    true
}

pub(crate) fn fuzzy_rules_seeds() -> Vec<Vec<u8>> {
    vec![DEFAULT_RULES.as_bytes().to_vec()]
}

/// Surfaces that a detector takes come out of it again and are taken by another.
pub(crate) fn bank(bytes: &[u8]) -> bool {
    let Ok(surfaces) =
        str::from_utf8(bytes).map_err(drop).and_then(|text| SurfaceFile::from_json(text).map_err(drop))
    else {
        return false;
    };
    let detector = || {
        let config = RoadSurfaceConfig { detector: RoadMethod::Bank, ..RoadSurfaceConfig::default() };
        must(fingerpost_papers::road_detector(&config), "a detector")
    };
    let mut first = detector();
    if first.know(&surfaces).is_ok()
        && let Some(known) = first.known_surfaces()
    {
        must(detector().know(&known), "surfaces that were known");
        return true;
    }
    false
}

pub(crate) fn bank_seeds() -> Vec<Vec<u8>> {
    let text = "{\"version\": 1, \"surfaces\": [{\"name\": \"asphalt\", \"frames\": 120, \"histogram\": [[320, 0.5], [321, 0.25], \
                [352, 0.25]]}, {\"name\": \"grass\", \"frames\": 7, \"histogram\": [[13, 1.0]]}]}";
    vec![text.as_bytes().to_vec()]
}
