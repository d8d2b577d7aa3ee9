//! Dilation of pictures by rectangles, crosses and ellipses, opening along rows, and thinning of shapes to lines.
//!
//! Dilation: J. Serra, "Image analysis and mathematical morphology", 1982. A pixel becomes the largest of those that the structuring
//! element covers when its middle lies on it; pixels outside the picture do not count. Elements have OpenCV's shapes.

mod dilation;
mod element;
mod row_opening;
mod thinning;

pub use dilation::Dilation;
pub use element::{ElementError, MAX_SIZE_PX, StructuringElement};
pub use row_opening::RowOpening;
pub use thinning::Thinning;
