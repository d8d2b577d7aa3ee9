//! Checks settings against their declarations.
//!
//! A field of a settings struct declares its range in an attribute, its unit in its name, its meaning in its comment and its
//! default in the struct's `Default`. The JSON Schema that follows from them is what numbers are checked against.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde::Serialize;
use serde_json::Value;
use thiserror::Error;

/// Ends of keys and the units that they stand for; the longest that fits counts.
const UNITS: [(&str, &str); 13] = [
    ("_m", "metres"),
    ("_per_m", "per metre"),
    ("metres_per_pixel", "metres a pixel"),
    ("_heights", "camera heights"),
    ("_px", "pixels"),
    ("_deg", "degrees"),
    ("_deg_per_s", "degrees a second"),
    ("_deg_per_s2", "degrees/s²"),
    ("_s", "seconds"),
    ("_mps", "m/s"),
    ("_mps2", "m/s²"),
    ("_bins", "bins"),
    ("_frames", "frames"),
];

/// A setting that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{key} = {} cannot be used: give {expected}", number(*.value))]
pub struct ConfigError {
    /// Key, with its table.
    pub key: String,
    /// Value found.
    pub value: f64,
    /// What would be accepted, with its unit.
    pub expected: String,
}

/// The schema of `T` in one piece: of each field the meaning, the unit where it has one, range and default.
pub(crate) fn schema_of<T: JsonSchema>() -> Value {
    let settings = SchemaSettings::draft2020_12().with(|settings| settings.inline_subschemas = true);
    let mut schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    complete(&mut schema);
    schema
}

/// Gives every number under `schema` the unit that its key ends in, unless its field declares another, and leaves defaults
/// to the fields.
fn complete(schema: &mut Value) {
    let Some(table) = schema.as_object_mut().filter(|schema| schema.contains_key("properties")) else {
        return;
    };
    table.remove("default");
    let Some(properties) = table.get_mut("properties").and_then(Value::as_object_mut) else { return };
    for (key, property) in properties {
        complete(property);
        let number = if property.get("items").is_some() { &mut property["items"] } else { property };
        if let Some(unit) = unit_of(key, number)
            && let Some(number) = number.as_object_mut()
        {
            number.entry("x-unit").or_insert_with(|| unit.into());
        }
    }
}

/// The unit of a number by its key; one that counts is named by what it counts.
fn unit_of<'k>(key: &'k str, number: &Value) -> Option<&'k str> {
    let kind = number["type"].as_str()?;
    let fits = UNITS.iter().filter(|(end, _)| key.ends_with(end)).max_by_key(|(end, _)| end.len());
    match (fits, kind) {
        (Some((_, unit)), "number" | "integer") => Some(unit),
        (None, "integer") => key.rsplit('_').next(),
        _ => None,
    }
}

/// Checks every number of `settings`, whose keys stand in `table`, against its declaration in `schema`.
pub(crate) fn check(schema: &Value, table: &str, settings: &impl Serialize) -> Result<(), ConfigError> {
    // What could not be written would be null, which no schema of settings allows.
    refused(schema, table, &serde_json::to_value(settings).unwrap_or_default()).map_or(Ok(()), Err)
}

/// The first number in `value` that its schema does not allow.
fn refused(schema: &Value, key: &str, value: &Value) -> Option<ConfigError> {
    match value {
        Value::Object(fields) => fields.iter().find_map(|(name, value)| {
            let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            refused(&schema["properties"][name], &key, value)
        }),
        Value::Array(items) => items.iter().find_map(|item| refused(&schema["items"], key, item)),
        // JSON writes null for a number that is not finite.
        Value::Null if !may_be_absent(schema) => Some(error(schema, key, f64::NAN)),
        Value::Number(number) => {
            let value = number.as_f64().unwrap_or(f64::NAN);
            let beyond = |limit: &str, side: fn(&f64, &f64) -> bool| {
                schema[limit].as_f64().is_some_and(|limit| side(&value, &limit))
            };
            (beyond("minimum", f64::lt) || beyond("maximum", f64::gt)).then(|| error(schema, key, value))
        }
        _ => None,
    }
}

fn may_be_absent(schema: &Value) -> bool {
    schema["type"].as_array().is_some_and(|kinds| kinds.iter().any(|kind| kind == "null"))
}

fn error(schema: &Value, key: &str, value: f64) -> ConfigError {
    let range = match (schema["minimum"].as_f64(), schema["maximum"].as_f64()) {
        (Some(least), Some(most)) => format!("{} to {}", number(least), number(most)),
        _ => "a finite number".to_owned(),
    };
    let unit = schema["x-unit"].as_str().map(|unit| format!(" {unit}")).unwrap_or_default();
    ConfigError { key: key.to_owned(), value, expected: range + &unit }
}

/// A number in a few digits, with an exponent where it is very large or small.
pub(crate) fn number(value: f64) -> String {
    match value.abs() {
        size if size.is_nan() => "NaN or infinity".to_owned(),
        size if size == 0.0 || (1e-4..1e7).contains(&size) => value.to_string(),
        _ => format!("{value:e}"),
    }
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::GroundGrid;
    use serde_json::json;

    use super::*;
    use crate::Config;
    use crate::ground_view::GroundViewConfig;

    /// The key and the schema of every number under `schema`; of an array, that of its items.
    fn numbers(schema: &Value, key: &str) -> Vec<(String, Value)> {
        let Some(properties) = schema["properties"].as_object() else {
            let number = if schema["items"].is_object() { &schema["items"] } else { schema };
            let is_number = ["number", "integer"].contains(&number["type"].as_str().unwrap_or_default());
            return if is_number { vec![(key.to_owned(), number.clone())] } else { Vec::new() };
        };
        properties.iter().flat_map(|(name, property)| numbers(property, &format!("{key}/{name}"))).collect()
    }

    /// What the check says of the default settings with `number` at the place `pointer`.
    fn with(pointer: &str, number: f64) -> Result<(), ConfigError> {
        let mut settings = serde_json::to_value(Config::default()).unwrap();
        let place = settings.pointer_mut(pointer).unwrap();
        let number = if number.fract() == 0.0 { json!(number as i64) } else { json!(number) };
        *place = match place {
            Value::Array(items) => vec![number; items.len()].into(),
            _ => number,
        };
        check(Config::schema(), "", &settings)
    }

    #[test]
    fn every_number_has_a_meaning_and_a_range_around_its_default() {
        let all = numbers(Config::schema(), "");
        assert!(all.len() >= 100, "{} numbers", all.len());
        let defaults = serde_json::to_value(Config::default()).unwrap();
        for (pointer, number) in all {
            let [least, most] = ["minimum", "maximum"].map(|limit| number[limit].as_f64().expect(&pointer));
            assert!(least < most && most < 1e10, "{pointer}: {least} to {most}");
            let default = defaults.pointer(&pointer).unwrap();
            let values = default.as_array().map_or(std::slice::from_ref(default), Vec::as_slice);
            assert!(values.iter().all(|v| (least..=most).contains(&v.as_f64().unwrap())), "{pointer}");
            let field = Config::schema().pointer(&pointer.replace('/', "/properties/")).unwrap();
            assert!(field["description"].is_string() && field.get("default").is_some(), "{pointer}");
        }
    }

    #[test]
    fn every_number_is_taken_up_to_its_limits_and_no_further() {
        for (pointer, number) in numbers(Config::schema(), "") {
            let [least, most] = ["minimum", "maximum"].map(|limit| number[limit].as_f64().unwrap());
            let key = pointer[1..].replace('/', ".");
            for (limit, beyond) in [(least, least - 1.0), (most, most + 1.0)] {
                assert_eq!(with(&pointer, limit), Ok(()));
                let error = with(&pointer, beyond).unwrap_err();
                assert_eq!((&error.key, error.value), (&key, beyond));
            }
        }
    }

    #[test]
    fn the_limits_of_the_ground_view_are_those_of_its_grid() {
        let grid = |change: &dyn Fn(&mut GroundViewConfig)| {
            let mut view = GroundViewConfig::default();
            change(&mut view);
            GroundGrid::new(view.near_m, view.far_m, view.half_width_m, view.metres_per_pixel)
        };
        let limits = |key: &str| {
            let number = &Config::schema()["properties"]["ground_view"]["properties"][key];
            [("minimum", -1e-6), ("maximum", 1e-6)].map(|(limit, step)| {
                (number[limit].as_f64().unwrap(), number[limit].as_f64().unwrap() + step)
            })
        };
        let agree = |key: &str, set: &dyn Fn(&mut GroundViewConfig, f64)| {
            for (limit, beyond) in limits(key) {
                grid(&|view| set(view, limit)).expect(key);
                assert!(
                    grid(&|view| set(view, beyond)).unwrap_err().to_string().contains(key),
                    "{key} {beyond}"
                );
            }
        };
        agree("near_m", &|view, near_m| (view.near_m, view.far_m) = (near_m, near_m + 20.0));
        // The view ends at least a metre beyond where it begins.
        agree("far_m", &|view, far_m| {
            (view.near_m, view.far_m) = ((far_m - 20.0).clamp(-10.0, 200.0), far_m)
        });
        agree("half_width_m", &|view, half_width_m| view.half_width_m = half_width_m);
        agree("metres_per_pixel", &|view, scale| {
            view.metres_per_pixel = scale;
            (view.near_m, view.far_m) = (4.0, 4.0 + 20.0 * scale.max(0.05));
            view.half_width_m = 10.0 * scale.max(0.05);
        });
    }

    #[test]
    fn units_are_those_that_keys_end_in() {
        let said = |pointer| with(pointer, -1e6).unwrap_err().to_string();
        for (pointer, words) in [
            ("/vehicle/width_m", "vehicle.width_m = -1000000 cannot be used: give 0.3 to 6 metres"),
            ("/can/max_yaw_acceleration_deg_per_s2", "give 1 to 10000 degrees/s²"),
            ("/road_surface/bank/turning_per_m", "give 0 to 1000 per metre"),
            ("/road_surface/backprojection/hue_bins", "give 2 to 180 bins"),
            ("/road_surface/bank/frames", "give 1 to 1000 frames"),
            ("/lanes/canny_high", "give 8 to 1000 levels of the Sobel gradient"),
            ("/match/min_seen_share", "give 0 to 1"),
        ] {
            assert!(said(pointer).ends_with(words), "{}", said(pointer));
        }
    }
}
