//! Frames, cameras and curves on the road plane.
//!
//! Everything that must agree on where things are shares this crate: the method looks through a [`Camera`] at the
//! road, the simulator draws what that camera would see, the report draws lines back into its picture. The frames
//! and units are those of `CONVENTIONS.md`; transforms are named `target_from_source`.
//!
//! Limits: the road is the plane z = 0 of the vehicle frame; cameras look forward (no mirror or panorama optics).

mod angle;
mod camera;
mod distortion;
mod error;
mod ground_grid;
mod homography;
mod mount;
mod observed_angle;
mod pchip;
mod picture_scale;
mod pixel;
mod polyline;

pub use angle::{heading_of, wrap_angle};
pub use camera::{Camera, Intrinsics, View};
pub use distortion::Distortion;
pub use error::GeometryError;
pub use ground_grid::{GroundGrid, GroundPixel};
pub use homography::Homography;
pub use mount::Mount;
pub use observed_angle::ObservedAngle;
pub use pchip::Pchip;
pub use picture_scale::PictureScale;
pub use pixel::Pixel;
pub use polyline::{Footpoint, Polyline};
