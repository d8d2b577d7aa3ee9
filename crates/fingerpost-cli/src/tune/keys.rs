//! Settings that are searched: named by their keys, ranged by their declarations.

use std::fmt::{self, Display, Formatter};
use std::str::FromStr;

use fingerpost::Config;
use fingerpost_format::TriedSettings;
use fingerpost_search::{Scale, Variable, VariableError};
use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

use crate::changed_settings::{pointer, with_changes};

/// Keys that are searched where none are named: how probable a feature and how sure its
/// place must be to be followed, and how roads may differ from the map.
pub(super) const DEFAULT_KEYS: [&str; 5] = [
    "track.detect_present",
    "track.lost_present",
    "track.detect_sigma_m",
    "track.width_sigma_share",
    "track.kerb_radius_m",
];
/// Keys that are named for one that does not exist.
const NEAR_KEYS: usize = 3;
/// How far from its default a positive number is searched, as a factor, where nothing else is said: declared ranges reach to what
/// is possible at all, and most of them are useless.
const DEFAULT_FACTOR: f64 = 3.0;

/// A key that cannot be searched.
#[derive(Debug, Error)]
pub(crate) enum KeyError {
    /// There is no such setting.
    #[error("there is no setting {key}; near to it are {near}; `fingerpost schema` prints every key")]
    Unknown { key: String, near: String },
    /// It is no number, choice or switch.
    #[error("{key} is {kind}, which cannot be searched; name a number, a choice or a switch of it")]
    Kind { key: String, kind: &'static str },
    /// Its range reaches beyond what is declared.
    #[error("{key} = {range} reaches beyond {least} to {most}; give a range within")]
    Range { key: String, range: SearchRange, least: f64, most: f64 },
    /// It is a choice, and those have no range.
    #[error("{key} is a choice of {choices}, which has no range; name it alone")]
    Choice { key: String, choices: usize },
    /// It is named twice.
    #[error("{key} is named twice; name each key once")]
    Twice { key: String },
    /// It says what the vehicle is like, which the drives say.
    #[error("{key} is known of the vehicle of each drive, not searched; leave it out")]
    Vehicle { key: String },
    /// Nothing in its range can be searched.
    #[error("{key}: {cause}")]
    Variable { key: String, cause: VariableError },
}

/// The numbers between which a setting is searched.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct SearchRange {
    least: f64,
    most: f64,
}

impl Display for SearchRange {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.least, self.most)
    }
}

/// A setting as an argument names it: `KEY` or `KEY=LEAST..MOST`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct WantedKey {
    name: String,
    range: Option<SearchRange>,
}

impl FromStr for WantedKey {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || {
            format!(
                "{text:?} is no key to search; give KEY or KEY=LEAST..MOST, as in track.detect_present=0.6..0.9"
            )
        };
        let Some((name, range)) = text.split_once('=') else {
            return Ok(Self { name: text.to_owned(), range: None });
        };
        let (least, most) = range.split_once("..").ok_or_else(form)?;
        let number =
            |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(form);
        Ok(Self {
            name: name.to_owned(),
            range: Some(SearchRange { least: number(least)?, most: number(most)? }),
        })
    }
}

/// A setting that is searched.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Key {
    /// With its tables, as in `track.detect_present`.
    pub(crate) name: String,
    kind: Kind,
    /// What the search begins with.
    start: f64,
    #[serde(skip)]
    pub(crate) variable: Variable,
}

#[derive(Debug, Clone, Serialize)]
#[serde(rename_all = "snake_case")]
enum Kind {
    Real(SearchRange),
    Whole(SearchRange),
    Choice(Vec<Value>),
}

/// The settings of a search, with those that stay as they are.
#[derive(Debug, Clone)]
pub(crate) struct SearchedSettings {
    pub(crate) keys: Vec<Key>,
    pub(crate) base: Config,
    /// The base as a table of tables.
    base_json: Value,
}

impl SearchedSettings {
    /// Settings that vary `wanted` and leave the rest of `base`.
    pub(crate) fn new(wanted: &[WantedKey], base: &Config) -> Result<Self, KeyError> {
        let base_json = base.to_json();
        let keys: Vec<Key> =
            wanted.iter().map(|wanted| Key::new(wanted, &base_json)).collect::<Result<_, _>>()?;
        let is_repeated =
            |(index, key): &(usize, &Key)| keys[..*index].iter().any(|other| other.name == key.name);
        if let Some((_, key)) = keys.iter().enumerate().find(is_repeated) {
            return Err(KeyError::Twice { key: key.name.clone() });
        }
        Ok(Self { keys, base: base.clone(), base_json })
    }

    pub(crate) fn variables(&self) -> Vec<Variable> {
        self.keys.iter().map(|key| key.variable).collect()
    }

    /// The values that the search begins with.
    pub(crate) fn start(&self) -> Vec<f64> {
        self.keys.iter().map(|key| key.start).collect()
    }

    /// Values of the search as those of settings.
    pub(crate) fn named(&self, values: &[f64]) -> TriedSettings {
        self.keys.iter().zip(values).map(|(key, &value)| (key.name.clone(), key.json(value))).collect()
    }

    /// All settings with these among them; none where they contradict each other.
    pub(crate) fn config(&self, settings: &TriedSettings) -> Option<Config> {
        with_changes(&self.base_json, settings).ok()
    }
}

impl Key {
    fn new(wanted: &WantedKey, base: &Value) -> Result<Self, KeyError> {
        let key = wanted.name.clone();
        let unknown = || KeyError::Unknown { key: key.clone(), near: near(&key).join(", ") };
        let declared = declaration(&key).ok_or_else(unknown)?;
        if key.starts_with("vehicle.") {
            return Err(KeyError::Vehicle { key });
        }
        let value = base.pointer(&pointer(&key)).ok_or_else(unknown)?;
        let choices = choices(declared);
        if let Some(start) = choices.iter().position(|choice| choice == value) {
            if wanted.range.is_some() {
                return Err(KeyError::Choice { key, choices: choices.len() });
            }
            let variable = Variable::choice(choices.len())
                .map_err(|cause| KeyError::Variable { key: key.clone(), cause })?;
            return Ok(Self { name: key, kind: Kind::Choice(choices), start: start as f64, variable });
        }
        let (Some(start), Some(least), Some(most)) =
            (value.as_f64(), declared["minimum"].as_f64(), declared["maximum"].as_f64())
        else {
            let kind = match value {
                Value::Object(_) => "a table",
                Value::Array(_) => "a list",
                _ => "a text or nothing",
            };
            return Err(KeyError::Kind { key, kind });
        };
        let range = match wanted.range {
            Some(range) if range.least < least || range.most > most => {
                return Err(KeyError::Range { key, range, least, most });
            }
            Some(range) => range,
            None if start > 0.0 => SearchRange {
                least: least.max(start / DEFAULT_FACTOR),
                most: most.min(start * DEFAULT_FACTOR),
            },
            None => SearchRange { least, most },
        };
        let scale = if range.least > 0.0 { Scale::Logarithmic } else { Scale::Linear };
        let is_whole = declared["type"] == "integer";
        let (kind, variable) = if is_whole {
            let whole = SearchRange { least: range.least.ceil(), most: range.most.floor() };
            (Kind::Whole(whole), Variable::whole(whole.least as i32, whole.most as i32, scale))
        } else {
            (Kind::Real(range), Variable::real(range.least, range.most, scale))
        };
        let variable = variable.map_err(|cause| KeyError::Variable { key: key.clone(), cause })?;
        Ok(Self { name: key, kind, start, variable })
    }

    /// A value of the search as that of the setting.
    fn json(&self, value: f64) -> Value {
        match &self.kind {
            Kind::Real(_) => value.into(),
            Kind::Whole(_) => (value as i64).into(),
            Kind::Choice(choices) => choices.get(value as usize).cloned().unwrap_or_default(),
        }
    }
}

/// What the schema says of a key.
fn declaration(key: &str) -> Option<&'static Value> {
    key.split('.').try_fold(Config::schema(), |schema, name| schema.get("properties")?.get(name))
}

/// What a declared choice or switch may be; nothing of anything else.
fn choices(declared: &Value) -> Vec<Value> {
    if declared["type"] == "boolean" {
        return vec![false.into(), true.into()];
    }
    let listed = declared["enum"].as_array().cloned().unwrap_or_default();
    let one_of = declared["oneOf"].as_array().map(Vec::as_slice).unwrap_or_default();
    let each = one_of.iter().flat_map(|variant| match &variant["const"] {
        Value::Null => variant["enum"].as_array().cloned().unwrap_or_default(),
        value => vec![value.clone()],
    });
    listed.into_iter().chain(each).collect()
}

/// The keys that are most like one that does not exist, likest first.
fn near(key: &str) -> Vec<String> {
    let mut all = Vec::new();
    collect_keys(Config::schema(), "", &mut all);
    let last = |key: &str| key.rsplit('.').next().unwrap_or_default().to_owned();
    // A key may be misspelt, or stand in another table.
    let likeness =
        |other: &str| strsim::jaro_winkler(key, other).max(strsim::jaro_winkler(&last(key), &last(other)));
    all.sort_by(|a, b| likeness(b).total_cmp(&likeness(a)));
    all.truncate(NEAR_KEYS);
    all
}

fn collect_keys(schema: &Value, table: &str, all: &mut Vec<String>) {
    for (name, property) in schema["properties"].as_object().into_iter().flatten() {
        let key = if table.is_empty() { name.clone() } else { format!("{table}.{name}") };
        if property.get("properties").is_some() {
            collect_keys(property, &key, all);
        } else {
            all.push(key);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searched(keys: &[&str]) -> Result<SearchedSettings, KeyError> {
        let wanted: Vec<WantedKey> = keys.iter().map(|key| key.parse().unwrap()).collect();
        SearchedSettings::new(&wanted, &Config::default())
    }

    #[test]
    fn numbers_choices_and_switches_are_set_by_name() {
        let settings =
            searched(&["road_surface.bank.frames", "match.surface", "track.detect_sigma_m=1..4"]).unwrap();
        assert_eq!(settings.start(), [5.0, 0.0, 2.5]);
        let named = settings.named(&[7.0, 1.0, 3.5]);
        let config = settings.config(&named).unwrap();
        assert_eq!(config.road_surface.bank.frames, 7);
        assert_eq!(config.matching.surface, fingerpost::matching::MatchedSurface::Binary);
        assert!((config.track.detect_sigma_m - 3.5).abs() < 1e-12);
        assert_eq!(settings.config(&settings.named(&settings.start())), Some(Config::default()));
        // From a third of it to three times as much.
        let limits: Vec<f64> = [0.0, 1.0].iter().map(|&gene| settings.keys[0].variable.value(gene)).collect();
        assert_eq!(limits, [2.0, 15.0]);
    }

    #[test]
    fn settings_that_contradict_each_other_are_none() {
        let settings = searched(&["track.lost_present"]).unwrap();
        assert!(settings.config(&settings.named(&[0.9])).is_none());
    }

    #[test]
    fn what_cannot_be_searched_is_refused_with_the_next_action() {
        for (keys, words) in [
            (&["track.detect_presnt"][..], &["track.detect_present", "fingerpost schema"][..]),
            (&["detect_sigma_m"], &["track.detect_sigma_m"]),
            (&["track"], &["track is a table"]),
            (&["track.detect_present=0.5..1.5"], &["0.5..1.5", "0.5 to 1", "within"]),
            (&["match.surface=1..2"], &["choice of 2"]),
            (&["track.lost_present", "track.lost_present"], &["twice"]),
            (&["track.detect_sigma_m=3..2"], &["the lesser first"]),
        ] {
            let error = searched(keys).unwrap_err().to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
        assert!("track.x=1-2".parse::<WantedKey>().is_err_and(|error| error.contains("LEAST..MOST")));
    }
}
