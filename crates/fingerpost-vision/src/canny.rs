//! Canny's edge detector.
//!
//! J. Canny, "A computational approach to edge detection", IEEE PAMI 8(6), 1986: pixels whose gradient is stronger than
//! that of both neighbours across the edge, and that are strong themselves or hang together with strong ones. The gradient
//! is Sobel's over 3 x 3 pixels, the picture continued by its edge pixel; its direction counts as one of four, with
//! boundaries at 22.5 and 67.5 degrees in OpenCV's fixed point. Beyond the picture the gradient is 0. The picture is not
//! smoothed here; [`crate::smoothing::GaussianBlur`] does that.

mod hysteresis;
mod suppression;

use crate::border::Border;
use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::simd::CodePath;
use crate::sobel::Columns;
use hysteresis::Hysteresis;
use suppression::{Direction, Neighbourhood, gradient_l1, gradient_l2, suppress_l1, suppress_l2};

/// Strongest gradient that 8-bit pictures have, in the L1 norm: 1020 along either axis.
const STRONGEST: f64 = 2040.0;

/// How a gradient's strength is measured.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum GradientNorm {
    /// |dx| + |dy|: fast, and up to 41 % higher on slanted edges.
    #[default]
    L1,
    /// The root of dx² + dy²: the same for all directions.
    L2,
}

/// Thresholds of an edge detector, in levels of the 3 x 3 Sobel gradient (a slope of one level a pixel reads 8).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CannyParams {
    /// Gradients above this belong to an edge that reaches them.
    pub low: f64,
    /// Gradients above this start an edge.
    pub high: f64,
    /// How the strength of a gradient is measured.
    pub norm: GradientNorm,
}

/// Thresholds that do not work.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CannyError {
    /// Negative, not a number, or in the wrong order.
    #[error("edge thresholds of {low} (low) and {high} (high) do not work; give 0 <= low <= high")]
    Thresholds {
        /// The lower threshold given.
        low: f64,
        /// The upper threshold given.
        high: f64,
    },
}

/// Canny's edge detector, with the buffers that it needs.
///
/// ```
/// use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
/// use fingerpost_vision::picture::Plane;
/// let step = Plane::from_vec(6, 3, [0_u8, 0, 0, 200, 200, 200].repeat(3))?;
/// let mut edges = Plane::new(6, 3, 0);
/// Canny::new(CannyParams { low: 80.0, high: 160.0, norm: GradientNorm::L1 })?.apply(step.view(), &mut edges)?;
/// assert_eq!(edges.row(1), &[0, 0, 255, 0, 0, 0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Canny {
    norm: GradientNorm,
    /// Whole thresholds in the units of the norm: levels, or their squares.
    low: u32,
    high: u32,
    columns: Columns,
    levels: Gradients<u16>,
    squares: Gradients<u32>,
    hysteresis: Hysteresis,
}

/// Strengths and directions of the gradient in the last rows; a row's place is its number modulo the rows kept.
#[derive(Debug, Clone, Default)]
struct Gradients<M> {
    /// With one strength beyond either end, always 0.
    strength: [Vec<M>; 3],
    direction: [Vec<Direction>; 2],
}

impl Canny {
    /// A detector with the given thresholds.
    ///
    /// # Errors
    /// [`CannyError`] when a threshold is negative or no number, or the lower one above the upper one.
    pub fn new(params: CannyParams) -> Result<Self, CannyError> {
        let [low, high] = thresholds(&params)?;
        Ok(Self {
            norm: params.norm,
            low,
            high,
            columns: Columns::default(),
            levels: Gradients::default(),
            squares: Gradients::default(),
            hysteresis: Hysteresis::default(),
        })
    }

    /// Goes on with other thresholds, and the buffers that there are.
    ///
    /// # Errors
    /// [`CannyError`] as for a new detector, which then stays as it was.
    pub fn set_params(&mut self, params: CannyParams) -> Result<(), CannyError> {
        [self.low, self.high] = thresholds(&params)?;
        self.norm = params.norm;
        Ok(())
    }

    /// Sets `edges` to 255 where `source` has an edge and to 0 elsewhere.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] when the two differ in size.
    pub fn apply(&mut self, source: PlaneView<'_, u8>, edges: &mut Plane<u8>) -> Result<(), PictureError> {
        self.apply_on(CodePath::fastest(), source, edges)
    }

    fn apply_on(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        edges: &mut Plane<u8>,
    ) -> Result<(), PictureError> {
        check_size("edge picture", source.size(), edges.size())?;
        if source.width() == 0 || source.height() == 0 {
            return Ok(());
        }
        let Self { columns, hysteresis, .. } = self;
        hysteresis.resize(source.width(), source.height());
        match self.norm {
            GradientNorm::L1 => {
                let thresholds = [self.low as u16, self.high as u16];
                let gradient = |columns: &Columns, strength: &mut [u16], direction: &mut [Direction]| {
                    gradient_l1(path, &columns.smooth, &columns.difference, strength, direction);
                };
                self.levels.for_each_row(path, source, columns, gradient, |y, around, direction| {
                    suppress_l1(path, around, direction, thresholds, hysteresis.row_mut(y));
                });
            }
            GradientNorm::L2 => {
                let thresholds = [self.low, self.high];
                let gradient = |columns: &Columns, strength: &mut [u32], direction: &mut [Direction]| {
                    gradient_l2(path, &columns.smooth, &columns.difference, strength, direction);
                };
                self.squares.for_each_row(path, source, columns, gradient, |y, around, direction| {
                    suppress_l2(path, around, direction, thresholds, hysteresis.row_mut(y));
                });
            }
        }
        hysteresis.finish(path, edges);
        Ok(())
    }
}

/// The whole thresholds, lower and upper, in the units of the norm.
fn thresholds(params: &CannyParams) -> Result<[u32; 2], CannyError> {
    let &CannyParams { low, high, norm } = params;
    if !(low >= 0.0 && high >= low) {
        return Err(CannyError::Thresholds { low, high });
    }
    Ok([low, high].map(|level| {
        let level = level.min(STRONGEST);
        match norm {
            GradientNorm::L1 => level as u32,
            GradientNorm::L2 => (level * level) as u32,
        }
    }))
}

impl<M: Copy + Default> Gradients<M> {
    /// Computes `gradient` of each row of `source` and hands every row, with its neighbours, to `take`.
    fn for_each_row(
        &mut self,
        path: CodePath,
        source: PlaneView<'_, u8>,
        columns: &mut Columns,
        gradient: impl Fn(&Columns, &mut [M], &mut [Direction]),
        mut take: impl FnMut(usize, Neighbourhood<'_, M>, &[Direction]),
    ) {
        let (width, height) = source.size();
        for strength in &mut self.strength {
            strength.clear();
            strength.resize(width + 2, M::default());
        }
        for direction in &mut self.direction {
            direction.resize(width, Direction::default());
        }
        for y in 0..=height {
            let strength = &mut self.strength[y % 3];
            if y < height {
                columns.fill(path, source, y, Border::Replicate);
                gradient(columns, &mut strength[1..=width], &mut self.direction[y % 2]);
            } else {
                strength.fill(M::default());
            }
            if let Some(here) = y.checked_sub(1) {
                let [above, here_row, below] = [here + 2, here, y].map(|row| &self.strength[row % 3][..]);
                take(here, Neighbourhood { above, here: here_row, below }, &self.direction[here % 2]);
            }
        }
    }
}

#[cfg(test)]
mod tests;
