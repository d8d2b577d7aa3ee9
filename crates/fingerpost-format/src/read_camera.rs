//! A camera as it was read of a calibration, with what its user must know of how it was understood.

use std::fmt;

use fingerpost_geometry::Camera;

/// A camera, and what was taken for granted or left aside on the way to it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadCamera {
    /// The camera.
    pub camera: Camera,
    /// What is to be said once.
    pub remarks: Vec<CameraRemark>,
}

/// What a calibration leaves open.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum CameraRemark {
    /// It says nothing of a lens.
    NoDistortion,
    /// It names a model of a lens and says that there are no coefficients.
    NoCoefficients {
        /// The model.
        model: String,
    },
    /// It has keys that are not known.
    UnknownKeys {
        /// The keys in their order.
        keys: Vec<String>,
    },
    /// It has several cameras.
    OneOfSeveral {
        /// Name of the one that is used.
        used: String,
        /// Names of the others.
        others: Vec<String>,
    },
    /// More than one document stands in it.
    FirstDocument {
        /// Documents in all.
        count: usize,
    },
}

impl fmt::Display for CameraRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoDistortion => f.write_str(
                "it says nothing of the lens, which is taken not to distort, as in rectified pictures",
            ),
            Self::NoCoefficients { model } => write!(
                f,
                "its lens of model {model:?} has no coefficients and is taken not to distort, as in rectified pictures"
            ),
            Self::UnknownKeys { keys } => {
                write!(f, "{} keys are not known and not used: {}", keys.len(), keys.join(", "))
            }
            Self::OneOfSeveral { used, others } => write!(
                f,
                "of its cameras {used} is used; for {}, put that part alone into a file",
                others.join(" or ")
            ),
            Self::FirstDocument { count } => write!(f, "the first of its {count} documents is used"),
        }
    }
}
