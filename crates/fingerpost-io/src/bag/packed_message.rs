//! Messages that were packed one by one, as rosbag2 does with `compression_mode: message` and `compression_format: zstd`.
//!
//! Their channels say nothing of it. A frame of Zstandard begins with bytes that no CDR has (RFC 8878, 3.1.1), so that each message
//! shows how it is stored.

use std::borrow::Cow;
use std::io::Read;

use ruzstd::decoding::StreamingDecoder;

use super::message::MessageError;
use super::records::MOST_RECORD_BYTES;

/// How a frame of Zstandard begins: 0xFD2FB528, lowest byte first.
const ZSTD_MAGIC: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];

/// The message itself, of no more bytes than a record may have.
pub(super) fn unpacked(data: &[u8]) -> Result<Cow<'_, [u8]>, MessageError> {
    if !data.starts_with(&ZSTD_MAGIC) {
        return Ok(Cow::Borrowed(data));
    }
    let failed = |cause: String| MessageError::Packed { cause };
    let decoder = StreamingDecoder::new(data).map_err(|cause| failed(cause.to_string()))?;
    let mut message = Vec::new();
    let most = MOST_RECORD_BYTES as u64;
    decoder.take(most + 1).read_to_end(&mut message).map_err(|cause| failed(cause.to_string()))?;
    if message.len() > MOST_RECORD_BYTES {
        return Err(failed(format!("it holds more than {MOST_RECORD_BYTES} bytes")));
    }
    Ok(Cow::Owned(message))
}
