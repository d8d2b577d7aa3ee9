//! A finished run stepped through frame by frame, as a local web page.
//!
//! - [`Overview`]: the whole run in short, gathered record by record: curves over time, and the events to jump to.
//! - [`shapes`]: what a frame's record knows of places, on the road in metres and in the camera's picture in pixels.
//! - [`RunPage`]: the page, and its questions answered; `fingerpost_server` puts it on the loopback address.
//!
//! Nothing here opens a file: records come from [`Records`], pictures from [`fingerpost_server::Pictures`].

mod curves;
mod events;
mod overview;
mod run_page;
mod shapes;

pub use curves::{Curve, Quantity};
pub use events::{Event, EventKind};
pub use overview::Overview;
pub use run_page::{GroundArea, Records, RunPage};
pub use shapes::{Shape, ShapeKind, shapes};
