//! One colour for one meaning, as in the report.

use foxglove::messages::Color;

/// Yellow: where the feature is believed.
pub(crate) const FEATURE: [u8; 3] = [255, 221, 51];
/// Orange: the road's middle by its edges.
pub(crate) const CENTRELINE: [u8; 3] = [255, 128, 32];
/// Violet: an edge of the lane.
pub(crate) const LANE: [u8; 3] = [190, 120, 255];

/// A colour of the report, opaque by `alpha` (0 to 1).
pub(crate) fn colour([r, g, b]: [u8; 3], alpha: f64) -> Color {
    let unit = |part: u8| f64::from(part) / 255.0;
    Color { r: unit(r), g: unit(g), b: unit(b), a: alpha }
}
