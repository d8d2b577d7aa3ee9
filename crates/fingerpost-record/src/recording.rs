//! Recordings: a run as MCAP messages in Foxglove's published schemas, for the viewers that people already have.
//!
//! [`FrameRecorder`] turns a frame with its evidence into messages while the evidence is there, [`MessageEncoder`] makes bytes of
//! them, later and elsewhere if need be, because pictures compress slowly, and [`Recording`] writes these to whatever takes
//! bytes. Times are those of the drive, from zero, so that the same run gives the same bytes. [`Odometry`], [`feature_entities`] and
//! [`position_covariance`] serve other formats of messages too. [`RecordedSurface`] reads a road surface back.
//!
//! | topic | schema | frame |
//! |---|---|---|
//! | `/camera/image` | `foxglove.CompressedImage`, JPEG | `camera` |
//! | `/camera/calibration` | `foxglove.CameraCalibration` | `camera` |
//! | `/camera/annotations` | `foxglove.ImageAnnotations`: lane edges, driving line, the feature's node | pixels |
//! | `/ground_view/image` | `foxglove.CompressedImage`, JPEG | `ground` |
//! | `/road_surface` | `foxglove.Grid`: `road` (0 to 255: probability 0 to 1), `known` (0 unknown, 1 remembered, 2 seen) | `vehicle` |
//! | `/feature/masks` | `foxglove.Grid`: `mask`, number of the sub-mask from 1, 0 for none | `vehicle` |
//! | `/feature` | `foxglove.SceneUpdate`: arms and node of the followed feature | `vehicle` |
//! | `/driving_line`, `/centreline`, `/lanes` | `foxglove.SceneUpdate` | `vehicle` |
//! | `/driving_line/poses` | `foxglove.PosesInFrame` | `vehicle` |
//! | `/odometry` | `foxglove.Odometry` with covariance | `odom` |
//! | `/tf` | `foxglove.FrameTransforms`: `odom` to `vehicle` to `camera` | |
//! | `/fix` | `foxglove.LocationFix` with covariance | |
//! | `/route` | `foxglove.GeoJSON` | |
//! | `/record` | the line of `frames.jsonl`, JSON | |
//! | `/log` | `foxglove.Log`: what changed and why | |
//!
//! Limits: `odom` is dead reckoning from the first frame and drifts; a camera that is known by points has neither calibration nor
//! place.

mod annotations;
mod channel;
mod colour;
mod entities;
mod frame_messages;
mod frame_recorder;
mod ground;
mod log;
mod mcap_writer;
mod odometry;
mod place;
mod transforms;

pub use channel::Channel;
pub use entities::feature_entities;
pub use frame_messages::{FrameMessages, MessageEncoder, route_message};
pub use frame_recorder::{FrameRecorder, RecordedFrame};
pub use ground::{RecordedSurface, SurfaceError};
pub use mcap_writer::{Recording, RecordingError};
pub use odometry::{Odometry, OdometryEstimate, Velocity};
pub use place::position_covariance;
