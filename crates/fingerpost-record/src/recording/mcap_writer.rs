//! The recording: messages into an MCAP stream that is readable up to its last whole chunk whenever writing ends.
//!
//! Format: the MCAP specification (mcap.dev/spec). A chunk is written in one piece when it holds half a second of the drive or
//! [`CHUNK_BYTES`], so that a program that is killed loses no more than that; the summary behind the last chunk only makes
//! reading faster.

use std::collections::BTreeMap;
use std::io::{Seek, Write};

use fingerpost_map::{Route, RouteFileError};
use fingerpost_vision::jpeg::JpegError;
use mcap::records::MessageHeader;
use mcap::{Compression, WriteOptions, Writer};
use thiserror::Error;

use super::channel::Channel;
use super::frame_messages::{FrameMessages, route_message};
use super::frame_recorder::nanoseconds;

/// Most of the drive that one chunk holds, seconds.
const CHUNK_S: f64 = 0.5;
/// Bytes from which a chunk is written before that.
const CHUNK_BYTES: u64 = 4 << 20;

/// A recording that cannot go on; what was written before stays readable.
#[derive(Debug, Error)]
pub enum RecordingError {
    /// The stream takes no more bytes, or the messages do not fit into it.
    #[error("the recording cannot be written ({cause}); check the disk's free space")]
    Stream {
        /// What the system or the writer says.
        cause: String,
    },
    /// A picture cannot be compressed.
    #[error("a picture cannot be recorded: {0}")]
    Picture(#[from] JpegError),
    /// The route has no GeoJSON form.
    #[error("the route cannot be recorded: {0}")]
    Route(#[from] RouteFileError),
    /// A message has no bytes.
    #[error(
        "a message of {topic} cannot be encoded ({cause}); this is a fault of the program, please report it"
    )]
    Message {
        /// Its topic.
        topic: &'static str,
        /// What the encoder says.
        cause: String,
    },
}

impl From<mcap::McapError> for RecordingError {
    fn from(cause: mcap::McapError) -> Self {
        Self::Stream {
            cause: match cause {
                // The writer's own message leaves out the system's.
                mcap::McapError::Io(cause) => cause.to_string(),
                cause => cause.to_string(),
            },
        }
    }
}

/// A recording being written.
pub struct Recording<W: Write + Seek> {
    writer: Writer<W>,
    ids: BTreeMap<Channel, u16>,
    /// Time of the first frame in the chunk at hand, seconds.
    chunk_since_s: Option<f64>,
}

impl<W: Write + Seek> std::fmt::Debug for Recording<W> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recording").field("chunk_since_s", &self.chunk_since_s).finish_non_exhaustive()
    }
}

impl<W: Write + Seek> Recording<W> {
    /// Begins a recording of a drive along `route`, made by the program `written_by`.
    ///
    /// # Errors
    /// [`RecordingError`] when nothing can be written.
    pub fn create(sink: W, written_by: &str, route: Option<&Route>) -> Result<Self, RecordingError> {
        let options = WriteOptions::new()
            .library(written_by)
            .compression(Some(Compression::Lz4))
            .chunk_size(Some(CHUNK_BYTES))
            // A chunk goes out whole or not at all.
            .disable_seeking(true);
        let mut writer = options.create(sink)?;
        let mut ids = BTreeMap::new();
        for channel in Channel::ALL {
            let schema = channel.schema();
            let schema_id = writer.add_schema(&schema.name, &schema.encoding, &schema.data)?;
            let id = writer.add_channel(schema_id, channel.topic(), channel.encoding(), &BTreeMap::new())?;
            ids.insert(channel, id);
        }
        let mut recording = Self { writer, ids, chunk_since_s: None };
        if let Some(route) = route {
            recording.add(Channel::Route, 0, 0.0, &route_message(route)?)?;
        }
        Ok(recording)
    }

    /// Adds a frame's messages.
    ///
    /// # Errors
    /// [`RecordingError`] when they cannot be written; the frames before stay readable.
    pub fn write(&mut self, frame: &FrameMessages) -> Result<(), RecordingError> {
        for (channel, data) in &frame.messages {
            self.add(*channel, frame.frame, frame.t_s, data)?;
        }
        let t_s = frame.t_s;
        let since_s = *self.chunk_since_s.get_or_insert(t_s);
        // Also where times step back.
        if !(t_s - since_s).abs().lt(&CHUNK_S) {
            self.writer.flush()?;
            self.chunk_since_s = None;
        }
        Ok(())
    }

    /// Ends the recording with its summary and gives back what it was written to.
    ///
    /// # Errors
    /// [`RecordingError`] when the end cannot be written; what came before stays readable.
    pub fn finish(mut self) -> Result<W, RecordingError> {
        self.writer.finish()?;
        Ok(self.writer.into_inner())
    }

    fn add(&mut self, channel: Channel, frame: u64, t_s: f64, data: &[u8]) -> Result<(), RecordingError> {
        let Some(&channel_id) = self.ids.get(&channel) else { return Ok(()) };
        let time = nanoseconds(t_s);
        // Sequence numbers wrap after years of frames.
        let header = MessageHeader { channel_id, sequence: frame as u32, log_time: time, publish_time: time };
        Ok(self.writer.write_to_known_channel(&header, data)?)
    }
}

#[cfg(test)]
mod tests;
