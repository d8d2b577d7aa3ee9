//! Others' recordings: MCAP files, and ROS 2 bags that are stored as such, to pictures, calibrations, GPS and motion.
//!
//! [`Records`] reads messages from start to end out of whatever gives bytes, so that a file without its end reads as far as it
//! goes. [`survey`] says which topics there are, [`Choice`] which of them serve for what, and [`decode`] makes values of a
//! message. Nothing here opens a file.
//!
//! | schema | encoding | value |
//! |---|---|---|
//! | `sensor_msgs/msg/Image`, `sensor_msgs/msg/CompressedImage` | CDR | picture |
//! | `foxglove.RawImage`, `foxglove.CompressedImage` | protobuf | picture |
//! | `sensor_msgs/msg/CameraInfo`, `foxglove.CameraCalibration` | CDR, protobuf | calibration without a mount |
//! | `sensor_msgs/msg/NavSatFix`, `foxglove.LocationFix` | CDR, protobuf | GPS position |
//! | `geometry_msgs/msg/Twist`, `TwistStamped`, `TwistWithCovarianceStamped`, `nav_msgs/msg/Odometry` | CDR | speed and yaw rate |
//! | `sensor_msgs/msg/Imu` | CDR | turn and acceleration along its axes |
//! | `tf2_msgs/msg/TFMessage` on `/tf_static` | CDR | how frames are turned on each other |
//!
//! [`Frames`] says along which axes twists and inertial units measure. Messages that rosbag2 packed one by one are unpacked.
//!
//! Limits: video streams (`CompressedVideo`), Bayer and YUV pictures, SQLite bags and ROS 1 messages are not read; every one of
//! them is named where it is met.

mod cdr;
mod choice;
mod chunk_bounds;
mod foxglove_messages;
mod frame_names;
mod frames;
mod message;
mod packed_message;
mod picture;
mod record_fields;
mod records;
mod ros_messages;
mod schema;
mod survey;
mod topics;
mod zstd_chunks;

pub use cdr::CdrError;
pub use choice::{Choice, ChoiceError, Wanted, is_rectified};
pub use frame_names::FrameNameError;
pub use frames::{Axes, AxesSource, Frames, KnownAxes, StaticTransform};
pub use message::{
    Content, GpsPosition, Inertial, Message, MessageError, Twist, TwistError, VehicleMotion, decode,
};
pub use picture::{Picture, PictureError};
pub use records::{Record, Records, RecordsError};
pub use schema::{Role, Schema};
pub use survey::{Survey, Topic, survey};
