//! How lanes are marked.

use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;

/// Length of a dash, and of a dash and a gap together, metres.
const SHORT_DASHES_M: [f32; 2] = [3.0, 12.0];
const LONG_DASHES_M: [f32; 2] = [6.0, 18.0];

/// The lines of a marking. Of two lines the inner one is nearer to who drives along the road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LinePattern {
    /// None.
    None,
    /// One without gaps.
    Continuous,
    /// Dashes of 3 m with gaps of 9 m.
    Broken,
    /// Dashes of 6 m with gaps of 12 m.
    LongBroken,
    /// Two without gaps.
    Double,
    /// Two of which the inner one has gaps.
    DoubleInnerBroken,
    /// Two of which the outer one has gaps.
    DoubleOuterBroken,
    /// Two with gaps.
    DoubleBroken,
}

impl LinePattern {
    /// The dashes of each line, from the inner one to the outer one; none for a line without gaps.
    pub(crate) fn dashes_m(self) -> &'static [Option<[f32; 2]>] {
        const BROKEN: Option<[f32; 2]> = Some(SHORT_DASHES_M);
        match self {
            Self::None => &[],
            Self::Continuous => &[None],
            Self::Broken => &[BROKEN],
            Self::LongBroken => &[Some(LONG_DASHES_M)],
            Self::Double => &[None, None],
            Self::DoubleInnerBroken => &[BROKEN, None],
            Self::DoubleOuterBroken => &[None, BROKEN],
            Self::DoubleBroken => &[BROKEN, BROKEN],
        }
    }
}

/// The colour of a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LineColour {
    /// White.
    White,
    /// Yellow.
    Yellow,
}

/// A marking along a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LineStyle {
    /// Its lines.
    pub pattern: LinePattern,
    /// Their colour.
    pub colour: LineColour,
}

impl LineStyle {
    /// White lines.
    pub const fn white(pattern: LinePattern) -> Self {
        Self { pattern, colour: LineColour::White }
    }

    /// Yellow lines.
    pub const fn yellow(pattern: LinePattern) -> Self {
        Self { pattern, colour: LineColour::Yellow }
    }
}

/// How roads are divided into lanes, as many of them as the road has room for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LaneMarkings {
    /// What divides the directions of a road and lanes of one direction.
    pub between: LineStyle,
    /// What bounds the outermost lanes.
    pub edge: LineStyle,
    /// From the middle of a marking to that of the next, metres.
    pub lane_width_m: f64,
    /// Width of a line, metres.
    pub line_width_m: f64,
    /// Share of the paint that is gone, in flecks and as paleness.
    pub worn: f64,
}

impl LaneMarkings {
    /// A broken line between lanes, continuous ones along the edges, all of them white and whole.
    pub const WHITE: Self = Self {
        between: LineStyle::white(LinePattern::Broken),
        edge: LineStyle::white(LinePattern::Continuous),
        lane_width_m: 3.5,
        line_width_m: 0.15,
        worn: 0.0,
    };

    pub(super) fn check(&self) -> Result<(), SimError> {
        check_range("lane_width_m", self.lane_width_m, 2.5, 5.0, "2.5 to 5 metres")?;
        check_range("line_width_m", self.line_width_m, 0.05, 0.5, "0.05 to 0.5 metres")?;
        check_range("worn", self.worn, 0.0, 1.0, "a share between 0 and 1")
    }
}

impl Default for LaneMarkings {
    fn default() -> Self {
        Self::WHITE
    }
}
