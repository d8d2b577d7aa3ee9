//! Where a straight road lies that has no edges in the sections: behind a corner, across the vehicle's direction.

use nalgebra::Point2;

use super::Centreline;
use super::band::{Approach, Band, LogOdds, Shown};
use super::turn::RoadLine;

/// How sure a line is at the most before it is settled, metres and radians: what frames that follow each other show errs alike.
const LEAST_SIGMA: [f64; 2] = [0.2, 0.05];
/// A line is settled within so many standard deviations, in so many steps to either side.
const SETTLE_SIGMAS: f64 = 2.5;
const SETTLE_STEPS: i32 = 6;
const TRIED: usize = (2 * SETTLE_STEPS as usize + 1).pow(2);

/// Where a straight road lies of which a line is believed: the line and the standard deviations of its offset, metres, and of
/// its direction, radians, by the road under bands about it.
pub(super) fn settle(
    shown: &Shown<'_>,
    log_odds: &LogOdds,
    road: &Centreline,
    sigma: [f64; 2],
) -> (RoadLine, [f64; 2]) {
    let band = Band { shown, width_m: road.width_m, log_odds };
    let sigma = [0, 1].map(|axis| sigma[axis].max(LEAST_SIGMA[axis]));
    let steps = || -SETTLE_STEPS..=SETTLE_STEPS;
    let at = |i: i32, sigma: f64| f64::from(i) / f64::from(SETTLE_STEPS) * SETTLE_SIGMAS * sigma;
    let tried = || steps().flat_map(|i| steps().map(move |j| (i, j)));
    let evidence = |(i, j): (i32, i32)| {
        let (offset_m, turn_rad) = (at(i, sigma[0]), at(j, sigma[1]));
        let place = Point2::new(0.0, road.offset_m + offset_m);
        let start = RoadLine { place, heading_rad: road.heading_rad + turn_rad };
        let expected = -0.5 * ((offset_m / sigma[0]).powi(2) + (turn_rad / sigma[1]).powi(2));
        (Approach::new(&start, &band).evidence(&band) + expected, [offset_m, turn_rad])
    };
    let mut evidences = [(0.0, [0.0; 2]); TRIED];
    evidences.iter_mut().zip(tried()).for_each(|(of, at)| *of = evidence(at));
    let most = evidences.iter().map(|(evidence, _)| *evidence).fold(f64::NEG_INFINITY, f64::max);
    let (mut all, mut sum, mut squares) = (0.0, [0.0; 2], [0.0; 2]);
    for (evidence, off) in evidences {
        let weight = libm::exp(evidence - most);
        all += weight;
        for axis in [0, 1] {
            sum[axis] += weight * off[axis];
            squares[axis] += weight * off[axis] * off[axis];
        }
    }
    let mean = sum.map(|sum| sum / all);
    // Between the steps nothing was tried.
    let step = [0, 1].map(|axis| at(1, sigma[axis]));
    let settled = [0, 1].map(|axis| {
        let variance = (squares[axis] / all - mean[axis] * mean[axis]).max(0.0);
        (variance + step[axis] * step[axis] / 12.0).sqrt().max(0.5 * LEAST_SIGMA[axis])
    });
    let place = Point2::new(0.0, road.offset_m + mean[0]);
    (RoadLine { place, heading_rad: road.heading_rad + mean[1] }, settled)
}
