//! ROS `camera_info` and OpenCV calibration YAML.
//!
//! The two differ in key names and in how they name the distortion model; both count pixels from the centre of the
//! top-left one, as this project does. References: ROS `sensor_msgs/CameraInfo`, OpenCV `FileStorage` as written by its
//! calibration samples.
//!
//! Kalibr's camera chains (`camN:` with `intrinsics`, `distortion_coeffs`, `distortion_model`, `resolution`) and messages that
//! `ros2 topic echo` printed are read as well.
//!
//! Limits: the rectification and projection matrices are not used; skew, a picture cut to a region, camera models other than
//! pinhole, and OpenCV's thin-prism and tilt coefficients other than zero are refused. What may describe a lens and is not
//! known is refused, other unknown keys are remarked on.

mod keys;

use fingerpost_geometry::Mount;
use yaml_rust2::{Event, Yaml, YamlLoader, parser::Parser, yaml::Hash};

use self::keys::Key;
use crate::{
    CameraFileError, CameraInfo, CameraRemark, PictureKind, ReadCamera, camera_file::MountTable,
    camera_info::KANNALA_BRANDT_NAMES,
};

/// Bytes of a calibration: calibration programs write two thousand, with every picture's corners a hundred thousand.
const MOST_BYTES: usize = 1 << 20;
/// Lists and mappings within each other: a matrix by rows has three.
const MOST_DEPTH: usize = 16;

/// The camera of a ROS `camera_info`, OpenCV `FileStorage` or Kalibr YAML, with what must be known of how it was understood.
///
/// No kind knows a mount: it is given beside the text, or as a mapping `mount:` in it with the keys of
/// `camera.toml`; the one given goes first.
///
/// # Errors
/// [`CameraFileError`] when the text is neither kind, has no mount, or its numbers cannot be right.
///
/// ```
/// let text = "image_width: 640\nimage_height: 480\ncamera_matrix: {rows: 3, cols: 3, data: [500, 0, 320, 0, 500, 240, \
///             0, 0, 1]}\ndistortion_model: plumb_bob\ndistortion_coefficients: {data: [0.1, 0, 0, 0, 0]}\n\
///             mount: {height_m: 1.5}\n";
/// let read = fingerpost_format::camera_from_yaml(text, None).unwrap();
/// assert_eq!((read.camera.width(), read.remarks), (640, Vec::new()));
/// ```
pub fn camera_from_yaml(text: &str, mount: Option<Mount>) -> Result<ReadCamera, CameraFileError> {
    let (root, documents) = first_mapping(text)?;
    let (calibration, chosen) = one_of_chain(&root)?;
    let mount = match mount {
        Some(mount) => mount,
        None => own_mount(&root)?.or(own_mount(calibration)?).ok_or(CameraFileError::NoMount)?,
    };
    check_whole_picture(calibration)?;
    check_camera_model(calibration)?;
    let (width, height) = size(calibration)?;
    let unknown = keys::unknown(calibration);
    let (lens, others): (Vec<&str>, Vec<&str>) = unknown.into_iter().partition(|key| keys::is_of_lens(key));
    if !lens.is_empty() {
        return Err(CameraFileError::NotUnderstood { keys: format!("`{}`", lens.join("`, `")) });
    }
    let (distortion_model, distortion) = distortion(calibration)?;
    let matrix = matrix(calibration)?;
    let info = CameraInfo { width, height, distortion_model, distortion, matrix, projection: [0.0; 12] };
    let mut read = info.camera(PictureKind::AsTaken, mount)?;
    read.remarks.extend(chosen);
    if !others.is_empty() {
        let keys = others.into_iter().map(str::to_owned).collect();
        read.remarks.push(CameraRemark::UnknownKeys { keys });
    }
    if documents > 1 {
        read.remarks.push(CameraRemark::FirstDocument { count: documents });
    }
    Ok(read)
}

/// The first document as a mapping, and how many hold something.
fn first_mapping(text: &str) -> Result<(Hash, usize), CameraFileError> {
    if text.len() > MOST_BYTES {
        let cause = format!("it has {} bytes, more than the {MOST_BYTES} of any calibration", text.len());
        return Err(parse_error(cause));
    }
    // OpenCV's first line, `%YAML:1.0`, is no directive that YAML knows.
    let body: Vec<&str> = text.lines().filter(|line| !line.starts_with('%')).collect();
    let body = body.join("\n");
    check_structure(&body)?;
    let documents = YamlLoader::load_from_str(&body).map_err(|cause| parse_error(cause.to_string()))?;
    let count = documents.iter().filter(|document| !document.is_null()).count();
    match documents.into_iter().next() {
        Some(Yaml::Hash(root)) => Ok((root, count)),
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

/// The calibration in a file: the file's own mapping, or of Kalibr's chain of cameras the first, with the names of the others.
fn one_of_chain(root: &Hash) -> Result<(&Hash, Option<CameraRemark>), CameraFileError> {
    let mut cameras: Vec<(&str, &Yaml)> = root
        .iter()
        .filter_map(|(key, value)| Some((key.as_str()?, value)))
        .filter(|(key, _)| keys::is_camera_of_chain(key))
        .collect();
    cameras.sort_by_key(|(key, _)| (key.len(), *key));
    let Some(((used, calibration), others)) = cameras.split_first() else { return Ok((root, None)) };
    let calibration =
        calibration.as_hash().ok_or_else(|| parse_error(format!("`{used}` must be a mapping")))?;
    let others: Vec<String> = others.iter().map(|(key, _)| (*key).to_owned()).collect();
    let remark = CameraRemark::OneOfSeveral { used: (*used).to_owned(), others: others.clone() };
    Ok((calibration, (!others.is_empty()).then_some(remark)))
}

/// Refuses the calibration of a picture that was binned or cut, as messages of ROS describe it.
fn check_whole_picture(root: &Hash) -> Result<(), CameraFileError> {
    for key in ["binning_x", "binning_y"] {
        let sides = value_at(root, &[key]).map_or(Ok(1.0), |value| number(value, key))?;
        if sides > 1.0 {
            return Err(CameraFileError::PartOfPicture { key });
        }
    }
    let region = match value_at(root, &["roi"]) {
        None | Some(Yaml::Null) => return Ok(()),
        Some(Yaml::Hash(region)) if region.keys().all(|key| key.as_str().is_some_and(keys::is_of_region)) => {
            region
        }
        Some(_) => {
            let keys = keys::OF_REGION.join(", ");
            return Err(parse_error(format!(
                "`roi` must be a mapping of {keys}; delete it if the picture is whole"
            )));
        }
    };
    let side = |key: &str| value_at(region, &[key]).map_or(Ok(0.0), |value| number(value, key));
    let offset = [side("x_offset")?, side("y_offset")?];
    let region_px = [side("width")?, side("height")?];
    let (width, height) = size(root)?;
    let of_no_size = region_px.iter().all(|side| side.abs() < 1.0);
    // A region of no size is the whole picture.
    let is_whole = of_no_size || region_px.map(|side| side as usize) == [width, height];
    if !offset.iter().all(|start| start.abs() < 1.0) || !is_whole {
        return Err(CameraFileError::PartOfPicture { key: "roi" });
    }
    Ok(())
}

/// Refuses what Kalibr calibrates as another camera than a pinhole: `omni`, `eucm`, `ds`.
fn check_camera_model(root: &Hash) -> Result<(), CameraFileError> {
    match value_at(root, &["camera_model"]) {
        None => Ok(()),
        Some(Yaml::String(model)) if model == "pinhole" => Ok(()),
        Some(Yaml::String(model)) => Err(CameraFileError::UnknownCameraModel { model: model.clone() }),
        Some(_) => Err(parse_error("camera_model must be a word".to_owned())),
    }
}

fn size(root: &Hash) -> Result<(usize, usize), CameraFileError> {
    let sides = match numbers_of(root, Key::Size)? {
        Some(sides) => sides,
        None => [Key::Width, Key::Height]
            .into_iter()
            .map(|key| numbers_of(root, key)?.ok_or_else(|| missing(&[key])))
            .collect::<Result<Vec<_>, _>>()?
            .concat(),
    };
    match sides[..] {
        // Truncation of what is no whole number of pixels, and zero for what is none, end in the camera's own check.
        [width, height] => Ok((width as usize, height as usize)),
        _ => Err(parse_error("the picture's size needs a width and a height".to_owned())),
    }
}

/// The camera matrix by rows, or Kalibr's two focal lengths with the principal point as one.
fn matrix(root: &Hash) -> Result<[f64; 9], CameraFileError> {
    if let Some(numbers) = numbers_of(root, Key::Matrix)? {
        let count = numbers.len();
        let wrong = |_| parse_error(format!("the camera matrix needs 9 numbers, {count} were found"));
        return numbers.try_into().map_err(wrong);
    }
    let numbers =
        numbers_of(root, Key::Intrinsics)?.ok_or_else(|| missing(&[Key::Matrix, Key::Intrinsics]))?;
    let [fx, fy, cx, cy] = numbers[..] else {
        let count = numbers.len();
        return Err(parse_error(format!("`intrinsics` needs fx, fy, cx, cy; {count} numbers were found")));
    };
    Ok([fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0])
}

/// Model and coefficients; empty where the file says nothing of a lens.
fn distortion(root: &Hash) -> Result<(String, Vec<f64>), CameraFileError> {
    let coefficients = numbers_of(root, Key::Coefficients)?;
    let is_fisheye = match value_at(root, &["fisheye_model"]) {
        None | Some(Yaml::Null) => None,
        Some(Yaml::Integer(0) | Yaml::Boolean(false)) => Some(false),
        Some(Yaml::Integer(1) | Yaml::Boolean(true)) => Some(true),
        Some(_) => return Err(parse_error("fisheye_model must be 0 or 1".to_owned())),
    };
    let model = match value_at(root, &["distortion_model"]) {
        Some(Yaml::String(model)) => Some(model.as_str()),
        Some(Yaml::Null) | None => (is_fisheye == Some(true)).then_some("equidistant"),
        Some(_) => return Err(parse_error("distortion_model must be a word".to_owned())),
    };
    // Where both are there, one of them says which lens the coefficients are of.
    if let (Some(is_fisheye), Some(model)) = (is_fisheye, model)
        && is_fisheye != KANNALA_BRANDT_NAMES.contains(&model)
    {
        let (first, second) = ("fisheye_model".to_owned(), "distortion_model".to_owned());
        return Err(CameraFileError::Contradiction { first, second });
    }
    match (model, coefficients) {
        (None, None) => Ok((String::new(), Vec::new())),
        // OpenCV names no model; these are the coefficients of its calibration.
        (None, Some(coefficients)) => Ok(("plumb_bob".to_owned(), coefficients)),
        (Some(model), Some(coefficients)) => Ok((model.to_owned(), coefficients)),
        (Some(model @ ("none" | "")), None) => Ok((model.to_owned(), Vec::new())),
        (Some(model), None) => Err(CameraFileError::CoefficientsMissing { model: model.to_owned() }),
    }
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

/// The numbers under the key of such a meaning: one number, a list, a list of lists, or a matrix with `data`.
fn numbers_of(root: &Hash, meaning: Key) -> Result<Option<Vec<f64>>, CameraFileError> {
    let mut found: Option<(&str, Vec<f64>)> = None;
    for (name, value) in root.iter().filter_map(|(key, value)| Some((key.as_str()?, value))) {
        if Key::named(name) != Some(meaning) {
            continue;
        }
        let numbers = numbers(value, name)?;
        match &found {
            Some((first, others)) if *others != numbers => {
                let (first, second) = ((*first).to_owned(), name.to_owned());
                return Err(CameraFileError::Contradiction { first, second });
            }
            Some(_) => {}
            None => found = Some((name, numbers)),
        }
    }
    Ok(found.map(|(_, numbers)| numbers))
}

fn numbers(value: &Yaml, name: &str) -> Result<Vec<f64>, CameraFileError> {
    let mut numbers = Vec::new();
    match value {
        Yaml::Hash(matrix) => {
            let data =
                value_at(matrix, &["data"]).ok_or_else(|| parse_error(format!("`{name}` has no `data`")))?;
            collect_numbers(data, name, &mut numbers)?;
        }
        value => collect_numbers(value, name, &mut numbers)?,
    }
    Ok(numbers)
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

fn missing(keys: &[Key]) -> CameraFileError {
    let names: Vec<&str> = keys.iter().flat_map(|key| key.names()).copied().collect();
    parse_error(format!("there is none of the keys {}", names.join(", ")))
}

fn parse_error(cause: String) -> CameraFileError {
    CameraFileError::Parse { cause }
}
