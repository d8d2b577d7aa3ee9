//! What the papers claim, held against simulated drives: the settings that are compared, the figures, the verdicts and the page.
//!
//! Every claim is a comparison of settings on the same drives ([`variants`]). Whoever runs them gives a [`Measurement`] a drive;
//! the [`Page`] follows from those alone.

mod axes;
mod drives;
mod feature_claims;
mod figures;
mod lane_claims;
mod masks;
mod measurements;
mod page;
mod scatter;
mod sparse_flow;
mod verdict;

pub use axes::{Variant, variants};
pub use drives::{DriveError, Planned, RENDERED_FPS, ROADS, RoadKind, SIZE_PX};
pub use figures::{Place, followed_pct, map_from_vehicle, places, way_error_pct};
pub use lane_claims::{SAMPLES, cell_name};
pub use masks::{MaskReading, ReadingError};
pub use measurements::{Measured, Measurement, Measurements};
pub use page::{Asked, PLOTS_FOLDER, Page};
pub use sparse_flow::SparseFlow;
