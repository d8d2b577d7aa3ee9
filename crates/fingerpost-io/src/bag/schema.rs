//! The messages that are read, by the name of their schema.

/// A message that is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Schema {
    /// `sensor_msgs/msg/Image`
    RosImage,
    /// `sensor_msgs/msg/CompressedImage`
    RosCompressedImage,
    /// `sensor_msgs/msg/CameraInfo`
    RosCameraInfo,
    /// `sensor_msgs/msg/NavSatFix`
    RosNavSatFix,
    /// `sensor_msgs/msg/Imu`
    RosImu,
    /// `geometry_msgs/msg/Twist`
    RosTwist,
    /// `geometry_msgs/msg/TwistStamped`
    RosTwistStamped,
    /// `geometry_msgs/msg/TwistWithCovarianceStamped`
    RosTwistWithCovarianceStamped,
    /// `nav_msgs/msg/Odometry`
    RosOdometry,
    /// `tf2_msgs/msg/TFMessage`
    RosTransforms,
    /// `foxglove.RawImage`
    FoxgloveRawImage,
    /// `foxglove.CompressedImage`
    FoxgloveCompressedImage,
    /// `foxglove.CameraCalibration`
    FoxgloveCameraCalibration,
    /// `foxglove.LocationFix`
    FoxgloveLocationFix,
}

/// What a message is good for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Role {
    /// The camera's picture.
    Pictures,
    /// The camera's intrinsics.
    Calibration,
    /// A GPS position.
    Gps,
    /// Speed and yaw rate.
    Twist,
    /// Yaw rate of an inertial unit.
    Imu,
    /// How frames sit on each other.
    Transforms,
}

impl Schema {
    /// Every message that is read.
    pub const ALL: [Self; 14] = [
        Self::RosImage,
        Self::RosCompressedImage,
        Self::RosCameraInfo,
        Self::RosNavSatFix,
        Self::RosImu,
        Self::RosTwist,
        Self::RosTwistStamped,
        Self::RosTwistWithCovarianceStamped,
        Self::RosOdometry,
        Self::RosTransforms,
        Self::FoxgloveRawImage,
        Self::FoxgloveCompressedImage,
        Self::FoxgloveCameraCalibration,
        Self::FoxgloveLocationFix,
    ];

    /// The message of a schema's name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|schema| schema.name() == name)
    }

    /// Its schema's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RosImage => "sensor_msgs/msg/Image",
            Self::RosCompressedImage => "sensor_msgs/msg/CompressedImage",
            Self::RosCameraInfo => "sensor_msgs/msg/CameraInfo",
            Self::RosNavSatFix => "sensor_msgs/msg/NavSatFix",
            Self::RosImu => "sensor_msgs/msg/Imu",
            Self::RosTwist => "geometry_msgs/msg/Twist",
            Self::RosTwistStamped => "geometry_msgs/msg/TwistStamped",
            Self::RosTwistWithCovarianceStamped => "geometry_msgs/msg/TwistWithCovarianceStamped",
            Self::RosOdometry => "nav_msgs/msg/Odometry",
            Self::RosTransforms => "tf2_msgs/msg/TFMessage",
            Self::FoxgloveRawImage => "foxglove.RawImage",
            Self::FoxgloveCompressedImage => "foxglove.CompressedImage",
            Self::FoxgloveCameraCalibration => "foxglove.CameraCalibration",
            Self::FoxgloveLocationFix => "foxglove.LocationFix",
        }
    }

    /// The encoding that its messages are read in.
    pub const fn encoding(self) -> &'static str {
        match self {
            Self::FoxgloveRawImage
            | Self::FoxgloveCompressedImage
            | Self::FoxgloveCameraCalibration
            | Self::FoxgloveLocationFix => "protobuf",
            _ => "cdr",
        }
    }

    /// What it is good for.
    pub const fn role(self) -> Role {
        match self {
            Self::RosImage
            | Self::RosCompressedImage
            | Self::FoxgloveRawImage
            | Self::FoxgloveCompressedImage => Role::Pictures,
            Self::RosCameraInfo | Self::FoxgloveCameraCalibration => Role::Calibration,
            Self::RosNavSatFix | Self::FoxgloveLocationFix => Role::Gps,
            Self::RosTwist
            | Self::RosTwistStamped
            | Self::RosTwistWithCovarianceStamped
            | Self::RosOdometry => Role::Twist,
            Self::RosImu => Role::Imu,
            Self::RosTransforms => Role::Transforms,
        }
    }
}
