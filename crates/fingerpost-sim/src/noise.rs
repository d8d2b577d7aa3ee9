//! Noise by counting: every value is a function of a seed and a place, so that any cell, pixel or frame can be made
//! without those before it.

/// A 64-bit mixing function (the finaliser of SplitMix64, Steele, Lea & Flood 2014): every input bit reaches every
/// output bit.
pub(crate) const fn mix(value: u64) -> u64 {
    let mut z = value.wrapping_add(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// A hash of a seed and a cell.
pub(crate) const fn cell_hash(seed: u64, x: i32, y: i32) -> u64 {
    mix(seed ^ mix(((x as u32 as u64) << 32) | y as u32 as u64))
}

/// The upper bits of a hash as a number in [0, 1).
pub(crate) fn unit(hash: u64) -> f32 {
    // 24 bits are what an f32 in [0, 1) can hold.
    (hash >> 40) as f32 * (1.0 / 16_777_216.0)
}

/// An endless row of numbers in [0, 1) for placing things.
#[derive(Debug, Clone)]
pub(crate) struct Stream {
    state: u64,
}

impl Stream {
    /// A stream of its own for each `topic` of a seed.
    pub(crate) const fn new(seed: u64, topic: u64) -> Self {
        Self { state: mix(seed ^ mix(topic)) }
    }

    /// The next number in [0, 1).
    pub(crate) fn unit(&mut self) -> f64 {
        self.state = mix(self.state);
        f64::from(unit(self.state))
    }

    /// The next number in [low, high).
    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// The next number of a normal distribution with mean 0 and this standard deviation (Box and Muller), cut off at three of
    /// it.
    pub(crate) fn normal(&mut self, sigma: f64) -> f64 {
        let radius = (-2.0 * libm::log(1.0 - self.unit())).sqrt();
        let angle = std::f64::consts::TAU * self.unit();
        sigma * (radius * libm::cos(angle)).clamp(-3.0, 3.0)
    }

    /// The next of some things, each as likely as its weight among those of all.
    pub(crate) fn choose<T: Copy>(&mut self, things: &[(f64, T)]) -> Option<T> {
        let mut left = self.unit() * things.iter().map(|(weight, _)| weight).sum::<f64>();
        let chosen = things.iter().find(|(weight, _)| {
            left -= weight;
            left < 0.0
        });
        chosen.or(things.last()).map(|(_, thing)| *thing)
    }
}

/// The integer at or below `value`; without the call into a maths library that `f32::floor` is on older processors.
#[inline(always)]
pub(crate) fn floor_int(value: f32) -> i32 {
    let whole = value as i32;
    whole - i32::from((whole as f32) > value)
}

/// Smooth noise in [0, 1] with features the size of one unit of `x` and `y`.
pub(crate) fn value_noise(seed: u64, x: f32, y: f32) -> f32 {
    let (column, row) = (floor_int(x), floor_int(y));
    let ease = |t: f32| t * t * (3.0 - 2.0 * t);
    let (fx, fy) = (ease(x - column as f32), ease(y - row as f32));
    let corner = |dx: i32, dy: i32| unit(cell_hash(seed, column.wrapping_add(dx), row.wrapping_add(dy)));
    let top = corner(0, 0) + (corner(1, 0) - corner(0, 0)) * fx;
    let bottom = corner(0, 1) + (corner(1, 1) - corner(0, 1)) * fx;
    top + (bottom - top) * fy
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floor_of_negative_numbers() {
        for value in [-2.0_f32, -1.5, -0.1, 0.0, 0.9, 1.0, 7.3] {
            assert_eq!(floor_int(value), value.floor() as i32, "{value}");
        }
    }

    #[test]
    fn noise_is_continuous_and_spread_over_its_range() {
        let (mut low, mut high, mut sum) = (1.0_f32, 0.0_f32, 0.0_f32);
        for i in 0..4000 {
            let x = i as f32 * 0.37 - 700.0;
            let here = value_noise(3, x, 0.5 * x);
            assert!((value_noise(3, x + 1e-3, 0.5 * x) - here).abs() < 0.01);
            (low, high, sum) = (low.min(here), high.max(here), sum + here);
        }
        assert!(low < 0.05 && high > 0.95 && (sum / 4000.0 - 0.5).abs() < 0.03);
    }

    #[test]
    fn normal_numbers_have_their_spread_and_choices_their_weights() {
        let mut stream = Stream::new(1, 3);
        let numbers: Vec<f64> = (0..4000).map(|_| stream.normal(2.0)).collect();
        let mean = numbers.iter().sum::<f64>() / 4000.0;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 4000.0;
        assert!(mean.abs() < 0.1 && (variance.sqrt() - 2.0).abs() < 0.08, "{mean} {variance}");
        assert!(numbers.iter().all(|x| x.abs() <= 6.0));
        let chosen = (0..4000).filter(|_| stream.choose(&[(3.0, true), (1.0, false)]) == Some(true)).count();
        assert!((2850..3150).contains(&chosen), "{chosen}");
        assert_eq!(stream.choose::<u8>(&[]), None);
    }

    #[test]
    fn streams_of_different_topics_differ() {
        let (mut one, mut other) = (Stream::new(1, 1), Stream::new(1, 2));
        assert!((one.unit() - other.unit()).abs() > 1e-6);
        let mut mean = 0.0;
        for _ in 0..1000 {
            mean += one.between(2.0, 4.0) / 1000.0;
        }
        assert!((mean - 3.0).abs() < 0.06);
    }
}
