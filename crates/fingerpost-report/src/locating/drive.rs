//! What the page shows of a located drive, gathered row by row.

use std::ops::RangeInclusive;

use fingerpost_locate::{Fix, RISK, Rival, Status};
use nalgebra::Point2;

use super::stanford::Stanford;
use crate::fix_track::{FixTrack, TrackedFix};
use crate::series::Series;

/// Distances driven at which the hypotheses are kept, metres: about doubling, because every turn rules out a share of them.
const MOMENTS_M: [f64; 5] = [0.0, 50.0, 100.0, 200.0, 400.0];

/// A drive over time: curves are thinned as it goes on, tracks have a point a metre.
#[derive(Debug, Clone, Default)]
pub struct LocatedDrive {
    /// Time of the first row.
    start_s: Option<f64>,
    /// Since the first row.
    pub(super) end_s: f64,
    pub(super) fixes: FixTrack,
    pub(super) place_p: Series,
    pub(super) off_map_p: Series,
    pub(super) moments: Vec<Moment>,
    /// The next of the distances at which the hypotheses are kept.
    next_moment: usize,
    pub(super) stanford: Stanford,
    pub(super) converged: Option<Convergence>,
    pub(super) last: Option<Fix>,
    last_true_m: Option<Point2<f64>>,
}

/// The first converged fix.
#[derive(Debug, Clone, Copy)]
pub(super) struct Convergence {
    /// Since the first row.
    pub(super) after_s: f64,
    /// Driven by then.
    pub(super) after_m: f64,
}

/// All hypotheses at one time.
#[derive(Debug, Clone)]
pub(super) struct Moment {
    pub(super) name: String,
    pub(super) status: Status,
    /// Probability of the likeliest place, and of being on no road of the map.
    pub(super) place_p: f64,
    pub(super) off_map_p: f64,
    pub(super) hypotheses: usize,
    /// The heaviest first; those that weigh less than the risk together are left out.
    pub(super) places: Vec<Rival>,
    pub(super) true_m: Option<Point2<f64>>,
}

impl LocatedDrive {
    /// Goes on with the fix of the next row, and where the vehicle truly was then, metres in the plane of the map's graph, where
    /// that is known. `places` gives every place that is possible; it is asked at a few rows only.
    pub fn add(&mut self, fix: &Fix, true_m: Option<Point2<f64>>, places: impl FnOnce() -> Vec<Rival>) {
        let t_s = fix.t_s - *self.start_s.get_or_insert(fix.t_s);
        self.end_s = t_s;
        let Fix { driven_m, place_m, level_m, status, .. } = *fix;
        self.fixes.add(TrackedFix { t_s, driven_m, place_m, level_m, status }, true_m);
        self.place_p.push(t_s, Some(fix.mass));
        self.off_map_p.push(t_s, Some(fix.off_map));
        if let Some(true_m) = true_m {
            self.stanford.add(status, (place_m - true_m).norm(), level_m);
        }
        if let Some(name) = self.due_moment(fix, t_s) {
            self.moments.push(Moment::of(name, fix, true_m, places()));
        }
        self.last = Some(fix.clone());
        self.last_true_m = true_m;
    }

    /// The drive is over; `places` are those that are possible at its end.
    pub fn end(&mut self, places: Vec<Rival>) {
        if let Some(fix) = &self.last {
            let name = format!("at the end, {:.0} m", fix.driven_m);
            self.moments.push(Moment::of(name, fix, self.last_true_m, places));
        }
    }

    /// The time that the curves are over, seconds from the first row.
    pub(super) fn seconds(&self) -> RangeInclusive<f64> {
        0.0..=self.end_s
    }

    /// Name of the moment that a fix is, if it is one.
    fn due_moment(&mut self, fix: &Fix, t_s: f64) -> Option<String> {
        let converges = fix.status == Status::Converged && self.converged.is_none();
        let passed =
            MOMENTS_M.iter().skip(self.next_moment).take_while(|at_m| **at_m <= fix.driven_m).count();
        self.next_moment += passed;
        if converges {
            self.converged = Some(Convergence { after_s: t_s, after_m: fix.driven_m });
            Some(format!("on convergence, after {:.0} m", fix.driven_m))
        } else if passed > 0 && fix.driven_m > 0.0 {
            Some(format!("after {:.0} m", fix.driven_m))
        } else {
            (passed > 0).then(|| "at the start".to_owned())
        }
    }
}

impl Moment {
    fn of(name: String, fix: &Fix, true_m: Option<Point2<f64>>, mut places: Vec<Rival>) -> Self {
        let hypotheses = places.len();
        places.sort_by(|a, b| b.weight.total_cmp(&a.weight));
        let all: f64 = places.iter().map(|place| place.weight).sum();
        let mut kept = 0.0;
        places.retain(|place| {
            let is_kept = kept < all * (1.0 - RISK);
            kept += place.weight;
            is_kept
        });
        Self {
            name,
            status: fix.status,
            place_p: fix.mass,
            off_map_p: fix.off_map,
            hypotheses,
            places,
            true_m,
        }
    }
}
