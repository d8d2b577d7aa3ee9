//! What became of each feature of the route, from the run's records alone.

use fingerpost_format::{FeatureOutcome, FeatureSummary, FrameRecord, TrackState};

/// What a feature of the route is called.
#[derive(Debug, Clone, PartialEq)]
pub struct FeatureIdentity {
    /// OpenStreetMap node.
    pub id: i64,
    /// Name of the place.
    pub name: String,
    /// `junction`, `side_road` or `bend`.
    pub kind: String,
    /// Distance along the route to it, metres.
    pub at_m: f64,
}

/// Detection, arrival and highest P(F) of every feature, in the order of the route.
///
/// Detected is the first frame in which the feature is tracked; arrived the first in state `arrived`; the highest P(F)
/// counts in both states and in the search before. A route that passes the same node twice has it twice. What was never found was missed
/// where the vehicle is believed to have passed it in the end; where its motion was not believed, nothing says that it was not reached.
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
    reached: Reached,
}

/// How far along the route the vehicle is believed to have come.
#[derive(Debug, Clone, Copy, Default)]
struct Reached {
    route_m: Option<f64>,
    is_done: bool,
    is_at_least: bool,
}

impl FeatureOutcomes {
    /// Nothing seen yet of the route's features.
    pub fn new(features: &[FeatureIdentity]) -> Self {
        Self {
            ids: features.iter().map(|feature| feature.id).collect(),
            summaries: features.iter().map(untouched).collect(),
            places: PlacesInRoute::default(),
            reached: Reached::default(),
        }
    }

    /// Goes on with the next frame.
    pub fn add(&mut self, record: &FrameRecord) {
        self.reached.add(record);
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
                summary.arrived_forward_m = Some(feature.forward_m);
            }
            _ => {}
        }
        if matches!(record.state, TrackState::Tracking | TrackState::Arrived) {
            summary.max_p = summary.max_p.into_iter().chain(feature.p).reduce(f64::max);
        }
    }

    /// What became of them, in the order of the route.
    pub fn into_summaries(self) -> Vec<FeatureSummary> {
        let Self { mut summaries, reached, .. } = self;
        for summary in &mut summaries {
            summary.outcome = match summary {
                FeatureSummary { arrived_frame: Some(_), .. } => Some(FeatureOutcome::Arrived),
                FeatureSummary { detected_frame: Some(_), .. } => Some(FeatureOutcome::Detected),
                FeatureSummary { at_m, .. } => at_m.and_then(|at_m| reached.unfound(at_m)),
            };
        }
        summaries
    }
}

impl Reached {
    fn add(&mut self, record: &FrameRecord) {
        self.route_m = record.route_m;
        self.is_done |= record.state == TrackState::RouteDone;
        self.is_at_least |= record.motion.is_some_and(|motion| motion.doubt.is_some());
    }

    /// What became of a feature at a place of the route that was never found; none where that is not known.
    fn unfound(&self, at_m: f64) -> Option<FeatureOutcome> {
        if self.is_done || self.route_m? >= at_m {
            Some(FeatureOutcome::Missed)
        } else {
            (!self.is_at_least).then_some(FeatureOutcome::NotReached)
        }
    }
}

fn untouched(feature: &FeatureIdentity) -> FeatureSummary {
    FeatureSummary {
        id: feature.id,
        name: feature.name.clone(),
        kind: feature.kind.clone(),
        at_m: Some(feature.at_m),
        ..FeatureSummary::default()
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
