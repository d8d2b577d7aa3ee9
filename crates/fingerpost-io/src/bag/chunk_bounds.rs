//! Bounds of the records in chunks that are not compressed. Source: the MCAP specification (mcap.dev/spec).
//!
//! The `mcap` crate takes the length of such a record at its word, subtracts it from what is left of the chunk (which overflows), and
//! does not say where a chunk begins or ends. Here lengths are held against the chunk while bytes pass on their way to the crate, which
//! gets those of a record only where they are in bounds. Records of compressed chunks are bounded by the crate.

use std::io::{self, Read};

use mcap::MAGIC;
use mcap::records::op;

use super::record_fields::Fields;
use super::records::RecordsError;

/// Bytes of a record's opcode and length.
const HEAD_BYTES: usize = 1 + 8;
/// Bytes of a chunk's fields up to its records, without a compression's name: two times, size, checksum, length of the name, size packed.
const CHUNK_FIELDS_BYTES: usize = 8 + 8 + 8 + 4 + 4 + 8;

/// A stream of MCAP whose chunks hold their records.
#[derive(Debug)]
pub(super) struct ChunkBounds<R> {
    stream: R,
    /// Bytes read so far.
    offset: u64,
    /// Bytes that were read to look at them, and how many of them have been passed on.
    looked_at: Vec<u8>,
    passed_on: usize,
    next: Next,
}

/// What follows the bytes that were looked at.
#[derive(Debug, Clone, Copy)]
enum Next {
    /// Bytes that say nothing of where records end, then a record's head.
    Plain { bytes: u64, chunk: Chunk },
    /// What does not fit into its chunk.
    PastEnd { record_at: u64, record_bytes: u64, left_bytes: u64 },
}

/// What is left of the chunk that is being read.
#[derive(Debug, Clone, Copy)]
struct Chunk {
    /// Bytes of its records.
    left_bytes: u64,
    /// Bytes of the chunk behind its records.
    padding_bytes: u64,
}

impl Chunk {
    /// Where no chunk is being read.
    const NONE: Self = Self { left_bytes: 0, padding_bytes: 0 };
}

impl<R: Read> ChunkBounds<R> {
    /// At the start of a recording.
    pub(super) fn new(stream: R) -> Self {
        let next = Next::Plain { bytes: MAGIC.len() as u64, chunk: Chunk::NONE };
        Self {
            stream,
            offset: 0,
            looked_at: Vec::with_capacity(HEAD_BYTES + CHUNK_FIELDS_BYTES),
            passed_on: 0,
            next,
        }
    }

    /// Reads bytes into `buffer` and says how many: none at the stream's end, or where `buffer` is empty.
    ///
    /// # Errors
    /// [`RecordsError::Damaged`] in place of a record that does not fit into its chunk, [`RecordsError::Read`] when the system gives none.
    pub(super) fn read(&mut self, buffer: &mut [u8]) -> Result<usize, RecordsError> {
        loop {
            let mut looked_at = &self.looked_at[self.passed_on..];
            if !looked_at.is_empty() {
                let read = looked_at.read(buffer)?;
                self.passed_on += read;
                return Ok(read);
            }
            match self.next {
                Next::PastEnd { record_at, record_bytes, left_bytes } => {
                    return Err(past_end(record_at, record_bytes, left_bytes));
                }
                Next::Plain { bytes: 0, chunk } => {
                    if !self.look_at_head(chunk)? {
                        return Ok(0);
                    }
                }
                Next::Plain { bytes, chunk } => {
                    let most = usize::try_from(bytes).unwrap_or(usize::MAX).min(buffer.len());
                    let read = self.stream.read(&mut buffer[..most])?;
                    self.offset += read as u64;
                    self.next = Next::Plain { bytes: bytes - read as u64, chunk };
                    return Ok(read);
                }
            }
        }
    }

    /// Reads the next record's head, and a chunk's up to its records; says whether there is any of it.
    fn look_at_head(&mut self, chunk: Chunk) -> Result<bool, RecordsError> {
        let record_at = self.offset;
        (self.passed_on, self.next) = (0, Next::Plain { bytes: 0, chunk: Chunk::NONE });
        self.looked_at.clear();
        let left_bytes = chunk.left_bytes;
        if (1..HEAD_BYTES as u64).contains(&left_bytes) {
            return Err(past_end(record_at, HEAD_BYTES as u64, left_bytes));
        }
        self.look_at(HEAD_BYTES)?;
        let mut fields = Fields::of(&self.looked_at);
        let (Some(opcode), Some(bytes)) = (fields.u8(), fields.u64()) else {
            return Ok(!self.looked_at.is_empty());
        };
        self.next = if left_bytes > 0 {
            let left_bytes = left_bytes - HEAD_BYTES as u64;
            match left_bytes.checked_sub(bytes) {
                None => Next::PastEnd { record_at, record_bytes: bytes, left_bytes },
                Some(0) => {
                    Next::Plain { bytes: bytes.saturating_add(chunk.padding_bytes), chunk: Chunk::NONE }
                }
                Some(left_bytes) => Next::Plain { bytes, chunk: Chunk { left_bytes, ..chunk } },
            }
        } else if opcode == op::CHUNK {
            self.look_at(CHUNK_FIELDS_BYTES)?;
            begun_chunk(&self.looked_at[HEAD_BYTES..], bytes)
        } else {
            Next::Plain { bytes, chunk: Chunk::NONE }
        };
        Ok(true)
    }

    /// Reads so many bytes more to look at them, or those that there are.
    fn look_at(&mut self, bytes: usize) -> io::Result<()> {
        let read = self.stream.by_ref().take(bytes as u64).read_to_end(&mut self.looked_at)?;
        self.offset += read as u64;
        Ok(())
    }
}

/// What follows the fields of a chunk of so many bytes. Sizes that contradict each other are left to the crate, which refuses them.
fn begun_chunk(fields: &[u8], bytes: u64) -> Next {
    let bytes = bytes.saturating_sub(fields.len() as u64);
    let records_bytes = (|| {
        let mut fields = Fields::of(fields);
        let (_start, _end, _unpacked, _checksum) =
            (fields.u64()?, fields.u64()?, fields.u64()?, fields.u32()?);
        Some(fields.text()?).filter(|compression| compression.is_empty()).and_then(|_| fields.u64())
    })();
    match records_bytes.and_then(|records| Some((records, bytes.checked_sub(records)?))) {
        Some((left_bytes @ 1.., padding_bytes)) => {
            Next::Plain { bytes: 0, chunk: Chunk { left_bytes, padding_bytes } }
        }
        _ => Next::Plain { bytes, chunk: Chunk::NONE },
    }
}

fn past_end(record_at: u64, record_bytes: u64, left_bytes: u64) -> RecordsError {
    RecordsError::Damaged {
        cause: format!(
            "a record of {record_bytes} bytes at byte {record_at} runs past the end of its chunk, which has {left_bytes} left"
        ),
    }
}
