//! Every number of a configuration with values that are none: refused by its key, or the method works with it within bounds.

// Functions shared by tests fail their test by unwrapping.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use fingerpost_vision::picture::RgbImage;
use toml::{Table, Value};

/// Memory that the method may take for an accepted configuration and a small camera, bytes.
const MOST_BYTES: u64 = 1_000_000_000;
/// Time that two frames may take on a loaded machine.
const MOST_TIME: Duration = Duration::from_secs(60);

const FLOATS: [f64; 11] = [
    0.0,
    -1.0,
    1e-300,
    1e300,
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    9_223_372_036_854_775_808.0,
    1e7,
    1e4,
    1e-3,
];
const INTEGERS: [i64; 9] = [0, -1, 1, i64::MIN, i64::MAX, 1 << 31, 1 << 32, 1_000_000, 10_000];

/// The paths of all numbers in a table.
fn numbers(table: &Table, path: &[String], found: &mut Vec<Vec<String>>) {
    for (key, value) in table {
        let path = [path, std::slice::from_ref(key)].concat();
        match value {
            Value::Table(table) => numbers(table, &path, found),
            Value::Integer(_) | Value::Float(_) => found.push(path),
            _ => {}
        }
    }
}

/// The default configuration with these values.
fn with(changes: &[(Vec<String>, Value)]) -> String {
    let mut root = Value::try_from(Config::default()).unwrap();
    for (path, value) in changes {
        let place = path.iter().fold(&mut root, |place, key| place.get_mut(key.as_str()).unwrap());
        *place = value.clone();
    }
    toml::to_string(&root).unwrap()
}

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 100.0, fy: 100.0, cx: 79.5, cy: 59.5 };
    let mount = Mount { pitch_rad: 0.15, ..Mount::level(1.5) };
    Camera::calibrated(160, 120, intrinsics, Distortion::None, mount).unwrap()
}

fn frame() -> RgbImage {
    let mut frame = RgbImage::new(160, 120);
    for row in 0..120 {
        for (column, byte) in frame.row_mut(row).iter_mut().enumerate() {
            *byte = ((row * row + column * 5) % 200) as u8;
        }
    }
    frame
}

/// What a configuration leads to: refused with these words, or worked with.
fn outcome(text: &str) -> Result<(), String> {
    let config = Config::from_toml(text).map_err(|error| error.to_string())?;
    config.check().map_err(|error| error.to_string())?;
    let parts = fingerpost_papers::parts(&config).map_err(|error| error.to_string())?;
    let mut pipeline =
        Pipeline::with_parts(&config, &camera(), None, None, parts).map_err(|error| error.to_string())?;
    for _ in 0..2 {
        let sensors = Sensors { dt_s: Some(0.1), ..Sensors::default() };
        pipeline.step(&frame(), sensors, &mut |_| {}).map_err(|error| error.to_string())?;
    }
    Ok(())
}

/// What is wrong with the way that a configuration is taken, if anything.
fn fault(text: &str, keys: &[&str]) -> Option<String> {
    let began = Instant::now();
    let mut taken = None;
    let memory =
        allocation_counter::measure(|| taken = catch_unwind(AssertUnwindSafe(|| outcome(text))).ok());
    match taken {
        None => Some("it panics".to_owned()),
        Some(_) if memory.bytes_max > MOST_BYTES => {
            Some(format!("it takes {} MB", memory.bytes_max / 1_000_000))
        }
        Some(_) if began.elapsed() > MOST_TIME => Some(format!("it takes {:?}", began.elapsed())),
        Some(Err(message)) if !keys.iter().any(|key| message.contains(key)) => {
            Some(format!("its key is not named: {message}"))
        }
        Some(Err(message)) if message.len() > 600 => Some(format!("its message is long: {message}")),
        Some(_) => None,
    }
}

#[test]
fn every_number_is_refused_by_its_key_or_worked_with() {
    let root = Table::try_from(Config::default()).unwrap();
    let mut paths = Vec::new();
    numbers(&root, &[], &mut paths);
    assert!(paths.len() > 60, "{} numbers", paths.len());
    let mut faults = Vec::new();
    for path in &paths {
        let value = path.iter().skip(1).fold(root.get(&path[0]).unwrap(), |value, key| &value[key.as_str()]);
        let values: Vec<Value> = match value {
            Value::Integer(_) => INTEGERS.map(Value::Integer).to_vec(),
            _ => FLOATS.map(Value::Float).to_vec(),
        };
        for value in values {
            let text = with(&[(path.clone(), value.clone())]);
            if let Some(fault) = fault(&text, &[path.last().unwrap()]) {
                faults.push(format!("{} = {value}: {fault}", path.join(".")));
            }
        }
    }
    assert!(faults.is_empty(), "{} faults:\n{}", faults.len(), faults.join("\n"));
}
