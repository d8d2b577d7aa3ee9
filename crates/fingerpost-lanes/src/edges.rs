//! Low and mid level: from a frame to thin lines that may be edges of markings (paper 3, III-A and III-B).
//!
//! Grey by the weights of CCIR 601, the mean of the last frames, Canny's edges; of these only what points to a stretch of the
//! horizon to which a lane can lead and, where inner edges alone are wanted, is brighter on the side away from the vehicle. Then
//! dilation, labels, least area and thinning.

mod limits;

use fingerpost_vision::canny::{Canny, CannyError, CannyParams, GradientNorm};
use fingerpost_vision::colour::grey_of_rows;
use fingerpost_vision::components::{ConnectedComponents, Connectivity};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::frame_buffer::FrameBuffer;
use fingerpost_vision::morphology::{Dilation, ElementError, StructuringElement, Thinning};
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::smoothing::{GaussianBlur, SmoothingError};
use thiserror::Error;

use self::limits::{RowLimits, lay_limits};
use super::LanesConfig;

pub use self::limits::MarkingEdges;
use super::region::LaneRegion;
use super::road_view::RoadView;

/// Window of the blur before the edges, pixels.
const BLUR_PX: usize = 5;
/// Window of the dilation, pixels: joins what Canny left apart.
const DILATION_PX: usize = 3;
/// The area threshold is for pictures this wide.
const AREA_WIDTH_PX: f64 = 640.0;
/// How far the horizon may be from where the calibration has it, share of the picture's height: 1.5 degrees of pitch in a
/// lens of 45 degrees.
const HORIZON_SHARE: f32 = 0.035;
/// Columns that are passed over at once where none of them is an edge.
const BLOCK_PX: usize = 32;
/// A gradient commoner than this share of the pixels is the road's texture.
const TEXTURE_SHARE: f64 = 0.9;
/// How much an edge must be stronger than that texture.
const TEXTURE_FACTOR: f64 = 1.5;
/// Upper thresholds are steps of this factor, so that few detectors are needed.
const THRESHOLD_STEP: f64 = 1.25;

/// A lane finder that cannot be set up.
#[derive(Debug, Error)]
pub enum LaneError {
    /// Paper 3's own finder is asked for, and none was given.
    #[error(
        "lanes.finder = \"sections\" is the papers' own: give the pipeline the parts of `fingerpost_papers::parts`, or choose \
         \"markings\""
    )]
    NotGiven,
    /// Thresholds of the edge detector.
    #[error("lanes: {0}")]
    Canny(#[from] CannyError),
    /// The blur.
    #[error("lanes: {0}")]
    Smoothing(#[from] SmoothingError),
    /// The dilation.
    #[error("lanes: {0}")]
    Element(#[from] ElementError),
    /// The Hough transform.
    #[error("lanes: {0}")]
    Hough(#[from] fingerpost_vision::hough::HoughError),
    /// Pictures do not fit together.
    #[error("lanes: {0}")]
    Picture(#[from] PictureError),
}

/// What the steps up to thin lines made of a frame: one picture a step, whose first row is the region's top (paper 3, figures 4
/// to 11). Pixels of edges are 255, all others 0.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct EdgeSteps {
    /// The picture's row that is the first of these.
    pub top_row: usize,
    /// Grey, the mean of the last frames.
    pub mean: Plane<u8>,
    /// All edges.
    pub edges: Plane<u8>,
    /// Those whose gradient has a direction that a marking's can have.
    pub oriented: Plane<u8>,
    /// The same, joined to their neighbours.
    pub dilated: Plane<u8>,
    /// Pieces that are large enough.
    pub labelled: Plane<u8>,
    /// The same, thinned to lines: what the Hough transform sees.
    pub thin: Plane<u8>,
}

impl EdgeSteps {
    fn reset(&mut self, top_row: usize, width: usize, rows: usize) {
        self.top_row = top_row;
        for plane in [
            &mut self.mean,
            &mut self.edges,
            &mut self.oriented,
            &mut self.dilated,
            &mut self.labelled,
            &mut self.thin,
        ] {
            plane.reset(width, rows, 0);
        }
    }
}

/// Finds the edges of the region, with the buffers that it needs.
#[derive(Debug)]
pub struct LaneEdges {
    kept: MarkingEdges,
    buffer: FrameBuffer,
    blur: GaussianBlur,
    canny: Canny,
    canny_high: f64,
    dilation: Dilation,
    components: ConnectedComponents,
    thinning: Thinning,
    grey: Plane<u8>,
    smooth: Plane<u8>,
    limits: Vec<RowLimits>,
}

impl LaneEdges {
    /// A finder that has seen no frame yet.
    ///
    /// # Errors
    /// [`LaneError`] when the kernels cannot be set up as configured.
    pub fn new(config: &LanesConfig, kept: MarkingEdges) -> Result<Self, LaneError> {
        Ok(Self {
            kept,
            buffer: FrameBuffer::new(config.buffer_frames),
            blur: GaussianBlur::new(BLUR_PX, 0.0)?,
            canny: Canny::new(params(config, config.canny_high))?,
            canny_high: config.canny_high,
            dilation: Dilation::new(StructuringElement::rectangle(DILATION_PX, DILATION_PX)?),
            components: ConnectedComponents::new(Connectivity::Eight),
            thinning: Thinning::new(),
            grey: Plane::default(),
            smooth: Plane::default(),
            limits: Vec::new(),
        })
    }

    /// Forgets the frames before.
    pub fn clear(&mut self) {
        self.buffer.clear();
    }

    /// Finds the lines of a frame. `curvature_per_m` is that of the vehicle's way by its yaw rate, positive left.
    ///
    /// # Errors
    /// [`LaneError`] when the frame does not reach down to the region's base, or thresholds that are adapted to it cannot be used.
    pub fn find(
        &mut self,
        config: &LanesConfig,
        region: &LaneRegion,
        view: &RoadView<'_>,
        curvature_per_m: f64,
        frame: &RgbImage,
        steps: &mut EdgeSteps,
    ) -> Result<(), LaneError> {
        let (width, rows) = (frame.width(), region.base_row - region.top_row);
        if steps.thin.size() != (width, rows) || steps.top_row != region.top_row {
            steps.reset(region.top_row, width, rows);
            self.grey.reset(width, rows, 0);
            self.smooth.reset(width, rows, 0);
            self.buffer.clear();
        }
        grey_of_rows(frame, region.top_row, &mut self.grey)?;
        self.buffer.add(self.grey.view(), &mut steps.mean)?;
        self.blur.apply(steps.mean.view(), &mut self.smooth)?;
        self.adapt(config)?;
        self.canny.apply(self.smooth.view(), &mut steps.edges)?;
        lay_limits(&mut self.limits, config, region, view, curvature_per_m, width);
        self.keep_oriented(steps);
        self.dilation.apply(steps.oriented.view(), &mut steps.dilated)?;
        self.components.find(steps.dilated.view());
        let least = config.min_area_px * width as f64 / AREA_WIDTH_PX;
        self.components.write_mask(&mut steps.labelled, |component| component.area_px as f64 >= least)?;
        self.thinning.apply(steps.labelled.view(), &mut steps.thin)?;
        Ok(())
    }

    /// Raises the edge detector's thresholds above the texture of the road.
    fn adapt(&mut self, config: &LanesConfig) -> Result<(), LaneError> {
        let mut counts = [0_u32; 256];
        let mut total = 0;
        // A sixteenth of the pixels: differences over two columns, in the Sobel gradient's units.
        for y in (1..self.smooth.height().saturating_sub(1)).step_by(4) {
            for around in self.smooth.row(y).windows(3).step_by(4) {
                counts[usize::from(around[0].abs_diff(around[2]))] += 1;
                total += 1;
            }
        }
        let most = (TEXTURE_SHARE * f64::from(total)) as u32;
        let mut seen = 0;
        let common = counts.iter().position(|&count| {
            seen += count;
            seen >= most
        });
        let texture = 4.0 * TEXTURE_FACTOR * common.unwrap_or(0) as f64;
        let steps = (libm::log((texture / config.canny_high).max(1.0)) / libm::log(THRESHOLD_STEP)).floor();
        let high = config.canny_high * libm::pow(THRESHOLD_STEP, steps);
        if (high - self.canny_high).abs() > 1e-9 {
            self.canny.set_params(params(config, high))?;
            self.canny_high = high;
        }
        Ok(())
    }

    /// Copies the edges that may be a marking's.
    fn keep_oriented(&self, steps: &mut EdgeSteps) {
        let EdgeSteps { top_row, edges, oriented, .. } = steps;
        let (width, height) = edges.size();
        let slack_rows = HORIZON_SHARE * (*top_row + height) as f32;
        let mut next = 0;
        for y in 0..height {
            let kept = oriented.row_mut(y);
            kept.fill(0);
            if y == 0 || y + 1 == height || width < 3 {
                continue;
            }
            while next + 1 < self.limits.len() && self.limits[next + 1].row <= y as f32 {
                next += 1;
            }
            let Some(&low) = self.limits.get(next).filter(|limit| limit.row <= y as f32) else { continue };
            let high = self.limits.get(next + 1).copied().unwrap_or(low);
            let limit = low.towards(&high, y as f32);
            let from = limit.from.clamp(1.0, (width - 1) as f32) as usize;
            let to = limit.to.clamp(1.0, (width - 1) as f32) as usize;
            if from >= to {
                continue;
            }
            let rows = [self.smooth.row(y - 1), self.smooth.row(y), self.smooth.row(y + 1)];
            for (block, columns) in edges.row(y)[from..to].chunks(BLOCK_PX).enumerate() {
                // Most blocks hold no edge.
                if columns.iter().fold(0, |any, &edge| any | edge) == 0 {
                    continue;
                }
                for (offset, _) in columns.iter().enumerate().filter(|&(_, &edge)| edge != 0) {
                    let x = from + block * BLOCK_PX + offset;
                    if limit.accepts(self.kept, x as f32, y as f32, sobel_at(rows, x), slack_rows) {
                        kept[x] = 255;
                    }
                }
            }
        }
    }
}

/// The Sobel gradient of the middle of three rows, to the right and down.
fn sobel_at(rows: [&[u8]; 3], x: usize) -> [f32; 2] {
    let at = |row: usize, x: usize| i32::from(rows[row][x]);
    let right = at(0, x + 1) + 2 * at(1, x + 1) + at(2, x + 1);
    let left = at(0, x - 1) + 2 * at(1, x - 1) + at(2, x - 1);
    let below = at(2, x - 1) + 2 * at(2, x) + at(2, x + 1);
    let above = at(0, x - 1) + 2 * at(0, x) + at(0, x + 1);
    [(right - left) as f32, (below - above) as f32]
}

fn params(config: &LanesConfig, high: f64) -> CannyParams {
    CannyParams { low: config.canny_low_share * high, high, norm: GradientNorm::L1 }
}

#[cfg(test)]
mod tests;
