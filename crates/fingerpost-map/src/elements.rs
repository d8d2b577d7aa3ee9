//! The elements of a file on their way into [`OsmData`]: which of several with one number counts.
//!
//! Histories hold every version of an element, and maps of several dates or areas that were put together hold some twice: the
//! newest version counts, and none where that one is a deletion; of copies with one version the first. A deletion is newer than an element
//! of its version: editors mark it without counting the version up. A file whose numbers
//! ascend, as nearly all do, is read once. Any other is read again, for the versions of the elements that are in question
//! alone, so that versions take no memory where nobody needs them.

use std::collections::BTreeMap;

use crate::osm::{OsmBarrier, OsmData, OsmError, OsmNode, OsmWay};
use crate::osm_budget::Budget;
use crate::{LatLon, MapNoticeKind, notice::Notices};

/// What a file says of an element's age, in the order of time: by the number, and of one number what is deleted comes last, because
/// editors keep the number of an element that they delete.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Version {
    /// Its number, ascending with time; 0 where the file does not say it.
    pub(crate) number: i64,
    /// Whether the element is there no more.
    pub(crate) is_deleted: bool,
}

/// Takes the elements of a file in the file's order.
pub(crate) struct Elements {
    /// What is left of the memory.
    pub(crate) budget: Budget,
    /// What was noticed.
    pub(crate) notices: Notices,
    nodes: Vec<OsmNode>,
    ways: Vec<OsmWay>,
    /// Barriers, each with the place of its node in `nodes`.
    barriers: Vec<(usize, OsmBarrier)>,
    /// Places of nodes that stand on their ways.
    on_ways: Vec<OsmNode>,
    node_order: Order,
    way_order: Order,
    contest: Option<Contest>,
}

/// Reads a file with one of the readers, again where its elements have versions.
pub(crate) fn gather(
    memory_bytes: usize,
    read: impl Fn(&mut Elements) -> Result<(), OsmError>,
) -> Result<OsmData, OsmError> {
    let mut elements = Elements {
        budget: Budget::new(memory_bytes),
        notices: Notices::default(),
        nodes: Vec::new(),
        ways: Vec::new(),
        barriers: Vec::new(),
        on_ways: Vec::new(),
        node_order: Order::default(),
        way_order: Order::default(),
        contest: None,
    };
    read(&mut elements)?;
    elements.contest = elements.contest()?;
    if elements.contest.is_some() {
        read(&mut elements)?;
    }
    elements.into_data()
}

impl Elements {
    /// Whether elements are taken whole; else their versions alone.
    pub(crate) const fn are_taken(&self) -> bool {
        self.contest.is_none()
    }

    /// Takes a node; no place for one that is deleted.
    pub(crate) fn node(&mut self, id: i64, version: Version, at: Option<LatLon>) -> Result<(), OsmError> {
        if let Some(contest) = &mut self.contest {
            Contest::enter(&mut contest.nodes, id, version, at.is_some());
            return Ok(());
        }
        self.node_order.add(id);
        if let Some(at) = at {
            self.budget.take_node()?;
            self.nodes.push(OsmNode { id, at });
        }
        Ok(())
    }

    /// Takes the tags of a barrier, which the last node that was taken carries.
    pub(crate) fn barrier(&mut self, tags: BTreeMap<String, String>) -> Result<(), OsmError> {
        self.budget.take_way()?;
        let Some((place, node)) = self.nodes.len().checked_sub(1).zip(self.nodes.last()) else {
            return Ok(());
        };
        self.barriers.push((place, OsmBarrier { node: node.id, tags }));
        Ok(())
    }

    /// Takes a way; none for one that is deleted or no highway.
    pub(crate) fn way(&mut self, id: i64, version: Version, way: Option<OsmWay>) {
        if let Some(contest) = &mut self.contest {
            Contest::enter(&mut contest.ways, id, version, way.is_some());
            return;
        }
        self.way_order.add(id);
        self.ways.extend(way);
    }

    /// Takes the place of a node that stands on a way.
    pub(crate) fn place_on_way(&mut self, id: i64, at: LatLon) -> Result<(), OsmError> {
        self.budget.take_node()?;
        self.on_ways.push(OsmNode { id, at });
        Ok(())
    }

    /// The elements whose versions must be known, if there are any.
    fn contest(&mut self) -> Result<Option<Contest>, OsmError> {
        let mut contest = Contest::default();
        if self.node_order.is_broken {
            // Nodes that are deleted in between are in question as well: all that are there may be.
            contest.nodes = self.entries(self.nodes.iter().map(|node| node.id).collect())?;
        }
        if self.way_order.is_broken {
            contest.ways = self.entries(self.ways.iter().map(|way| way.id).collect())?;
        }
        Ok((!contest.nodes.is_empty() || !contest.ways.is_empty()).then_some(contest))
    }

    fn entries(&mut self, mut ids: Vec<i64>) -> Result<Vec<Entry>, OsmError> {
        self.budget.take(ids.len().saturating_mul(size_of::<i64>() + size_of::<Entry>()))?;
        ids.sort_unstable();
        ids.dedup();
        Ok(ids.into_iter().map(Entry::of).collect())
    }

    fn into_data(self) -> Result<OsmData, OsmError> {
        let Self { mut budget, mut notices, mut nodes, mut ways, barriers, mut on_ways, contest, .. } = self;
        let mut barriers = barriers;
        if let Some(Contest { nodes: mut node_entries, ways: mut way_entries }) = contest {
            budget.take(nodes.len())?;
            let counts: Vec<bool> =
                nodes.iter().map(|node| Entry::counts(&mut node_entries, node.id)).collect();
            barriers.retain(|(place, _)| counts[*place]);
            let mut counts = counts.into_iter();
            nodes.retain(|_| counts.next().unwrap_or(true));
            ways.retain(|way| Entry::counts(&mut way_entries, way.id));
            for (entries, element) in [(&node_entries, "node"), (&way_entries, "way")] {
                for entry in entries.iter().filter(|entry| entry.entered > 1) {
                    notices.add(MapNoticeKind::RepeatedElement, || format!("{element} {}", entry.id));
                }
            }
        }
        nodes.sort_by_key(|node| node.id);
        ways.sort_by_key(|way| way.id);
        let mut barriers: Vec<OsmBarrier> = barriers.into_iter().map(|(_, barrier)| barrier).collect();
        barriers.sort_by_key(|barrier| barrier.node);
        on_ways.sort_by_key(|node| node.id);
        on_ways.dedup_by_key(|node| node.id);
        on_ways.retain(|node| nodes.binary_search_by_key(&node.id, |node| node.id).is_err());
        nodes.append(&mut on_ways);
        nodes.sort_by_key(|node| node.id);
        Ok(OsmData { nodes, ways, barriers, notices: notices.into_list() })
    }
}

/// Whether numbers ascend, so that none comes twice.
#[derive(Debug, Clone, Copy, Default)]
struct Order {
    last: Option<i64>,
    is_broken: bool,
}

impl Order {
    fn add(&mut self, id: i64) {
        self.is_broken |= self.last.is_some_and(|last| id <= last);
        self.last = Some(id);
    }
}

/// The versions of elements in question, ascending numbers.
#[derive(Debug, Default)]
struct Contest {
    nodes: Vec<Entry>,
    ways: Vec<Entry>,
}

impl Contest {
    fn enter(entries: &mut [Entry], id: i64, version: Version, is_kept: bool) {
        let Ok(place) = entries.binary_search_by_key(&id, |entry| entry.id) else { return };
        let entry = &mut entries[place];
        if entry.entered == 0 || version > entry.newest {
            entry.newest = version;
            entry.winner = is_kept.then_some(entry.kept);
        }
        entry.entered += 1;
        entry.kept += u32::from(is_kept);
    }
}

/// The versions of an element.
#[derive(Debug, Clone, Copy)]
struct Entry {
    id: i64,
    newest: Version,
    /// How many there are.
    entered: u32,
    /// How many of them are there as nodes or highways.
    kept: u32,
    /// How many of those stand before the newest; none where that one is deleted or no highway.
    winner: Option<u32>,
}

impl Entry {
    fn of(id: i64) -> Self {
        Self { id, newest: Version::default(), entered: 0, kept: 0, winner: None }
    }

    /// Whether the next element of this number, in the file's order, counts.
    fn counts(entries: &mut [Self], id: i64) -> bool {
        let Ok(place) = entries.binary_search_by_key(&id, |entry| entry.id) else { return true };
        let entry = &mut entries[place];
        // Counted down until the newest is reached.
        let counts = entry.winner == Some(0);
        entry.winner = entry.winner.and_then(|ahead| ahead.checked_sub(1));
        counts
    }
}
