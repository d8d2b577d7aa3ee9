//! What the page has from its program: ground views, and a place to save in.

use fingerpost_geometry::Camera;
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
