//! From the road's middle to its part of a line of `frames.jsonl`.

use fingerpost::centreline::{Centreline, CentrelineEvidence, NoCentreline, SteerBy};
use fingerpost_format::{CentrelineRecord, WaysRecord};

use crate::record::{ANGLE_DIGITS, DIGITS, rounded};

pub(crate) fn centreline_record(found: &Centreline, evidence: &CentrelineEvidence) -> CentrelineRecord {
    let ways = evidence.ways.map(|ways| {
        let [left, on, right] = ways.probability.map(|probability| rounded(probability, DIGITS));
        WaysRecord { left, on, right }
    });
    let steer_by = match found.steer_by {
        SteerBy::Road => "road",
        SteerBy::DrivingLine => "driving_line",
    };
    CentrelineRecord {
        offset_m: rounded(found.offset_m, DIGITS),
        sigma_m: Some(rounded(found.sigma_m, DIGITS)),
        heading_rad: rounded(found.heading_rad, ANGLE_DIGITS),
        curvature_per_m: Some(rounded(found.curvature_per_m, ANGLE_DIGITS)),
        width_m: Some(rounded(found.width_m, DIGITS)),
        steer_rad: rounded(found.steer_rad, ANGLE_DIGITS),
        steer_sigma_rad: Some(rounded(found.steer_sigma_rad, ANGLE_DIGITS)),
        steer_by: Some(steer_by.to_owned()),
        ways,
    }
}

/// The reason why there is none, as files have it.
pub(crate) const fn no_centreline_name(why: NoCentreline) -> &'static str {
    match why {
        NoCentreline::NothingShown => "nothing_shown",
        NoCentreline::NoEdges => "no_edges",
        NoCentreline::TooFewSections => "too_few_sections",
        NoCentreline::Unsure => "unsure",
        NoCentreline::Off => "off",
    }
}
