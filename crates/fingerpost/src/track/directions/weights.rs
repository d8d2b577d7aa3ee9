//! How probable it is that the vehicle comes to a feature of the route first.
//!
//! Half of all drives begin where a route that was made for them begins, the others anywhere along it. A tracker that finds its
//! first feature says where the vehicle began; each further one is found where it is expected or not at all. What is found is
//! weighed against a place that looks like a feature and is none, as clutter is where targets are tracked (Bar-Shalom, Daum, Huang:
//! The probabilistic data association filter, 2009).

use std::f64::consts::TAU;

/// Share of the drives without a start that begin at the route's beginning, and how far off, metres; numbers ours.
const BEGIN_AT_BEGINNING: f64 = 0.5;
const BEGINNING_SIGMA_M: f64 = 5.0;
/// Places along a metre of road that the rules take for a feature and are none: on some ten kilometres of the harder simulated drives
/// `harder-false` (docs/figures.toml), and more where nothing says where to look.
const CLUTTER_PER_M: f64 = 0.001;
/// Share of the features that the rules find where they are, on simulated drives: `harder-found` (docs/figures.toml).
const FOUND: f64 = 0.9;
/// How far off the rules place a feature, metres, which their own standard deviations do not say: more than the medians of `rules-201`,
/// `rules-401` and `rules-501` (docs/figures.toml).
const PLACE_SIGMA_M: f64 = 1.5;
/// Room that is given a feature beside the stretch on which it would be the first, metres.
const ROOM_M: f64 = 10.0;

/// A feature that is found for the first time.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// Its index in the route.
    pub(super) index: usize,
    /// How far ahead along the approach it is, metres.
    pub(super) ahead_m: f64,
    /// How far from where it was expected, and the standard deviation of that, metres; none where it was not expected anywhere.
    pub(super) off: Option<(f64, f64)>,
}

/// The weight of one hypothesis, up to a factor that all of them share.
#[derive(Debug, Clone)]
pub(super) struct Weight {
    /// What was found and missed so far.
    factor: f64,
    /// Before anything was found: where the vehicle may have begun.
    unplaced: Option<Unplaced>,
    driven_m: f64,
    /// Index of the next feature that has not been found or missed.
    next: usize,
}

/// Where a vehicle that comes to a feature first may have begun.
#[derive(Debug, Clone, Copy)]
struct Unplaced {
    /// From the feature before to this one, metres, or from the route's beginning.
    stretch_m: f64,
    /// Probability of each metre of it, and beside that of the route's beginning.
    per_m: f64,
    at_beginning: f64,
}

impl Unplaced {
    /// Probability after so many metres without the feature: what lies behind was missed.
    fn left(&self, driven_m: f64) -> f64 {
        let behind_m = driven_m.clamp(0.0, self.stretch_m);
        let has_come = driven_m > self.stretch_m + ROOM_M;
        self.per_m * (self.stretch_m - FOUND * behind_m)
            + self.at_beginning * if has_come { 1.0 - FOUND } else { 1.0 }
    }

    /// Probability per metre of having begun so far before the feature.
    fn begun_before(&self, before_m: f64) -> f64 {
        // One farther along than its stretch is long: one before it was missed.
        let is_beyond = before_m > self.stretch_m + ROOM_M;
        self.per_m * if is_beyond { 1.0 - FOUND } else { 1.0 }
            + self.at_beginning * normal(self.stretch_m - before_m, BEGINNING_SIGMA_M)
    }
}

impl Weight {
    /// Of coming first to the feature `first` of those at these places of the route, metres.
    pub(super) fn of_first(places_m: &[f64], first: usize) -> Self {
        let place_m = |index: usize| places_m.get(index).copied().unwrap_or(0.0);
        let stretch_m = |index: usize| match index.checked_sub(1) {
            Some(before) => place_m(index) - place_m(before),
            None => place_m(index),
        };
        let length_m: f64 = (0..places_m.len()).map(stretch_m).sum();
        let unplaced = Unplaced {
            stretch_m: stretch_m(first).max(1.0),
            per_m: (1.0 - BEGIN_AT_BEGINNING) / length_m.max(1.0),
            at_beginning: if first == 0 { BEGIN_AT_BEGINNING } else { 0.0 },
        };
        Self { factor: 1.0, unplaced: Some(unplaced), driven_m: 0.0, next: first }
    }

    /// The weight after the frames so far.
    pub(super) fn now(&self) -> f64 {
        self.factor * self.unplaced.map_or(1.0, |unplaced| unplaced.left(self.driven_m))
    }

    pub(super) fn divide(&mut self, total: f64) {
        self.factor /= total;
    }

    /// Takes a frame in: the distance driven so far, what was found in it for the first time, the feature that is sought now, and
    /// whether one that was followed was not there.
    pub(super) fn step(&mut self, driven_m: f64, sighting: Option<Sighting>, sought: usize, is_lost: bool) {
        self.driven_m = driven_m;
        if is_lost {
            self.factor *= 1.0 - FOUND;
        }
        let found = sighting.filter(|sighting| sighting.index >= self.next);
        let reached = found.map_or(sought, |sighting| sighting.index);
        for _ in self.next..reached {
            self.factor *= 1.0 - FOUND;
        }
        self.next = self.next.max(reached);
        let Some(sighting) = found else { return };
        self.next = sighting.index + 1;
        let per_m = match (self.unplaced.take(), sighting.off) {
            (Some(unplaced), _) => unplaced.begun_before(driven_m + sighting.ahead_m),
            (None, Some((off_m, sigma_m))) => normal(off_m, libm::hypot(sigma_m, PLACE_SIGMA_M)),
            (None, None) => CLUTTER_PER_M,
        };
        self.factor *= FOUND * per_m / CLUTTER_PER_M;
    }
}

/// The normal distribution's density.
fn normal(off: f64, sigma: f64) -> f64 {
    libm::exp(-0.5 * (off / sigma).powi(2)) / (TAU.sqrt() * sigma)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PLACES_M: [f64; 4] = [60.0, 120.0, 220.0, 300.0];

    fn weights() -> Vec<Weight> {
        (0..PLACES_M.len()).map(|first| Weight::of_first(&PLACES_M, first)).collect()
    }

    /// Probabilities of the weights.
    fn shares(weights: &[Weight]) -> Vec<f64> {
        let total: f64 = weights.iter().map(Weight::now).sum();
        weights.iter().map(|weight| weight.now() / total).collect()
    }

    fn found(index: usize, ahead_m: f64, off: Option<(f64, f64)>) -> Option<Sighting> {
        Some(Sighting { index, ahead_m, off })
    }

    #[test]
    fn before_anything_is_seen_half_begin_at_the_beginning_and_the_others_anywhere() {
        let shares = shares(&weights());
        for (share, expected) in shares.iter().zip([0.6, 0.1, 0.5 / 3.0, 0.4 / 3.0]) {
            assert!((share - expected).abs() < 1e-12, "{shares:?}");
        }
    }

    #[test]
    fn a_way_on_which_nothing_is_found_speaks_for_features_that_are_far_from_the_one_before() {
        let mut weights = weights();
        let before = shares(&weights);
        weights.iter_mut().enumerate().for_each(|(first, weight)| weight.step(90.0, None, first, false));
        let after = shares(&weights);
        assert!(after[2] > 1.5 * before[2] && after[0] < 0.9 * before[0], "{after:?}");
    }

    /// A place so far ahead of the first frame that looks like the first and like the third.
    fn after_a_place(ahead_m: f64) -> Vec<Weight> {
        let mut weights = weights();
        for (first, weight) in weights.iter_mut().enumerate() {
            let seen = [0, 2].contains(&first).then(|| found(first, 20.0, None)).flatten();
            weight.step(ahead_m - 20.0, seen, first, false);
        }
        weights
    }

    #[test]
    fn a_first_place_that_is_where_the_first_feature_must_be_from_the_beginning_is_it() {
        let shares = shares(&after_a_place(57.0));
        assert!(shares[0] > 0.9, "{shares:?}");
    }

    #[test]
    fn elsewhere_one_feature_is_no_proof_and_the_next_where_it_must_be_is() {
        let mut weights = after_a_place(25.0);
        let after_one = shares(&weights);
        assert!(after_one.iter().all(|share| *share < 0.9), "{after_one:?}");
        // The third's next comes where it is expected; the first's does not come.
        for (first, weight) in weights.iter_mut().enumerate() {
            let seen = (first == 2).then(|| found(3, 15.0, Some((0.8, 2.0)))).flatten();
            weight.step(90.0, seen, if first == 0 { 2 } else { first + 1 }, false);
        }
        let after_two = shares(&weights);
        assert!(after_two[2] > 0.9, "{after_two:?}");
    }

    #[test]
    fn one_that_is_far_off_or_lost_speaks_against() {
        let step = |off_m: f64, is_lost: bool| {
            let mut weight = Weight::of_first(&PLACES_M, 0);
            weight.step(40.0, found(0, 20.0, None), 0, false);
            let before = weight.now();
            weight.step(100.0, found(1, 15.0, Some((off_m, 2.0))), 1, false);
            weight.step(101.0, None, 1, is_lost);
            weight.now() / before
        };
        assert!(step(0.5, false) > 10.0 && step(12.0, false) < 0.1);
        assert!(step(0.5, true) < 0.2 * step(0.5, false));
        // The same feature again is no news.
        let mut weight = Weight::of_first(&PLACES_M, 0);
        weight.step(40.0, found(0, 20.0, None), 0, false);
        let before = weight.now();
        weight.step(41.0, found(0, 19.0, Some((0.0, 0.5))), 0, false);
        assert!((weight.now() / before - 1.0).abs() < 1e-12);
    }
}
