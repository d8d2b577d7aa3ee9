//! A frame's messages as bytes, for a file, for viewers that are connected, or for both.

use bytes::Bytes;
use fingerpost_format::{FrameRecord, ToJson};
use fingerpost_map::{Route, write_route};
use fingerpost_vision::jpeg::{JpegEncoder, JpegPlanes};
use foxglove::messages::{CompressedImage, GeoJson};

use super::channel::Channel;
use super::frame_recorder::{RecordedFrame, encoded, nanoseconds, timestamp};
use super::log::ChangeLog;
use super::mcap_writer::RecordingError;

/// Quality of pictures: no block is seen at twice their size.
const JPEG_QUALITY: u8 = 85;

/// The messages of a frame in the order in which they are sent.
#[derive(Debug, Clone, PartialEq)]
pub struct FrameMessages {
    /// The frame's number.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// The messages.
    pub messages: Vec<(Channel, Vec<u8>)>,
}

impl FrameMessages {
    /// The time of the messages, nanoseconds since the first frame.
    pub fn time_ns(&self) -> u64 {
        nanoseconds(self.t_s)
    }
}

/// Makes messages of frames: compresses their pictures and notices what has changed.
#[derive(Debug)]
pub struct MessageEncoder {
    changes: ChangeLog,
    encoder: JpegEncoder,
    /// Memory that pictures are compressed in.
    jpeg: Vec<u8>,
}

impl Default for MessageEncoder {
    fn default() -> Self {
        Self { changes: ChangeLog::default(), encoder: JpegEncoder::new(JPEG_QUALITY), jpeg: Vec::new() }
    }
}

impl MessageEncoder {
    /// The messages of a frame that was used, with its record.
    ///
    /// # Errors
    /// [`RecordingError`] when a picture or message cannot be encoded.
    pub fn frame(
        &mut self,
        frame: RecordedFrame,
        record: &FrameRecord,
    ) -> Result<FrameMessages, RecordingError> {
        let mut messages = Vec::with_capacity(Channel::ALL.len());
        for (channel, frame_id, picture) in frame.pictures {
            let message = CompressedImage {
                timestamp: Some(timestamp(frame.t_s)),
                frame_id: frame_id.to_owned(),
                data: self.compressed(&picture)?,
                format: "jpeg".to_owned(),
            };
            messages.push((channel, bytes_of(channel, &message)?));
        }
        messages.extend(frame.messages);
        self.add_record(&mut messages, record)?;
        Ok(FrameMessages { frame: record.frame, t_s: frame.t_s, messages })
    }

    /// The record alone: of a frame that could not be used.
    ///
    /// # Errors
    /// [`RecordingError`] when it cannot be encoded.
    pub fn record(&mut self, record: &FrameRecord) -> Result<FrameMessages, RecordingError> {
        let mut messages = Vec::new();
        self.add_record(&mut messages, record)?;
        Ok(FrameMessages { frame: record.frame, t_s: record.t_s, messages })
    }

    fn add_record(
        &mut self,
        messages: &mut Vec<(Channel, Vec<u8>)>,
        record: &FrameRecord,
    ) -> Result<(), RecordingError> {
        let line = record.to_json().map_err(|cause| RecordingError::Message {
            topic: Channel::Record.topic(),
            cause: cause.to_string(),
        })?;
        messages.push((Channel::Record, line.into_bytes()));
        for entry in self.changes.of(timestamp(record.t_s), record) {
            messages.push((Channel::Log, bytes_of(Channel::Log, &entry)?));
        }
        Ok(())
    }

    /// A picture as JPEG, in memory of its size.
    fn compressed(&mut self, picture: &JpegPlanes) -> Result<Bytes, RecordingError> {
        self.jpeg.clear();
        self.encoder.encode(picture, &mut self.jpeg)?;
        Ok(Bytes::copy_from_slice(&self.jpeg))
    }
}

/// The message of [`Channel::Route`].
///
/// # Errors
/// [`RecordingError`] when the route has no GeoJSON form.
pub fn route_message(route: &Route) -> Result<Vec<u8>, RecordingError> {
    bytes_of(Channel::Route, &GeoJson { geojson: write_route(route)? })
}

fn bytes_of<M: foxglove::Encode>(channel: Channel, message: &M) -> Result<Vec<u8>, RecordingError> {
    encoded(message)
        .map_err(|cause| RecordingError::Message { topic: channel.topic(), cause: cause.to_string() })
}
