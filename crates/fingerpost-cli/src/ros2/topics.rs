//! Arguments that name the node, its topics and where it is.

use std::env;
use std::net::Ipv4Addr;

use anyhow::{Result, bail};
use clap::{Args, ValueEnum};
use fingerpost_ros2::{InputTopics, NodeSetting, OutputTopics, PictureType, Transforms, TwistType};

use crate::mount_args::KnownCamera;

/// What names the domain where no argument does, as for every program of ROS 2.
const DOMAIN_VARIABLE: &str = "ROS_DOMAIN_ID";
/// The last domain that has ports of its own (RTPS 2.3, section 9.6.1).
const LAST_DOMAIN: u16 = 232;
/// What `image_transport` ends the names of topics of packed pictures with.
const PACKED_ENDING: &str = "/compressed";

/// Node and topics.
#[derive(Debug, Args)]
pub(super) struct TopicArgs {
    /// Topic of the camera's pictures: sensor_msgs Image, or CompressedImage (JPEG or PNG) where its name ends in /compressed.
    #[arg(long, value_name = "TOPIC", default_value = "/camera/image_raw")]
    image_topic: String,
    /// The message of pictures, where the topic's name does not say it.
    #[arg(long, value_enum, value_name = "TYPE")]
    image_type: Option<ImageType>,
    /// Topic of the camera's calibration, sensor_msgs CameraInfo; by default camera_info beside the pictures.
    #[arg(long, value_name = "TOPIC", conflicts_with = "camera")]
    camera_info_topic: Option<String>,
    /// Topic of GPS positions, sensor_msgs NavSatFix; none is listened to by default.
    #[arg(long, value_name = "TOPIC", requires = "roads")]
    gps_topic: Option<String>,
    /// Topic of the vehicle's speed and yaw rate (REP 103: along x, about z); none is listened to by default.
    #[arg(long, value_name = "TOPIC")]
    twist_topic: Option<String>,
    /// The message of speed and yaw rate.
    #[arg(long, value_enum, value_name = "TYPE", default_value = "twist-stamped", requires = "twist_topic")]
    twist_type: TwistMessage,
    /// Pictures that may wait while one is being used; the oldest make room for later ones and are counted. 1 to 1000.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u16).range(1..=1000))]
    queue: u16,
    /// Name of the node.
    #[arg(long, value_name = "NAME", default_value = "/fingerpost")]
    node: String,
    /// Topic that odometry is sent on, nav_msgs Odometry.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/odometry")]
    odometry_topic: String,
    /// Topic that the way driven is sent on, nav_msgs Path.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/path")]
    path_topic: String,
    /// Topic that the driving line ahead is sent on, nav_msgs Path.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/driving_line")]
    driving_line_topic: String,
    /// Topic that steering angle and speed are sent on, ackermann_msgs AckermannDriveStamped: speed 0 to stop. Most vehicles listen on
    /// /ackermann_cmd; by default none does.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/ackermann_cmd")]
    command_topic: String,
    /// Topic that the followed feature is sent on, visualization_msgs MarkerArray.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/feature")]
    feature_topic: String,
    /// Topic that the fix on the map is sent on, sensor_msgs NavSatFix; with --map.
    #[arg(long, value_name = "TOPIC", default_value = "/fingerpost/fix")]
    fix_topic: String,
    /// Topic that diagnostics are sent on, diagnostic_msgs DiagnosticArray.
    #[arg(long, value_name = "TOPIC", default_value = "/diagnostics")]
    diagnostics_topic: String,
    /// Send transforms on /tf: odom to base_link, and with --map also map to odom. Leave it out where another node sends them.
    #[arg(long)]
    tf: bool,
    /// Domain of ROS 2, 0 to 232; by default that of ROS_DOMAIN_ID, else 0.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(0..=i64::from(LAST_DOMAIN)))]
    domain: Option<u16>,
    /// Address of the network interface to use, as 127.0.0.1 for this machine alone; may be given several times. All by default.
    #[arg(long, value_name = "ADDRESS")]
    interface: Vec<Ipv4Addr>,
}

/// The message of pictures.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum ImageType {
    /// sensor_msgs Image.
    Image,
    /// sensor_msgs CompressedImage.
    CompressedImage,
}

/// The message of speed and yaw rate.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum TwistMessage {
    /// geometry_msgs TwistStamped.
    TwistStamped,
    /// geometry_msgs TwistWithCovarianceStamped.
    TwistWithCovarianceStamped,
    /// nav_msgs Odometry.
    Odometry,
}

impl TopicArgs {
    /// Topic of the camera's pictures.
    pub(super) fn pictures(&self) -> &str {
        &self.image_topic
    }

    /// What is listened to; a calibration where the camera is not known.
    pub(super) fn inputs(&self, known: &KnownCamera) -> InputTopics {
        let is_packed = self.image_topic.ends_with(PACKED_ENDING);
        let picture_type = match self.image_type {
            Some(ImageType::CompressedImage) => PictureType::CompressedImage,
            None if is_packed => PictureType::CompressedImage,
            Some(ImageType::Image) | None => PictureType::Image,
        };
        let twist_type = match self.twist_type {
            TwistMessage::TwistStamped => TwistType::TwistStamped,
            TwistMessage::TwistWithCovarianceStamped => TwistType::TwistWithCovarianceStamped,
            TwistMessage::Odometry => TwistType::Odometry,
        };
        let calibration = || self.camera_info_topic.clone().unwrap_or_else(|| beside(&self.image_topic));
        InputTopics {
            pictures: self.image_topic.clone(),
            picture_type,
            calibration: matches!(known, KnownCamera::Mount(_)).then(calibration),
            gps: self.gps_topic.clone(),
            twist: self.twist_topic.clone().map(|topic| (topic, twist_type)),
            depth: usize::from(self.queue),
        }
    }

    /// What is sent.
    pub(super) fn outputs(&self) -> OutputTopics {
        OutputTopics {
            odometry: self.odometry_topic.clone(),
            path: self.path_topic.clone(),
            driving_line: self.driving_line_topic.clone(),
            command: self.command_topic.clone(),
            feature: self.feature_topic.clone(),
            fix: self.fix_topic.clone(),
            diagnostics: self.diagnostics_topic.clone(),
            transforms: if self.tf { Transforms::Sent } else { Transforms::LeftToOthers },
        }
    }

    /// The node.
    pub(super) fn setting(&self) -> Result<NodeSetting> {
        let named = env::var(DOMAIN_VARIABLE).ok().filter(|text| !text.is_empty());
        let domain = match (self.domain, named) {
            (Some(domain), _) => domain,
            (None, Some(text)) => match text.parse() {
                Ok(domain) if domain <= LAST_DOMAIN => domain,
                _ => bail!("{DOMAIN_VARIABLE} is {text:?}; set it to 0 to {LAST_DOMAIN}, or give --domain"),
            },
            (None, None) => 0,
        };
        Ok(NodeSetting { name: self.node.clone(), domain, interfaces: self.interface.clone() })
    }
}

/// Where a camera's driver sends its calibration: beside the pictures, whatever they are packed in (`image_transport`).
fn beside(image_topic: &str) -> String {
    let raw = image_topic.strip_suffix(PACKED_ENDING).unwrap_or(image_topic);
    let camera = raw.rsplit_once('/').map_or("", |(camera, _)| camera);
    format!("{camera}/camera_info")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_calibration_lies_beside_its_pictures() {
        assert_eq!(beside("/camera/image_raw"), "/camera/camera_info");
        assert_eq!(beside("/front/left/image_raw/compressed"), "/front/left/camera_info");
        assert_eq!(beside("/image"), "/camera_info");
    }
}
