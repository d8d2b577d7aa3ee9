//! The outside contract as types: what the program's files hold.
//!
//! Texts in, values out and back; nothing here opens a file. Producers and consumers (the program, the simulator, the
//! evaluation, anybody else's tools) meet in these types and in nothing else. Degrees appear here alone, in keys that
//! end in `_deg`; everything behind the files is in radians.

mod advice;
mod camera_file;
mod camera_info;
mod camera_yaml;
mod campaign;
mod centreline;
mod closed_loop;
mod columns;
mod drive_summary;
mod frame_header;
mod frame_record;
mod json;
mod kitti;
mod lanes;
mod location;
mod marks;
mod motion_log;
mod read_camera;
mod summary;
mod times;
mod track_files;
mod truth;
mod tuning;
mod tusimple;

pub use advice::{AdviceRecord, FiredRuleRecord, SilenceRecord};
pub use camera_file::{
    CameraFileError, camera_from_toml, camera_to_toml, is_written_camera, mount_from_toml, points_to_toml,
};
pub use camera_info::{CameraInfo, PictureKind};
pub use camera_yaml::camera_from_yaml;
pub use campaign::{Campaign, CampaignDrive, CampaignGroup, RoadEdgeSummary, SigmaQuantiles, WorstDrive};
pub use centreline::{CentrelineRecord, WaysRecord};
pub use closed_loop::{ClosedLoop, CrossTrackCounts, JUNCTION_M, LoopDrive, LoopEnd, LoopFrame, LoopGroup};
pub use columns::ColumnsError;
pub use drive_summary::DriveSummary;
pub use frame_header::{FrameHeader, FrameHeaderError};
pub use frame_record::{
    CameraRecord, CameraRecordState, ContrastRecord, DisagreementRecord, FeatureRecord, FixRecord,
    FrameRecord, MeasurementRecord, MotionDoubtRecord, MotionRecord, MountContradictionRecord,
    MountFaultRecord, MountRecord, MountRecordState, RivalRecord, RoadSurfaceRecord, SignalsRecord,
    SoughtRecord, TrackState,
};
pub use json::{FromJson, LinesError, ToJson, from_json_lines, json_lines, to_json_line};
pub use kitti::{KittiError, KittiOxts, KittiTime, kitti_oxts, kitti_projection, kitti_timestamps};
pub use lanes::{
    DepartureRecord, LaneEdgeRecord, LanesRecord, MarkingColour, MarkingKind, MarkingRecord, Side,
};
pub use location::{
    FixLine, FixStatus, GpsCount, GpsLine, LocationScores, LocationSummary, MapNoticeRecord, MotionFaults,
    PlaceLine, Recall,
};
pub use marks::{
    EdgeMark, MARKS_VERSION, MarksError, MarksFile, is_near_picture, marks_from_json, marks_to_json,
};
pub use motion_log::{
    MotionLog, MotionLogRow, PoseLogRow, motion_log_text, parse_motion_log, parse_pose_log, pose_log_text,
};
pub use read_camera::{CameraRemark, ReadCamera};
// For `json_records`.
#[doc(hidden)]
pub use serde_json;
pub use summary::{
    ErrorQuantiles, FeatureOutcome, FeatureSummary, SamplingRecord, StageTime, Summary, TruthSummary,
};
pub use times::{TimesError, parse_times};
pub use track_files::{TrackPoint, gps_gpx, track_geojson, track_gpx, track_kitti, track_tum, utc_time};
pub use truth::TruthRecord;
pub use tuning::{
    TriedSettings, TuningFront, TuningObjective, TuningPoint, TuningPurpose, TuningScores, TuningTrial,
};
pub use tusimple::{TUSIMPLE_NO_POINT, TuSimpleRecord};
