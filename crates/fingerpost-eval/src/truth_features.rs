//! Where each feature of the route really is, and when the vehicle passes it.

use std::collections::BTreeMap;

use fingerpost_format::TruthRecord;

use crate::EvalError;

/// The truth of one feature of the route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TruthFeature {
    /// East and north, map frame, metres.
    place_m: [f64; 2],
    /// Smallest true distance ahead, metres.
    pub(crate) nearest_m: f64,
}

/// The features of a truth by their place in the route.
#[derive(Debug)]
pub(crate) struct TruthFeatures {
    features: BTreeMap<usize, TruthFeature>,
    /// Place in the route of the next feature, by frame; the route's length behind the last.
    next: BTreeMap<u64, usize>,
}

impl TruthFeatures {
    /// The features `ids` of a route in `truth`.
    pub(crate) fn new(truth: &[TruthRecord], ids: &[i64]) -> Result<Self, EvalError> {
        let (mut features, mut next) = (BTreeMap::new(), BTreeMap::new());
        let mut from = 0;
        for record in truth {
            let Some(id) = record.feature_id else {
                next.insert(record.frame, ids.len());
                continue;
            };
            let place = (from..ids.len()).find(|&i| ids[i] == id).ok_or(EvalError::OtherRoute {
                frame: record.frame,
                id,
                features: ids.len(),
            })?;
            from = place;
            next.insert(record.frame, place);
            let Some((forward_m, left_m)) = record.feature_forward_m.zip(record.feature_left_m) else {
                continue;
            };
            let seen = TruthFeature { place_m: in_map(record, forward_m, left_m), nearest_m: forward_m };
            let kept = features.entry(place).or_insert(seen);
            if seen.nearest_m < kept.nearest_m {
                *kept = seen;
            }
        }
        Ok(Self { features, next })
    }

    /// The features with their places in the route.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, &TruthFeature)> {
        self.features.iter().map(|(place, feature)| (*place, feature))
    }

    /// Whether the vehicle has passed the feature in that frame.
    pub(crate) fn passed(&self, place: usize, frame: u64) -> bool {
        self.next.get(&frame).is_some_and(|&next| next > place)
    }

    /// True place of a feature in the vehicle frame, metres forward and left; none where the truth never has it.
    pub(crate) fn in_vehicle(&self, place: usize, truth: &TruthRecord) -> Option<[f64; 2]> {
        let feature = self.features.get(&place)?;
        let (east, north) = (feature.place_m[0] - truth.x_m, feature.place_m[1] - truth.y_m);
        let (sin, cos) = libm::sincos(truth.heading_rad);
        Some([cos * east + sin * north, cos * north - sin * east])
    }
}

fn in_map(truth: &TruthRecord, forward_m: f64, left_m: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(truth.heading_rad);
    [truth.x_m + cos * forward_m - sin * left_m, truth.y_m + sin * forward_m + cos * left_m]
}
