//! Numbers that follow from a seed.

/// An endless row of numbers: SplitMix64 (G. Steele, D. Lea and C. Flood, "Fast splittable pseudorandom number generators",
/// OOPSLA 2014).
#[derive(Debug, Clone)]
pub(crate) struct Random {
    state: u64,
}

impl Random {
    /// A row of its own for each `topic` of a seed.
    pub(crate) fn new(seed: u64, topic: u64) -> Self {
        let mut mixed = Self { state: seed };
        Self { state: mixed.next() ^ topic.wrapping_mul(0xD1B5_4A32_D192_ED03) }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    /// The next number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        // 53 bits are what an f64 in [0, 1) can hold.
        (self.next() >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
    }

    /// One of `count` numbers from zero; zero of none.
    pub(crate) fn below(&mut self, count: usize) -> usize {
        ((self.unit() * count as f64) as usize).min(count.saturating_sub(1))
    }

    /// The numbers below `count` in a drawn order (Fisher and Yates).
    pub(crate) fn order(&mut self, count: usize) -> Vec<usize> {
        let mut order: Vec<usize> = (0..count).collect();
        for last in (1..count).rev() {
            order.swap(last, self.below(last + 1));
        }
        order
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_repeat_differ_by_topic_and_fill_their_range() {
        let row = |seed, topic| {
            let mut random = Random::new(seed, topic);
            (0..1000).map(|_| random.unit()).collect::<Vec<_>>()
        };
        assert_eq!(row(7, 1), row(7, 1));
        assert!(row(7, 1) != row(7, 2) && row(7, 1) != row(8, 1));
        let mean = row(7, 1).iter().sum::<f64>() / 1000.0;
        assert!((mean - 0.5).abs() < 0.03, "{mean}");
        let mut order = Random::new(7, 1).order(20);
        assert!(order != (0..20).collect::<Vec<_>>());
        order.sort_unstable();
        assert_eq!(order, (0..20).collect::<Vec<_>>());
    }
}
