//! What became of each feature of the route, from the run's records alone.

use fingerpost_format::{FeatureSummary, FrameRecord, TrackState};

/// What a feature of the route is called.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FeatureIdentity {
    /// OpenStreetMap node.
    pub id: i64,
    /// Name of the place.
    pub name: String,
    /// `junction`, `side_road` or `bend`.
    pub kind: String,
}

/// Detection, arrival and highest P(F) of every feature, in the order of the route.
///
/// Detected is the first frame in which the feature is tracked; arrived the first in state `arrived`; the highest P(F)
/// counts in both states and in the search before. A route that passes the same node twice has it twice.
pub fn feature_summaries(records: &[FrameRecord], features: &[FeatureIdentity]) -> Vec<FeatureSummary> {
    let mut outcomes = FeatureOutcomes::new(features);
    records.iter().for_each(|record| outcomes.add(record));
    outcomes.into_summaries()
}

/// What becomes of every feature, frame by frame: [`feature_summaries`] of a run that goes on.
#[derive(Debug, Clone)]
pub struct FeatureOutcomes {
    ids: Vec<i64>,
    summaries: Vec<FeatureSummary>,
    places: PlacesInRoute,
}

impl FeatureOutcomes {
    /// Nothing seen yet of the route's features.
    pub fn new(features: &[FeatureIdentity]) -> Self {
        Self {
            ids: features.iter().map(|feature| feature.id).collect(),
            summaries: features.iter().map(untouched).collect(),
            places: PlacesInRoute::default(),
        }
    }

    /// Goes on with the next frame.
    pub fn add(&mut self, record: &FrameRecord) {
        if let Some(sought) = &record.sought {
            // A node that the route passes twice is searched for twice; the highest P(F) stands for both.
            for summary in self.summaries.iter_mut().filter(|summary| summary.id == sought.id) {
                summary.max_p = summary.max_p.into_iter().chain(sought.p).reduce(f64::max);
            }
        }
        let place = self.places.next(record, &self.ids);
        let summary = place.and_then(|place| self.summaries.get_mut(place));
        let Some((summary, feature)) = summary.zip(record.feature.as_ref()) else { return };
        match record.state {
            TrackState::Tracking if summary.detected_frame.is_none() => {
                summary.detected_frame = Some(record.frame);
                summary.detected_forward_m = Some(feature.forward_m);
            }
            TrackState::Arrived if summary.arrived_frame.is_none() => {
                summary.arrived_frame = Some(record.frame);
            }
            _ => {}
        }
        if matches!(record.state, TrackState::Tracking | TrackState::Arrived) {
            summary.max_p = summary.max_p.into_iter().chain(feature.p).reduce(f64::max);
        }
    }

    /// What became of them, in the order of the route.
    pub fn into_summaries(self) -> Vec<FeatureSummary> {
        self.summaries
    }
}

fn untouched(feature: &FeatureIdentity) -> FeatureSummary {
    FeatureSummary {
        id: feature.id,
        name: feature.name.clone(),
        kind: feature.kind.clone(),
        detected_frame: None,
        detected_forward_m: None,
        arrived_frame: None,
        max_p: None,
    }
}

/// Which feature of the route, counted from zero, each record's feature is.
///
/// Records name nodes and a route may pass a node twice: features are taken in the order of the route, and one that was
/// arrived at is not followed again.
#[derive(Debug, Clone, Default)]
pub(crate) struct PlacesInRoute {
    from: usize,
    arrived: bool,
}

impl PlacesInRoute {
    /// The feature of the next record; `ids` are those of the route's features.
    pub(crate) fn next(&mut self, record: &FrameRecord, ids: &[i64]) -> Option<usize> {
        let feature = record.feature.as_ref()?;
        let behind_arrival = usize::from(self.arrived && record.state == TrackState::Tracking);
        let place = (self.from + behind_arrival..ids.len()).find(|&i| ids[i] == feature.id)?;
        self.arrived = record.state == TrackState::Arrived || (self.arrived && place == self.from);
        self.from = place;
        Some(place)
    }
}
