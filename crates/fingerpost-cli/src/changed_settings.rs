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

/// Settings that differ between two JSON objects of them: key, and the value in either; null where one has none.
pub(crate) fn differing(one: &Value, other: &Value) -> Vec<(String, [Value; 2])> {
    let mut found = Vec::new();
    collect_differing("", one, other, &mut found);
    found
}

fn collect_differing(key: &str, one: &Value, other: &Value, found: &mut Vec<(String, [Value; 2])>) {
    match (one.as_object(), other.as_object()) {
        (Some(fields), Some(of_other)) => {
            let only_there = of_other.keys().filter(|name| !fields.contains_key(*name));
            for name in fields.keys().chain(only_there) {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                collect_differing(&key, &one[name], &other[name], found);
            }
        }
        _ if one != other => found.push((key.to_owned(), [one.clone(), other.clone()])),
        _ => (),
    }
}

/// The settings of `config` that differ from those of `base`, a table a stage, as TOML; a setting that is none stays out.
pub(crate) fn differences_to_toml(config: &Config, base: &Config) -> String {
    let mut tables = Value::Object(Map::new());
    for (key, [value, _]) in differing(&config.to_json(), &base.to_json()) {
        if !value.is_null() {
            let place = key.split('.').fold(&mut tables, |table, name| &mut table[name]);
            *place = value;
        }
    }
    // Numbers, texts, lists and tables of them all have a form in TOML.
    toml::to_string(&tables).unwrap_or_default()
}

/// Whether a text is a file of settings that this program wrote: signed in its first line, and without comments that would be lost.
pub(crate) fn is_written_settings(text: &str) -> bool {
    let is_signed = text.starts_with("# Written by fingerpost ");
    is_signed && text.lines().skip(1).all(|line| !line.contains('#')) && Config::from_toml(text).is_ok()
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
