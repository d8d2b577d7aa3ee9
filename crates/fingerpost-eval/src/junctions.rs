//! Junctions against truth: detected, falsely detected, arrived at, and how far off they were.

use std::collections::BTreeMap;

use fingerpost_format::{ErrorQuantiles, FrameRecord, TrackState, TruthRecord, TruthSummary};
use serde::Serialize;

use crate::claims::{Claim, ClaimError};
use crate::error::check_ascending;
use crate::features::PlacesInRoute;
use crate::fixes::fix_scores;
use crate::motion::distance_error_pct;
use crate::pose::poses_from_truth;
use crate::truth_features::TruthFeatures;
use crate::{EvalError, error_quantiles};

/// A detection farther than this from the true place of its feature is a false one, metres: half the width of a
/// two-lane street, so that what is nearer lies on the right crossing.
pub const FALSE_BEYOND_M: f64 = 3.0;
/// A feature counts when the vehicle passes it or comes at least so near, metres: nearer than every feature should have
/// been detected.
pub const COUNTED_WITHIN_M: f64 = 10.0;

/// A run's junctions against truth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JunctionEvaluation {
    /// The numbers that `summary.json` holds.
    #[serde(flatten)]
    pub summary: TruthSummary,
    /// Distance between reported and true place in state `arrived`, where the feature is below the vehicle's view and
    /// its place is dead reckoning, metres.
    pub arrived_position_error_m: Option<ErrorQuantiles>,
    /// The claims behind `position_error_m`, in the order of frames: quantiles over several runs need them all.
    #[serde(skip)]
    pub claims: Vec<Claim>,
}

/// Compares the features that a run followed with the truth of the same drive.
///
/// `route_ids` are the nodes of the route's features in their order. Counted are, over the frames of the run:
/// - `features_total`: features that the vehicle passes, or comes within [`COUNTED_WITHIN_M`] of;
/// - `features_detected`: of those, the ones with a detection that is not false;
/// - `false_detections`: detections (first frames in which a feature is tracked, also anew after a loss) that report a
///   place more than [`FALSE_BEYOND_M`] from the feature's true one, or a feature that the vehicle has passed or never
///   comes to;
/// - `arrivals`: of the counted features, the ones with a frame in state `arrived`;
/// - `position_error_m`: distance between reported and true place, over all frames in state `tracking`;
/// - `motion_error_pct`: see [`crate::evaluate_motion`]; none where nothing moves;
/// - `fix_error_m`: distance between fix and true place, over all frames with a fix;
/// - `bound_violations`: of these, the frames whose error is more than the fix's protection level.
///
/// # Errors
/// [`EvalError`] when there are no frames, frames do not ascend, a frame has no truth, or the truth is of another route.
pub fn evaluate_junctions(
    records: &[FrameRecord],
    truth: &[TruthRecord],
    route_ids: &[i64],
) -> Result<JunctionEvaluation, EvalError> {
    let by_frame = truth_of_run(records, truth)?;
    let last_frame = records.last().map_or(0, |record| record.frame);
    let driven: Vec<TruthRecord> = by_frame.values().map(|&truth| truth.clone()).collect();
    // A run without a route has nothing to find, whatever the truth holds.
    let features = TruthFeatures::new(if route_ids.is_empty() { &[] } else { &driven }, route_ids)?;
    let mut places = PlacesInRoute::default();

    let mut detected = vec![false; route_ids.len()];
    let mut arrived = vec![false; route_ids.len()];
    let mut false_detections = 0;
    let (mut claims, mut arrived_errors_m) = (Vec::new(), Vec::new());
    let mut followed_before = None;
    for record in records {
        let place = places.next(record, route_ids);
        if record.error.is_some() {
            continue;
        }
        let tracked = record.feature.as_ref().filter(|_| record.state == TrackState::Tracking);
        let followed = tracked.map(|feature| feature.id);
        let begins = followed.is_some() && followed != followed_before;
        followed_before = followed;
        let Some(feature) = record.feature.as_ref() else { continue };
        let truth = by_frame.get(&record.frame);
        let true_m = place.zip(truth).and_then(|(place, truth)| features.in_vehicle(place, truth));
        let error = true_m.map(|true_m| ClaimError::new(feature, true_m));
        let error_m = error.map(|error| error.distance_m);
        if begins {
            let passed = place.is_none_or(|place| features.passed(place, record.frame));
            if passed || error_m.is_none_or(|error_m| error_m > FALSE_BEYOND_M) {
                false_detections += 1;
            } else if let Some(detected) = place.and_then(|place| detected.get_mut(place)) {
                *detected = true;
            }
        }
        match record.state {
            TrackState::Tracking => {
                claims.push(Claim { place, error, present: feature.present.or(feature.confidence) })
            }
            TrackState::Arrived => {
                arrived_errors_m.extend(error_m);
                if let Some(arrived) = place.and_then(|place| arrived.get_mut(place)) {
                    *arrived = true;
                }
            }
            _ => {}
        }
    }

    let counted: Vec<usize> = features
        .iter()
        .filter(|(place, feature)| {
            feature.nearest_m < COUNTED_WITHIN_M || features.passed(*place, last_frame)
        })
        .map(|(place, _)| place)
        .collect();
    let count = |flags: &[bool]| counted.iter().filter(|&&place| flags[place]).count() as u64;
    let (fix_error_m, bound_violations) = fix_scores(records, &by_frame);
    let summary = TruthSummary {
        features_total: counted.len() as u64,
        features_detected: count(&detected),
        false_detections,
        arrivals: count(&arrived),
        position_error_m: error_quantiles(claims.iter().filter_map(|claim| Some(claim.error?.distance_m))),
        motion_error_pct: distance_error_pct(records, &poses_from_truth(truth)),
        fix_error_m,
        bound_violations,
    };
    Ok(JunctionEvaluation { summary, arrived_position_error_m: error_quantiles(arrived_errors_m), claims })
}

/// The truth of every frame of a run, by frame.
pub(crate) fn truth_of_run<'a>(
    records: &[FrameRecord],
    truth: &'a [TruthRecord],
) -> Result<BTreeMap<u64, &'a TruthRecord>, EvalError> {
    let (Some(first), Some(last)) = (records.first(), records.last()) else {
        return Err(EvalError::NoFrames);
    };
    check_ascending("run", records.iter().map(|record| record.frame))?;
    check_ascending("truth", truth.iter().map(|truth| truth.frame))?;
    let by_frame: BTreeMap<u64, &TruthRecord> = truth.iter().map(|truth| (truth.frame, truth)).collect();
    match records.iter().find(|record| !by_frame.contains_key(&record.frame)) {
        Some(record) => Err(EvalError::NoTruth {
            frame: record.frame,
            truths: truth.len(),
            first: truth.first().map_or(0, |truth| truth.frame),
            last: truth.last().map_or(0, |truth| truth.frame),
        }),
        None => {
            Ok(by_frame.into_iter().filter(|(frame, _)| (first.frame..=last.frame).contains(frame)).collect())
        }
    }
}
