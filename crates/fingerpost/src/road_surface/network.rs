//! Settings of a segmentation network that a user brings.
//!
//! Networks differ in the size and layout of their input and in what their output means; all of it is configured here,
//! so that any network of one picture in and one score a class and pixel out can be used. The method itself runs none:
//! the program does, with a library that it loads then.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Settings of the detector "onnx": which network, and what goes in and comes out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct NetworkConfig {
    /// ONNX file of the network; none by default.
    pub model: String,
    /// Shared library of ONNX Runtime 1.17 or later (`libonnxruntime.so`); default: that of the environment variable
    /// `ORT_DYLIB_PATH`, else the system's.
    pub library: String,
    /// Width of the picture that goes in, pixels, 16 to 4096; default 640.
    pub width_px: usize,
    /// Its height, pixels, 16 to 4096; default 360.
    pub height_px: usize,
    /// Order of the numbers: "nchw" (plane after plane) or "nhwc" (channels together); default "nchw".
    pub layout: TensorLayout,
    /// Order of the channels: "rgb" or "bgr"; default "rgb".
    pub channels: ChannelOrder,
    /// What is taken from each channel, after division by 255; default 0, 0, 0.
    pub mean: [f32; 3],
    /// What each channel is then divided by, above 0; default 1, 1, 1.
    pub standard_deviation: [f32; 3],
    /// Name of the output with a score for every class and pixel; empty, as by default: the first.
    pub output: String,
    /// How scores become probabilities: "softmax" over the classes, "sigmoid" of each, or "none", where they are
    /// probabilities already; default "softmax".
    pub scores: ScoreKind,
    /// Classes that are road, counted from 0; their probabilities are added up; default 1.
    pub road_classes: Vec<usize>,
    /// Threads of the network, 1 to 256; default 1, with which a run always gives the same bytes.
    pub threads: usize,
}

/// Order of the numbers of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TensorLayout {
    /// Channel, row, column.
    Nchw,
    /// Row, column, channel.
    Nhwc,
}

/// Order of a picture's channels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ChannelOrder {
    /// Red, green, blue.
    Rgb,
    /// Blue, green, red.
    Bgr,
}

/// What a network's scores are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ScoreKind {
    /// Logarithms of weights over all classes.
    Softmax,
    /// Log-odds of each class by itself.
    Sigmoid,
    /// Probabilities.
    None,
}

impl Default for NetworkConfig {
    fn default() -> Self {
        Self {
            model: String::new(),
            library: String::new(),
            width_px: 640,
            height_px: 360,
            layout: TensorLayout::Nchw,
            channels: ChannelOrder::Rgb,
            mean: [0.0; 3],
            standard_deviation: [1.0; 3],
            output: String::new(),
            scores: ScoreKind::Softmax,
            road_classes: vec![1],
            threads: 1,
        }
    }
}
