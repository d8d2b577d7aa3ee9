//! One line of TuSimple's lane files: labels, and results to be judged by its benchmark.

use serde::{Deserialize, Serialize};

/// What stands in a lane at rows that it does not reach; anything negative is read so.
pub const TUSIMPLE_NO_POINT: f64 = -2.0;

/// The lanes of one picture in the form of the TuSimple lane benchmark (2017).
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct TuSimpleRecord {
    /// Each lane boundary's column at every one of `h_samples`, pixels; [`TUSIMPLE_NO_POINT`] where it has none.
    pub lanes: Vec<Vec<f64>>,
    /// Rows, pixels from the picture's top.
    pub h_samples: Vec<f64>,
    /// The picture.
    #[serde(default)]
    pub raw_file: String,
}
