//! A node of ROS 2 without ROS: it speaks DDS itself, so that nothing of ROS has to be installed where it runs.
//!
//! [`RosNode`] listens to a camera's pictures and what is measured beside them, and sends what the method makes of each picture.
//! Stamps are those of the pictures. Names of frames are those of REP 105, their axes those of REP 103.
//!
//! | in | message |
//! |---|---|
//! | pictures | `sensor_msgs/Image` or `CompressedImage` (JPEG, PNG) |
//! | calibration | `sensor_msgs/CameraInfo` |
//! | GPS | `sensor_msgs/NavSatFix` |
//! | speed and yaw rate | `geometry_msgs/TwistStamped`, `TwistWithCovarianceStamped` or `nav_msgs/Odometry`, x forward and z up |
//!
//! | out | message | frame |
//! |---|---|---|
//! | odometry | `nav_msgs/Odometry` with covariances, none of whose variances is zero | `odom`, `base_link` |
//! | the way driven | `nav_msgs/Path`, when it has a new pose | `odom` |
//! | the driving line ahead | `nav_msgs/Path` | `base_link` |
//! | steering angle and speed | `ackermann_msgs/AckermannDriveStamped`, and once more to stop | `base_link` |
//! | the followed feature | `visualization_msgs/MarkerArray` | `base_link` |
//! | the fix on a map | `sensor_msgs/NavSatFix` | `base_link` |
//! | inputs and method | `diagnostic_msgs/DiagnosticArray`, every second | |
//! | where the frames lie | `tf2_msgs/TFMessage`, where it is wanted | `map`, `odom`, `base_link` |
//!
//! Inputs are taken with best effort and keep the last ones, as sensors send; results are sent reliably. Messages that come are
//! read by `fingerpost_io::bag`, which reads the same ones from bags. A message that cannot be used is counted and said in the
//! diagnostics.
//!
//! Limits: no parameters, services, actions or `/rosout`; markers have the fields of ROS 2 Humble and later.

mod command;
mod frames;
mod health;
mod inbox;
mod markers;
mod messages;
mod node;
mod odometry;
mod place;
mod receiving;

pub use inbox::Arrival;
pub use node::{
    InputTopics, NodeError, NodeSetting, OutputTopics, PictureType, RosNode, Transforms, TwistType,
};
