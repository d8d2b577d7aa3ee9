//! What is known of the vehicle's place before it has moved.

use std::f64::consts::TAU;

use fingerpost_geometry::wrap_angle;
use nalgebra::{Matrix2, Point2};

use crate::belief::Belief;
use crate::state::HEADING;

/// A place that the vehicle starts near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Start {
    /// The place, metres in the plane of the map's graph.
    pub place_m: Point2<f64>,
    /// Its standard deviation east and north, metres.
    pub sigma_m: f64,
    /// Heading, radians anticlockwise from east, and its standard deviation; none where it is not known.
    pub heading_rad: Option<[f64; 2]>,
}

impl Belief {
    /// Weighs all hypotheses by the start and moves them towards it.
    pub(crate) fn begin_near(&mut self, start: &Start) {
        let variance_m2 = start.sigma_m * start.sigma_m;
        self.weigh(|hypothesis| {
            let innovation = start.place_m - hypothesis.state.place();
            let expected = hypothesis.state.place_covariance() + Matrix2::identity() * variance_m2;
            let squared = expected
                .try_inverse()
                .map_or(f64::INFINITY, |precision| innovation.dot(&(precision * innovation)));
            hypothesis.log_weight -=
                0.5 * (squared + libm::log(expected.determinant().max(f64::MIN_POSITIVE)));
            if let Some([heading_rad, sigma_rad]) = start.heading_rad {
                let off_rad = wrap_angle(heading_rad - hypothesis.state.mean[HEADING]);
                let variance = hypothesis.state.covariance[(HEADING, HEADING)] + sigma_rad * sigma_rad;
                hypothesis.log_weight -= 0.5 * (off_rad * off_rad / variance + libm::log(TAU * variance));
            }
            hypothesis.state.take_place(innovation, variance_m2);
        });
    }
}
