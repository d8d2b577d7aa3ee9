//! A finished run stepped through frame by frame, and a drive set up by eye, as local web pages.
//!
//! - [`Overview`]: the whole run in short, gathered record by record: curves over time, and the events and worst frames to jump to.
//! - [`shapes`]: what a frame's record knows of places, on the road in metres and in the camera's picture in pixels.
//! - [`RunPage`]: the page, and its questions answered; `fingerpost_server` puts it on the loopback address.
//! - [`FeelPage`]: its part on which settings are felt: the last seconds run again, each stage before and after.
//! - [`Differences`]: two runs of one drive, and the frames in which they differ most, for the part on which they are compared.
//! - [`MountPage`]: the page on which a drive is set up: its camera's mount, with the horizon, [`metre_grid`] and the ground view that it
//!   gives, and with a [`RouteMap`] the start of its route.
//!
//! Nothing here opens a file: records come from [`Records`], pictures from [`fingerpost_server::Pictures`].

mod classes;
mod compare;
mod curves;
mod events;
mod feel;
mod mount_page;
mod overview;
mod page_files;
mod peaks;
mod route_map;
mod run_page;
mod shapes;
mod worst;

pub use classes::{NetworkClasses, SeenClass};
pub use compare::{Difference, DifferenceKind, Differences, Measure};
pub use curves::{Curve, Quantity};
pub use events::{Event, EventKind};
pub use feel::{
    Beginning, FeelPage, Feelable, FoundPoint, Refusal, Reruns, SavedSettings, StageView, Stretch,
};
pub use mount_page::{
    DriveFrames, DriveSources, GroundViews, Kept, MountPage, MountSearch, SearchState, SetUpKeeper,
};
pub use overview::Overview;
pub use route_map::{RouteMap, RoutePlace, RunMap};
pub use run_page::{GroundArea, Records, RunPage};
pub use shapes::{Shape, ShapeKind, metre_grid, shapes};
