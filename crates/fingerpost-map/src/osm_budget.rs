//! How much memory a map may take while it is read.

use crate::osm::{OsmError, OsmNode, OsmWay};

/// Bytes that a tag or a way takes beside its texts and node numbers: a place in a tree, two texts' headers.
const OVERHEAD_BYTES: usize = 96;
/// A list that grows is copied into one of twice its size: for a moment both are there.
const GROWTH: usize = 3;

/// What is left of the memory that a map may take.
#[derive(Debug)]
pub(crate) struct Budget {
    limit_bytes: usize,
    left_bytes: usize,
}

impl Budget {
    /// All of it.
    pub(crate) fn new(limit_bytes: usize) -> Self {
        Self { limit_bytes, left_bytes: limit_bytes }
    }

    /// Takes what a node needs.
    pub(crate) fn take_node(&mut self) -> Result<(), OsmError> {
        self.take(GROWTH * size_of::<OsmNode>())
    }

    /// Takes what a way needs beside its nodes and tags.
    pub(crate) fn take_way(&mut self) -> Result<(), OsmError> {
        self.take(GROWTH * size_of::<OsmWay>())
    }

    /// Takes what one node of a way needs, and says how much.
    pub(crate) fn take_reference(&mut self) -> Result<usize, OsmError> {
        let bytes = GROWTH * size_of::<i64>();
        self.take(bytes).map(|()| bytes)
    }

    /// Takes what a tag needs, and says how much; asked before its texts are copied, since many tags of a PBF block may be the
    /// same long text.
    pub(crate) fn take_tag(&mut self, key: &str, value: &str) -> Result<usize, OsmError> {
        let bytes = OVERHEAD_BYTES.saturating_add(key.len()).saturating_add(value.len());
        self.take(bytes).map(|()| bytes)
    }

    /// Gives back what something took that is there no more, bytes.
    pub(crate) fn give_back(&mut self, bytes: usize) {
        self.left_bytes = self.left_bytes.saturating_add(bytes).min(self.limit_bytes);
    }

    /// Takes so many bytes.
    pub(crate) fn take(&mut self, bytes: usize) -> Result<(), OsmError> {
        let limit_mb = self.limit_bytes / 1_000_000;
        self.left_bytes = self.left_bytes.checked_sub(bytes).ok_or(OsmError::TooLarge { limit_mb })?;
        Ok(())
    }
}
