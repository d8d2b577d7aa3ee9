//! Which topics a recording has.

use std::collections::BTreeMap;
use std::io::Read;

use super::records::{Record, Records, RecordsError};
use super::schema::Schema;
use super::topics::NamesLeft;

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
    /// Messages whose channel is not introduced.
    pub without_channel: u64,
    /// Why it could not be read to its end.
    pub cut_short: Option<RecordsError>,
}

/// Counts the messages of every topic in streams that follow each other, as far as they can be read.
pub fn survey<R: Read>(streams: impl IntoIterator<Item = R>) -> Survey {
    let mut found = Found::default();
    let (mut without_channel, mut cut_short) = (0, None);
    for stream in streams {
        let mut records = Records::new(stream);
        let counted = records.by_ref().try_for_each(|record| found.count(&record?));
        cut_short = counted.err().or(cut_short);
        without_channel += records.without_channel();
    }
    Survey { topics: found.topics.into_values().collect(), without_channel, cut_short }
}

/// The topics so far, by name.
#[derive(Debug, Default)]
struct Found {
    topics: BTreeMap<String, Topic>,
    /// Of all streams together.
    left: NamesLeft,
}

impl Found {
    fn count(&mut self, record: &Record) -> Result<(), RecordsError> {
        if let Some(topic) = self.topics.get_mut(&*record.topic) {
            topic.messages += 1;
            return Ok(());
        }
        self.left.take(&[&record.topic, &record.schema, &record.encoding])?;
        let topic = Topic {
            name: record.topic.to_string(),
            schema: record.schema.to_string(),
            encoding: record.encoding.to_string(),
            messages: 1,
        };
        self.topics.insert(record.topic.to_string(), topic);
        Ok(())
    }
}
