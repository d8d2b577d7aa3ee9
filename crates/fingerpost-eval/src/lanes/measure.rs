//! How lane edges are measured: regions of interest, thresholds, and what a deviation is divided by.

/// Rows of the paper's regions of interest, from the picture's base.
pub const LANE_ROI_ROWS: [u32; 4] = [100, 120, 140, 150];
/// The paper's thresholds of the Lane Position Deviation, squared pixels.
pub const LANE_THRESHOLDS_PX2: [f64; 3] = [10.0, 15.0, 20.0];

/// What the sum of an edge's squared distances is divided by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum LpdDivisor {
    /// The rows that the truth reaches, so that a short edge is measured as strictly as a long one.
    #[default]
    EvaluatedRows,
    /// The rows of the region, as equation 1 of paper 3 is printed (y_max - y_min): rows that the truth does not reach count as
    /// without deviation.
    Region,
}

/// Regions of interest, thresholds and divisor; the paper's by default, but for the divisor.
#[derive(Debug, Clone, PartialEq)]
pub struct LaneMeasure {
    /// Rows of the regions, from the picture's base, ascending.
    pub roi_rows: Vec<u32>,
    /// Thresholds of the Lane Position Deviation, squared pixels, ascending.
    pub thresholds_px2: Vec<f64>,
    /// What deviations are divided by.
    pub divisor: LpdDivisor,
}

impl Default for LaneMeasure {
    fn default() -> Self {
        Self {
            roi_rows: LANE_ROI_ROWS.to_vec(),
            thresholds_px2: LANE_THRESHOLDS_PX2.to_vec(),
            divisor: LpdDivisor::default(),
        }
    }
}
