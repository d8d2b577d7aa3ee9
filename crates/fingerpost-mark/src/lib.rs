//! Lane edges marked by hand: the paper's RoadMarker (paper 3, IV-B and figure 20) as a local web page.
//!
//! A person marks the two edges of the vehicle's lane in key frames; between them an edge is interpolated, row by row and
//! linearly in time. Three layers that know nothing of the one above:
//!
//! - [`LaneMarks`]: the marks, the curve through an edge's points and what an edge is in any frame; [`truth_of_marks`] and
//!   [`tusimple_of_marks`] make truth of them.
//! - [`Session`]: edits that can be undone.
//! - [`Desk`]: the page, and questions and edits as they come from it, answered; `fingerpost_server` puts it on the loopback
//!   address.
//!
//! Nothing here opens a file: pictures come from [`fingerpost_server::Pictures`], marks and truth leave through [`Keeper`].

mod desk;
mod edge_curve;
mod export;
mod lane_marks;
mod session;

pub use desk::{Desk, Keeper};
pub use edge_curve::EdgeCurve;
pub use export::{ExportError, truth_of_marks, tusimple_of_marks};
pub use lane_marks::{EdgeInFrame, LaneMarks, Marked};
pub use session::{Edit, Session};
