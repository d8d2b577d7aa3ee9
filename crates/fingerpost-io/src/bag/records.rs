//! Messages of an MCAP stream, from its start to its end or to where it breaks off.

use std::collections::BTreeMap;
use std::io::Read;
use std::rc::Rc;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use thiserror::Error;

use super::record_fields::Fields;
use super::zstd_chunks::ZstdChunks;

/// Bytes of the largest record: a bare picture of 44 million pixels.
pub(super) const MOST_RECORD_BYTES: usize = 128 << 20;
/// Bytes that are asked for at once, whatever a length in the stream says.
const READ_BYTES: usize = 1 << 20;

/// A stream that cannot be read on.
#[derive(Debug, Error)]
pub enum RecordsError {
    /// It ends without the end that a recording has: its recorder was killed, or the copy is not whole.
    #[error("it ends before its end; its recorder was stopped, or the copy is not whole")]
    BreaksOff,
    /// What stands there is no MCAP.
    #[error("it is no MCAP recording from here on ({cause}); copy it again, or mend it with `mcap recover`")]
    Damaged {
        /// What the reader says.
        cause: String,
    },
    /// The system does not give its bytes.
    #[error("it cannot be read on ({0}); check the disk or the connection")]
    Read(#[from] std::io::Error),
}

/// A message with its topic.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Record {
    /// Its name.
    pub topic: Rc<str>,
    /// Name of the schema of its messages; empty where there is none.
    pub schema: Rc<str>,
    /// Encoding of its messages.
    pub encoding: Rc<str>,
    /// When the message was recorded, nanoseconds.
    pub log_ns: u64,
    /// The message.
    pub data: Vec<u8>,
}

/// What is known of a channel.
#[derive(Debug, Clone)]
struct Channel {
    topic: Rc<str>,
    schema: Rc<str>,
    encoding: Rc<str>,
}

/// What a stream has introduced.
#[derive(Debug, Default)]
struct Topics {
    schemas: BTreeMap<u16, Rc<str>>,
    channels: BTreeMap<u16, Channel>,
}

impl Topics {
    /// Takes in a record, and gives the message if it is one of a channel that was introduced; none where it is too short.
    fn take(&mut self, opcode: u8, mut fields: Fields<'_>) -> Option<Option<Record>> {
        match opcode {
            op::SCHEMA => {
                let (id, name) = (fields.u16()?, fields.text()?);
                self.schemas.insert(id, name.into());
            }
            op::CHANNEL => {
                let (id, schema_id) = (fields.u16()?, fields.u16()?);
                let (topic, encoding) = (fields.text()?.into(), fields.text()?.into());
                let schema = self.schemas.get(&schema_id).cloned().unwrap_or_else(|| "".into());
                self.channels.insert(id, Channel { topic, schema, encoding });
            }
            op::MESSAGE => {
                let (id, _sequence, log_ns, _published_ns) =
                    (fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?);
                return Some(self.channels.get(&id).cloned().map(|Channel { topic, schema, encoding }| {
                    Record { topic, schema, encoding, log_ns, data: fields.rest().to_vec() }
                }));
            }
            _ => {}
        }
        Some(None)
    }
}

/// Messages in the order in which they were written.
pub struct Records<R> {
    stream: R,
    reader: LinearReader,
    topics: Topics,
    ended: bool,
}

impl<R: Read> Records<R> {
    /// Begins at the start of a stream.
    pub fn new(stream: R) -> Self {
        // A chunk whose bytes were changed says so before anything of it is believed.
        let options = LinearReaderOptions::default()
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(MOST_RECORD_BYTES);
        let mut reader = LinearReader::new_with_options(options);
        // Only a decoder without a name is refused; a chunk that none is there for says so when it is met.
        reader.add_decompressor(ZstdChunks::new()).ok();
        Self { stream, reader, topics: Topics::default(), ended: false }
    }

    /// The next message; none at the end.
    fn next_message(&mut self) -> Result<Option<Record>, RecordsError> {
        while let Some(event) = self.reader.next_event() {
            match event.map_err(damaged)? {
                LinearReadEvent::ReadRequest(wanted) => {
                    let buffer = self.reader.insert(wanted.min(READ_BYTES));
                    let read = self.stream.read(buffer)?;
                    self.reader.notify_read(read);
                }
                // What follows makes looking things up faster, and repeats schemas and channels.
                LinearReadEvent::Record { opcode: op::DATA_END, .. } => return Ok(None),
                LinearReadEvent::Record { opcode, data } => {
                    let taken = self.topics.take(opcode, Fields::of(data));
                    if let Some(record) = taken.ok_or_else(|| too_short(opcode))? {
                        return Ok(Some(record));
                    }
                }
            }
        }
        Ok(None)
    }
}

impl<R: Read> Iterator for Records<R> {
    type Item = Result<Record, RecordsError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.ended {
            return None;
        }
        let next = self.next_message().transpose();
        self.ended = !matches!(next, Some(Ok(_)));
        next
    }
}

impl<R> std::fmt::Debug for Records<R> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Records").field("topics", &self.topics).finish_non_exhaustive()
    }
}

fn damaged(cause: McapError) -> RecordsError {
    match cause {
        McapError::UnexpectedEof => RecordsError::BreaksOff,
        cause => RecordsError::Damaged { cause: cause.to_string() },
    }
}

fn too_short(opcode: u8) -> RecordsError {
    RecordsError::Damaged { cause: format!("a record of kind {opcode} is shorter than its fields") }
}
