//! What changed from one frame to the next, as log messages.

use fingerpost_format::{CameraRecordState, FrameRecord, TrackState};
use foxglove::messages::log::Level;
use foxglove::messages::{Log, Timestamp};

/// Remembers what was last said.
#[derive(Debug, Default)]
pub(crate) struct ChangeLog {
    state: Option<TrackState>,
    camera: Option<CameraRecordState>,
}

impl ChangeLog {
    /// What is new in a frame: a frame that could not be used, a change of the search's state with its reason, a change of what
    /// the camera's picture is good for.
    pub(crate) fn of(&mut self, timestamp: Timestamp, record: &FrameRecord) -> Vec<Log> {
        let line = |level: Level, message: String| Log {
            timestamp: Some(timestamp),
            level: level as i32,
            message,
            name: "fingerpost".to_owned(),
            file: String::new(),
            line: 0,
        };
        let frame = record.frame;
        if let Some(error) = &record.error {
            return vec![line(Level::Error, format!("frame {frame} is passed over: {error}"))];
        }
        let mut lines = Vec::new();
        if self.state.replace(record.state) != Some(record.state) {
            let level = if record.state == TrackState::Lost { Level::Warning } else { Level::Info };
            lines.push(line(level, format!("frame {frame}: {}", record.why)));
        }
        let camera = record.camera.as_ref().map(|camera| camera.state);
        if let Some(now) = camera.filter(|_| self.camera != camera) {
            let level = if now == CameraRecordState::Clear { Level::Info } else { Level::Warning };
            lines.push(line(level, format!("frame {frame}: the camera's picture is {}", camera_name(now))));
        }
        self.camera = camera;
        lines
    }
}

const fn camera_name(state: CameraRecordState) -> &'static str {
    match state {
        CameraRecordState::Clear => "clear",
        CameraRecordState::Frozen => "frozen",
        CameraRecordState::Black => "black",
        CameraRecordState::NoContrast => "without contrast",
    }
}
