//! What a message says.

use fingerpost_format::CameraInfo;
use thiserror::Error;

use super::cdr::CdrError;
use super::picture::{Picture, PictureError};
use super::schema::Schema;
use super::{foxglove_messages, ros_messages};

/// A message's values and time.
#[derive(Debug, Clone, PartialEq)]
pub struct Message {
    /// When what it says was so, nanoseconds on its sender's clock; none where it does not say.
    pub stamp_ns: Option<u64>,
    /// What it says.
    pub content: Content,
}

/// What a message says.
#[derive(Debug, Clone, PartialEq)]
pub enum Content {
    /// The camera's picture.
    Picture(Picture),
    /// The camera's intrinsics.
    Calibration(CameraInfo),
    /// A position; none where the receiver has none.
    Gps(Option<GpsPosition>),
    /// Speed and yaw rate.
    Twist(Twist),
    /// Yaw rate of an inertial unit, rad/s, positive to the left; none where it measures none.
    YawRate(Option<f64>),
}

/// Where a GPS receiver is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpsPosition {
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
}

/// How a vehicle moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Twist {
    /// Speed forward, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: f64,
}

/// A message that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum MessageError {
    /// It is no CDR of its type.
    #[error("a message is no {name}: {cause}")]
    Cdr {
        /// The schema's name.
        name: &'static str,
        /// What is wrong.
        cause: CdrError,
    },
    /// It is no protobuf of its type.
    #[error("a message is no {name}: {cause}")]
    Protobuf {
        /// The schema's name.
        name: &'static str,
        /// What the decoder says.
        cause: String,
    },
    /// Its picture cannot be used.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// Its calibration is none of a whole picture.
    #[error(
        "the calibration is that of a picture that was binned by {binning_px:?} or cut to a region; give the calibration of the \
         pictures as they are in a file instead"
    )]
    Binned {
        /// Pixels that became one, across and down.
        binning_px: [u32; 2],
    },
}

/// The values of a message.
///
/// # Errors
/// [`MessageError`] when it is none of its schema, or holds what is not read.
pub fn decode(schema: Schema, data: &[u8]) -> Result<Message, MessageError> {
    match schema.encoding() {
        "protobuf" => foxglove_messages::decode(schema, data),
        _ => ros_messages::decode(schema, data),
    }
}
