//! Settings changed by their keys, and those that differ from others.

use fingerpost::{Config, ConfigError, ConfigTextError};
use fingerpost_format::TriedSettings;
use serde_json::{Map, Value};
use thiserror::Error;

/// Settings that cannot be changed so.
#[derive(Debug, Error)]
pub(crate) enum ChangeError {
    /// There is no such setting.
    #[error("there is no setting {key}; `fingerpost schema` prints every key")]
    Unknown { key: String },
    /// A value is of the wrong kind.
    #[error(transparent)]
    Kind(#[from] ConfigTextError),
    /// A value is out of range, or contradicts another.
    #[error(transparent)]
    Range(#[from] ConfigError),
}

impl ChangeError {
    /// The setting that is to blame, where one is.
    pub(crate) fn key(&self) -> Option<&str> {
        match self {
            Self::Unknown { key }
            | Self::Kind(ConfigTextError::Setting { key, .. })
            | Self::Range(ConfigError { key, .. }) => Some(key),
            Self::Kind(_) => None,
        }
    }
}

/// All settings of a JSON object with these in place of its own.
pub(crate) fn with_changes(base: &Value, changed: &TriedSettings) -> Result<Config, ChangeError> {
    let mut json = base.clone();
    for (key, value) in changed {
        let place =
            json.pointer_mut(&pointer(key)).ok_or_else(|| ChangeError::Unknown { key: key.clone() })?;
        *place = value.clone();
    }
    let config = Config::from_json(json)?;
    config.check()?;
    Ok(config)
}

/// Where a key's value stands in the settings as JSON.
pub(crate) fn pointer(key: &str) -> String {
    format!("/{}", key.replace('.', "/"))
}

/// The settings of `config` that differ from those of `base`, a table a stage, as TOML; a setting that is none stays out.
pub(crate) fn differences_to_toml(config: &Config, base: &Config) -> String {
    let differing =
        differences(&config.to_json(), &base.to_json()).unwrap_or_else(|| Value::Object(Map::new()));
    // Numbers, texts, lists and tables of them all have a form in TOML.
    toml::to_string(&differing).unwrap_or_default()
}

/// Whether a text is a file of settings that this program wrote: signed in its first line, and without comments that would be lost.
pub(crate) fn is_written_settings(text: &str) -> bool {
    let is_signed = text.starts_with("# Written by fingerpost ");
    is_signed && text.lines().skip(1).all(|line| !line.contains('#')) && Config::from_toml(text).is_ok()
}

fn differences(value: &Value, base: &Value) -> Option<Value> {
    let (Value::Object(fields), Value::Object(of_base)) = (value, base) else {
        return (value != base && !value.is_null()).then(|| value.clone());
    };
    let differing: Map<String, Value> = fields
        .iter()
        .filter_map(|(name, value)| {
            let differing = differences(value, of_base.get(name).unwrap_or(&Value::Null))?;
            Some((name.clone(), differing))
        })
        .collect();
    (!differing.is_empty()).then_some(Value::Object(differing))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(settings: &[(&str, Value)]) -> Result<Config, ChangeError> {
        let settings = settings.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
        with_changes(&Config::default().to_json(), &settings)
    }

    #[test]
    fn what_is_written_is_what_was_changed_and_is_read_again() {
        let config =
            changed(&[("track.detect_present", 0.7.into()), ("road_surface.bank.frames", 7.into())]).unwrap();
        let text = differences_to_toml(&config, &Config::default());
        assert_eq!(text, "[road_surface.bank]\nframes = 7\n\n[track]\ndetect_present = 0.7\n");
        assert_eq!(Config::from_toml(&text), Ok(config.clone()));
        assert_eq!(differences_to_toml(&config, &config), "");
    }

    #[test]
    fn what_is_refused_is_named_by_its_key() {
        for (key, value, words) in [
            ("track.detect_presnt", 0.7.into(), "no setting track.detect_presnt"),
            ("track.detect_present", 1.5.into(), "give 0.5 to 1"),
            ("track.lost_present", 0.9.into(), "no more than track.detect_present"),
            ("road_surface.bank.frames", Value::from("many"), "invalid type"),
        ] {
            let error = changed(&[(key, value)]).unwrap_err();
            assert!(error.to_string().contains(words), "{error}");
            assert_eq!(error.key(), Some(key));
        }
    }
}
