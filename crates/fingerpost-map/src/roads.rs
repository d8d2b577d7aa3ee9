//! The drivable ways of a map with the places of their nodes, before a plane is chosen.

use std::collections::{BTreeMap, BTreeSet};

use crate::access::closes;
use crate::notice::Notices;
use crate::path::SAME_POINT_M;
use crate::{GraphError, LatLon, MapBounds, MapNotice, MapNoticeKind, OsmData, RoadAttributes};

/// Drivable ways, nodes that a way joins at one place taken for one.
pub(crate) struct Roads {
    /// Places of the ways' nodes.
    pub(crate) places: BTreeMap<i64, LatLon>,
    /// Number, nodes and attributes of each way.
    pub(crate) ways: Vec<(i64, Vec<i64>, RoadAttributes)>,
    /// Nodes whose barriers let no car through.
    pub(crate) closed: BTreeSet<i64>,
    /// What the places cover.
    pub(crate) bounds: MapBounds,
    /// What was not understood, of the file and of its roads.
    pub(crate) notices: Vec<MapNotice>,
}

impl Roads {
    pub(crate) fn of(osm: &OsmData) -> Result<Self, GraphError> {
        let known: BTreeMap<i64, LatLon> = osm.nodes.iter().map(|node| (node.id, node.at)).collect();
        let mut notices = Notices::default();
        let mut joined = Joined::default();
        let mut places = BTreeMap::new();
        let mut ways = Vec::new();
        for way in &osm.ways {
            let mut unread = |kind: MapNoticeKind, key: &str, value: &str| {
                notices.add(kind, || format!("way {}, {key}={value}", way.id));
            };
            let Some(attributes) = RoadAttributes::read(&way.tags, &mut unread) else { continue };
            let place = |id: &i64| known.get(id).copied();
            // Extracts cut ways at their border: nodes outside are named but not given.
            for piece in way.nodes.split(|id| place(id).is_none()) {
                if piece.len() >= 2 {
                    places.extend(piece.iter().filter_map(|id| Some((*id, place(id)?))));
                    ways.push((way.id, piece.to_vec(), attributes.clone()));
                }
            }
            for ends in way.nodes.windows(2) {
                joined.join(ends[0], ends[1], place);
            }
        }
        for (_, nodes, _) in &mut ways {
            nodes.iter_mut().for_each(|id| *id = joined.first(*id));
            nodes.dedup();
        }
        ways.retain(|(_, nodes, _)| nodes.len() >= 2);
        places.retain(|id, _| joined.first(*id) == *id);
        // A way of one place is no road, and leaves its node without one.
        let used: BTreeSet<i64> = ways.iter().flat_map(|(_, nodes, _)| nodes.iter().copied()).collect();
        places.retain(|id, _| used.contains(id));
        let bounds = MapBounds::of(places.values().copied());
        let Some(bounds) = bounds else {
            return Err(GraphError::NoRoads {
                highways: osm.ways.len(),
                notices: with_those_of(osm, notices),
            });
        };
        let mut closed = BTreeSet::new();
        for barrier in &osm.barriers {
            let node = joined.first(barrier.node);
            let mut unread = |kind: MapNoticeKind, key: &str, value: &str| {
                notices.add(kind, || format!("node {}, {key}={value}", barrier.node));
            };
            if places.contains_key(&node) && closes(&barrier.tags, &mut unread) {
                closed.insert(node);
            }
        }
        notice_unjoined(&places, &mut notices);
        Ok(Self { places, ways, closed, bounds, notices: with_those_of(osm, notices) })
    }
}

/// The notices of the file, and behind them those of its roads.
fn with_those_of(osm: &OsmData, of_roads: Notices) -> Vec<MapNotice> {
    osm.notices.iter().cloned().chain(of_roads.into_list()).collect()
}

/// Notes nodes of roads at one place, which a mapper may have meant to join, or which lie on top of each other.
fn notice_unjoined(places: &BTreeMap<i64, LatLon>, notices: &mut Notices) {
    let mut by_place: Vec<(LatLon, i64)> = places.iter().map(|(id, at)| (*at, *id)).collect();
    by_place.sort_by(|(a, _), (b, _)| a.lat_deg.total_cmp(&b.lat_deg).then(a.lon_deg.total_cmp(&b.lon_deg)));
    for pair in by_place.windows(2).filter(|pair| pair[0].0 == pair[1].0) {
        notices.add(MapNoticeKind::UnjoinedNodes, || format!("nodes {} and {}", pair[0].1, pair[1].1));
    }
}

/// Nodes that are one, each with the smallest of their numbers in the end.
#[derive(Default)]
struct Joined(BTreeMap<i64, i64>);

impl Joined {
    fn first(&mut self, id: i64) -> i64 {
        let mut first = id;
        while let Some(&before) = self.0.get(&first) {
            first = before;
        }
        // The next one finds it at once, however long the row was.
        let mut here = id;
        while let Some(before) = self.0.get_mut(&here).filter(|before| **before != first) {
            here = std::mem::replace(before, first);
        }
        first
    }

    /// Joins two neighbours on a way where they lie at one place, and where the nodes do that they are joined with: a row of
    /// near nodes is still a way.
    fn join(&mut self, one: i64, other: i64, place: impl Fn(&i64) -> Option<LatLon>) {
        let (one, other) = (self.first(one), self.first(other));
        if one != other && place(&one).zip(place(&other)).is_some_and(|(a, b)| a.chord_m(b) < SAME_POINT_M) {
            self.0.insert(one.max(other), one.min(other));
        }
    }
}
