//! Kerbs: where the road surface ends against where the truth has the kerb, and what lies on either side of it.
//!
//! From the vehicle's axis outwards the road ends where nothing within 0.2 m is road any more. Kerbs that count are at least
//! [`LEAST_KERB_M`] high and [`KERBS_AHEAD_M`] ahead.

use fingerpost_format::{ErrorQuantiles, TruthRecord};
use serde::Serialize;

use crate::error_quantiles;
use crate::surface_end::{SurfaceEnd, is_called_road, places_aside};

/// How far ahead of the vehicle kerbs count, metres.
pub const KERBS_AHEAD_M: [f64; 2] = [5.0, 12.0];
/// Lower kerbs do not count, metres: drivers take them for lowered ones.
pub const LEAST_KERB_M: f64 = 0.08;
/// How far behind the kerb the ground counts as pavement, metres: the narrowest that are built.
pub const PAVEMENT_M: f64 = 1.5;

/// What the road surfaces of one or more drives make of kerbs.
#[derive(Debug, Clone, Default)]
pub struct KerbScores {
    errors_m: Vec<f64>,
    missed: u64,
    road: Called,
    pavement: Called,
}

/// Places of one kind, and those among them that are called road.
#[derive(Debug, Clone, Copy, Default)]
struct Called {
    road: u64,
    all: u64,
}

/// Road surfaces against kerbs.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct KerbEvaluation {
    /// Places of kerbs that count.
    pub kerbs: u64,
    /// Those beyond which the surface goes on to the end of what is seen, percent; their error is as far as that.
    pub missed_pct: f64,
    /// Distance between the surface's end and the kerb, across the road, metres.
    pub error_m: Option<ErrorQuantiles>,
    /// Pavement that is called road, percent of its area.
    pub pavement_called_road_pct: f64,
    /// Road that is not called road, percent of its area.
    pub road_not_called_road_pct: f64,
}

impl KerbScores {
    /// Adds a frame. `probability_at` gives the probability of road, 0 to 1, at a place, metres forward and left; none where
    /// nothing is seen.
    pub fn add(&mut self, truth: &TruthRecord, probability_at: impl Fn([f64; 2]) -> Option<f64>) {
        for kerb in truth.kerb_left_m.iter().chain(&truth.kerb_right_m) {
            let [forward_m, left_m, height_m] = *kerb;
            if height_m >= LEAST_KERB_M && (KERBS_AHEAD_M[0]..=KERBS_AHEAD_M[1]).contains(&forward_m) {
                let side = left_m.signum();
                let across = |aside_m: f64| probability_at([forward_m, side * aside_m]);
                self.add_kerb(left_m.abs(), across);
            }
        }
    }

    /// Adds a kerb so far aside of the vehicle's axis.
    fn add_kerb(&mut self, kerb_m: f64, across: impl Fn(f64) -> Option<f64>) {
        let seen = places_aside().map_while(|aside_m| across(aside_m).map(|p| (aside_m, is_called_road(p))));
        let mut surface = SurfaceEnd::default();
        for (aside_m, is_road) in seen {
            let of = if aside_m < kerb_m { &mut self.road } else { &mut self.pavement };
            if aside_m < kerb_m + PAVEMENT_M {
                of.all += 1;
                of.road += u64::from(is_road);
            }
            surface.take(aside_m, is_road);
        }
        if surface.last_m < kerb_m {
            // What is not seen as far as to its kerb says nothing about it.
            return;
        }
        self.missed += u64::from(!surface.ended);
        self.errors_m.push((surface.end_m - kerb_m).abs());
    }

    /// Adds what other drives made of theirs.
    pub fn extend(&mut self, other: &Self) {
        self.errors_m.extend(&other.errors_m);
        self.missed += other.missed;
        for (of, more) in [(&mut self.road, other.road), (&mut self.pavement, other.pavement)] {
            of.road += more.road;
            of.all += more.all;
        }
    }

    /// The numbers.
    pub fn evaluation(&self) -> KerbEvaluation {
        let percent = |part: u64, all: u64| 100.0 * part as f64 / all.max(1) as f64;
        let kerbs = self.errors_m.len() as u64;
        KerbEvaluation {
            kerbs,
            missed_pct: percent(self.missed, kerbs),
            error_m: error_quantiles(self.errors_m.iter().copied()),
            pavement_called_road_pct: percent(self.pavement.road, self.pavement.all),
            road_not_called_road_pct: percent(self.road.all - self.road.road, self.road.all),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A road from 2 m right of the axis to 3 m left, with a pale line 1 m left, seen 6 m to each side.
    fn surface([_, left_m]: [f64; 2]) -> Option<f64> {
        let is_road = (-2.0..3.0).contains(&left_m) && !(1.0..1.1).contains(&left_m);
        (left_m.abs() < 6.0).then_some(if is_road { 0.9 } else { 0.1 })
    }

    fn scores(left: &[[f64; 3]], right: &[[f64; 3]]) -> KerbScores {
        let truth = TruthRecord {
            kerb_left_m: left.to_vec(),
            kerb_right_m: right.to_vec(),
            ..TruthRecord::default()
        };
        let mut scores = KerbScores::default();
        scores.add(&truth, surface);
        scores
    }

    #[test]
    fn the_road_s_end_is_measured_on_either_side_through_a_line() {
        let left = scores(&[[8.0, 2.6, 0.12]], &[]).evaluation();
        assert!((left.error_m.unwrap().p50 - 0.4).abs() < 0.03, "{left:?}");
        assert!((left.pavement_called_road_pct - 100.0 * 0.4 / 1.5).abs() < 4.0, "{left:?}");
        assert!((left.road_not_called_road_pct - 100.0 * 0.1 / 2.6).abs() < 2.0, "{left:?}");
        let right = scores(&[], &[[8.0, -2.5, 0.12]]).evaluation();
        assert!((right.error_m.unwrap().p50 - 0.5).abs() < 0.03, "{right:?}");
        assert!((right.road_not_called_road_pct - 20.0).abs() < 2.0, "{right:?}");
        assert!(right.missed_pct < 0.1 && right.pavement_called_road_pct < 0.1);
    }

    #[test]
    fn a_surface_that_goes_on_misses_the_kerb() {
        let truth = TruthRecord { kerb_left_m: vec![[8.0, 2.5, 0.12]], ..TruthRecord::default() };
        let mut scores = KerbScores::default();
        scores.add(&truth, |[_, left_m]| (left_m.abs() < 6.0).then_some(0.9));
        let all = scores.evaluation();
        assert!(all.missed_pct > 99.9 && (all.error_m.unwrap().p50 - 3.5).abs() < 0.03, "{all:?}");
        scores.extend(&scores.clone());
        assert_eq!(scores.evaluation().kerbs, 2);
    }

    #[test]
    fn low_far_and_unseen_kerbs_do_not_count() {
        let none = scores(&[[8.0, 2.5, 0.05], [13.0, 2.5, 0.12], [8.0, 7.0, 0.12]], &[]).evaluation();
        assert!(none.kerbs == 0 && none.error_m.is_none());
    }
}
