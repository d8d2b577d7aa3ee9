//! From the road's middle to its part of a line of `frames.jsonl`.

use fingerpost::centreline::{Centreline, CentrelineEvidence, NoCentreline, Steer, SteerBy};
use fingerpost_format::{CentrelineRecord, WaysRecord};

use crate::frame::{ANGLE_DIGITS, DIGITS, rounded};

pub(crate) fn centreline_record(found: &Centreline, evidence: &CentrelineEvidence) -> CentrelineRecord {
    let ways = evidence.ways.map(|ways| {
        let [left, on, right] = ways.probability.map(|probability| rounded(probability, DIGITS));
        WaysRecord { left, on, right }
    });
    let steer_by = |steer: Steer| match steer.by {
        SteerBy::Road => "road",
        SteerBy::DrivingLine => "driving_line",
    };
    CentrelineRecord {
        offset_m: rounded(found.offset_m, DIGITS),
        sigma_m: Some(rounded(found.sigma_m, DIGITS)),
        heading_rad: rounded(found.heading_rad, ANGLE_DIGITS),
        curvature_per_m: Some(rounded(found.curvature_per_m, ANGLE_DIGITS)),
        width_m: Some(rounded(found.width_m, DIGITS)),
        steer_rad: found.steer.map(|steer| rounded(steer.direction_rad, ANGLE_DIGITS)),
        steer_none: found.steer.is_none().then(|| "ambiguous".to_owned()),
        steer_sigma_rad: found.steer.map(|steer| rounded(steer.sigma_rad, ANGLE_DIGITS)),
        steer_by: found.steer.map(|steer| steer_by(steer).to_owned()),
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
