//! What a message says.

use std::sync::Arc;

use fingerpost_format::CameraInfo;
use thiserror::Error;

use super::cdr::CdrError;
use super::frame_names::{FrameNameError, MOST_FRAMES};
use super::frames::{self, Axes, StaticTransform};
use super::picture::{Picture, PictureError};
use super::schema::Schema;
use super::{foxglove_messages, packed_message, ros_messages};

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
    /// Speed and turn.
    Twist(Twist),
    /// Turn of an inertial unit; none where it measures none.
    Inertial(Option<Inertial>),
    /// How frames sit on each other.
    Transforms(Vec<StaticTransform>),
}

/// Where a GPS receiver is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpsPosition {
    /// Latitude, degrees.
    pub lat_deg: f64,
    /// Longitude, degrees.
    pub lon_deg: f64,
}

/// How a vehicle moves, along the axes of a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Twist {
    /// Name of the frame; empty where the message names none.
    pub frame_id: Arc<str>,
    /// Speed along its axes, m/s.
    pub linear_mps: [f64; 3],
    /// Turn about its axes, rad/s.
    pub angular_rps: [f64; 3],
}

/// How a vehicle moves, in its own frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VehicleMotion {
    /// Speed forward, m/s.
    pub speed_mps: f64,
    /// Yaw rate, rad/s, positive to the left.
    pub yaw_rate_rps: f64,
}

/// A twist that does not say how the vehicle moves.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum TwistError {
    /// Its axes are not the vehicle's.
    #[error(
        "a twist is along the axes of {frame_id:?}, which is on the ground; record the vehicle's odometry, or its twist in base_link"
    )]
    OnGround {
        /// The frame.
        frame_id: Arc<str>,
    },
    /// It holds what is no number.
    #[error("a speed or yaw rate is no number; its sender is at fault")]
    NoNumber,
}

impl Twist {
    /// How the vehicle moves, by the axes of the twist's frame.
    ///
    /// # Errors
    /// [`TwistError`] when the frame is on the ground, or what it says is no number.
    pub fn of_vehicle(&self, axes: &Axes) -> Result<VehicleMotion, TwistError> {
        if frames::is_on_ground(&self.frame_id) {
            return Err(TwistError::OnGround { frame_id: Arc::clone(&self.frame_id) });
        }
        let ([speed_mps, ..], [.., yaw_rate_rps]) =
            (axes.in_vehicle(self.linear_mps), axes.in_vehicle(self.angular_rps));
        if speed_mps.is_finite() && yaw_rate_rps.is_finite() {
            Ok(VehicleMotion { speed_mps, yaw_rate_rps })
        } else {
            Err(TwistError::NoNumber)
        }
    }
}

/// What an inertial unit measures, along the axes of its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Inertial {
    /// Name of the frame; empty where the message names none.
    pub frame_id: Arc<str>,
    /// Turn about its axes, rad/s.
    pub angular_rps: [f64; 3],
    /// Acceleration against free fall along its axes, m/s²: upwards by gravity where it stands. None where it measures none.
    pub acceleration_mps2: Option<[f64; 3]>,
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
    /// It is packed by itself, and cannot be unpacked.
    #[error(
        "a message is packed with Zstandard and cannot be unpacked ({cause}); unpack the bag with `ros2 bag convert`"
    )]
    Packed {
        /// What the decoder says.
        cause: String,
    },
    /// The name of a frame in it is none.
    #[error(transparent)]
    FrameName(#[from] FrameNameError),
    /// It holds more transforms than there may be frames.
    #[error(
        "a message has {count} transforms, more than the {MOST_FRAMES} frames that a recording may have; its sender is at fault"
    )]
    Transforms {
        /// How many it says that it has.
        count: u32,
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
        _ => ros_messages::decode(schema, &packed_message::unpacked(data)?),
    }
}
