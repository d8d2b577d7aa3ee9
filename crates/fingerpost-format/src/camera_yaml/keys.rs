//! What the keys of a calibration mean, however their programs spell them.
//!
//! Capitals, underscores and hyphens make no difference: OpenCV's samples alone write `camera_matrix`, `Camera_Matrix` and
//! `cameraMatrix`.

use yaml_rust2::{Yaml, yaml::Hash};

/// A key whose numbers are used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Key {
    /// The camera matrix.
    Matrix,
    /// Focal lengths and principal point.
    Intrinsics,
    /// The lens's coefficients.
    Coefficients,
    /// Width of the pictures.
    Width,
    /// Their height.
    Height,
    /// Both as one list.
    Size,
}

impl Key {
    const ALL: [Self; 6] =
        [Self::Matrix, Self::Intrinsics, Self::Coefficients, Self::Width, Self::Height, Self::Size];

    /// Its spellings, ROS's first.
    pub(super) const fn names(self) -> &'static [&'static str] {
        match self {
            Self::Matrix => &["camera_matrix", "K"],
            Self::Intrinsics => &["intrinsics"],
            Self::Coefficients => &[
                "distortion_coefficients",
                "distortion_coeffs",
                "distortion_coeff",
                "dist_coefficients",
                "dist_coeffs",
                "dist_coeff",
                "D",
            ],
            Self::Width => &["image_width", "width"],
            Self::Height => &["image_height", "height"],
            Self::Size => &["image_size", "resolution"],
        }
    }

    /// The meaning of a key.
    pub(super) fn named(name: &str) -> Option<Self> {
        let name = plain(name);
        Self::ALL.into_iter().find(|key| key.names().iter().any(|known| plain(known) == name))
    }
}

/// Keys whose values say nothing of how a picture as it was taken is computed with: whose camera it is, how it was calibrated, and
/// how its pictures are rectified or lie to other cameras.
const WITHOUT_EFFECT: &[&str] = &[
    // ROS
    "camera_name",
    "camera_id",
    "frame_id",
    "header",
    "rectification_matrix",
    "R",
    "projection_matrix",
    "P",
    // OpenCV
    "calibration_time",
    "calibration_date",
    "nframes",
    "nr_of_frames",
    "board_width",
    "board_height",
    "square_size",
    "marker_size",
    "flags",
    "fix_aspect_ratio",
    "aspect_ratio",
    "avg_reprojection_error",
    "reprojection_error",
    "rms",
    "per_view_reprojection_errors",
    "extrinsic_parameters",
    "image_points",
    "grid_points",
    "fix_principal_point_at_the_center",
    // Kalibr
    "T_cam_imu",
    "T_imu_cam",
    "T_cn_cnm1",
    "cam_overlaps",
    "rostopic",
    "timeshift_cam_imu",
];

/// Keys that are read where they are spelt so.
const READ_AS_SPELT: &[&str] =
    &["camera_model", "distortion_model", "fisheye_model", "binning_x", "binning_y", "roi", "mount"];

/// Keys of a region of the picture (ROS `sensor_msgs/RegionOfInterest`).
pub(super) const OF_REGION: [&str; 5] = ["x_offset", "y_offset", "height", "width", "do_rectify"];

/// Whether a key is one of a region's.
pub(super) fn is_of_region(name: &str) -> bool {
    OF_REGION.contains(&name)
}

/// Parts of the names of what describes a lens.
const OF_LENS: &[&str] = &[
    "dist",
    "coef",
    "lens",
    "fisheye",
    "model",
    "radial",
    "tangential",
    "prism",
    "projectiontype",
    "intrinsic",
];
/// Whole names of a lens's single numbers.
const NUMBERS_OF_LENS: &[&str] =
    &["k1", "k2", "k3", "k4", "k5", "k6", "p1", "p2", "s1", "s2", "s3", "s4", "xi", "alpha", "beta", "skew"];

/// The keys that nobody knows, in their order.
pub(super) fn unknown(root: &Hash) -> Vec<&str> {
    let is_known = |name: &str| {
        Key::named(name).is_some()
            || READ_AS_SPELT.contains(&name)
            || WITHOUT_EFFECT.iter().any(|known| plain(known) == plain(name))
    };
    root.keys().filter_map(Yaml::as_str).filter(|name| !is_known(name)).collect()
}

/// Whether an unknown key may describe a lens.
pub(super) fn is_of_lens(name: &str) -> bool {
    // A board's distance is none of the lens.
    let name = plain(name).replace("distance", "");
    OF_LENS.iter().any(|part| name.contains(part)) || NUMBERS_OF_LENS.contains(&name.as_str())
}

/// Whether a key names a camera of Kalibr's chain: `cam0`, `cam1`.
pub(super) fn is_camera_of_chain(name: &str) -> bool {
    name.strip_prefix("cam").is_some_and(|number| number.parse::<u32>().is_ok())
}

/// A name without capitals, underscores, hyphens and spaces.
fn plain(name: &str) -> String {
    name.chars().filter(|c| !matches!(c, '_' | '-' | ' ')).flat_map(char::to_lowercase).collect()
}
