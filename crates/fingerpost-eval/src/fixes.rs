//! The places on the map that a run gives, against truth.

use std::collections::BTreeMap;

use fingerpost_format::{ErrorQuantiles, FrameRecord, TruthRecord};

use crate::error_quantiles;

/// Mean radius of the Earth, metres (IUGG): as exact as errors of some metres need.
const EARTH_RADIUS_M: f64 = 6_371_008.8;

/// Distances between fix and true place, and in how many frames that is more than the protection level; none where no frame has a
/// fix.
pub(crate) fn fix_scores(
    records: &[FrameRecord],
    truth: &BTreeMap<u64, &TruthRecord>,
) -> (Option<ErrorQuantiles>, Option<u64>) {
    let beside = |record: &FrameRecord| {
        let (fix, truth) = (record.fix.as_ref()?, truth.get(&record.frame)?);
        let north_rad = (fix.lat - truth.lat).to_radians();
        let east_rad = (fix.lon - truth.lon).to_radians() * libm::cos(truth.lat.to_radians());
        let error_m = EARTH_RADIUS_M * libm::hypot(north_rad, east_rad);
        Some((error_m, fix.bound_m.is_some_and(|bound_m| error_m > bound_m)))
    };
    let fixes: Vec<(f64, bool)> = records.iter().filter_map(beside).collect();
    let violations = fixes.iter().filter(|(_, violates)| *violates).count() as u64;
    (error_quantiles(fixes.iter().map(|(error_m, _)| *error_m)), (!fixes.is_empty()).then_some(violations))
}
