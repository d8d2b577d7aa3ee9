//! What of a map was not understood, or is not as it seems: counted while it is read, so that the program says it once.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use crate::label::cleaned;

/// What a notice is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum MapNoticeKind {
    /// What the server that made the map says of it: Overpass tells in a remark that a query was cut short.
    Remark,
    /// Elements that stand in the map more than once, in versions or as copies.
    RepeatedElement,
    /// Letters of an encoding that is not read.
    Letter,
    /// XML elements that no OpenStreetMap file has there.
    UnknownElement,
    /// Nodes of roads that lie at one place and that no way joins.
    UnjoinedNodes,
    /// Values of `highway` that are no known class.
    Highway,
    /// Values of `access` and its kin that say nothing known.
    Access,
    /// Values of `oneway` that say no direction which lasts.
    Oneway,
    /// Ways that are driven in turns (`oneway=alternating`).
    Alternating,
    /// Restrictions that hold at times (`access:conditional` and its kin).
    Conditional,
    /// Values of `barrier` that are no known kind.
    Barrier,
    /// Values of `locked` on barriers that say neither yes nor no.
    Locked,
    /// Widths that cannot be read or cannot be.
    Width,
    /// Numbers of lanes that cannot be read or cannot be.
    Lanes,
    /// Values of `sidewalk`, `kerb`, `parking` and `cycleway` that say nothing known.
    Roadside,
}

impl MapNoticeKind {
    /// Its name, as in files: `width`, `oneway`, `remark` and so on.
    pub const fn as_str(self) -> &'static str {
        self.words()[0]
    }

    /// Its name in files, what there is, and what is done about it.
    const fn words(self) -> [&'static str; 3] {
        match self {
            Self::Remark => [
                "remark",
                "remarks of the server that made the map",
                "what they speak of is missing: download the map again, of a smaller area",
            ],
            Self::RepeatedElement => [
                "repeated_element",
                "nodes and ways that stand in the map again, as in a history or where extracts overlap",
                "of versions the newest counts, of copies the first",
            ],
            Self::Letter => [
                "letter",
                "letters that are not UTF-8",
                "they are replaced, and what they stand in may not be understood: write the map again in UTF-8",
            ],
            Self::UnknownElement => ["unknown_element", "elements not understood", "they are passed over"],
            Self::UnjoinedNodes => [
                "unjoined_nodes",
                "nodes of roads at one place that no way joins",
                "routes do not pass there",
            ],
            Self::Highway => {
                ["highway", "values of highway not understood", "those ways are taken for no roads"]
            }
            Self::Access => {
                ["access", "values of access not understood", "they are taken not to close the road"]
            }
            Self::Oneway => {
                ["oneway", "values of oneway that say no lasting direction", "routes do not use those ways"]
            }
            Self::Alternating => {
                ["alternating", "ways driven in turns", "routes use them in both directions"]
            }
            Self::Conditional => ["conditional", "restrictions that hold at times", "they are passed over"],
            Self::Barrier => {
                ["barrier", "values of barrier not understood", "they are taken to close the road"]
            }
            Self::Locked => {
                ["locked", "values of locked not understood", "they are taken not to close the road"]
            }
            Self::Width => ["width", "widths not understood", "lanes or the road's class say them instead"],
            Self::Lanes => {
                ["lanes", "numbers of lanes not understood", "the road's class says the width instead"]
            }
            Self::Roadside => {
                ["roadside", "values of what lies beside roads not understood", "they are passed over"]
            }
        }
    }
}

/// How often something in a map was not understood, and where first.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapNotice {
    /// What it is about.
    pub kind: MapNoticeKind,
    /// How many times.
    pub count: usize,
    /// The first place and what stands there, as in `way 5: width="wide"`; of a remark its words.
    pub first: String,
}

impl Display for MapNotice {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { kind, count, first } = self;
        let [_, what, done] = kind.words();
        write!(f, "{what}: {count}, first: {first}; {done}")
    }
}

/// Notices under way: one a kind.
#[derive(Debug, Clone, Default)]
pub(crate) struct Notices(BTreeMap<MapNoticeKind, (usize, String)>);

impl Notices {
    /// Counts one; `first` says where and what, and is asked for the first of its kind alone.
    pub(crate) fn add(&mut self, kind: MapNoticeKind, first: impl FnOnce() -> String) {
        self.add_many(kind, 1, first);
    }

    /// Counts several of one kind.
    pub(crate) fn add_many(&mut self, kind: MapNoticeKind, more: usize, first: impl FnOnce() -> String) {
        let (count, _) = self.0.entry(kind).or_insert_with(|| (0, cleaned(&first())));
        *count += more;
    }

    /// One a kind, in the order of the kinds.
    pub(crate) fn into_list(self) -> Vec<MapNotice> {
        self.0.into_iter().map(|(kind, (count, first))| MapNotice { kind, count, first }).collect()
    }
}
