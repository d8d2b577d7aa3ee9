//! A search of settings that is asked for trials and told what came of them; what spreads the trials is `fingerpost/fleet.py`.

use fingerpost::Config;
use fingerpost_search::{Nsga2, Scale, SearchOptions, Variable, fronts};
use pyo3::prelude::*;
use serde_json::{Map, Value};

use crate::errors::{ConfigError, chain, exception};
use crate::json;

/// NSGA-II over numbers of the configuration.
#[pyclass(module = "fingerpost")]
pub(crate) struct Search {
    keys: Vec<Key>,
    /// The settings that the search begins with, as a table of tables.
    base: Value,
    search: Nsga2,
}

struct Key {
    name: String,
    is_whole: bool,
}

#[pymethods]
impl Search {
    /// Each key with its range, `(name, least, most)`.
    #[new]
    #[pyo3(signature = (keys, *, config=None, population=10, seed=1))]
    fn new(
        keys: Vec<(String, f64, f64)>,
        config: Option<&str>,
        population: usize,
        seed: u64,
    ) -> PyResult<Self> {
        let config =
            config.map_or(Ok(Config::default()), Config::from_toml).map_err(exception!(ConfigError))?;
        config.check().map_err(exception!(ConfigError))?;
        let base = config.to_json();
        let mut known: Vec<Key> = Vec::with_capacity(keys.len());
        let (mut variables, mut start) = (Vec::new(), Vec::new());
        for (name, least, most) in keys {
            let refused = |cause: String| ConfigError::new_err(format!("{name}: {cause}"));
            let number = base.pointer(&pointer(&name)).and_then(Value::as_f64);
            let (Some(number), Some(declared)) = (number, declaration(&name)) else {
                return Err(refused(
                    "there is no number of that name among the settings; config_schema() has them all"
                        .to_owned(),
                ));
            };
            if name.starts_with("vehicle.") {
                return Err(refused(
                    "the vehicle of each drive is known, not searched; leave it out".to_owned(),
                ));
            }
            let allowed = declared["minimum"].as_f64().zip(declared["maximum"].as_f64());
            if let Some((lowest, highest)) =
                allowed.filter(|(lowest, highest)| least < *lowest || most > *highest)
            {
                return Err(refused(format!(
                    "{least} to {most} reaches beyond {lowest} to {highest}; give a range within"
                )));
            }
            let is_whole = declared["type"] == "integer";
            let scale = if least > 0.0 { Scale::Logarithmic } else { Scale::Linear };
            let variable = if is_whole {
                Variable::whole(least.ceil() as i32, most.floor() as i32, scale)
            } else {
                Variable::real(least, most, scale)
            };
            variables.push(variable.map_err(|cause| refused(chain(&cause)))?);
            start.push(number);
            known.push(Key { name, is_whole });
        }
        let search = Nsga2::new(variables, &start, SearchOptions { population, seed })
            .map_err(exception!(ConfigError))?;
        Ok(Self { keys: known, base, search })
    }

    /// The next generation: of each trial its values by their keys, and the whole configuration as TOML.
    fn ask<'py>(&mut self, py: Python<'py>) -> PyResult<Vec<(Bound<'py, PyAny>, String)>> {
        let Self { keys, base, search } = self;
        let points = search.ask(&|values| config(keys, base, values).is_some());
        let trial = |values: &Vec<f64>| {
            let config = config(keys, base, values)
                .ok_or_else(|| ConfigError::new_err("the settings contradict each other"))?;
            let named: Map<String, Value> =
                keys.iter().zip(values).map(|(key, &value)| (key.name.clone(), key.json(value))).collect();
            Ok((json::to_python(py, &named)?, config.to_toml().map_err(exception!(ConfigError))?))
        };
        points.iter().map(trial).collect()
    }

    /// Takes in what came of them, in their order; everything is to be small.
    fn tell(&mut self, objectives: Vec<Vec<f64>>) -> PyResult<()> {
        self.search.tell(objectives).map_err(exception!(ConfigError))
    }
}

impl Key {
    fn json(&self, value: f64) -> Value {
        if self.is_whole { (value as i64).into() } else { value.into() }
    }
}

/// All settings with these among them; none where they contradict each other.
fn config(keys: &[Key], base: &Value, values: &[f64]) -> Option<Config> {
    let mut json = base.clone();
    for (key, &value) in keys.iter().zip(values) {
        *json.pointer_mut(&pointer(&key.name))? = key.json(value);
    }
    let config = Config::from_json(json).ok()?;
    config.check().is_ok().then_some(config)
}

/// Where a key's value stands in the settings as JSON.
fn pointer(key: &str) -> String {
    format!("/{}", key.replace('.', "/"))
}

/// What the schema says of a key.
fn declaration(key: &str) -> Option<&'static Value> {
    key.split('.').try_fold(Config::schema(), |schema, name| schema.get("properties")?.get(name))
}

/// Which points no other beats in everything, by their numbers.
#[pyfunction]
pub(crate) fn front(objectives: Vec<Vec<f64>>) -> Vec<usize> {
    fronts(&objectives).into_iter().next().unwrap_or_default()
}
