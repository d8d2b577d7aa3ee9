//! From a fix to its part of a line of `frames.jsonl` and of `fix.jsonl`.

use fingerpost::fix::{FixEvidence, MapFix};
use fingerpost_eval::FeatureIdentity;
use fingerpost_format::{FixRecord, FixStatus, MeasurementRecord};
use fingerpost_locate::{GpsEvidence, SightingEvidence, Status, Verdict};

use crate::frame::{ANGLE_DIGITS, DIGITS, rounded};

/// Digits behind the point of degrees of place: a centimetre.
const PLACE_DIGITS: i32 = 7;

/// A fix, with what was made of the measurements in its frame; `features` are what those of the route are called.
pub(crate) fn fix_record(
    fix: &MapFix,
    evidence: Option<&FixEvidence>,
    features: &[FeatureIdentity],
) -> FixRecord {
    let feature = evidence.and_then(|evidence| evidence.feature.as_ref());
    let gps = evidence.and_then(|evidence| evidence.gps.as_ref());
    let measurements =
        feature.map(|seen| feature_record(seen, features)).into_iter().chain(gps.map(gps_record));
    FixRecord {
        lat: rounded(fix.at.lat_deg, PLACE_DIGITS),
        lon: rounded(fix.at.lon_deg, PLACE_DIGITS),
        heading_rad: rounded(fix.heading_rad, ANGLE_DIGITS),
        sigma_m: rounded(fix.sigma_m, DIGITS),
        bound_m: fix.bound_m.map(|bound_m| rounded(bound_m, DIGITS)),
        status: Some(fix_status(fix.status)),
        measurements: measurements.collect(),
    }
}

fn feature_record(seen: &SightingEvidence, features: &[FeatureIdentity]) -> MeasurementRecord {
    let why_not = match seen.verdict {
        Verdict::Accepted => None,
        Verdict::Unlikely => Some("unlikely"),
        Verdict::Disagrees => Some("disagrees"),
        Verdict::Counted => Some("counted_before"),
    };
    let place = |[forward_m, left_m, _]: [f64; 3]| [forward_m, left_m].map(|metres| rounded(metres, DIGITS));
    MeasurementRecord {
        kind: "feature".to_owned(),
        id: features.get(seen.landmark).map(|feature| feature.id),
        innovation_m: seen.innovation.map(|innovation| place(innovation.off)),
        innovation_rad: seen.innovation.map(|innovation| rounded(innovation.off[2], ANGLE_DIGITS)),
        sigma_m: seen.innovation.map(|innovation| place(innovation.sigma)),
        present: (seen.verdict != Verdict::Counted).then(|| rounded(seen.present, DIGITS)),
        accepted: seen.verdict == Verdict::Accepted,
        why_not: why_not.map(str::to_owned),
    }
}

fn gps_record(gps: &GpsEvidence) -> MeasurementRecord {
    MeasurementRecord {
        kind: "gps".to_owned(),
        id: None,
        innovation_m: Some(gps.innovation_m.map(|metres| rounded(metres, DIGITS))),
        innovation_rad: None,
        sigma_m: None,
        present: None,
        accepted: gps.believed,
        why_not: (!gps.believed).then(|| "disagrees".to_owned()),
    }
}

/// What a fix is worth as the files have it.
pub const fn fix_status(status: Status) -> FixStatus {
    match status {
        Status::Converged => FixStatus::Converged,
        Status::Ambiguous => FixStatus::Ambiguous,
        Status::Coasting => FixStatus::Coasting,
        Status::Lost => FixStatus::Lost,
    }
}
