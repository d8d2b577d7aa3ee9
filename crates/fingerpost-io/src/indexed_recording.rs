//! An MCAP recording of which single messages are read, by the index at its end.

use std::{
    fs::File,
    io::{self, Read, Seek, SeekFrom},
    path::{Path, PathBuf},
    sync::{Mutex, PoisonError},
    time::Duration,
};

use mcap::{
    McapError, Summary,
    sans_io::{
        IndexedReadEvent, IndexedReader, IndexedReaderOptions, SummaryReadEvent, SummaryReader,
        SummaryReaderOptions,
    },
};
use thiserror::Error;

use crate::file::FileError;

/// Bytes of the largest record or chunk, packed and unpacked.
const MOST_RECORD_BYTES: usize = 128 << 20;

/// A recording that cannot be looked things up in.
#[derive(Debug, Error)]
pub enum IndexedRecordingError {
    /// The file cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// Its index is damaged, or not there because its program was killed.
    #[error("{} has no index that can be used ({cause}); mend it with `mcap recover`", .path.display())]
    Index {
        /// The file.
        path: PathBuf,
        /// What the reader says.
        cause: String,
    },
}

/// A recording with its index.
pub struct IndexedRecording {
    path: PathBuf,
    file: Mutex<File>,
    summary: Summary,
}

impl std::fmt::Debug for IndexedRecording {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("IndexedRecording").field("path", &self.path).finish_non_exhaustive()
    }
}

impl IndexedRecording {
    /// Reads the index.
    ///
    /// # Errors
    /// [`IndexedRecordingError`] when the file cannot be read, or has no index.
    pub fn open(path: &Path) -> Result<Self, IndexedRecordingError> {
        let mut file = File::open(path).map_err(FileError::reading(path))?;
        let bytes = file.metadata().map_err(FileError::reading(path))?.len();
        let summary = summary(&mut file, bytes).map_err(|cause| faulty(path, cause))?;
        let summary = summary.filter(|summary| !summary.chunk_indexes.is_empty()).ok_or_else(|| {
            let cause = "it is not there".to_owned();
            IndexedRecordingError::Index { path: path.to_owned(), cause }
        })?;
        Ok(Self { path: path.to_owned(), file: Mutex::new(file), summary })
    }

    /// Whether there is any message of a topic.
    pub fn holds(&self, topic: &str) -> bool {
        let of_topic = self.summary.channels.values().filter(|channel| channel.topic == topic);
        let counts = self.summary.stats.as_ref().map(|stats| &stats.channel_message_counts);
        of_topic
            .map(|channel| counts.and_then(|counts| counts.get(&channel.id)))
            .any(|count| count.is_some_and(|count| *count > 0))
    }

    /// The message of a topic with that sequence number, recorded at about that time; none where there is none.
    ///
    /// # Errors
    /// [`IndexedRecordingError`] when it cannot be read.
    pub fn message(
        &self,
        topic: &str,
        sequence: u32,
        time: Duration,
    ) -> Result<Option<Vec<u8>>, IndexedRecordingError> {
        self.read_message(topic, sequence, time).map_err(|cause| faulty(&self.path, cause))
    }

    fn read_message(&self, topic: &str, sequence: u32, time: Duration) -> Result<Option<Vec<u8>>, McapError> {
        // A reader that knows none of the topics gives the messages of all.
        let mut channels = self.summary.channels.values();
        let Some(channel_id) = channels.find(|channel| channel.topic == topic).map(|channel| channel.id)
        else {
            return Ok(None);
        };
        // Times in records have six digits.
        let slack = Duration::from_micros(10);
        let nanoseconds = |time: Duration| u64::try_from(time.as_nanos()).unwrap_or(u64::MAX);
        let options = IndexedReaderOptions::new()
            .include_topics([topic])
            .starting_at(nanoseconds(time.saturating_sub(slack)))
            .ending_at(nanoseconds(time.saturating_add(slack)))
            .with_record_length_limit(MOST_RECORD_BYTES);
        let mut reader = IndexedReader::new_with_options(&self.summary, options)?;
        let mut file = self.file.lock().unwrap_or_else(PoisonError::into_inner);
        let mut chunk = Vec::new();
        while let Some(event) = reader.next_event() {
            match event? {
                IndexedReadEvent::ReadChunkRequest { offset, length } => {
                    chunk.resize(length, 0);
                    file.seek(SeekFrom::Start(offset))?;
                    file.read_exact(&mut chunk)?;
                    reader.insert_chunk_record_data(offset, &chunk)?;
                }
                IndexedReadEvent::Message { header, data } => {
                    if (header.channel_id, header.sequence) == (channel_id, sequence) {
                        return Ok(Some(data.to_vec()));
                    }
                }
            }
        }
        Ok(None)
    }
}

/// The index of a file of so many bytes; none where it has none.
fn summary(file: &mut File, bytes: u64) -> Result<Option<Summary>, McapError> {
    let options =
        SummaryReaderOptions::default().with_file_size(bytes).with_record_length_limit(MOST_RECORD_BYTES);
    let mut reader = SummaryReader::new_with_options(options);
    while let Some(event) = reader.next_event() {
        match event? {
            SummaryReadEvent::ReadRequest(wanted) => {
                let read = file.read(reader.insert(wanted))?;
                reader.notify_read(read);
            }
            SummaryReadEvent::SeekRequest(to) => {
                let at = file.seek(to)?;
                reader.notify_seeked(at);
            }
        }
    }
    Ok(reader.finish())
}

fn faulty(path: &Path, cause: McapError) -> IndexedRecordingError {
    match cause {
        McapError::Io(cause) if cause.kind() != io::ErrorKind::UnexpectedEof => {
            FileError::reading(path)(cause).into()
        }
        cause => IndexedRecordingError::Index { path: path.to_owned(), cause: cause.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;
    use std::fs;

    use mcap::records::MessageHeader;
    use mcap::{WriteOptions, Writer};

    use super::*;

    /// A recording of so many frames, ten a second, a message "frame N" each in either of two topics.
    fn write(path: &Path, frames: u32) {
        let options = WriteOptions::new().chunk_size(Some(256));
        let mut writer: Writer<File> = options.create(File::create(path).unwrap()).unwrap();
        let ids = ["/camera/image", "/other"]
            .map(|topic| writer.add_channel(0, topic, "protobuf", &BTreeMap::new()).unwrap());
        for frame in 0..frames {
            let time = u64::from(frame) * 100_000_000;
            for channel_id in ids {
                let header =
                    MessageHeader { channel_id, sequence: frame, log_time: time, publish_time: time };
                let text = format!("frame {frame} of {channel_id}");
                writer.write_to_known_channel(&header, text.as_bytes()).unwrap();
            }
        }
        writer.finish().unwrap();
    }

    #[test]
    fn messages_are_found_by_topic_time_and_number() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("run.mcap");
        write(&path, 100);
        let recording = IndexedRecording::open(&path).unwrap();
        let message = |topic, frame: u32, t_s| {
            recording.message(topic, frame, Duration::from_secs_f64(t_s)).unwrap().map(String::from_utf8)
        };
        for frame in [57, 0, 99, 58] {
            let found = message("/camera/image", frame, 0.1 * f64::from(frame)).unwrap().unwrap();
            assert!(found.starts_with(&format!("frame {frame} of")), "{found}");
        }
        assert!(message("/camera/image", 57, 5.7 + 4e-7).is_some(), "times in records are rounded");
        assert!(message("/camera/image", 57, 5.8).is_none());
        assert!(message("/camera/image", 100, 10.0).is_none());
        assert!(message("/nobody", 57, 5.7).is_none());
        assert!(recording.holds("/camera/image") && !recording.holds("/nobody"));
    }

    #[test]
    fn what_has_no_index_is_refused() {
        let folder = tempfile::TempDir::new().unwrap();
        let path = folder.path().join("run.mcap");
        let said = |path: &Path| IndexedRecording::open(path).unwrap_err().to_string();
        assert!(said(&path).contains("cannot be read"));
        write(&path, 100);
        let whole = fs::read(&path).unwrap();
        for bytes in [
            &whole[..whole.len() / 2],
            &whole[..whole.len() - 3],
            b"",
            b"no recording at all, but long enough",
        ] {
            fs::write(&path, bytes).unwrap();
            assert!(said(&path).contains("no index"), "{} bytes: {}", bytes.len(), said(&path));
        }
    }
}
