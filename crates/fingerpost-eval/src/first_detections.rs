//! First detections of features against where dead reckoning had them.

use fingerpost_format::{FrameRecord, TrackState, TruthRecord};

use crate::EvalError;
use crate::claims::FirstDetection;
use crate::features::PlacesInRoute;
use crate::junctions::truth_of_run;
use crate::truth_features::TruthFeatures;

/// Holds the distance of every feature that is detected and is there, in the first frame of its first detection, against the
/// distance that the route's progress expected: from the frame before, less the way driven since.
///
/// `route` has node and distance along the route of each feature, metres. Distances are those in a straight line, forward and to
/// the left together, so that a bend before the feature makes the expectation look too far by what it cuts off. Features whose
/// expectation is not known are left out.
///
/// # Errors
/// As [`crate::evaluate_junctions`].
pub fn first_detections(
    records: &[FrameRecord],
    truth: &[TruthRecord],
    route: &[(i64, f64)],
) -> Result<Vec<FirstDetection>, EvalError> {
    let ids: Vec<i64> = route.iter().map(|(id, _)| *id).collect();
    let by_frame = truth_of_run(records, truth)?;
    let driven: Vec<TruthRecord> = by_frame.values().map(|&truth| truth.clone()).collect();
    let features = TruthFeatures::new(if ids.is_empty() { &[] } else { &driven }, &ids)?;
    let mut places = PlacesInRoute::default();
    let places: Vec<Option<usize>> = records.iter().map(|record| places.next(record, &ids)).collect();
    let mut seen = vec![false; ids.len()];
    let mut found = Vec::new();
    for (i, pair) in records.windows(2).enumerate() {
        let (before, record) = (&pair[0], &pair[1]);
        let Some(place) = places[i + 1].filter(|&place| !seen[place]) else { continue };
        if record.state != TrackState::Tracking {
            continue;
        }
        seen[place] = true;
        let true_m = by_frame.get(&record.frame).and_then(|truth| features.in_vehicle(place, truth));
        let Some(((feature, [forward_m, left_m]), before_m)) =
            record.feature.as_ref().zip(true_m).zip(before.route_m)
        else {
            continue;
        };
        let moved_m = record.motion.map_or(0.0, |motion| motion.forward_m);
        let expected_m = route[place].1 - before_m - moved_m;
        let distance_m = libm::hypot(forward_m, left_m);
        found.push(FirstDetection {
            detected_off_m: (libm::hypot(feature.forward_m, feature.left_m) - distance_m).abs(),
            expected_off_m: (expected_m - distance_m).abs(),
        });
    }
    Ok(found)
}
