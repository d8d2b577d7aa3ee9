//! OpenStreetMap data as it is stored: nodes with a place, ways with tags.
//!
//! Only what a road map needs is kept: every node, the barriers on them, and the ways that carry a `highway` tag. Relations
//! (turn restrictions among them) are left out. OSM XML and OSM PBF, with histories and with nodes' places on their ways; both
//! come to the same data in the same order.

use std::collections::BTreeMap;

use thiserror::Error;

use crate::elements::gather;
use crate::text_encoding::{first_letter, text_of};
use crate::{LatLon, MapNotice, osm_pbf, osm_xml};

/// A node: a place with a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OsmNode {
    /// OSM's number.
    pub id: i64,
    /// Where it is.
    pub at: LatLon,
}

/// A way: the numbers of its nodes in their order, and its tags.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OsmWay {
    /// OSM's number.
    pub id: i64,
    /// Numbers of its nodes, in the way's direction.
    pub nodes: Vec<i64>,
    /// Tags: key and value.
    pub tags: BTreeMap<String, String>,
}

/// A barrier on a node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct OsmBarrier {
    /// OSM's number of the node.
    pub node: i64,
    /// Those of the node's tags that say what the barrier is and whom it lets through: key and value.
    pub tags: BTreeMap<String, String>,
}

/// The nodes and highways of an extract, each sorted by number.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct OsmData {
    /// Nodes, ascending numbers, no number twice.
    pub nodes: Vec<OsmNode>,
    /// Ways that carry a `highway` tag, ascending numbers, no number twice.
    pub ways: Vec<OsmWay>,
    /// Barriers on nodes, ascending numbers of those.
    pub barriers: Vec<OsmBarrier>,
    /// What was not understood.
    pub notices: Vec<MapNotice>,
}

/// Why bytes are no OpenStreetMap data.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum OsmError {
    /// No bytes at all.
    #[error("the map is empty (0 bytes); export or download it again")]
    Empty,
    /// A compressed file.
    #[error("the map is packed with {packer}; unpack it first ({command})")]
    Packed {
        /// The packer its first bytes name.
        packer: &'static str,
        /// The command that unpacks it.
        command: &'static str,
    },
    /// JSON, as Overpass gives it where nothing else is asked for.
    #[error(
        "the map is JSON, which is not read here; ask Overpass for XML ([out:xml]), or give a .osm or .osm.pbf file"
    )]
    Json,
    /// Neither XML nor PBF.
    #[error("this is neither OSM XML nor OSM PBF (it starts with \"{start}\"); give a .osm or .osm.pbf file")]
    UnknownFormat {
        /// The first bytes, printable ones as they are.
        start: String,
    },
    /// XML that is not well formed or holds values that cannot be read.
    #[error("the OSM XML is broken at byte {at_byte}: {cause}; export or download it again")]
    Xml {
        /// Where reading stopped, bytes from the start of the text in UTF-8.
        at_byte: u64,
        /// What is wrong there.
        cause: String,
    },
    /// PBF whose blocks are packed in a way that is not read.
    #[error("the blocks of the OSM PBF are packed with {packing}, which is not read here; {}", repacking(.packing))]
    PackedBlocks {
        /// The way that their blobs name.
        packing: &'static str,
    },
    /// PBF that asks of its reader what this one cannot do.
    #[error(
        "the OSM PBF asks for \"{feature}\", which is not read here; write it again without (osmium cat IN.osm.pbf -o OUT.osm.pbf)"
    )]
    Feature {
        /// The feature that its header names.
        feature: String,
    },
    /// More data than may be held.
    #[error(
        "the map takes more than the {limit_mb} MB of memory that it may take; cut out the area that is driven (osmium \
         extract), or allow more (--max-input-mib)"
    )]
    TooLarge {
        /// The memory that it may take, megabytes.
        limit_mb: usize,
    },
    /// PBF that is cut short or damaged.
    #[error("the OSM PBF is broken: {cause}; download it again")]
    Pbf {
        /// What is wrong.
        cause: String,
    },
}

/// What to do about blocks of a packing: osmium-tool reads zlib and LZ4 alone.
fn repacking(packing: &str) -> &'static str {
    match packing {
        "LZ4" => "pack them with zlib (osmium cat IN.osm.pbf -o OUT.osm.pbf -f pbf,pbf_compression=zlib)",
        _ => {
            "osmium does not read it either: have the program that wrote it pack with zlib, or download the area anew, as a \
             .osm.pbf of download.geofabrik.de or by its corners with wget -O map.osm \
             \"https://overpass-api.de/api/map?bbox=WEST,SOUTH,EAST,NORTH\""
        }
    }
}

/// How many of the first bytes a message shows.
const SHOWN_BYTES: usize = 16;
/// Where a PBF file names its first block: after the block header's length (4 bytes) and the name's tag and length.
const PBF_NAME_AT: usize = 6;

impl OsmData {
    /// Memory that a map may take where nothing else is said, bytes: about 28 million nodes, those of a small country; an
    /// extract of 100 km has some ten million.
    pub const MEMORY_BYTES: usize = 2048 << 20;

    /// Reads OSM XML or OSM PBF, whichever it is, within [`Self::MEMORY_BYTES`].
    ///
    /// # Errors
    /// As [`Self::from_bytes_within`].
    pub fn from_bytes(bytes: &[u8]) -> Result<Self, OsmError> {
        Self::from_bytes_within(bytes, Self::MEMORY_BYTES)
    }

    /// Reads OSM XML or OSM PBF, whichever it is, into at most `memory_bytes`.
    ///
    /// # Errors
    /// Empty, packed or foreign bytes, and those of [`Self::from_xml`] and [`Self::from_pbf`].
    pub fn from_bytes_within(bytes: &[u8], memory_bytes: usize) -> Result<Self, OsmError> {
        if bytes.is_empty() {
            Err(OsmError::Empty)
        } else if bytes.get(PBF_NAME_AT..).is_some_and(|rest| rest.starts_with(b"OSMHeader")) {
            Self::from_pbf(bytes, memory_bytes)
        } else if first_letter(bytes) == Some(b'<') {
            Self::from_xml(bytes, memory_bytes)
        } else if first_letter(bytes) == Some(b'{') {
            Err(OsmError::Json)
        } else if bytes.starts_with(b"BZh") {
            Err(OsmError::Packed { packer: "bzip2", command: "bunzip2 FILE" })
        } else if bytes.starts_with(b"\x1f\x8b") {
            Err(OsmError::Packed { packer: "gzip", command: "gunzip FILE" })
        } else {
            let start = bytes[..bytes.len().min(SHOWN_BYTES)].escape_ascii().to_string();
            Err(OsmError::UnknownFormat { start })
        }
    }

    /// Reads OSM XML (`<osm>` with `<node>` and `<way>`), in UTF-8 or UTF-16, into at most `memory_bytes`. Letters of another encoding are
    /// replaced, and counted among the notices.
    ///
    /// # Errors
    /// [`OsmError::Empty`], [`OsmError::TooLarge`], and [`OsmError::Xml`] for XML that is cut short, not well formed, no OSM document, or holds
    /// a number or place that cannot be read.
    pub fn from_xml(bytes: &[u8], memory_bytes: usize) -> Result<Self, OsmError> {
        if bytes.is_empty() {
            return Err(OsmError::Empty);
        }
        let decoded = text_of(bytes);
        gather(memory_bytes, |elements| osm_xml::read(&decoded, elements))
    }

    /// Reads OSM PBF into at most `memory_bytes`.
    ///
    /// The block being read, at most 32 MiB, and the list of its texts are counted while they are there.
    ///
    /// # Errors
    /// [`OsmError::Empty`], [`OsmError::TooLarge`], [`OsmError::PackedBlocks`], [`OsmError::Feature`], and [`OsmError::Pbf`] for data that is cut short,
    /// damaged, or holds a place that is none or a number beyond 64 bits.
    pub fn from_pbf(bytes: &[u8], memory_bytes: usize) -> Result<Self, OsmError> {
        if bytes.is_empty() {
            return Err(OsmError::Empty);
        }
        gather(memory_bytes, |elements| osm_pbf::read(bytes, elements))
    }
}
