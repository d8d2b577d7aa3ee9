//! The channels of a recording: a topic and the schema of its messages.

use foxglove::messages::{
    CameraCalibration, CompressedImage, FrameTransforms, GeoJson, Grid, ImageAnnotations, LocationFix, Log,
    Odometry, PosesInFrame, SceneUpdate,
};
use foxglove::{Encode, Schema};

/// A channel of a recording.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Channel {
    /// The camera's picture.
    CameraImage,
    /// The camera's intrinsics.
    CameraCalibration,
    /// What is drawn into the camera's picture.
    CameraAnnotations,
    /// The ground view.
    GroundView,
    /// The road surface.
    RoadSurface,
    /// The feature's masks.
    FeatureMasks,
    /// The followed feature.
    Feature,
    /// The driving line.
    DrivingLine,
    /// The driving line as the poses along it.
    DrivingLinePoses,
    /// The road's middle.
    Centreline,
    /// The lane.
    Lanes,
    /// The vehicle's pose by its own motion.
    Odometry,
    /// How the frames lie to each other.
    Transforms,
    /// Where the vehicle is on the map.
    Fix,
    /// The route.
    Route,
    /// The line of `frames.jsonl`.
    Record,
    /// What changed and why.
    Log,
}

/// Schema of a frame's record: an object, whose keys are those of `frames.jsonl`.
const RECORD_SCHEMA: &[u8] =
    br#"{"title":"fingerpost.FrameRecord","type":"object","properties":{"frame":{"type":"integer"},"t_s":{"type":"number"},"state":{"type":"string"},"why":{"type":"string"},"stage_ms":{"type":"object"}},"required":["frame","t_s","state"]}"#;

impl Channel {
    /// Every channel, in the order of the data.
    pub const ALL: [Self; 17] = [
        Self::CameraImage,
        Self::CameraCalibration,
        Self::CameraAnnotations,
        Self::GroundView,
        Self::RoadSurface,
        Self::FeatureMasks,
        Self::Feature,
        Self::DrivingLine,
        Self::DrivingLinePoses,
        Self::Centreline,
        Self::Lanes,
        Self::Odometry,
        Self::Transforms,
        Self::Fix,
        Self::Route,
        Self::Record,
        Self::Log,
    ];

    /// Its topic.
    pub const fn topic(self) -> &'static str {
        match self {
            Self::CameraImage => "/camera/image",
            Self::CameraCalibration => "/camera/calibration",
            Self::CameraAnnotations => "/camera/annotations",
            Self::GroundView => "/ground_view/image",
            Self::RoadSurface => "/road_surface",
            Self::FeatureMasks => "/feature/masks",
            Self::Feature => "/feature",
            Self::DrivingLine => "/driving_line",
            Self::DrivingLinePoses => "/driving_line/poses",
            Self::Centreline => "/centreline",
            Self::Lanes => "/lanes",
            Self::Odometry => "/odometry",
            Self::Transforms => "/tf",
            Self::Fix => "/fix",
            Self::Route => "/route",
            Self::Record => "/record",
            Self::Log => "/log",
        }
    }

    /// How its messages are encoded.
    pub const fn encoding(self) -> &'static str {
        match self {
            Self::Record => "json",
            _ => "protobuf",
        }
    }

    /// What its messages are.
    pub fn schema(self) -> Schema {
        let published = match self {
            Self::CameraImage | Self::GroundView => CompressedImage::get_schema(),
            Self::CameraCalibration => CameraCalibration::get_schema(),
            Self::CameraAnnotations => ImageAnnotations::get_schema(),
            Self::RoadSurface | Self::FeatureMasks => Grid::get_schema(),
            Self::Feature | Self::DrivingLine | Self::Centreline | Self::Lanes => SceneUpdate::get_schema(),
            Self::DrivingLinePoses => PosesInFrame::get_schema(),
            Self::Odometry => Odometry::get_schema(),
            Self::Transforms => FrameTransforms::get_schema(),
            Self::Fix => LocationFix::get_schema(),
            Self::Route => GeoJson::get_schema(),
            Self::Log => Log::get_schema(),
            Self::Record => None,
        };
        published.unwrap_or_else(|| Schema::new("fingerpost.FrameRecord", "jsonschema", RECORD_SCHEMA))
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_channel_has_a_topic_of_its_own_and_a_schema() {
        let topics: BTreeSet<&str> = Channel::ALL.iter().map(|channel| channel.topic()).collect();
        assert_eq!(topics.len(), Channel::ALL.len());
        for channel in Channel::ALL {
            let schema = channel.schema();
            assert!(!schema.data.is_empty(), "{channel:?}");
            let published = schema.name.starts_with("foxglove.");
            assert_eq!(published, channel != Channel::Record, "{channel:?} {}", schema.name);
        }
    }

    #[test]
    fn the_schema_of_records_is_json() {
        let schema: serde_json::Value = serde_json::from_slice(&Channel::Record.schema().data).unwrap();
        assert_eq!(schema["type"], "object");
    }
}
