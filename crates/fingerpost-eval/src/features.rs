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
    let ids: Vec<i64> = features.iter().map(|feature| feature.id).collect();
    let mut summaries: Vec<FeatureSummary> = features.iter().map(untouched).collect();
    for sought in records.iter().filter_map(|record| record.sought.as_ref()) {
        // A node that the route passes twice is searched for twice; the highest P(F) stands for both.
        for summary in summaries.iter_mut().filter(|summary| summary.id == sought.id) {
            summary.max_p = summary.max_p.into_iter().chain(sought.p).reduce(f64::max);
        }
    }
    for (record, place) in records.iter().zip(places_in_route(records, &ids)) {
        let Some((summary, feature)) = place.and_then(|i| summaries.get_mut(i)).zip(record.feature.as_ref())
        else {
            continue;
        };
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
    summaries
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
pub(crate) fn places_in_route(records: &[FrameRecord], ids: &[i64]) -> Vec<Option<usize>> {
    let (mut from, mut arrived) = (0, false);
    records
        .iter()
        .map(|record| {
            let feature = record.feature.as_ref()?;
            let behind_arrival = usize::from(arrived && record.state == TrackState::Tracking);
            let place = (from + behind_arrival..ids.len()).find(|&i| ids[i] == feature.id)?;
            arrived = record.state == TrackState::Arrived || (arrived && place == from);
            from = place;
            Some(place)
        })
        .collect()
}
