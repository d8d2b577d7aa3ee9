//! What the page has from its program: ground views, a place to save in, and a search for the mount.

use fingerpost_geometry::{Camera, Mount};
use fingerpost_server::{Cause, Picture};
use serde::Serialize;

/// Where ground views come from.
pub trait GroundViews: Send + Sync {
    /// What a frame shows from above when such a camera took it.
    ///
    /// # Errors
    /// Why there is none.
    fn ground_view(&self, frame: u64, camera: &Camera) -> Result<Picture, Cause>;
}

/// Where goes what was set up.
pub trait SetUpKeeper: Send + Sync {
    /// Keeps a camera, and where on its route the drive begins, metres, in place of what was kept before.
    ///
    /// # Errors
    /// Why it could not be kept.
    fn keep(&self, camera: &Camera, start_m: Option<f64>) -> Result<Kept, Cause>;
}

/// What is kept.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Kept {
    /// Its files.
    pub files: Vec<String>,
    /// The command line that runs the drive with them.
    pub command: String,
}

/// A search for the mount in the whole drive, one at a time, that goes on while the page is used.
pub trait MountSearch: Send + Sync {
    /// Begins one about the mount of a camera.
    ///
    /// # Errors
    /// Why none can begin; one that goes on is a reason.
    fn begin(&self, camera: &Camera) -> Result<(), Cause>;

    /// Ends the one that goes on, if one does.
    fn stop(&self);

    /// How far it is, or what came of the last.
    fn state(&self) -> SearchState;
}

/// How far a search for the mount is.
#[derive(Debug, Clone)]
pub enum SearchState {
    /// None was begun, or the last was stopped.
    Idle,
    /// One goes on.
    Running {
        /// Frames that it has looked at.
        frames: u64,
        /// Of how many; none where the drive does not say.
        of: Option<u64>,
    },
    /// The drive shows the mount.
    Found {
        /// The mount.
        mount: Mount,
        /// What there is to say of it, a line each.
        said: Vec<String>,
    },
    /// The drive does not show it.
    Failed {
        /// Why, and what to do.
        cause: String,
    },
}
