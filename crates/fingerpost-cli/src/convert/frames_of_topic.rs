//! In which frames a topic's messages are, to be said.

use std::collections::BTreeMap;
use std::sync::Arc;

use fingerpost_io::bag::{Axes, AxesSource};

/// A frame's name, how many messages are in it, and its axes.
type InFrame<'a> = (&'a str, u64, &'a Axes);

/// The frames of a topic's messages: how many messages are in each, and along which axes they measure.
#[derive(Debug, Default)]
pub(super) struct FramesOfTopic(BTreeMap<Arc<str>, (u64, Axes)>);

impl FramesOfTopic {
    pub(super) fn count(&mut self, frame_id: &Arc<str>, axes: Axes) {
        let (count, _) = self.0.entry(Arc::clone(frame_id)).or_insert((0, axes));
        *count += 1;
    }

    /// By what each sort of axes is known, with a sentence on `what` that `topic` gives along them.
    pub(super) fn said(&self, what: &str, topic: &str) -> impl Iterator<Item = (AxesSource, String)> {
        let mut sorts: BTreeMap<(AxesSource, bool), Vec<InFrame<'_>>> = BTreeMap::new();
        for (frame_id, (count, axes)) in &self.0 {
            let sort = sorts.entry((axes.source(), axes.is_chain_cut())).or_default();
            sort.push((frame_id, *count, axes));
        }
        sorts.into_iter().filter_map(move |((source, _), frames)| {
            let messages: u64 = frames.iter().map(|(_, count, _)| count).sum();
            let ((first, _, axes), others) = frames.split_first()?;
            let more = others_in_words(others.len());
            let frame = frame_in_words(first, axes);
            let advice = if source == AxesSource::Guessed {
                "; where it is not, record /tf_static with base_link, or name its frame by REP 103"
            } else {
                ""
            };
            Some((source, format!("{what}: that of {messages} messages of {topic} in {frame}{more}{advice}")))
        })
    }
}

/// A frame and its axes in words.
pub(super) fn frame_in_words(frame_id: &str, axes: &Axes) -> String {
    let name =
        if frame_id.is_empty() { "a frame without a name".to_owned() } else { format!("frame {frame_id:?}") };
    let cut = if axes.is_chain_cut() {
        "; /tf_static has it on more than 64 frames or in a circle, which is not followed"
    } else {
        ""
    };
    format!("{name}, {}{cut}", axes.source().words())
}

/// How many frames there are beside one that is named; nothing for none.
pub(super) fn others_in_words(others: usize) -> String {
    if others == 0 { String::new() } else { format!(" (and in {others} more)") }
}
