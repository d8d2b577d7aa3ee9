//! OSM PBF: blocks in blobs (the format's `fileformat.proto`), unpacked one at a time.

use std::io::{self, Read};

use flate2::read::ZlibDecoder;

use crate::elements::Elements;
use crate::label::cleaned;
use crate::osm::OsmError;
use crate::osm_budget::Budget;
use crate::pbf_block::read_block;
use crate::pbf_fields::{Fields, Value};

/// Bytes of a blob's header at the most, as the format has it.
const MOST_HEADER_BYTES: usize = 64 * 1024;
/// Bytes of a blob and of its block at the most, as the format has it.
const MOST_BLOCK_BYTES: usize = 32 * 1024 * 1024;
/// Bytes of a feature's name that a message shows.
const MOST_FEATURE_BYTES: usize = 100;

/// Features that a file may ask of its reader and that this one has.
const FEATURES: [&[u8]; 4] = [b"OsmSchema-V0.6", b"DenseNodes", b"HistoricalInformation", b"LocationsOnWays"];

/// Gives nodes and highways to `elements`, in the file's order, block by block.
pub(crate) fn read(mut bytes: &[u8], elements: &mut Elements) -> Result<(), OsmError> {
    let mut unpacked = Vec::new();
    while !bytes.is_empty() {
        let (kind, blob) = next_blob(&mut bytes).map_err(broken)?;
        if kind == b"OSMHeader" || kind == b"OSMData" {
            let block = unpack(blob, &mut elements.budget, &mut unpacked)?;
            if kind == b"OSMData" {
                read_block(block, elements)?;
            } else {
                check_features(block)?;
            }
            elements.budget.give_back(unpacked.len());
        }
    }
    Ok(())
}

/// Refuses a file that asks for more than is read here.
fn check_features(header: &[u8]) -> Result<(), OsmError> {
    let mut fields = Fields::of(header);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        if let (4, Value::Bytes(feature)) = (number, value)
            && !FEATURES.contains(&feature)
        {
            let feature =
                cleaned(&String::from_utf8_lossy(&feature[..feature.len().min(MOST_FEATURE_BYTES)]));
            return Err(OsmError::Feature { feature });
        }
    }
    Ok(())
}

/// Data that is cut short or damaged.
pub(crate) fn broken(cause: impl Into<String>) -> OsmError {
    OsmError::Pbf { cause: cause.into() }
}

/// The kind of the next blob and its message; `bytes` begin behind it then.
fn next_blob<'a>(bytes: &mut &'a [u8]) -> Result<(&'a [u8], &'a [u8]), String> {
    let cut = || "it is cut short".to_owned();
    let (length, rest) = bytes.split_first_chunk().ok_or_else(cut)?;
    let length = u32::from_be_bytes(*length) as usize;
    if length > MOST_HEADER_BYTES {
        return Err(format!("a blob's header of {length} bytes"));
    }
    let (header, rest) = rest.split_at_checked(length).ok_or_else(cut)?;
    let (mut kind, mut size) = (None, None);
    let mut fields = Fields::of(header);
    while let Some((number, value)) = fields.next()? {
        match number {
            1 => kind = Some(value.bytes()?),
            3 => size = Some(value.number()?),
            _ => {}
        }
    }
    let (Some(kind), Some(size)) = (kind, size) else { return Err("a blob without kind or size".to_owned()) };
    let size = usize::try_from(size).ok().filter(|size| *size <= MOST_BLOCK_BYTES);
    let size = size.ok_or("a blob of more than 32 MiB")?;
    let (blob, rest) = rest.split_at_checked(size).ok_or_else(cut)?;
    *bytes = rest;
    Ok((kind, blob))
}

/// The block of a blob, into `unpacked` where it is packed. What that holds is taken from the budget.
fn unpack<'a>(blob: &'a [u8], budget: &mut Budget, unpacked: &'a mut Vec<u8>) -> Result<&'a [u8], OsmError> {
    unpacked.clear();
    let (mut packed, mut stated_size) = (None, None);
    let mut fields = Fields::of(blob);
    while let Some((number, value)) = fields.next().map_err(broken)? {
        let packing = match (number, value) {
            (1, Value::Bytes(block)) => return Ok(block),
            (2, Value::Number(size)) => {
                stated_size = Some(size);
                continue;
            }
            (3, Value::Bytes(bytes)) => {
                packed = Some(bytes);
                continue;
            }
            (4, _) => "LZMA",
            (5, _) => "bzip2",
            (6, _) => "LZ4",
            (7, _) => "zstd",
            _ => continue,
        };
        return Err(OsmError::PackedBlocks { packing });
    }
    let packed = packed.ok_or_else(|| broken("a blob that holds nothing"))?;
    let size = match stated_size {
        Some(size) => size,
        None => unpacked_size(packed)?,
    };
    let size = usize::try_from(size).ok().filter(|size| *size <= MOST_BLOCK_BYTES);
    let size = size.ok_or_else(|| broken("a block of more than 32 MiB"))?;
    budget.take(size)?;
    unpacked.reserve_exact(size);
    let read = ZlibDecoder::new(packed).take(size as u64).read_to_end(unpacked);
    read.map_err(|error| broken(error.to_string()))?;
    if unpacked.len() < size {
        return Err(broken(format!("a block of {} bytes where {size} are stated", unpacked.len())));
    }
    Ok(unpacked)
}

/// The bytes of a block that does not state them, up to one more than there may be.
fn unpacked_size(packed: &[u8]) -> Result<u64, OsmError> {
    let mut unpacker = ZlibDecoder::new(packed).take(MOST_BLOCK_BYTES as u64 + 1);
    io::copy(&mut unpacker, &mut io::sink()).map_err(|error| broken(error.to_string()))
}
