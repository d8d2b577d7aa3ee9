//! The topics that a stream introduces: what is kept of its schemas and channels.
//!
//! Names are all that is kept of a recording while it is read, so they are what a small file could unpack to without end.

use std::collections::BTreeMap;
use std::rc::Rc;

use super::record_fields::Fields;
use super::records::RecordsError;

/// Bytes of all names of a recording together: 65,536 channels, as many as MCAP can number, of 256 bytes each, which is one more than DDS
/// allows a topic.
pub(super) const MOST_NAMES_BYTES: usize = 1 << 24;
/// Bytes of a single name that is kept by itself: as many as DDS allows a topic.
pub(super) const MOST_NAME_BYTES: usize = 255;
/// Characters of a name that a message shows.
const SHOWN_CHARS: usize = 80;

/// What names may still take.
#[derive(Debug)]
pub(super) struct NamesLeft(usize);

impl Default for NamesLeft {
    fn default() -> Self {
        Self(MOST_NAMES_BYTES)
    }
}

impl NamesLeft {
    /// Counts names that are about to be kept.
    pub(super) fn take(&mut self, names: &[&str]) -> Result<(), RecordsError> {
        let wanted = names.iter().map(|name| name.len()).sum();
        self.0 = self.0.checked_sub(wanted).ok_or_else(|| {
            let longest = names.iter().max_by_key(|name| name.len()).copied().unwrap_or_default();
            RecordsError::Names { name: shown(longest), bytes: longest.len() }
        })?;
        Ok(())
    }
}

/// What is known of a channel.
#[derive(Debug, Clone)]
pub(super) struct Channel {
    pub(super) topic: Rc<str>,
    pub(super) schema: Rc<str>,
    pub(super) encoding: Rc<str>,
    schema_id: u16,
}

/// Schemas and channels by their numbers.
#[derive(Debug, Default)]
pub(super) struct Topics {
    schemas: BTreeMap<u16, Rc<str>>,
    channels: BTreeMap<u16, Channel>,
    left: NamesLeft,
}

impl Topics {
    /// Takes in a schema; none where the record is too short.
    ///
    /// # Errors
    /// [`RecordsError`] when its number has another name already, or there are too many names.
    pub(super) fn add_schema(&mut self, mut fields: Fields<'_>) -> Option<Result<(), RecordsError>> {
        let (id, name) = (fields.u16()?, fields.text()?);
        Some(match self.schemas.get(&id) {
            Some(first) => same("schema", id, first, name),
            None => self.left.take(&[name]).map(|()| {
                self.schemas.insert(id, name.into());
            }),
        })
    }

    /// Takes in a channel; none where the record is too short.
    ///
    /// # Errors
    /// [`RecordsError`] when its number has another topic, schema or encoding already, or there are too many names.
    pub(super) fn add_channel(&mut self, mut fields: Fields<'_>) -> Option<Result<(), RecordsError>> {
        let (id, schema_id) = (fields.u16()?, fields.u16()?);
        let (topic, encoding) = (fields.text()?, fields.text()?);
        let Some(first) = self.channels.get(&id) else {
            return Some(self.left.take(&[topic, encoding]).map(|()| {
                let schema = self.schemas.get(&schema_id).cloned().unwrap_or_else(|| "".into());
                let channel = Channel { topic: topic.into(), schema, encoding: encoding.into(), schema_id };
                self.channels.insert(id, channel);
            }));
        };
        let schema = |id: u16| format!("schema {id}");
        Some(
            same("channel", id, &first.topic, topic)
                .and_then(|()| same("channel", id, &first.encoding, encoding))
                .and_then(|()| same("channel", id, &schema(first.schema_id), &schema(schema_id))),
        )
    }

    /// What was introduced under a channel's number.
    pub(super) fn channel(&self, id: u16) -> Option<&Channel> {
        self.channels.get(&id)
    }
}

/// Refuses a number that is given a second meaning: which of the two a message has cannot be known.
fn same(kind: &'static str, id: u16, first: &str, second: &str) -> Result<(), RecordsError> {
    if first == second {
        return Ok(());
    }
    Err(RecordsError::TwoMeanings { kind, id, first: shown(first), second: shown(second) })
}

/// The beginning of a name.
fn shown(name: &str) -> String {
    match name.char_indices().nth(SHOWN_CHARS) {
        Some((end, _)) => format!("{}...", &name[..end]),
        None => name.to_owned(),
    }
}
