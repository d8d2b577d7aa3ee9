//! Which topics a recording has.

use std::collections::BTreeMap;
use std::io::Read;

use super::records::{Records, RecordsError};
use super::schema::Schema;

/// A topic of a recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// Name of its messages' schema.
    pub schema: String,
    /// Their encoding.
    pub encoding: String,
    /// How many there are.
    pub messages: u64,
}

impl Topic {
    /// Its schema, where messages of that name are read; whether in its encoding is another matter.
    pub fn known_schema(&self) -> Option<Schema> {
        Schema::named(&self.schema)
    }
}

/// What a recording holds.
#[derive(Debug)]
pub struct Survey {
    /// Its topics that have messages, by name.
    pub topics: Vec<Topic>,
    /// Why it could not be read to its end.
    pub cut_short: Option<RecordsError>,
}

/// Counts the messages of every topic in streams that follow each other, as far as they can be read.
pub fn survey<R: Read>(streams: impl IntoIterator<Item = R>) -> Survey {
    let mut topics: BTreeMap<String, Topic> = BTreeMap::new();
    let mut cut_short = None;
    for record in streams.into_iter().flat_map(Records::new) {
        match record {
            Ok(record) => {
                let topic = topics.entry(record.topic.to_string()).or_insert_with(|| Topic {
                    name: record.topic.to_string(),
                    schema: record.schema.to_string(),
                    encoding: record.encoding.to_string(),
                    messages: 0,
                });
                topic.messages += 1;
            }
            Err(cause) => cut_short = Some(cause),
        }
    }
    Survey { topics: topics.into_values().collect(), cut_short }
}
