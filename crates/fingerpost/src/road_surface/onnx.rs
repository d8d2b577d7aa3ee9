//! Road from a segmentation network that a user brings.
//!
//! Networks differ in the size and layout of their input and in what their output means; all of it is configured, so
//! that any network of one picture in and one score a class and pixel out can be used. The method itself runs none: a
//! [`UserNetwork`] is given to it, and what that finds in the camera picture is laid into the picture asked for.

use std::collections::BTreeSet;

use fingerpost_vision::picture::{Plane, Rect, RgbImage};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::perspective::clear_unseen;
use super::reduced_frame::{ReducedFrame, evidence_of_a_network};
use super::{RoadDetector, RoadError, RoadEvidence, RoadInput};
use crate::declared::{self, ConfigError};

/// Settings of the detector "onnx": which network, and what goes in and comes out of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct OnnxConfig {
    /// ONNX file of the network; none by default.
    pub model: String,
    /// Shared library of ONNX Runtime 1.20 or later (`libonnxruntime.so`); empty, as by default: the one that the
    /// environment variable `FINGERPOST_ONNX_LIBRARY` names, else the system's.
    pub library: String,
    /// Width of the picture that goes in, pixels.
    #[schemars(range(min = 16, max = 4096))]
    pub width_px: usize,
    /// Its height, pixels.
    #[schemars(range(min = 16, max = 4096))]
    pub height_px: usize,
    /// Order of the numbers.
    pub layout: TensorLayout,
    /// Order of the channels.
    pub channels: ChannelOrder,
    /// What is taken from each channel after division by 255, in the channels' order.
    #[schemars(inner(range(min = -1000.0, max = 1000.0)))]
    pub mean: [f32; 3],
    /// What each channel is then divided by.
    #[schemars(inner(range(min = 0.001, max = 1000.0)))]
    pub standard_deviation: [f32; 3],
    /// Name of the output with a score for every class and pixel; empty, as by default: the first.
    pub output: String,
    /// How scores become probabilities.
    pub scores: ScoreKind,
    /// Classes that are road, counted from 0; their probabilities are added up.
    #[schemars(inner(range(min = 0, max = 65535)))]
    pub road_classes: BTreeSet<usize>,
    /// Added to the logarithm of the odds of road; above 0 where the network takes too little for road.
    #[schemars(range(min = -20.0, max = 20.0))]
    pub log_odds_offset: f32,
    /// Threads of the network; with one a run always gives the same bytes.
    #[schemars(range(min = 1, max = 256))]
    pub threads: usize,
}

/// Order of the numbers of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TensorLayout {
    /// Channel, row, column: plane after plane.
    Nchw,
    /// Row, column, channel: channels together.
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
    /// By their softmax over the classes.
    Softmax,
    /// By the sigmoid of each.
    Sigmoid,
    /// They are probabilities already.
    None,
}

impl Default for OnnxConfig {
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
            road_classes: BTreeSet::from([1]),
            log_odds_offset: 0.0,
            threads: 1,
        }
    }
}

impl OnnxConfig {
    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        declared::check(&declared::schema_of::<Self>(), "road_surface.onnx", self)
    }
}

/// A network that is ready to run.
pub trait UserNetwork: Send {
    /// Finds the probability of road (255 = 1) all over `frame`, into `probability`, whose size is the network's choice.
    ///
    /// # Errors
    /// [`RoadError::Network`] when the network fails.
    fn segment(&mut self, frame: &RgbImage, probability: &mut Plane<u8>) -> Result<(), RoadError>;
}

/// The detector that asks a network of the user's.
pub struct Onnx {
    network: Box<dyn UserNetwork>,
    found: Plane<u8>,
    reduced: ReducedFrame,
}

impl Onnx {
    /// A detector around `network`.
    pub fn new(network: Box<dyn UserNetwork>) -> Self {
        Self { network, found: Plane::default(), reduced: ReducedFrame::default() }
    }
}

impl RoadDetector for Onnx {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        self.network.segment(input.camera_picture(), &mut self.found)?;
        let (width, height) = input.camera_picture().size();
        let whole = Rect { x: 0, y: 0, width, height };
        self.reduced.lay_into(&input, (whole, &self.found), probability)?;
        clear_unseen(input.validity, probability);
        Ok(evidence_of_a_network("onnx", &input, 0.0, probability))
    }

    fn reset(&mut self) {}
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount};
    use fingerpost_vision::colour::HueSaturationBins;
    use fingerpost_vision::picture::{Rect, ValidityMask};
    use nalgebra::Point2;

    use super::*;
    use crate::ground_view::{GroundPicture, GroundView, GroundViewConfig};
    use crate::road_surface::Perspective;

    /// Finds road in the left half of the picture.
    struct LeftIsRoad;

    impl UserNetwork for LeftIsRoad {
        fn segment(&mut self, _: &RgbImage, probability: &mut Plane<u8>) -> Result<(), RoadError> {
            probability.reset(32, 24, 0);
            (0..24).for_each(|y| probability.row_mut(y)[..16].fill(200));
            Ok(())
        }
    }

    struct Fails;

    impl UserNetwork for Fails {
        fn segment(&mut self, _: &RgbImage, _: &mut Plane<u8>) -> Result<(), RoadError> {
            Err(RoadError::Network { reason: "it is tired".into() })
        }
    }

    const BINS: HueSaturationBins = HueSaturationBins { hue: 8, saturation: 8 };

    fn estimate(network: Box<dyn UserNetwork>, input: RoadInput<'_>) -> Result<Plane<u8>, RoadError> {
        let mut probability = Plane::default();
        Onnx::new(network).estimate(input, &mut probability)?;
        Ok(probability)
    }

    #[test]
    fn what_a_network_finds_is_laid_over_the_camera_picture() {
        let picture = GroundPicture { colour: RgbImage::new(64, 48), ..GroundPicture::new(64, 48, BINS) };
        let mut seen = Plane::new(64, 48, 1_u8);
        seen.row_mut(10).fill(0);
        let validity = ValidityMask::from_plane(seen);
        let perspective = Perspective::Camera { horizon_row: 16.0 };
        let sample = Rect { x: 0, y: 20, width: 64, height: 10 };
        let input = RoadInput { picture: &picture, validity: &validity, sample, perspective, motion: None };
        let found = estimate(Box::new(LeftIsRoad), input).unwrap();
        let at = |x, y| found.get(x, y);
        assert_eq!([at(0, 47), at(28, 30), at(36, 30), at(63, 0)], [200, 200, 0, 0].map(Some));
        assert_eq!(at(5, 10), Some(0), "an unseen row is no road");
        let error = estimate(Box::new(Fails), input).unwrap_err();
        assert!(error.to_string().contains("it is tired"), "{error}");
    }

    #[test]
    fn the_left_of_the_camera_is_the_left_of_the_ground_view() {
        let intrinsics = Intrinsics { fx: 60.0, fy: 60.0, cx: 31.5, cy: 10.0 };
        let camera = Camera::calibrated(64, 48, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
        let view = GroundView::new(&GroundViewConfig::default(), BINS, &camera).unwrap();
        let (picture, frame) = (view.black_picture(), RgbImage::new(64, 48));
        let input = RoadInput {
            picture: &picture,
            validity: view.validity(),
            sample: Rect { x: 0, y: 0, width: 1, height: 1 },
            perspective: Perspective::Ground { view: &view, frame: &frame },
            motion: None,
        };
        let found = estimate(Box::new(LeftIsRoad), input).unwrap();
        let at = |forward_m: f64, left_m: f64| {
            let pixel = view.grid().ground_from_vehicle(Point2::new(forward_m, left_m));
            found.get(pixel.column.round() as usize, pixel.row.round() as usize)
        };
        assert_eq!([at(10.0, 2.0), at(10.0, -2.0), at(18.0, 4.0)], [200, 0, 200].map(Some));
    }
}
