//! A followed junction whose camera is covered on the way is neither confirmed nor found by the bank of known surfaces.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

#[path = "../../fingerpost/tests/covered/mod.rs"]
mod covered;
#[path = "../../fingerpost/tests/painted/mod.rs"]
mod painted;

use fingerpost::road_surface::RoadMethod;

#[test]
fn a_covered_lens_confirms_no_junction_by_the_bank() {
    covered::no_junction_is_confirmed(&[RoadMethod::Bank], |config| {
        fingerpost_papers::parts(config).unwrap()
    });
}
