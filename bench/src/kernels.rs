//! Every kernel beside OpenCV's with every instruction set, and beside Rust crates that have the operation.

mod agreement;
mod edges;
mod flow;
mod ground;
mod lines;
mod pyramid;
mod rust_crates;
mod shapes;
mod surface;

use anyhow::Result;
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::simd::{CodePath, InstructionSet};
use serde_json::Value;

use crate::measure::{Contestant, Effort, side_by_side};
use crate::peer::{Array, OpenCv};
use crate::results::{Agreement, Row, Section, set_name};

/// Side of the square pictures that most kernels are measured on, pixels.
const SIDE_PX: usize = 512;

/// How many times as fast as OpenCV a kernel is promised to be; OpenCV takes the best instructions that it has.
#[derive(Debug, Clone, Copy)]
struct Promise {
    avx512: f64,
    avx2: f64,
    portable: f64,
}

impl Promise {
    /// What is promised of every kernel.
    const EVERY: Self = Self { avx512: 1.5, avx2: 1.2, portable: 0.5 };

    const fn with(self, set: InstructionSet) -> f64 {
        match set {
            InstructionSet::Avx512 => self.avx512,
            InstructionSet::Avx2 => self.avx2,
            InstructionSet::Portable => self.portable,
        }
    }
}

/// What kernels are measured with.
pub struct Bench<'a> {
    pub opencv: &'a mut OpenCv,
    pub effort: Effort,
    /// Consecutive frames of the footage.
    pub frames: &'a [RgbImage],
    /// Instruction sets that are measured.
    pub sets: &'a [InstructionSet],
}

/// A kernel of Fingerpost's.
struct Kernel<'k, S> {
    what: &'k str,
    size: &'k str,
    promise: Promise,
    /// The kernel with its buffers, of which every instruction set gets its own.
    fresh: S,
    work: &'k dyn Fn(&mut S) -> Result<()>,
    /// How well what the work left agrees with OpenCV's; where it leaves nothing, the work is done again.
    compare: &'k dyn Fn(&mut S) -> Result<Agreement>,
}

impl Bench<'_> {
    /// What OpenCV gives for an operation, which is then the one that is timed.
    fn opencv_gives(&mut self, operation: &str, parameters: &Value, inputs: &[Array]) -> Result<Vec<Array>> {
        self.opencv.prepare(operation, parameters, inputs)?;
        self.opencv.outputs()
    }

    /// A row for every instruction set: compares the kernel's results, and times it against what OpenCV has prepared, all of
    /// them in the same turns; `others` stand in the first row.
    fn rows<S: Clone>(&mut self, kernel: &Kernel<'_, S>, others: Vec<Contestant<'_>>) -> Result<Vec<Row>> {
        let (mut agreements, mut contestants) = (Vec::new(), Vec::new());
        for &set in self.sets {
            CodePath::limit(set);
            let mut state = kernel.fresh.clone();
            (kernel.work)(&mut state)?;
            agreements.push((kernel.compare)(&mut state)?);
            contestants.push(Contestant::with(set, "Fingerpost", move || {
                // The same call was good a moment ago.
                let _ = (kernel.work)(&mut state);
            }));
        }
        contestants.push(self.opencv.contestant());
        contestants.extend(others);
        let times = self.effort.rounds > 0;
        let mut ours = if times { side_by_side(self.effort, &mut contestants)? } else { Vec::new() };
        let mut peers = ours.split_off(if times { self.sets.len() } else { 0 });
        let mut rows = Vec::new();
        for (index, (&set, agreement)) in self.sets.iter().zip(agreements).enumerate() {
            let measured = ours.get(index).cloned().into_iter().chain(peers.iter().cloned()).collect();
            let promised = times.then(|| kernel.promise.with(set));
            rows.push(Row {
                instruction_set: Some(set_name(set)),
                agreement: Some(agreement),
                ..Row::new(kernel.what, kernel.size, measured, promised)
            });
            peers.truncate(1);
        }
        Ok(rows)
    }
}

/// Measures all kernels.
pub fn kernels(bench: &mut Bench<'_>) -> Result<Section> {
    let mut section = Section::new(
        "Kernels",
        "one thread; medians; the ratio is OpenCV's time over Fingerpost's with the row's instruction set; OpenCV takes the best \
         that it has; results are compared before they are timed",
    );
    section.rows.extend(ground::rows(bench)?);
    section.rows.extend(surface::rows(bench)?);
    section.rows.extend(edges::rows(bench)?);
    section.rows.extend(shapes::rows(bench)?);
    section.rows.extend(lines::rows(bench)?);
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
