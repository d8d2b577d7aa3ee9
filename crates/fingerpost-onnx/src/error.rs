//! What can go wrong with a network.

use std::fmt::Display;

use fingerpost::ConfigError;
use fingerpost_vision::error::PictureError;
use thiserror::Error;

/// A network that cannot be loaded or run.
#[derive(Debug, Error)]
pub enum NetworkError {
    /// The shared library of ONNX Runtime cannot be loaded.
    #[error(
        "ONNX Runtime cannot be loaded from {library}: {reason}; install version 1.20 or later and name its shared library \
         in road_surface.onnx.library or FINGERPOST_ONNX_LIBRARY"
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
    /// A number among the settings is out of range.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A setting does not fit the network.
    #[error("road_surface.onnx.{key} does not fit the network: {reason}")]
    Setting {
        /// Key in the table.
        key: &'static str,
        /// What the network has instead.
        reason: String,
    },
    /// The network takes something else than the picture that the settings describe.
    #[error(
        "the network takes {taken} and road_surface.onnx gives {given}; make its width_px, height_px and layout those of the \
         network, or give another network"
    )]
    Input {
        /// What the network takes.
        taken: String,
        /// What the settings give.
        given: String,
    },
    /// The network fails on a picture.
    #[error("the network cannot be run: {reason}; give another")]
    Run {
        /// What ONNX Runtime says.
        reason: String,
    },
    /// The picture cannot be resampled to the network's size.
    #[error("the picture does not fit the network: {0}")]
    Picture(#[from] PictureError),
}

/// What ONNX Runtime says, without its line breaks and its last full stop.
pub(crate) fn one_line(error: &(impl Display + ?Sized)) -> String {
    let said = error.to_string();
    let words: Vec<&str> = said.split_whitespace().collect();
    words.join(" ").trim_end_matches('.').to_owned()
}
