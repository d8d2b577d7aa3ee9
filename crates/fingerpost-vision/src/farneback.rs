//! Dense optical flow between two pictures by polynomial expansion.
//!
//! G. Farneback, "Two-frame motion estimation based on polynomial expansion", SCIA 2003. Around every pixel each picture is
//! approximated by a quadratic polynomial; a displacement turns one polynomial into another, which gives a linear equation
//! for it; the equations of a window are solved together by least squares, again and again with the flow found so far, from
//! the coarsest level of a pyramid to the full picture.
//!
//! Parameters and conventions are those of OpenCV's `calcOpticalFlowFarneback` with a box window, and the results agree
//! with it to a small fraction of a pixel; `tests/opencv_golden.rs` holds them together.
//!
//! Limits: motion larger than about half the window at the coarsest level is not found; where the picture has no texture
//! the flow tends to that of its surroundings or to nothing; there is no measure of confidence. Pixels of the last row and
//! column have no full neighbourhood in the other picture, which bends the flow near the edges (by up to 0.14 px on a
//! still picture): take means over an inner region.

mod displacement;
mod expansion;
mod params;

pub use params::{FarnebackError, FarnebackParams};

use crate::error::{PictureError, check_size};
use crate::picture::{Plane, PlaneView};
use crate::pyramid::{PyramidLevel, Resizer, pyramid_levels};
use crate::simd::CodePath;
use displacement::DisplacementSolver;
use expansion::{Expander, PixelExpansion, RowExpansion};

/// A displacement for every pixel: `next(x + dx, y + dy)` shows what `previous(x, y)` shows.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FlowField {
    /// Displacement to the right, pixels.
    pub dx: Plane<f32>,
    /// Displacement down, pixels.
    pub dy: Plane<f32>,
}

impl FlowField {
    /// A flow of `width` x `height` pixels, each displaced by `(dx, dy)` pixels.
    #[must_use]
    pub fn uniform(width: usize, height: usize, [dx, dy]: [f32; 2]) -> Self {
        Self { dx: Plane::new(width, height, dx), dy: Plane::new(width, height, dy) }
    }

    /// Width, pixels.
    #[must_use]
    pub fn width(&self) -> usize {
        self.dx.width()
    }

    /// Height, pixels.
    #[must_use]
    pub fn height(&self) -> usize {
        self.dx.height()
    }

    /// Displacement (right, down) of the pixel in column `x` and row `y`, pixels, or `None` outside the flow.
    #[must_use]
    pub fn get(&self, x: usize, y: usize) -> Option<[f32; 2]> {
        Some([self.dx.get(x, y)?, self.dy.get(x, y)?])
    }

    fn check(&self, size: (usize, usize)) -> Result<(), FarnebackError> {
        check_size("initial flow, dx", size, self.dx.size())?;
        check_size("initial flow, dy", size, self.dy.size())?;
        let mut pairs = self.dx.as_slice().iter().zip(self.dy.as_slice());
        match pairs.position(|(dx, dy)| !(dx.is_finite() && dy.is_finite())) {
            Some(index) => Err(FarnebackError::InitialFlow { x: index % size.0, y: index / size.0 }),
            None => Ok(()),
        }
    }

    fn reset(&mut self, width: usize, height: usize) {
        self.dx.reset(width, height, 0.0);
        self.dy.reset(width, height, 0.0);
    }
}

/// Dense flow between pairs of pictures; keeps its buffers from pair to pair.
///
/// ```
/// use fingerpost_vision::{farneback::{Farneback, FarnebackParams}, picture::Plane};
/// // A smooth pattern, and the same moved two pixels to the right.
/// let pattern = |shift: f32| {
///     let value = |x: f32, y: f32| (127.0 + 60.0 * (0.35 * (x - shift)).sin() + 60.0 * (0.3 * y).cos()) as u8;
///     Plane::from_vec(64, 64, (0..64 * 64).map(|i| value((i % 64) as f32, (i / 64) as f32)).collect())
/// };
/// let mut farneback = Farneback::new(FarnebackParams::default())?;
/// let flow = farneback.flow(pattern(0.0)?.view(), pattern(2.0)?.view(), None)?;
/// let [dx, dy] = flow.get(32, 32).unwrap_or_default();
/// assert!((dx - 2.0).abs() < 0.1 && dy.abs() < 0.1);
/// # Ok::<(), fingerpost_vision::farneback::FarnebackError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Farneback {
    params: FarnebackParams,
    levels: Vec<PyramidLevel>,
    expander: Expander,
    solver: DisplacementSolver,
    resizer: Resizer,
    pictures: [Plane<f32>; 2],
    smoothed: Plane<f32>,
    reduced: Plane<f32>,
    from: RowExpansion,
    to: PixelExpansion,
    flow: FlowField,
    coarser: FlowField,
}

impl Farneback {
    /// Prepares the flow.
    ///
    /// # Errors
    /// [`FarnebackError::Parameter`] when a parameter is outside its range.
    pub fn new(params: FarnebackParams) -> Result<Self, FarnebackError> {
        params.check()?;
        Ok(Self {
            params,
            levels: Vec::new(),
            expander: Expander::new(params.poly_n_px, params.poly_sigma_px),
            solver: DisplacementSolver::new(params.window_px / 2),
            resizer: Resizer::default(),
            pictures: Default::default(),
            smoothed: Plane::default(),
            reduced: Plane::default(),
            from: RowExpansion::default(),
            to: PixelExpansion::default(),
            flow: FlowField::default(),
            coarser: FlowField::default(),
        })
    }

    /// The parameters.
    #[must_use]
    pub fn params(&self) -> &FarnebackParams {
        &self.params
    }

    /// The flow from `previous` to `next`, grey pictures of one size, in pixels; starts from `initial` where given, which
    /// must have the pictures' size.
    ///
    /// # Errors
    /// [`FarnebackError::Picture`] when sizes differ or there are no pixels; [`FarnebackError::InitialFlow`].
    pub fn flow(
        &mut self,
        previous: PlaneView<'_, u8>,
        next: PlaneView<'_, u8>,
        initial: Option<&FlowField>,
    ) -> Result<&FlowField, FarnebackError> {
        let size = previous.size();
        check_size("next picture", size, next.size())?;
        if size.0 == 0 || size.1 == 0 {
            return Err(
                PictureError::Empty { what: "previous picture", width: size.0, height: size.1 }.into()
            );
        }
        if let Some(initial) = initial {
            initial.check(size)?;
        }
        if self.levels.last().map(|level| (level.width, level.height)) != Some(size) {
            self.levels = pyramid_levels(size.0, size.1, self.params.pyramid_scale, self.params.levels);
            // The two take turns from level to level; each must hold the largest, so that the next pair finds room.
            self.flow.reset(size.0, size.1);
            self.coarser.reset(size.0, size.1);
        }
        let path = CodePath::fastest();
        copy_to_f32(previous, &mut self.pictures[0]);
        copy_to_f32(next, &mut self.pictures[1]);
        for index in 0..self.levels.len() {
            self.start_level(index, initial);
            self.reduce(index, 0)?;
            self.expander.expand_rows(path, &self.reduced, &mut self.from);
            self.reduce(index, 1)?;
            self.expander.expand_pixels(path, &self.reduced, &mut self.to);
            for _ in 0..self.params.iterations {
                self.solver.refine(path, &self.from, &self.to, &mut self.flow);
            }
        }
        Ok(&self.flow)
    }

    /// Brings the flow found so far, or the initial one, to the size of a level.
    fn start_level(&mut self, index: usize, initial: Option<&FlowField>) {
        let level = &self.levels[index];
        std::mem::swap(&mut self.flow, &mut self.coarser);
        self.flow.reset(level.width, level.height);
        let (start, gain) = match (index, initial) {
            (0, None) => return,
            (0, Some(initial)) => (initial, level.scale),
            _ => (&self.coarser, 1.0 / self.params.pyramid_scale),
        };
        self.resizer.resize(&start.dx, &mut self.flow.dx, gain as f32);
        self.resizer.resize(&start.dy, &mut self.flow.dy, gain as f32);
    }

    /// Brings one of the pictures to the size of a level.
    fn reduce(&mut self, index: usize, picture: usize) -> Result<(), PictureError> {
        let (level, picture) = (&mut self.levels[index], &self.pictures[picture]);
        resize(&mut self.reduced, level.width, level.height);
        if picture.size() == self.reduced.size() {
            return level.smoothing.apply(picture, &mut self.reduced);
        }
        resize(&mut self.smoothed, picture.width(), picture.height());
        level.smoothing.apply(picture, &mut self.smoothed)?;
        self.resizer.resize(&self.smoothed, &mut self.reduced, 1.0);
        Ok(())
    }
}

/// Gives a plane another size; what it holds then does not matter.
fn resize(plane: &mut Plane<f32>, width: usize, height: usize) {
    if plane.size() != (width, height) {
        plane.reset(width, height, 0.0);
    }
}

fn copy_to_f32(source: PlaneView<'_, u8>, target: &mut Plane<f32>) {
    resize(target, source.width(), source.height());
    for y in 0..source.height() {
        target.row_mut(y).iter_mut().zip(source.row(y)).for_each(|(out, &value)| *out = f32::from(value));
    }
}
