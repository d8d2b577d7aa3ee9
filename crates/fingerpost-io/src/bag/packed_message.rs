//! Messages that were packed one by one, as rosbag2 does with `compression_mode: message` and `compression_format: zstd`.
//!
//! Their channels say nothing of it. A frame of Zstandard begins with bytes that no CDR has (RFC 8878, 3.1.1), so that each message
//! shows how it is stored. A message may be in several frames behind each other, with skippable ones between.

use std::borrow::Cow;

use super::message::MessageError;
use super::records::MOST_RECORD_BYTES;
use super::zstd_chunks::{ZstdChunks, begins_frame};

/// The message itself, of no more bytes than a record may have.
pub(super) fn unpacked(data: &[u8]) -> Result<Cow<'_, [u8]>, MessageError> {
    if !begins_frame(data) {
        return Ok(Cow::Borrowed(data));
    }
    let message = ZstdChunks::new().whole(data, MOST_RECORD_BYTES);
    message.map(Cow::Owned).map_err(|cause| MessageError::Packed { cause })
}
