//! Heights along a row of places as a hidden Markov chain: from one place to the next the ground stays as high, drifts by a step of
//! height, or, once, rises by a kerb's.
//!
//! The forward-backward algorithm (L. Rabiner, "A tutorial on hidden Markov models", 1989, III-A) gives the probability that the rise
//! lies before each place. [`LANES`] rows are followed at once, a lane each: all sums are then of whole lanes.

use crate::simd::{CodePath, simd_kernel};

/// Rows that are followed at once.
pub const LANES: usize = 16;
/// A value of each row.
pub type Lanes = [f32; LANES];
/// A value of each height, the lowest first, and row.
pub type ByHeight<const HEIGHTS: usize> = [Lanes; HEIGHTS];
/// What is believed of a place: level heights, then raised ones.
type Belief<const HEIGHTS: usize> = [ByHeight<HEIGHTS>; 2];

/// Probabilities of what happens from one place to the next.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RiseSteps {
    /// Of a rise.
    pub rise: f32,
    /// Of a step of height up, and as much of one down.
    pub drift: f32,
}

/// The chains of so many heights, with their memory. A rise is of `LEAST` to `MOST` steps of height, each as likely, and the highest
/// state stands for all above it.
#[derive(Debug, Default)]
pub struct RiseChain<const HEIGHTS: usize, const LEAST: usize, const MOST: usize> {
    forward: Vec<Belief<HEIGHTS>>,
    odds: Vec<Lanes>,
}

impl<const HEIGHTS: usize, const LEAST: usize, const MOST: usize> RiseChain<HEIGHTS, LEAST, MOST> {
    /// Odds that the rise lies before each place, by the likelihoods of its heights, of which `seen` holds those of each place; all
    /// heights are as likely before the first.
    pub fn odds(&mut self, steps: &RiseSteps, seen: &[ByHeight<HEIGHTS>]) -> &[Lanes] {
        self.odds_with(CodePath::fastest(), steps, seen)
    }

    pub(super) fn odds_with(
        &mut self,
        path: CodePath,
        steps: &RiseSteps,
        seen: &[ByHeight<HEIGHTS>],
    ) -> &[Lanes] {
        self.forward.resize(seen.len(), [[[0.0; LANES]; HEIGHTS]; 2]);
        self.odds.resize(seen.len(), [0.0; LANES]);
        go_forward::<HEIGHTS, LEAST, MOST>(path, steps, seen, &mut self.forward);
        go_backward::<HEIGHTS, LEAST, MOST>(path, steps, seen, &self.forward, &mut self.odds);
        &self.odds
    }
}

// Loops run over the lanes of all heights at once: over the lanes of one at a time, the compiler gathers from height to height.

simd_kernel! {
    fn go_forward<const HEIGHTS: usize, const LEAST: usize, const MOST: usize>(
        steps: &RiseSteps, seen: &[ByHeight<HEIGHTS>], forward: &mut [Belief<HEIGHTS>],
    ) {
        let each_rise = steps.rise / (MOST + 1 - LEAST) as f32;
        let highest = (HEIGHTS - 1) * LANES;
        let mut belief = [[[1.0; LANES]; HEIGHTS], [[0.0; LANES]; HEIGHTS]];
        for (seen, forward) in seen.iter().zip(forward) {
            drift(&belief[0], 1.0 - steps.rise, steps.drift, &mut forward[0]);
            drift(&belief[1], 1.0, steps.drift, &mut forward[1]);
            let (level, raised) = (belief[0].as_flattened(), forward[1].as_flattened_mut());
            for rise in LEAST..=MOST {
                add_scaled(&mut raised[rise * LANES..highest], &level[..highest - rise * LANES], each_rise);
                // The highest state is reached by all rises that lead to it or beyond.
                for from in HEIGHTS - 1 - rise..HEIGHTS {
                    add_scaled(&mut raised[highest..], &level[from * LANES..(from + 1) * LANES], each_rise);
                }
            }
            weigh(forward, seen);
            belief = *forward;
        }
    }
}

simd_kernel! {
    fn go_backward<const HEIGHTS: usize, const LEAST: usize, const MOST: usize>(
        steps: &RiseSteps, seen: &[ByHeight<HEIGHTS>], forward: &[Belief<HEIGHTS>], odds: &mut [Lanes],
    ) {
        let each_rise = steps.rise / (MOST + 1 - LEAST) as f32;
        let highest = (HEIGHTS - 1) * LANES;
        let mut backward = [[[1.0; LANES]; HEIGHTS]; 2];
        for ((seen, forward), odds) in seen.iter().zip(forward).zip(odds).rev() {
            let [level, raised] = [0, 1].map(|kind: usize| product(&forward[kind], &backward[kind]));
            for lane in 0..LANES {
                odds[lane] = raised[lane].max(f32::MIN_POSITIVE) / level[lane].max(f32::MIN_POSITIVE);
            }
            weigh(&mut backward, seen);
            let mut before = backward;
            drift(&backward[0], 1.0 - steps.rise, steps.drift, &mut before[0]);
            drift(&backward[1], 1.0, steps.drift, &mut before[1]);
            let (level, raised) = (before[0].as_flattened_mut(), backward[1].as_flattened());
            for rise in LEAST..=MOST {
                add_scaled(&mut level[..highest - rise * LANES], &raised[rise * LANES..highest], each_rise);
                for to in HEIGHTS - 1 - rise..HEIGHTS {
                    add_scaled(&mut level[to * LANES..(to + 1) * LANES], &raised[highest..], each_rise);
                }
            }
            backward = before;
        }
    }
}

#[inline(always)]
fn add_scaled(to: &mut [f32], values: &[f32], by: f32) {
    for (to, value) in to.iter_mut().zip(values) {
        *to += value * by;
    }
}

/// `share` of what meets no rise: heights go one up, one down or stay.
#[inline(always)]
fn drift<const HEIGHTS: usize>(from: &ByHeight<HEIGHTS>, share: f32, drift: f32, to: &mut ByHeight<HEIGHTS>) {
    let (stays, goes) = (share * (1.0 - 2.0 * drift), share * drift);
    let (from, to) = (from.as_flattened(), to.as_flattened_mut());
    let last = (HEIGHTS - 1) * LANES;
    for (to, from) in to.iter_mut().zip(from) {
        *to = from * stays;
    }
    // What would leave at either end stays there.
    add_scaled(&mut to[..LANES], &from[..LANES], goes);
    add_scaled(&mut to[LANES..], &from[..last], goes);
    add_scaled(&mut to[..last], &from[LANES..], goes);
    add_scaled(&mut to[last..], &from[last..], goes);
}

#[inline(always)]
fn product<const HEIGHTS: usize>(a: &ByHeight<HEIGHTS>, b: &ByHeight<HEIGHTS>) -> Lanes {
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums
}

/// Multiplies by what is seen, and to a sum of one.
#[inline(always)]
fn weigh<const HEIGHTS: usize>(belief: &mut Belief<HEIGHTS>, seen: &ByHeight<HEIGHTS>) {
    let mut sums = [f32::MIN_POSITIVE; LANES];
    for kind in belief.iter_mut() {
        for (value, seen) in kind.as_flattened_mut().iter_mut().zip(seen.as_flattened()) {
            *value *= seen;
        }
        for lanes in kind.iter() {
            for lane in 0..LANES {
                sums[lane] += lanes[lane];
            }
        }
    }
    let by = [sums.map(|sum| 1.0 / sum); HEIGHTS];
    for kind in belief.iter_mut() {
        for (value, by) in kind.as_flattened_mut().iter_mut().zip(by.as_flattened()) {
            *value *= by;
        }
    }
}
