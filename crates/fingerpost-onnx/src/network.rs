//! A segmentation network: one picture in, the probability of road out.

use std::fmt::Display;

use fingerpost::road_surface::{ChannelOrder, OnnxConfig, RoadError, ScoreKind, TensorLayout, UserNetwork};
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::warp::WarpTable;
use ort::session::Session;
use ort::value::{TensorElementType, TensorRef, ValueType};

use crate::error::{NetworkError, one_line};
use crate::runtime::OnnxRuntime;

/// A network with its settings, ready to run.
#[derive(Debug)]
pub struct SegmentationNetwork {
    config: OnnxConfig,
    session: Session,
    /// Index of the output that is read.
    output: usize,
    /// From frame to `resampled`; none before the first frame.
    reduction: Option<WarpTable>,
    resampled: RgbImage,
    tensor: Vec<f32>,
}

/// Shape of the scores: how many classes, rows and columns, and how far apart the numbers of each lie.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct ScoreRaster {
    classes: usize,
    rows: usize,
    columns: usize,
    class_stride: usize,
    pixel_stride: usize,
}

impl SegmentationNetwork {
    /// Loads the network `model` (the bytes of an ONNX file) and tries it on a black picture.
    ///
    /// # Errors
    /// [`NetworkError`] when ONNX Runtime refuses the network, or a setting does not fit it.
    pub fn new(runtime: &OnnxRuntime, config: &OnnxConfig, model: &[u8]) -> Result<Self, NetworkError> {
        config.check()?;
        if config.road_classes.is_empty() {
            let reason = "it names none; name the class that is road".to_owned();
            return Err(NetworkError::Setting { key: "road_classes", reason });
        }
        let refused = |error: &dyn Display| NetworkError::Model { reason: one_line(error) };
        let session = Session::builder(runtime.environment())
            .map_err(|error| refused(&error))?
            .with_intra_threads(config.threads)
            .map_err(|error| refused(&error))?
            .commit_from_memory(model)
            .map_err(|error| refused(&error))?;
        check_input(&session, config)?;
        let output = output_index(&session, &config.output)?;
        let mut network = Self {
            config: config.clone(),
            session,
            output,
            reduction: None,
            resampled: RgbImage::new(config.width_px, config.height_px),
            tensor: vec![0.0; RgbImage::CHANNELS * config.width_px * config.height_px],
        };
        // A network that does not take such pictures, or gives something else, is refused before the drive.
        network.run(&mut Plane::default())?;
        Ok(network)
    }

    /// Finds the probability of road (255 = 1) in `frame`, into `probability`, which gets the size of the network's
    /// output; that shows the whole frame.
    fn find(&mut self, frame: &RgbImage, probability: &mut Plane<u8>) -> Result<(), NetworkError> {
        let reduction = match self.reduction.take() {
            Some(table) if table.source_size() == frame.size() => table,
            _ => reduction(frame.size(), self.resampled.size())?,
        };
        let warped = reduction.warp_rgb(frame, &mut self.resampled);
        self.reduction = Some(reduction);
        warped?;
        fill(&self.config, &self.resampled, &mut self.tensor);
        self.run(probability)
    }

    fn run(&mut self, probability: &mut Plane<u8>) -> Result<(), NetworkError> {
        let failed = |error: ort::Error| NetworkError::Run { reason: one_line(&error) };
        let picture = TensorRef::from_array_view((input_shape(&self.config), self.tensor.as_slice()))
            .map_err(failed)?;
        let outputs = self.session.run(ort::inputs![picture]).map_err(failed)?;
        let (shape, scores) = outputs[self.output].try_extract_tensor::<f32>().map_err(failed)?;
        let raster = score_raster(shape, self.config.layout)?;
        if let Some(&class) = self.config.road_classes.iter().find(|&&class| class >= raster.classes) {
            let reason = format!("it has {} classes, counted from 0; {class} is none", raster.classes);
            return Err(NetworkError::Setting { key: "road_classes", reason });
        }
        if raster.classes == 1 && self.config.scores == ScoreKind::Softmax {
            let reason = "it has one class, which softmax makes 1 everywhere; give \"sigmoid\" or \"none\"";
            return Err(NetworkError::Setting { key: "scores", reason: reason.to_owned() });
        }
        if probability.size() != (raster.columns, raster.rows) {
            probability.reset(raster.columns, raster.rows, 0);
        }
        for (pixel, out) in probability.as_mut_slice().iter_mut().enumerate() {
            let score = |class: usize| scores[class * raster.class_stride + pixel * raster.pixel_stride];
            *out = (255.0 * road_probability(&self.config, raster.classes, score)).round() as u8;
        }
        Ok(())
    }
}

impl UserNetwork for SegmentationNetwork {
    fn segment(&mut self, frame: &RgbImage, probability: &mut Plane<u8>) -> Result<(), RoadError> {
        self.find(frame, probability).map_err(|error| RoadError::Network { reason: error.to_string() })
    }
}

/// The shape of what goes in.
const fn input_shape(config: &OnnxConfig) -> [usize; 4] {
    let (width, height) = (config.width_px, config.height_px);
    match config.layout {
        TensorLayout::Nchw => [1, RgbImage::CHANNELS, height, width],
        TensorLayout::Nhwc => [1, height, width, RgbImage::CHANNELS],
    }
}

/// Checks what the network says of its input; sides that it leaves open fit any.
fn check_input(session: &Session, config: &OnnxConfig) -> Result<(), NetworkError> {
    let shape = input_shape(config).map(|side| side as i64);
    let taken = match session.inputs() {
        [input] => match input.dtype() {
            ValueType::Tensor { ty, shape: taken, .. } => {
                let fits = |(&taken, given): (&i64, i64)| taken < 0 || taken == given;
                let same = taken.len() == shape.len() && taken.iter().zip(shape).all(fits);
                if *ty == TensorElementType::Float32 && same {
                    return Ok(());
                }
                format!("{} of {ty}", sides(taken))
            }
            _ => "no picture".to_owned(),
        },
        inputs => format!("{} inputs", inputs.len()),
    };
    Err(NetworkError::Input { taken, given: format!("{} of f32", sides(&shape)) })
}

/// Sides of a shape in words; those that are left open as `?`.
fn sides(shape: &[i64]) -> String {
    let side = |&side: &i64| if side < 0 { "?".to_owned() } else { side.to_string() };
    shape.iter().map(side).collect::<Vec<_>>().join(" x ")
}

fn output_index(session: &Session, wanted: &str) -> Result<usize, NetworkError> {
    let outputs = session.outputs();
    if wanted.is_empty() && !outputs.is_empty() {
        return Ok(0);
    }
    outputs.iter().position(|output| output.name() == wanted).ok_or_else(|| {
        let names: Vec<&str> = outputs.iter().map(ort::value::Outlet::name).collect();
        NetworkError::Setting { key: "output", reason: format!("its outputs are {}", names.join(", ")) }
    })
}

/// The table that resamples frames to the network's size; edges, not pixel centres, correspond.
fn reduction(from: (usize, usize), to: (usize, usize)) -> Result<WarpTable, NetworkError> {
    let place = |target: usize, to: usize, from: usize| {
        let place = (target as f64 + 0.5) * from as f64 / to as f64 - 0.5;
        place.clamp(0.0, from.saturating_sub(1) as f64)
    };
    let table = WarpTable::new(to.0, to.1, from.0, from.1, |column, row| {
        Some([place(column, to.0, from.0), place(row, to.1, from.1)])
    })?;
    Ok(table)
}

/// Writes the picture as the network wants it.
fn fill(config: &OnnxConfig, picture: &RgbImage, tensor: &mut [f32]) {
    let (width, height) = picture.size();
    let order = match config.channels {
        ChannelOrder::Rgb => [0, 1, 2],
        ChannelOrder::Bgr => [2, 1, 0],
    };
    let (pixel_stride, channel_stride) = match config.layout {
        TensorLayout::Nchw => (1, width * height),
        TensorLayout::Nhwc => (RgbImage::CHANNELS, 1),
    };
    for y in 0..height {
        for (x, pixel) in picture.row(y).chunks_exact(RgbImage::CHANNELS).enumerate() {
            for (channel, &source) in order.iter().enumerate() {
                let value = f32::from(pixel[source]) / 255.0;
                tensor[(y * width + x) * pixel_stride + channel * channel_stride] =
                    (value - config.mean[channel]) / config.standard_deviation[channel];
            }
        }
    }
}

/// Reads the shape of scores: 1 x classes x rows x columns, with the classes last in "nhwc", or without classes.
fn score_raster(shape: &[i64], layout: TensorLayout) -> Result<ScoreRaster, NetworkError> {
    let sides: Vec<usize> = shape.iter().map(|&side| usize::try_from(side).unwrap_or(0)).collect();
    let (classes, rows, columns) = match (sides.as_slice(), layout) {
        (&[1, classes, rows, columns], TensorLayout::Nchw)
        | (&[1, rows, columns, classes], TensorLayout::Nhwc) => (classes, rows, columns),
        (&[1, rows, columns] | &[rows, columns], _) => (1, rows, columns),
        _ => (0, 0, 0),
    };
    if classes * rows * columns == 0 {
        let reason = format!("it has the shape {shape:?}; one picture of scores for each class is needed");
        return Err(NetworkError::Setting { key: "output", reason });
    }
    let (class_stride, pixel_stride) = match layout {
        TensorLayout::Nchw => (rows * columns, 1),
        TensorLayout::Nhwc => (1, classes),
    };
    Ok(ScoreRaster { classes, rows, columns, class_stride, pixel_stride })
}

/// The probability of road of one pixel from its scores, 0 to 1; scores that are no numbers give 0.
fn road_probability(config: &OnnxConfig, classes: usize, score: impl Fn(usize) -> f32) -> f32 {
    let of_road = |each: &dyn Fn(f32) -> f32| -> f32 {
        config.road_classes.iter().map(|&class| each(score(class))).sum()
    };
    let probability = match config.scores {
        ScoreKind::None => of_road(&|score| score),
        ScoreKind::Sigmoid => of_road(&|score| 1.0 / (1.0 + libm::expf(-score))),
        ScoreKind::Softmax => {
            let most = (0..classes).map(&score).fold(f32::NEG_INFINITY, f32::max);
            let total: f32 = (0..classes).map(|class| libm::expf(score(class) - most)).sum();
            of_road(&|score| libm::expf(score - most)) / total
        }
    };
    if probability.is_nan() {
        return 0.0;
    }
    let road = probability.clamp(0.0, 1.0) * libm::expf(config.log_odds_offset);
    let other = 1.0 - probability.clamp(0.0, 1.0);
    road / (road + other)
}

#[cfg(test)]
mod tests {
    // A failed assumption of a test is a failed test.
    #![allow(clippy::unwrap_used)]

    use super::*;

    fn picture() -> RgbImage {
        RgbImage::from_vec(2, 1, vec![255, 0, 51, 0, 102, 204]).unwrap()
    }

    #[test]
    fn channels_and_layout_are_as_configured() {
        let mut tensor = [0.0; 6];
        let config =
            OnnxConfig { mean: [0.0, 0.0, 0.2], standard_deviation: [1.0, 2.0, 1.0], ..Default::default() };
        fill(&config, &picture(), &mut tensor);
        let expected = [1.0, 0.0, 0.0, 0.2, 0.0, 0.6];
        assert!(tensor.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{tensor:?}");
        let config =
            OnnxConfig { layout: TensorLayout::Nhwc, channels: ChannelOrder::Bgr, ..OnnxConfig::default() };
        fill(&config, &picture(), &mut tensor);
        let expected = [0.2, 0.0, 1.0, 0.8, 0.4, 0.0];
        assert!(tensor.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-6), "{tensor:?}");
    }

    #[test]
    fn scores_become_probabilities_of_the_road_classes() {
        let of = |scores, values: [f32; 3], road_classes: &[usize]| {
            let road_classes = road_classes.iter().copied().collect();
            let config = OnnxConfig { scores, road_classes, ..Default::default() };
            road_probability(&config, 3, |class| values[class])
        };
        assert!((of(ScoreKind::Softmax, [1e4, 1e4, 0.0], &[1]) - 0.5).abs() < 1e-6);
        assert!((of(ScoreKind::Softmax, [0.0, 0.0, 0.0], &[0, 2]) - 2.0 / 3.0).abs() < 1e-6);
        assert!((of(ScoreKind::Sigmoid, [0.0, 3.0, 0.0], &[0]) - 0.5).abs() < 1e-6);
        assert!((of(ScoreKind::None, [0.7, 0.2, 0.1], &[0]) - 0.7).abs() < 1e-6);
        assert!(of(ScoreKind::None, [f32::NAN, 0.2, 0.1], &[0]) == 0.0);
        assert!(of(ScoreKind::None, [0.7, 0.6, 0.1], &[0, 1]) >= 1.0);
        let config = OnnxConfig { log_odds_offset: 2.0, scores: ScoreKind::None, ..Default::default() };
        let offset = |probability: f32| road_probability(&config, 2, |_| probability);
        assert!((offset(0.1) - 1.0 / (1.0 + 9.0 * libm::expf(-2.0))).abs() < 1e-6);
        assert!(offset(0.0) <= 0.0 && offset(1.0) >= 1.0);
    }

    #[test]
    fn shapes_are_read_in_both_layouts_and_others_refused() {
        let raster = score_raster(&[1, 2, 3, 4], TensorLayout::Nchw).unwrap();
        assert_eq!((raster.classes, raster.rows, raster.columns), (2, 3, 4));
        assert_eq!((raster.class_stride, raster.pixel_stride), (12, 1));
        let raster = score_raster(&[1, 3, 4, 2], TensorLayout::Nhwc).unwrap();
        assert_eq!((raster.classes, raster.rows, raster.columns), (2, 3, 4));
        assert_eq!((raster.class_stride, raster.pixel_stride), (1, 2));
        let raster = score_raster(&[3, 4], TensorLayout::Nchw).unwrap();
        assert_eq!((raster.classes, raster.rows, raster.columns), (1, 3, 4));
        assert!(score_raster(&[1, 1000], TensorLayout::Nchw).is_ok_and(|raster| raster.rows == 1));
        assert!(score_raster(&[1000], TensorLayout::Nchw).is_err());
        assert!(score_raster(&[1, 0, 3, 4], TensorLayout::Nchw).is_err());
    }
}
