//! From a fix to its part of a line of `frames.jsonl` and of `fix.jsonl`.

use fingerpost::fix::MapFix;
use fingerpost_format::{FixRecord, FixStatus};
use fingerpost_locate::Status;

use crate::record::{ANGLE_DIGITS, DIGITS, rounded};

/// Digits behind the point of degrees of place: a centimetre.
const PLACE_DIGITS: i32 = 7;

pub(crate) fn fix_record(fix: &MapFix) -> FixRecord {
    FixRecord {
        lat: rounded(fix.at.lat_deg, PLACE_DIGITS),
        lon: rounded(fix.at.lon_deg, PLACE_DIGITS),
        heading_rad: rounded(fix.heading_rad, ANGLE_DIGITS),
        sigma_m: rounded(fix.sigma_m, DIGITS),
        bound_m: fix.bound_m.map(|bound_m| rounded(bound_m, DIGITS)),
        status: Some(fix_status(fix.status)),
    }
}

/// What a fix is worth as the files have it.
pub(crate) const fn fix_status(status: Status) -> FixStatus {
    match status {
        Status::Converged => FixStatus::Converged,
        Status::Ambiguous => FixStatus::Ambiguous,
        Status::Coasting => FixStatus::Coasting,
        Status::Lost => FixStatus::Lost,
    }
}
