//! What can go wrong with a network.

use fingerpost_vision::error::PictureError;
use thiserror::Error;

/// A network that cannot be loaded or run.
#[derive(Debug, Error)]
pub enum NetworkError {
    /// The shared library of ONNX Runtime cannot be loaded.
    #[error(
        "ONNX Runtime cannot be loaded from {library}: {reason}; install it and name its shared library in \
         road_surface.onnx.library or ORT_DYLIB_PATH"
    )]
    Library {
        /// What was to be loaded.
        library: String,
        /// What the loader says.
        reason: String,
    },
    /// ONNX Runtime refuses the file.
    #[error(
        "the network cannot be loaded: {reason}; give an ONNX file that this version of ONNX Runtime reads"
    )]
    Model {
        /// What ONNX Runtime says.
        reason: String,
    },
    /// A setting does not fit the network.
    #[error("road_surface.onnx.{key} does not fit the network: {reason}")]
    Setting {
        /// Key in the table.
        key: &'static str,
        /// What the network has instead.
        reason: String,
    },
    /// The network fails on a picture.
    #[error("the network cannot be run: {reason}")]
    Run {
        /// What ONNX Runtime says.
        reason: String,
    },
    /// The picture cannot be resampled to the network's size.
    #[error("the picture does not fit the network: {0}")]
    Picture(#[from] PictureError),
}
