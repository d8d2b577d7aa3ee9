//! `camera.toml`: a camera's lens and mount, or four points on the road.

use fingerpost_geometry::{Camera, Distortion, GeometryError, Intrinsics, Mount, Pixel, View};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use thiserror::Error;

/// A calibration file that cannot be used.
#[derive(Debug, Error)]
pub enum CameraFileError {
    /// The text is no TOML or YAML, or a key is missing, misspelt or of the wrong type.
    #[error("the calibration cannot be read: {cause}; the book has every key, under \"camera.toml\"")]
    Parse {
        /// What the parser says.
        cause: String,
    },
    /// A table is missing.
    #[error(
        "the calibration has {found}; give [intrinsics] and [mount], or [points] with four picture points and \
         their places on the road"
    )]
    Incomplete {
        /// What was found.
        found: &'static str,
    },
    /// The distortion model is unknown.
    #[error("distortion model {model:?} is unknown; use {known}")]
    UnknownDistortion {
        /// The model found.
        model: String,
        /// The models that this kind of file may name.
        known: &'static str,
    },
    /// There are coefficients and no model whose they could be.
    #[error(
        "there are {count} coefficients of a lens and no model to which they belong; name it as distortion_model"
    )]
    NoModel {
        /// How many.
        count: usize,
    },
    /// A model is named, and its coefficients are nowhere.
    #[error(
        "distortion model {model:?} is named and its coefficients are not there; give them as distortion_coefficients, or \
         distortion_model: none for pictures that are rectified"
    )]
    CoefficientsMissing {
        /// The model named.
        model: String,
    },
    /// The camera's own model is none that is computed with.
    #[error(
        "camera model {model:?} is not known here, only a pinhole with a lens; calibrate it as pinhole-equi or pinhole-radtan"
    )]
    UnknownCameraModel {
        /// The model found.
        model: String,
    },
    /// Keys decide what the camera is and nobody knows how.
    #[error(
        "{keys} may describe the lens, and what it means is not known; write it as distortion_model and distortion_coefficients, \
         or delete it if it has nothing to say"
    )]
    NotUnderstood {
        /// The keys.
        keys: String,
    },
    /// Two keys that mean the same say different things.
    #[error("`{first}` and `{second}` mean the same and differ; delete the one that is wrong")]
    Contradiction {
        /// The one key.
        first: String,
        /// The other.
        second: String,
    },
    /// Rows and columns of the camera's pixels are not at right angles.
    #[error(
        "the camera matrix has a skew of {skew_px} pixels, which is not computed with; calibrate again with the skew fixed at zero"
    )]
    Skew {
        /// Element (0, 1) of the matrix, pixels.
        skew_px: f64,
    },
    /// A matrix that is no camera's.
    #[error(
        "the camera matrix {matrix:?} is not [fx, 0, cx, 0, fy, cy, 0, 0, 1] by rows; write it so, in pixels"
    )]
    Matrix {
        /// Its elements by rows.
        matrix: [f64; 9],
    },
    /// It is that of another picture than the camera's whole one.
    #[error(
        "the calibration is that of a picture that was binned or cut to a region (`{key}`); give the calibration of the pictures \
         as they are"
    )]
    PartOfPicture {
        /// The key that says so.
        key: &'static str,
    },
    /// A YAML calibration comes without the camera's place on the vehicle.
    #[error(
        "the calibration does not say where the camera sits on the vehicle; add a mapping `mount:` with height_m and, \
         where they are not zero, pitch_deg, yaw_deg, roll_deg, x_m, y_m"
    )]
    NoMount,
    /// The numbers cannot be right.
    #[error("the calibration cannot be right: {0}")]
    Geometry(#[from] GeometryError),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CameraFile {
    image: ImageTable,
    #[serde(skip_serializing_if = "Option::is_none")]
    intrinsics: Option<IntrinsicsTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    distortion: Option<DistortionTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    mount: Option<MountTable>,
    #[serde(skip_serializing_if = "Option::is_none")]
    points: Option<PointsTable>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ImageTable {
    width: usize,
    height: usize,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct IntrinsicsTable {
    fx: f64,
    fy: f64,
    cx: f64,
    cy: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DistortionTable {
    model: String,
    #[serde(default)]
    coefficients: Vec<f64>,
}

/// A mount as files state it: degrees, and zero for all but the height unless stated.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct MountTable {
    height_m: f64,
    #[serde(default)]
    pitch_deg: f64,
    #[serde(default)]
    yaw_deg: f64,
    #[serde(default)]
    roll_deg: f64,
    #[serde(default)]
    x_m: f64,
    #[serde(default)]
    y_m: f64,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct PointsTable {
    image_px: [[f64; 2]; 4],
    road_m: [[f64; 2]; 4],
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MountFile {
    mount: MountTable,
}

/// The camera of a `camera.toml`: `[image]` with `[intrinsics]`, `[mount]` and optionally `[distortion]`, or `[image]`
/// with `[points]`.
///
/// # Errors
/// [`CameraFileError`] when the text is no such file or its numbers cannot be right.
///
/// ```
/// let camera = fingerpost_format::camera_from_toml(
///     "[image]\nwidth = 640\nheight = 480\n\
///      [intrinsics]\nfx = 500.0\nfy = 500.0\ncx = 319.5\ncy = 239.5\n\
///      [mount]\nheight_m = 1.5\npitch_deg = 2.0\n",
/// ).unwrap();
/// assert_eq!(camera.width(), 640);
/// ```
pub fn camera_from_toml(text: &str) -> Result<Camera, CameraFileError> {
    let file: CameraFile =
        toml::from_str(text).map_err(|cause| CameraFileError::Parse { cause: cause.to_string() })?;
    let (width, height) = (file.image.width, file.image.height);
    match (file.intrinsics, file.mount, file.points) {
        (Some(k), Some(mount), None) => {
            let intrinsics = Intrinsics { fx: k.fx, fy: k.fy, cx: k.cx, cy: k.cy };
            let distortion = match file.distortion {
                None => Distortion::None,
                Some(table) => distortion_of(&table.model, &table.coefficients)?,
            };
            Ok(Camera::calibrated(width, height, intrinsics, distortion, Mount::from(mount))?)
        }
        (None, None, Some(points)) => {
            let image = points.image_px.map(|[u, v]| Pixel::new(u, v));
            Ok(Camera::from_points(width, height, image, points.road_m.map(|[x, y]| Point2::new(x, y)))?)
        }
        (Some(_), None, None) => Err(CameraFileError::Incomplete { found: "[intrinsics] but no [mount]" }),
        (None, Some(_), None) => Err(CameraFileError::Incomplete { found: "[mount] but no [intrinsics]" }),
        (None, None, None) => Err(CameraFileError::Incomplete { found: "neither [intrinsics] nor [points]" }),
        (_, _, Some(_)) => {
            Err(CameraFileError::Incomplete { found: "[points] beside a calibrated lens or mount" })
        }
    }
}

/// The mount of a text with the table `[mount]` alone, as it stands beside calibrations that have none.
///
/// # Errors
/// [`CameraFileError`] when the text is no such table or its numbers cannot be right.
///
/// ```
/// let mount = fingerpost_format::mount_from_toml("[mount]\nheight_m = 1.5\npitch_deg = 2.0\n").unwrap();
/// assert!((mount.pitch_rad - 2.0_f64.to_radians()).abs() < 1e-12);
/// ```
pub fn mount_from_toml(text: &str) -> Result<Mount, CameraFileError> {
    let file: MountFile =
        toml::from_str(text).map_err(|cause| CameraFileError::Parse { cause: cause.to_string() })?;
    let mount = Mount::from(file.mount);
    mount.check()?;
    Ok(mount)
}

/// The `camera.toml` of a calibrated camera; one known by points does not keep them.
///
/// # Errors
/// [`CameraFileError::Parse`] when the numbers have no TOML form, [`CameraFileError::Incomplete`] for a camera known
/// by points.
pub fn camera_to_toml(camera: &Camera) -> Result<String, CameraFileError> {
    let View::Calibrated { intrinsics, distortion, mount, .. } = camera.view() else {
        return Err(CameraFileError::Incomplete {
            found: "a camera known by points, which has no calibration",
        });
    };
    let (model, coefficients) = match distortion {
        Distortion::None => ("none", Vec::new()),
        Distortion::BrownConrady { coefficients, .. } => ("brown-conrady", coefficients.to_vec()),
        Distortion::KannalaBrandt { coefficients, .. } => ("kannala-brandt", coefficients.to_vec()),
    };
    let file = CameraFile {
        image: ImageTable { width: camera.width(), height: camera.height() },
        intrinsics: Some(IntrinsicsTable {
            fx: intrinsics.fx,
            fy: intrinsics.fy,
            cx: intrinsics.cx,
            cy: intrinsics.cy,
        }),
        distortion: Some(DistortionTable { model: model.to_owned(), coefficients }),
        mount: Some(MountTable {
            height_m: mount.height_m,
            pitch_deg: mount.pitch_rad.to_degrees(),
            yaw_deg: mount.yaw_rad.to_degrees(),
            roll_deg: mount.roll_rad.to_degrees(),
            x_m: mount.x_m,
            y_m: mount.y_m,
        }),
        points: None,
    };
    toml::to_string(&file).map_err(|cause| CameraFileError::Parse { cause: cause.to_string() })
}

/// The `camera.toml` of a camera known by four picture points, pixels, and their places on the road, vehicle frame, metres.
///
/// # Errors
/// [`CameraFileError::Geometry`] when they do not define a road seen from above, [`CameraFileError::Parse`] when the numbers
/// have no TOML form.
pub fn points_to_toml(
    (width, height): (usize, usize),
    image: [Pixel; 4],
    road_m: [Point2<f64>; 4],
) -> Result<String, CameraFileError> {
    Camera::from_points(width, height, image, road_m)?;
    let file = CameraFile {
        image: ImageTable { width, height },
        intrinsics: None,
        distortion: None,
        mount: None,
        points: Some(PointsTable {
            image_px: image.map(|pixel| [pixel.u, pixel.v]),
            road_m: road_m.map(|place| [place.x, place.y]),
        }),
    };
    toml::to_string(&file).map_err(|cause| CameraFileError::Parse { cause: cause.to_string() })
}

/// Whether a text is a `camera.toml` as [`camera_to_toml`] and [`points_to_toml`] write it, but for blank lines at its end: not by
/// hand, nor with comments that would be lost.
pub fn is_written_camera(text: &str) -> bool {
    let written = toml::from_str::<CameraFile>(text).ok().and_then(|file| toml::to_string(&file).ok());
    camera_from_toml(text).is_ok() && written.is_some_and(|written| written.trim_end() == text.trim_end())
}

fn distortion_of(model: &str, coefficients: &[f64]) -> Result<Distortion, CameraFileError> {
    match model {
        "none" => Ok(Distortion::None),
        "brown-conrady" => Ok(Distortion::brown_conrady(coefficients)?),
        "kannala-brandt" => Ok(Distortion::kannala_brandt(coefficients)?),
        other => Err(CameraFileError::UnknownDistortion {
            model: other.to_owned(),
            known: "\"none\", \"brown-conrady\" or \"kannala-brandt\"",
        }),
    }
}

impl From<MountTable> for Mount {
    fn from(table: MountTable) -> Self {
        Self {
            height_m: table.height_m,
            pitch_rad: table.pitch_deg.to_radians(),
            yaw_rad: table.yaw_deg.to_radians(),
            roll_rad: table.roll_deg.to_radians(),
            x_m: table.x_m,
            y_m: table.y_m,
        }
    }
}
