//! ROS `camera_info` and OpenCV calibration YAML.
//!
//! The two differ in key names and in how they name the distortion model; both count pixels from the centre of the
//! top-left one, as this project does. References: ROS `sensor_msgs/CameraInfo`, OpenCV `FileStorage` as written by its
//! calibration samples.
//!
//! Limits: skew, the rectification and projection matrices, and OpenCV's thin-prism and tilt coefficients are not used;
//! a file in which the latter are not zero is refused.

use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
use yaml_rust2::{Event, Yaml, YamlLoader, parser::Parser, yaml::Hash};

use crate::{CameraFileError, camera_file::MountTable, camera_info};

/// Names of the camera matrix, ROS's first.
const MATRIX_KEYS: &[&str] = &["camera_matrix", "Camera_Matrix", "cameraMatrix", "K"];
/// Names of the distortion coefficients, ROS's first.
const COEFFICIENT_KEYS: &[&str] =
    &["distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs", "D"];
/// Names of the picture's width, ROS's first.
const WIDTH_KEYS: &[&str] = &["image_width", "image_Width", "width"];
/// Names of the picture's height, ROS's first.
const HEIGHT_KEYS: &[&str] = &["image_height", "image_Height", "height"];
/// Names of width and height as one list.
const SIZE_KEYS: &[&str] = &["imageSize", "image_size"];
/// Bytes of a calibration: calibration programs write two thousand, with every picture's corners a hundred thousand.
const MOST_BYTES: usize = 1 << 20;
/// Lists and mappings within each other: a matrix by rows has three.
const MOST_DEPTH: usize = 16;

/// The camera of a ROS `camera_info` or OpenCV `FileStorage` YAML.
///
/// Neither kind knows a mount: it is given beside the text, or as a mapping `mount:` in it with the keys of
/// `camera.toml`; the one given goes first.
///
/// # Errors
/// [`CameraFileError`] when the text is neither kind, has no mount, or its numbers cannot be right.
///
/// ```
/// let text = "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, \
///             0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {data: [0.1, 0, 0, 0, 0]}\n\
///             mount: {height_m: 1.5}\n";
/// assert_eq!(fingerpost_format::camera_from_yaml(text, None).unwrap().width(), 640);
/// ```
pub fn camera_from_yaml(text: &str, mount: Option<Mount>) -> Result<Camera, CameraFileError> {
    let root = mapping(text)?;
    let (width, height) = size(&root)?;
    let matrix = numbers_at(&root, MATRIX_KEYS)?.ok_or_else(|| missing(MATRIX_KEYS))?;
    let [fx, _, cx, _, fy, cy, _, _, _] = matrix[..] else {
        return Err(parse_error(format!("the camera matrix needs 9 numbers, {} were found", matrix.len())));
    };
    let mount = match mount {
        Some(mount) => mount,
        None => own_mount(&root)?.ok_or(CameraFileError::NoMount)?,
    };
    Ok(Camera::calibrated(width, height, Intrinsics { fx, fy, cx, cy }, distortion(&root)?, mount)?)
}

/// The first document as a mapping.
fn mapping(text: &str) -> Result<Hash, CameraFileError> {
    if text.len() > MOST_BYTES {
        let cause = format!("it has {} bytes, more than the {MOST_BYTES} of any calibration", text.len());
        return Err(parse_error(cause));
    }
    // OpenCV's first line, `%YAML:1.0`, is no directive that YAML knows.
    let body: Vec<&str> = text.lines().filter(|line| !line.starts_with('%')).collect();
    let body = body.join("\n");
    check_structure(&body)?;
    let documents = YamlLoader::load_from_str(&body).map_err(|cause| parse_error(cause.to_string()))?;
    match documents.into_iter().next() {
        Some(Yaml::Hash(root)) => Ok(root),
        _ => Err(parse_error("there is no mapping of keys to values in it".to_owned())),
    }
}

/// Refuses what makes a tree larger or deeper than its text: aliases, which no calibration program writes and which copy what
/// they stand for, and collections within collections without end. Events come one by one and hold neither.
fn check_structure(text: &str) -> Result<(), CameraFileError> {
    let mut parser = Parser::new_from_str(text);
    let mut depth = 0_usize;
    loop {
        let (event, _) = parser.next_token().map_err(|cause| parse_error(cause.to_string()))?;
        match event {
            Event::StreamEnd => return Ok(()),
            Event::Alias(_) => {
                return Err(parse_error("it has an alias (*); write what it stands for".to_owned()));
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => depth += 1,
            Event::SequenceEnd | Event::MappingEnd => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth > MOST_DEPTH {
            let cause = format!("it has more than {MOST_DEPTH} lists and mappings within each other");
            return Err(parse_error(cause));
        }
    }
}

fn size(root: &Hash) -> Result<(usize, usize), CameraFileError> {
    let sides = match numbers_at(root, SIZE_KEYS)? {
        Some(sides) => sides,
        None => [WIDTH_KEYS, HEIGHT_KEYS]
            .into_iter()
            .map(|keys| numbers_at(root, keys)?.ok_or_else(|| missing(keys)))
            .collect::<Result<Vec<_>, _>>()?
            .concat(),
    };
    match sides[..] {
        // Truncation of what is no whole number of pixels, and zero for what is none, end in the camera's own check.
        [width, height] => Ok((width as usize, height as usize)),
        _ => Err(parse_error("the picture's size needs a width and a height".to_owned())),
    }
}

fn distortion(root: &Hash) -> Result<Distortion, CameraFileError> {
    let coefficients = numbers_at(root, COEFFICIENT_KEYS)?.unwrap_or_default();
    let is_fisheye =
        numbers_at(root, &["fisheye_model"])?.is_some_and(|flag| flag.iter().any(|flag| *flag > 0.5));
    let model = match value_at(root, &["distortion_model"]) {
        Some(Yaml::String(model)) => model.as_str(),
        Some(_) => return Err(parse_error("distortion_model must be a word".to_owned())),
        None if is_fisheye => "equidistant",
        None => "plumb_bob",
    };
    camera_info::distortion(model, &coefficients)
}

fn own_mount(root: &Hash) -> Result<Option<Mount>, CameraFileError> {
    let Some(mount) = value_at(root, &["mount"]) else {
        return Ok(None);
    };
    let pairs = mount.as_hash().ok_or_else(|| parse_error("`mount` must be a mapping".to_owned()))?;
    let mut table = toml::Table::new();
    for (key, value) in pairs {
        let key = key.as_str().ok_or_else(|| parse_error("a key in `mount` is no word".to_owned()))?;
        table.insert(key.to_owned(), toml::Value::Float(number(value, key)?));
    }
    let table: MountTable =
        table.try_into().map_err(|cause: toml::de::Error| parse_error(cause.to_string()))?;
    Ok(Some(Mount::from(table)))
}

fn value_at<'a>(root: &'a Hash, keys: &[&str]) -> Option<&'a Yaml> {
    keys.iter().find_map(|key| root.get(&Yaml::String((*key).to_owned())))
}

/// The numbers under the first of `keys` that is there: one number, a list, a list of lists, or a matrix with `data`.
fn numbers_at(root: &Hash, keys: &[&str]) -> Result<Option<Vec<f64>>, CameraFileError> {
    let Some(value) = value_at(root, keys) else {
        return Ok(None);
    };
    let name = keys.first().copied().unwrap_or_default();
    let mut numbers = Vec::new();
    match value {
        Yaml::Hash(matrix) => {
            let data =
                value_at(matrix, &["data"]).ok_or_else(|| parse_error(format!("`{name}` has no `data`")))?;
            collect_numbers(data, name, &mut numbers)?;
        }
        value => collect_numbers(value, name, &mut numbers)?,
    }
    Ok(Some(numbers))
}

fn collect_numbers(value: &Yaml, name: &str, into: &mut Vec<f64>) -> Result<(), CameraFileError> {
    match value {
        Yaml::Array(items) => items.iter().try_for_each(|item| collect_numbers(item, name, into)),
        value => number(value, name).map(|number| into.push(number)),
    }
}

fn number(value: &Yaml, name: &str) -> Result<f64, CameraFileError> {
    match value {
        Yaml::Integer(integer) => Ok(*integer as f64),
        value => {
            value.as_f64().ok_or_else(|| parse_error(format!("`{name}` holds something that is no number")))
        }
    }
}

fn missing(keys: &[&str]) -> CameraFileError {
    parse_error(format!("there is none of the keys {}", keys.join(", ")))
}

fn parse_error(cause: String) -> CameraFileError {
    CameraFileError::Parse { cause }
}
