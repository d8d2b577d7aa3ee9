//! A vehicle's camera from what it sees: its lens, how it is mounted, and how far it sees the road.
//!
//! | known | found | by |
//! |---|---|---|
//! | pictures of a chessboard | focal lengths, principal point, distortion | [`calibrate_lens`] |
//! | lens, a drive | pitch, yaw, roll; with a known length the height | [`MountCalibrator`], [`LaneWidth`]; held against [`DrivenWay`] |
//! | lens, four places on the road | the whole mount | [`mount_from_points`] |
//! | the whole camera | how far ahead its rows show the road | [`Reach`] |
//!
//! Frames, units and signs are those of `CONVENTIONS.md`. Everything here is done once, before a drive or after it; what watches
//! the mount while driving is `fingerpost::mount`. No file, clock or environment is read.

mod board;
mod driven_way;
mod lane_width;
mod lens;
mod mount;
mod points;
mod reach;

pub use board::{SizesError, board_points, common_size};
pub use driven_way::{DrivenWay, DrivenWayError};
pub use lane_width::LaneWidth;
pub use lens::{BoardOutcome, BoardPoint, LensCalibration, LensCalibrationError, calibrate_lens};
pub use mount::{CadenceDoubt, CalibrationError, Estimated, KnownScale, MountCalibration, MountCalibrator};
pub use points::{MountFromPoints, PointsError, mount_from_points};
pub use reach::{FARTHEST_M, Reach, ReachOfReaction, ReachOfRows, RowsNeeded};
