//! Parameters of the flow, and why one cannot be computed.

use crate::error::PictureError;

/// Most reductions of the pyramid; with the mildest scale they already span a factor of ten.
const MAX_LEVELS: usize = 32;
/// Widest window, pixels.
const MAX_WINDOW_PX: usize = 255;
/// Most iterations a level; the flow settles in a few.
const MAX_ITERATIONS: usize = 100;
/// Largest neighbourhood for the expansion to either side, pixels.
const MAX_POLY_N_PX: usize = 31;
/// Range of the scale between levels: outside it levels would repeat, or skip what the window can follow.
const SCALES: std::ops::RangeInclusive<f64> = 0.1..=0.95;

/// Parameters of [`Farneback`](super::Farneback); the defaults suit ground views.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FarnebackParams {
    /// Size of each level of the pyramid relative to the next finer one, 0.1 to 0.95.
    pub pyramid_scale: f64,
    /// Levels below the full size, 0 to 32; levels smaller than 32 pixels are left out.
    pub levels: usize,
    /// Side of the square window over which displacements are taken to be alike, pixels; odd, 1 to 255.
    pub window_px: usize,
    /// Iterations at each level, 1 to 100.
    pub iterations: usize,
    /// Pixels to either side of a pixel that its polynomial is fitted to, 1 to 31.
    pub poly_n_px: usize,
    /// Standard deviation of the Gaussian that weights them, pixels; above 0 and at most `poly_n_px`.
    pub poly_sigma_px: f64,
}

impl Default for FarnebackParams {
    fn default() -> Self {
        Self { pyramid_scale: 0.5, levels: 3, window_px: 15, iterations: 3, poly_n_px: 5, poly_sigma_px: 1.2 }
    }
}

/// A flow that cannot be computed.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum FarnebackError {
    /// A parameter outside its range.
    #[error("the flow's parameter {name} cannot be {value}; {range}")]
    Parameter {
        /// Name of the parameter.
        name: &'static str,
        /// Value given.
        value: f64,
        /// What is allowed.
        range: &'static str,
    },
    /// Pictures whose sizes do not fit.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The initial flow holds a value that is not finite.
    #[error("the initial flow at pixel ({x}, {y}) is not finite; leave the initial flow out or mend it")]
    InitialFlow {
        /// Column of the pixel.
        x: usize,
        /// Row of the pixel.
        y: usize,
    },
}

impl FarnebackParams {
    /// Checks every parameter against its range.
    ///
    /// # Errors
    /// [`FarnebackError::Parameter`] for the first one outside it.
    pub fn check(&self) -> Result<(), FarnebackError> {
        let refuse = |name, value, range| Err(FarnebackError::Parameter { name, value, range });
        if !SCALES.contains(&self.pyramid_scale) {
            return refuse("pyramid_scale", self.pyramid_scale, "give 0.1 to 0.95");
        }
        if self.levels > MAX_LEVELS {
            return refuse("levels", self.levels as f64, "give 0 to 32");
        }
        if !(1..=MAX_WINDOW_PX).contains(&self.window_px) || self.window_px.is_multiple_of(2) {
            return refuse("window_px", self.window_px as f64, "give an odd number from 1 to 255");
        }
        if !(1..=MAX_ITERATIONS).contains(&self.iterations) {
            return refuse("iterations", self.iterations as f64, "give 1 to 100");
        }
        if !(1..=MAX_POLY_N_PX).contains(&self.poly_n_px) {
            return refuse("poly_n_px", self.poly_n_px as f64, "give 1 to 31");
        }
        // Below a tenth of a pixel the neighbours' weights vanish and no polynomial can be fitted.
        if !(0.1..=self.poly_n_px as f64).contains(&self.poly_sigma_px) {
            return refuse("poly_sigma_px", self.poly_sigma_px, "give 0.1 to poly_n_px");
        }
        Ok(())
    }
}
