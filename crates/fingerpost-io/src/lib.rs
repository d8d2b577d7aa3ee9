//! Files, videos and cameras: the only library crate that touches the outside world.
//!
//! Frames come in through [`FrameSource`], calibrations through [`read_camera`], results go out through [`RunFolder`],
//! [`DriveFolder`] and [`VideoWriter`]. [`CanDatabase`] and [`SignalLog`] give the vehicle's own signals. With feature `bags`, the module
//! `bag` reads MCAP recordings and ROS 2 bags. Every error names the file, the cause and what to do next. Nothing is printed.

mod address;
#[cfg(feature = "bags")]
pub mod bag;
#[cfg(feature = "bags")]
mod bag_files;
mod camera;
mod can;
mod closed_loop_folder;
mod converted_drive;
mod decoders;
mod drive_folder;
mod ffmpeg;
mod file;
mod folder_kind;
mod folder_lock;
mod frame_clock;
#[cfg(feature = "bags")]
mod indexed_recording;
mod input_digest;
mod json_lines;
mod kept_inputs;
mod latest;
mod line_file;
mod line_listener;
mod lockstep;
mod numbered_names;
mod output_folder;
mod periodic_sync;
mod picture_file;
mod picture_folder;
mod picture_frames;
mod private;
mod run_folder;
mod sampling;
mod setup_file;
mod signed_png;
mod source;
mod tether;
mod tuning_folder;
mod video;
mod video_writer;
mod waiting;
mod whole_file;

pub use address::without_credentials;
#[cfg(feature = "bags")]
pub use bag_files::{BagFilesError, bag_files, open_bag};
pub use camera::{CameraReadError, read_camera};
pub use can::{
    CanDatabase, CanDatabaseError, CanFrame, CanId, CanLogError, CanLogFrames, LogFrame, NoValue, NoValues,
    SignalLayout, SignalLog, SignalReading, SignalSample, UnknownSignal, parse_candump_line, read_can_log,
};
#[cfg(all(feature = "socketcan", target_os = "linux"))]
pub use can::{CanListener, CanListenerError};
pub use closed_loop_folder::{ClosedLoopFolder, ClosedLoopFolderError};
pub use converted_drive::{ConvertedDrive, ConvertedDriveError, ConvertedLogs, PictureEnding};
pub use drive_folder::{BusTexts, DriveFolder, DriveFolderError, FrameFormat, TruthFileError, read_truth};
pub use ffmpeg::{FfmpegPrograms, VideoError};
pub use file::{FileError, create_folder, read_bytes, read_bytes_within, read_text, read_text_within};
pub use folder_kind::{
    CLOSED_LOOP_FILE, CROSSINGS_FILE, FIXES_FILE, FolderKind, LOOP_FRAMES_FILE, MARKED_FRAMES_FOLDER,
    PLAN_FILE,
};
pub use folder_lock::FolderLockError;
pub use frame_clock::FrameClock;
#[cfg(feature = "bags")]
pub use indexed_recording::{IndexedRecording, IndexedRecordingError};
pub use input_digest::{drive_digest, file_digest};
pub use json_lines::{AppendError, JsonLinesFile, LineSink};
pub use kept_inputs::{OverInput, file_keeps_inputs, folder_keeps_inputs};
pub use line_file::LineFile;
pub use line_listener::{LineListener, LineListenerError, TimedLine, is_serial_port};
#[cfg(unix)]
pub use lockstep::standard_feed;
pub use lockstep::{FedFrame, FeedError, FrameFeed};
pub use numbered_names::TimesDoubt;
pub use output_folder::{OutputFolder, OutputFolderError};
pub use picture_file::{
    EncodeError, PictureFileError, decode_picture, encode_png, read_picture, write_deep_png, write_grey_png,
    write_jpeg, write_png, write_ppm,
};
pub use picture_folder::{PictureFolderError, picture_paths, text_files};
pub use private::create_private_folder;
pub use run_folder::{RunFolder, RunFolderError};
pub use sampling::Sampling;
pub use signed_png::{is_signed_png, write_signed_png};
pub use source::{
    DEFAULT_PICTURE_FPS, Frame, FrameDecoder, FrameError, FrameSource, SourceError, SourceOptions,
};
pub use tether::TETHER_ARGUMENT;
#[cfg(unix)]
pub use tether::become_tethered;
pub use tuning_folder::{TuningFolder, TuningFolderError};
pub use video::{Liveness, StampFaults, VideoDecoder};
pub use video_writer::VideoWriter;
pub use waiting::{DEFAULT_LONGEST_WAIT, set_longest_wait};
pub use whole_file::{remove_abandoned, write_file, write_private_file};
