//! Chunks that are compressed with Zstandard (RFC 8878), by a decoder in Rust: the C library takes half a minute of processor
//! time to build, and reads here alone.

use std::io::Read;

use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::{McapError, McapResult};
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};
use ruzstd::decoding::{BlockDecodingStrategy, FrameDecoder};

/// How a frame begins: 0xFD2FB528, lowest byte first; and a skippable one: 0x184D2A50 to 0x184D2A5F (RFC 8878, 3.1.1 and 3.1.2).
const MAGIC: [u8; 4] = [0x28, 0xB5, 0x2F, 0xFD];
const SKIPPABLE_MAGIC: [u8; 3] = [0x2A, 0x4D, 0x18];
/// Bytes by which what comes out of a whole message grows: those of the largest block (RFC 8878, 3.1.1.2.4).
const STEP_BYTES: usize = 128 << 10;
/// Bytes of a block's header, and of the checksum at a frame's end.
const BLOCK_HEADER_BYTES: usize = 3;
const CHECKSUM_BYTES: usize = 4;
/// The byte of a frame's header that says what is in it, and its bit for a checksum.
const DESCRIPTOR: usize = 4;
const CHECKSUM_BIT: u8 = 1 << 2;
/// The longest header of a frame; one of which less is there may go on.
const LONGEST_FRAME_HEADER_BYTES: usize = 18;
/// Bytes of a skippable frame ahead of what is skipped.
const SKIPPED_HEADER_BYTES: usize = 8;

/// Decodes frames block by block, as their bytes come.
pub(super) struct ZstdChunks {
    decoder: FrameDecoder,
    next: Next,
}

/// Whether bytes begin as a frame does, a skippable one too.
pub(super) fn begins_frame(data: &[u8]) -> bool {
    data.starts_with(&MAGIC) || matches!(data, [0x50..=0x5F, rest @ ..] if rest.starts_with(&SKIPPABLE_MAGIC))
}

/// What the next byte belongs to.
#[derive(Debug, Clone, Copy)]
enum Next {
    /// A frame's header.
    Frame,
    /// A block of a frame.
    Block {
        /// Bytes behind the frame's last block.
        checksum_bytes: usize,
    },
    /// What a skippable frame holds.
    Skipped {
        /// How much of it is left.
        bytes: usize,
    },
}

impl ZstdChunks {
    pub(super) fn new() -> Self {
        Self { decoder: FrameDecoder::new(), next: Next::Frame }
    }

    /// What frames behind each other hold, in no more than `most_bytes`.
    ///
    /// # Errors
    /// Words when they hold more, cannot be unpacked, or end in the middle of one.
    pub(super) fn whole(mut self, packed: &[u8], most_bytes: usize) -> Result<Vec<u8>, String> {
        let (mut read, mut wrote, mut out) = (0, 0, Vec::new());
        loop {
            out.resize(wrote + STEP_BYTES, 0);
            let DecompressResult { consumed, wrote: more } =
                self.decompress(&packed[read..], &mut out[wrote..]).map_err(|cause| cause.to_string())?;
            (read, wrote) = (read + consumed, wrote + more);
            if wrote > most_bytes {
                return Err(format!("it holds more than {most_bytes} bytes"));
            }
            if consumed == 0 && more == 0 {
                break;
            }
        }
        if read < packed.len() || !matches!(self.next, Next::Frame) {
            return Err("it ends in the middle of a frame".to_owned());
        }
        out.truncate(wrote);
        Ok(out)
    }

    /// Takes in one header, block or part of what is skipped from the start of `source`, and gives the bytes that it took; none
    /// where not all of it is there yet.
    fn take_in(&mut self, source: &[u8]) -> Result<Option<usize>, FrameDecoderError> {
        match self.next {
            Next::Frame => self.take_in_header(source),
            Next::Block { checksum_bytes } => {
                let Some(bytes) = block_bytes(source, checksum_bytes).filter(|bytes| *bytes <= source.len())
                else {
                    return Ok(None);
                };
                if self.decoder.decode_blocks(&source[..bytes], BlockDecodingStrategy::UptoBlocks(1))? {
                    self.next = Next::Frame;
                }
                Ok(Some(bytes))
            }
            Next::Skipped { bytes } => {
                let taken = bytes.min(source.len());
                self.next = if taken == bytes { Next::Frame } else { Next::Skipped { bytes: bytes - taken } };
                Ok(Some(taken).filter(|taken| *taken > 0 || bytes == 0))
            }
        }
    }

    /// Whether a frame that has come out as a whole has the checksum behind it, where it has one.
    fn is_as_packed(&self) -> bool {
        let is_out = self.decoder.is_finished() && self.decoder.can_collect() == 0;
        let said = self.decoder.get_checksum_from_data().filter(|_| is_out);
        said.is_none_or(|said| self.decoder.get_calculated_checksum() == Some(said))
    }

    fn take_in_header(&mut self, source: &[u8]) -> Result<Option<usize>, FrameDecoderError> {
        let mut rest = source;
        match self.decoder.reset(&mut rest) {
            Ok(()) => {
                let has_checksum = source.get(DESCRIPTOR).is_some_and(|byte| byte & CHECKSUM_BIT != 0);
                self.next = Next::Block { checksum_bytes: if has_checksum { CHECKSUM_BYTES } else { 0 } };
                Ok(Some(source.len() - rest.len()))
            }
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length, ..
            })) => {
                self.next = Next::Skipped { bytes: length as usize };
                Ok(Some(SKIPPED_HEADER_BYTES))
            }
            Err(FrameDecoderError::ReadFrameHeaderError(cause))
                if source.len() < LONGEST_FRAME_HEADER_BYTES && ends_early(&cause) =>
            {
                Ok(None)
            }
            Err(cause) => Err(cause),
        }
    }
}

impl Decompressor for ZstdChunks {
    fn next_read_size(&self) -> usize {
        0
    }

    fn decompress(&mut self, source: &[u8], target: &mut [u8]) -> McapResult<DecompressResult> {
        let failed = |cause: &dyn std::fmt::Display| McapError::DecompressionError(cause.to_string());
        let (mut consumed, mut wrote) = (0, 0);
        loop {
            wrote += self.decoder.read(&mut target[wrote..]).map_err(|cause| failed(&cause))?;
            if !self.is_as_packed() {
                return Err(failed(&"a frame's checksum is another"));
            }
            if wrote == target.len() {
                break;
            }
            match self.take_in(&source[consumed..]).map_err(|cause| failed(&cause))? {
                Some(bytes) => consumed += bytes,
                None => break,
            }
        }
        Ok(DecompressResult { consumed, wrote })
    }

    fn reset(&mut self) -> McapResult<()> {
        // A frame that was left in the middle keeps its bytes until the next one's header replaces it.
        *self = Self::new();
        Ok(())
    }

    fn name(&self) -> &'static str {
        "zstd"
    }
}

/// Bytes of the block at the start of `source`, with the checksum behind a last one; none without its header.
fn block_bytes(source: &[u8], checksum_bytes: usize) -> Option<usize> {
    /// Kind of a block whose single byte stands for many.
    const REPEATED: usize = 1;
    let [low, middle, high] = *source.first_chunk::<BLOCK_HEADER_BYTES>()?;
    let header = usize::from(low) | usize::from(middle) << 8 | usize::from(high) << 16;
    let (is_last, kind, size) = (header & 1 == 1, header >> 1 & 3, header >> 3);
    let content = if kind == REPEATED { 1 } else { size };
    Some(BLOCK_HEADER_BYTES + content + if is_last { checksum_bytes } else { 0 })
}

/// Whether a header is not wrong but not all there.
fn ends_early(cause: &ReadFrameHeaderError) -> bool {
    use ReadFrameHeaderError as Cause;
    matches!(
        cause,
        Cause::MagicNumberReadError(_)
            | Cause::FrameDescriptorReadError(_)
            | Cause::WindowDescriptorReadError(_)
            | Cause::DictionaryIdReadError(_)
            | Cause::FrameContentSizeReadError(_)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    /// "The road is long. " 40 times as the command `zstd --check` packs it, behind a skippable frame and followed by a frame of
    /// one stored block.
    fn packed() -> Vec<u8> {
        let mut packed = vec![0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9];
        packed.extend(PACKED);
        packed.extend([0x28, 0xb5, 0x2f, 0xfd, 0x20, 3, 25, 0, 0, b'e', b'n', b'd']);
        packed
    }

    const PACKED: [u8; 39] = [
        40, 181, 47, 253, 100, 208, 1, 205, 0, 0, 144, 84, 104, 101, 32, 114, 111, 97, 100, 32, 105, 115, 32,
        108, 111, 110, 103, 46, 32, 1, 0, 118, 85, 53, 195, 119, 72, 231, 4,
    ];

    fn unpacked() -> Vec<u8> {
        [b"The road is long. ".repeat(40), b"end".to_vec()].concat()
    }

    /// What comes out when `step` more bytes are shown at a time and `room` may be written.
    fn decompressed(step: usize, room: usize) -> Vec<u8> {
        let (packed, mut decoder) = (packed(), ZstdChunks::new());
        let (mut read, mut shown, mut out) = (0, 0, Vec::new());
        loop {
            let mut target = vec![0; room];
            let result = decoder.decompress(&packed[read..shown], &mut target).unwrap();
            out.extend(&target[..result.wrote]);
            read += result.consumed;
            if result.wrote == 0 && result.consumed == 0 {
                if shown == packed.len() {
                    return out;
                }
                shown = (shown + step).min(packed.len());
            }
        }
    }

    #[test]
    fn a_frame_that_came_out_otherwise_than_it_went_in_is_refused() {
        let (mut spoilt, mut target) = (packed(), [0; 1000]);
        // The checksum stands behind the first frame that is not skipped.
        spoilt[SKIPPED_HEADER_BYTES + 3 + PACKED.len() - 1] ^= 1;
        let refused = ZstdChunks::new().decompress(&spoilt, &mut target).unwrap_err();
        assert!(refused.to_string().contains("checksum"), "{refused}");
        assert!(ZstdChunks::new().decompress(&packed(), &mut target).is_ok());
    }

    #[test]
    fn frames_come_out_whole_however_they_come_in() {
        for (step, room) in [(1, 1), (1, 1000), (7, 3), (1000, 1), (1000, 1000)] {
            assert_eq!(decompressed(step, room), unpacked(), "{step} {room}");
        }
    }
}
