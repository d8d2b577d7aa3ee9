//! Every kernel beside OpenCV's, and beside Rust crates that have the operation.

mod agreement;
mod edges;
mod flow;
mod ground;
mod pyramid;
mod rust_crates;

use anyhow::Result;
use fingerpost_vision::picture::{Plane, RgbImage};
use serde_json::Value;

use crate::measure::{Contestant, Effort, side_by_side};
use crate::peer::{Array, OpenCv};
use crate::results::{Agreement, Row, Section};

/// Side of the square pictures that most kernels are measured on, pixels.
const SIDE_PX: usize = 512;
/// How many times as fast as OpenCV a kernel is promised to be.
const PROMISED: f64 = 1.5;

/// What kernels are measured with.
pub struct Bench<'a> {
    pub opencv: &'a mut OpenCv,
    pub effort: Effort,
    /// Consecutive frames of the footage.
    pub frames: &'a [RgbImage],
}

impl Bench<'_> {
    /// What OpenCV gives for an operation, which is then the one that is timed.
    fn opencv_gives(&mut self, operation: &str, parameters: &Value, inputs: &[Array]) -> Result<Vec<Array>> {
        self.opencv.prepare(operation, parameters, inputs)?;
        self.opencv.outputs()
    }

    /// Times `ours` against what OpenCV has prepared, and against `others`.
    fn row<'a>(
        &'a mut self,
        title: (&str, &str),
        promised: Option<f64>,
        agreement: Agreement,
        ours: impl FnMut() + 'a,
        others: Vec<Contestant<'a>>,
    ) -> Result<Row> {
        if self.effort.rounds == 0 {
            return Ok(Row { agreement: Some(agreement), ..Row::new(title.0, title.1, Vec::new(), None) });
        }
        let mut contestants = vec![Contestant::here("Fingerpost", ours), self.opencv.contestant()];
        contestants.extend(others);
        let measured = side_by_side(self.effort, &mut contestants)?;
        Ok(Row { agreement: Some(agreement), ..Row::new(title.0, title.1, measured, promised) })
    }
}

/// Measures all kernels.
pub fn kernels(bench: &mut Bench<'_>) -> Result<Section> {
    let mut section = Section::new(
        "Kernels",
        "one thread; medians; the ratio is OpenCV's time over Fingerpost's; results are compared before they are timed",
    );
    section.rows.extend(ground::rows(bench)?);
    section.rows.extend(edges::rows(bench)?);
    section.rows.extend(pyramid::rows(bench)?);
    section.rows.extend(flow::rows(bench)?);
    Ok(section)
}

/// The middle of a frame as a square.
fn square(frame: &RgbImage, side_px: usize) -> RgbImage {
    let (left, top) = ((frame.width() - side_px) / 2, (frame.height() - side_px) / 2);
    let mut square = RgbImage::new(side_px, side_px);
    for y in 0..side_px {
        let from = left * RgbImage::CHANNELS;
        let row = &frame.row(top + y)[from..from + side_px * RgbImage::CHANNELS];
        square.row_mut(y).copy_from_slice(row);
    }
    square
}

fn grey_square(frame: &RgbImage, side_px: usize) -> Result<Plane<u8>> {
    let mut grey = Plane::new(side_px, side_px, 0);
    fingerpost_vision::colour::grey(&square(frame, side_px), &mut grey)?;
    Ok(grey)
}

fn array_of_plane(plane: &Plane<u8>) -> Array {
    Array::of_u8(&[plane.height(), plane.width()], plane.as_slice())
}

fn array_of_rgb(image: &RgbImage) -> Array {
    Array::of_u8(&[image.height(), image.width(), RgbImage::CHANNELS], image.as_slice())
}

fn array_of_floats(plane: &Plane<f32>) -> Array {
    Array::of_f32(&[plane.height(), plane.width()], plane.as_slice())
}

fn size_of(side_px: usize) -> String {
    format!("{side_px} x {side_px}")
}
