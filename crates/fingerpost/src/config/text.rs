//! Settings as TOML and as JSON.
//!
//! Every type of settings is written once for each of the two and read from JSON alone, which TOML is turned into: what
//! reads a type from TOML itself is four times as much code. It is all here, so that no program has it again.

use serde::Serialize;
use serde_json::{Value, json};
use thiserror::Error;

use super::Config;
use crate::vehicle::VehicleConfig;

/// Settings that cannot be read or written.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ConfigTextError {
    /// The text is no TOML.
    #[error("{cause}")]
    Toml {
        /// What the parser says, with the line.
        cause: toml::de::Error,
    },
    /// There is no such setting, or it cannot have this value.
    #[error("{key}: {cause}")]
    Setting {
        /// Key, with its tables.
        key: String,
        /// What is wrong with it.
        cause: String,
    },
    /// The settings have no form in TOML.
    #[error("the configuration cannot be written as TOML ({cause})")]
    Written {
        /// What the writer says.
        cause: toml::ser::Error,
    },
}

impl Config {
    /// The settings of a TOML text; those that it does not have are the default ones. Ranges are for [`Config::check`].
    ///
    /// # Errors
    /// [`ConfigTextError`] says in which line the text is no TOML, or which key is none or has a value of the wrong kind.
    pub fn from_toml(text: &str) -> Result<Self, ConfigTextError> {
        let table: toml::Table = text.parse().map_err(|cause| ConfigTextError::Toml { cause })?;
        Self::from_json(json_of(toml::Value::Table(table), "")?)
    }

    /// All settings as TOML, a table a stage.
    ///
    /// # Errors
    /// [`ConfigTextError::Written`] when a value has no form in TOML.
    pub fn to_toml(&self) -> Result<String, ConfigTextError> {
        written(self)
    }

    /// The settings of a JSON object; those that it does not have are the default ones.
    ///
    /// # Errors
    /// [`ConfigTextError::Setting`] says which key is none or has a value of the wrong kind.
    pub fn from_json(settings: Value) -> Result<Self, ConfigTextError> {
        serde_json::from_value(settings.clone()).map_err(|cause| {
            let cause = cause.to_string();
            ConfigTextError::Setting { key: key_of(&cause, &settings), cause }
        })
    }

    /// All settings as a JSON object; a number that is not finite is null.
    #[must_use]
    pub fn to_json(&self) -> Value {
        serde_json::to_value(self).unwrap_or_default()
    }
}

/// A vehicle as the TOML of a configuration that says nothing else.
///
/// # Errors
/// [`ConfigTextError::Written`] when a value has no form in TOML.
pub fn vehicle_to_toml(vehicle: &VehicleConfig) -> Result<String, ConfigTextError> {
    #[derive(Serialize)]
    struct Settings<'a> {
        vehicle: &'a VehicleConfig,
    }
    written(&Settings { vehicle })
}

fn written(settings: &impl Serialize) -> Result<String, ConfigTextError> {
    toml::to_string(settings).map_err(|cause| ConfigTextError::Written { cause })
}

/// A value of TOML as JSON has it.
fn json_of(value: toml::Value, key: &str) -> Result<Value, ConfigTextError> {
    let refused = |cause: String| ConfigTextError::Setting { key: key.to_owned(), cause };
    Ok(match value {
        toml::Value::String(text) => text.into(),
        toml::Value::Integer(number) => number.into(),
        toml::Value::Float(number) if number.is_finite() => number.into(),
        toml::Value::Float(number) => {
            return Err(refused(format!("{number} cannot be used: give a finite number")));
        }
        toml::Value::Boolean(is) => is.into(),
        toml::Value::Datetime(time) => return Err(refused(format!("no setting is a time, as {time} is"))),
        toml::Value::Array(items) => {
            items.into_iter().map(|item| json_of(item, key)).collect::<Result<Vec<_>, _>>()?.into()
        }
        toml::Value::Table(table) => {
            let field = |(name, value): (String, toml::Value)| {
                let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
                Ok((name, json_of(value, &key)?))
            };
            Value::Object(table.into_iter().map(field).collect::<Result<_, ConfigTextError>>()?)
        }
    })
}

/// The key that settings are refused for in these words: the innermost that alone is refused in the same ones.
fn key_of(cause: &str, settings: &Value) -> String {
    let (mut path, mut value): (Vec<&str>, _) = (Vec::new(), settings);
    while let Some(fields) = value.as_object() {
        let is_refused = |(name, value): &(&String, &Value)| {
            let names = path.iter().copied().chain([name.as_str()]);
            let alone = names.rev().fold((*value).clone(), |value, name| json!({ name: value }));
            serde_json::from_value::<Config>(alone).is_err_and(|error| error.to_string() == cause)
        };
        let Some((name, inner)) = fields.iter().find(is_refused) else { break };
        path.push(name);
        value = inner;
    }
    path.join(".")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let mut config = Config::default();
        (config.vehicle.width_m, config.can.interface) = (1.7, Some("can0".to_owned()));
        assert_eq!(Config::from_toml(&config.to_toml().unwrap()), Ok(config.clone()));
        assert_eq!(Config::from_json(config.to_json()), Ok(config.clone()));
        let vehicle = Config::from_toml(&vehicle_to_toml(&config.vehicle).unwrap()).unwrap();
        assert_eq!(vehicle, Config { vehicle: config.vehicle, ..Config::default() });
    }

    #[test]
    fn what_is_refused_is_named_by_its_key() {
        for (text, words) in [
            ("[vehicle]\nwidth_m = \"wide\"", "vehicle.width_m: invalid type: string \"wide\", expected f64"),
            ("[match]\nsize = 1", "match.size: unknown field `size`"),
            ("trak = 1", "trak: unknown field `trak`"),
            (
                "[vehicle]\nwidth_m = 1.7\n[road_surface]\ndetector = \"none\"",
                "road_surface.detector: unknown variant `none`",
            ),
            ("[road_surface.bank]\nframes = -1", "road_surface.bank.frames: invalid value: integer `-1`"),
            ("[vehicle]\nwidth_m = nan", "vehicle.width_m: NaN cannot be used: give a finite number"),
            ("[vehicle]\nwidth_m = 1979-05-27", "vehicle.width_m: no setting is a time"),
            ("vehicle = 1", "vehicle: invalid type: integer `1`"),
            ("[vehicle]\nwidth_m =", "line 2"),
        ] {
            let error = Config::from_toml(text).unwrap_err().to_string();
            assert!(error.contains(words), "{text}: {error}");
        }
    }
}
