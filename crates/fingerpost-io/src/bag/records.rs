//! Messages of an MCAP stream, from its start to its end or to where it breaks off.

use std::io::Read;
use std::rc::Rc;

use mcap::McapError;
use mcap::records::op;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use thiserror::Error;

use super::chunk_bounds::ChunkBounds;
use super::record_fields::Fields;
use super::topics::{Channel, MOST_NAMES_BYTES, Topics};
use super::zstd_chunks::ZstdChunks;

/// Bytes of the largest record, and of the largest chunk that is checked, packed and unpacked: a bare picture of 44 million pixels.
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
    /// A record is larger than any that is read.
    #[error(
        "a {what} there has {bytes} bytes, more than the {} MB that are read of one; record with smaller chunks, or without what \
         is so large",
        MOST_RECORD_BYTES >> 20
    )]
    TooLarge {
        /// What it is.
        what: &'static str,
        /// How many bytes it has, packed or unpacked.
        bytes: u64,
    },
    /// Its names are longer than those of any recording.
    #[error(
        "its names of topics and schemas have more than {} MB together (with {name:?}, of {bytes} bytes, there); no recorder writes \
         such names: copy it again, or record it again",
        MOST_NAMES_BYTES >> 20
    )]
    Names {
        /// How the name begins that is one too many.
        name: String,
        /// Its bytes.
        bytes: usize,
    },
    /// A number stands for two things.
    #[error(
        "its {kind} {id} is {first:?} first and {second:?} there, and what is recorded under a number may not change in MCAP; \
         record or merge it again (`mcap merge`)"
    )]
    TwoMeanings {
        /// Whether it is the number of a schema or of a channel.
        kind: &'static str,
        /// The number.
        id: u16,
        /// What it stood for first.
        first: String,
        /// What it was to stand for then.
        second: String,
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

/// Messages in the order in which they were written.
pub struct Records<R> {
    stream: ChunkBounds<R>,
    reader: LinearReader,
    topics: Topics,
    without_channel: u64,
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
        Self {
            stream: ChunkBounds::new(stream),
            reader,
            topics: Topics::default(),
            without_channel: 0,
            ended: false,
        }
    }

    /// Messages so far under a number that no channel had been introduced with; they are passed over.
    pub fn without_channel(&self) -> u64 {
        self.without_channel
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
                    let (short, fields) = (|| too_short(opcode), Fields::of(data));
                    match opcode {
                        op::SCHEMA => self.topics.add_schema(fields).ok_or_else(short)??,
                        op::CHANNEL => self.topics.add_channel(fields).ok_or_else(short)??,
                        op::MESSAGE => match message(&self.topics, fields).ok_or_else(short)? {
                            Some(record) => return Ok(Some(record)),
                            None => self.without_channel += 1,
                        },
                        _ => {}
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

/// A message with its channel, if that was introduced; none where the record is too short.
fn message(topics: &Topics, mut fields: Fields<'_>) -> Option<Option<Record>> {
    let (id, _sequence, log_ns, _published_ns) = (fields.u16()?, fields.u32()?, fields.u64()?, fields.u64()?);
    Some(topics.channel(id).cloned().map(|Channel { topic, schema, encoding, .. }| Record {
        topic,
        schema,
        encoding,
        log_ns,
        data: fields.rest().to_vec(),
    }))
}

fn damaged(cause: McapError) -> RecordsError {
    match cause {
        McapError::UnexpectedEof => RecordsError::BreaksOff,
        McapError::RecordTooLarge { opcode, len } => {
            RecordsError::TooLarge { what: kind_of_record(opcode), bytes: len }
        }
        McapError::ChunkTooLarge(len) => RecordsError::TooLarge { what: "chunk", bytes: len },
        cause => RecordsError::Damaged { cause: cause.to_string() },
    }
}

/// What a record is. Source: the MCAP specification (mcap.dev/spec).
const fn kind_of_record(opcode: u8) -> &'static str {
    match opcode {
        op::SCHEMA => "schema",
        op::CHANNEL => "channel",
        op::MESSAGE => "message",
        op::ATTACHMENT => "attachment",
        op::METADATA => "record of metadata",
        op::MESSAGE_INDEX | op::CHUNK_INDEX | op::ATTACHMENT_INDEX | op::METADATA_INDEX => "index",
        _ => "record",
    }
}

fn too_short(opcode: u8) -> RecordsError {
    RecordsError::Damaged { cause: format!("a record of kind {opcode} is shorter than its fields") }
}
