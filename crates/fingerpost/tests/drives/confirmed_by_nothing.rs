//! A followed junction whose camera is covered on the way is neither confirmed nor found by what no picture shows.

use fingerpost::pipeline::Parts;
use fingerpost::road_surface::RoadMethod;

#[test]
fn a_covered_lens_confirms_no_junction_by_any_detector() {
    let detectors =
        [RoadMethod::Backprojection, RoadMethod::Online, RoadMethod::Memory, RoadMethod::Combined];
    crate::covered::no_junction_is_confirmed(&detectors, |_| Parts::default());
}
