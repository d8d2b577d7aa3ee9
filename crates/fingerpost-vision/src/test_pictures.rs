//! Pictures for the property tests of kernels: noise, blobs and planes inside larger ones, all from a seed.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::picture::{Plane, PlaneView, Rect};

/// Columns left and right of a [`Framed`] picture, and rows above and below it.
const MARGIN: [usize; 2] = [3, 2];

/// A picture inside a larger one, so that its rows are further apart than they are wide.
#[derive(Debug, Clone)]
pub(crate) struct Framed {
    outer: Plane<u8>,
    size: (usize, usize),
}

impl Framed {
    pub(crate) fn view(&self) -> PlaneView<'_, u8> {
        let [x, y] = MARGIN;
        self.outer.view().crop(Rect { x, y, width: self.size.0, height: self.size.1 }).unwrap()
    }

    /// The pixel in column `x` and row `y`, `outside` where there is none.
    pub(crate) fn get(&self, x: isize, y: isize, outside: u8) -> u8 {
        let inside =
            |index: isize, length: usize| usize::try_from(index).ok().filter(|&index| index < length);
        match (inside(x, self.size.0), inside(y, self.size.1)) {
            (Some(x), Some(y)) => self.view().row(y)[x],
            _ => outside,
        }
    }
}

pub(crate) fn config(cases: u32) -> ProptestConfig {
    ProptestConfig {
        cases,
        rng_seed: RngSeed::Fixed(31),
        failure_persistence: None,
        ..ProptestConfig::default()
    }
}

/// Sizes about the widths of vector registers, and small ones down to nothing.
fn sizes() -> impl Strategy<Value = (usize, usize)> {
    (prop_oneof![0..20_usize, 60..70_usize, 120..140_usize], 0..24_usize)
}

/// Pictures of any grey levels: noise, or noise smoothed to slopes of either sign with saturated parts.
pub(crate) fn grey_pictures() -> impl Strategy<Value = Framed> {
    (sizes(), any::<u64>(), 0..4_u32).prop_map(|(size, seed, coarseness)| {
        framed(size, seed, |state, x, y| match coarseness {
            0 => (state >> 56) as u8,
            1 => ((state >> 62) * 85) as u8,
            _ => {
                let wave =
                    libm::sin((x * 11) as f64) + libm::cos(((x + y) * 3) as f64 / f64::from(coarseness));
                (128.0 + 90.0 * wave + (state >> 60) as f64) as u8
            }
        })
    })
}

/// Pictures of 0 and 255 alone, from nearly empty to nearly full.
pub(crate) fn binary_pictures() -> impl Strategy<Value = Framed> {
    (sizes(), any::<u64>(), 0..=16_u64).prop_map(|(size, seed, filled)| {
        framed(size, seed, |state, _, _| if (state >> 60) < filled { 255 } else { 0 })
    })
}

fn framed(size: (usize, usize), seed: u64, pixel: impl Fn(u64, usize, usize) -> u8) -> Framed {
    let mut state = seed;
    let mut outer = Plane::new(size.0 + 2 * MARGIN[0], size.1 + 2 * MARGIN[1], 0);
    for y in 0..outer.height() {
        for (x, value) in outer.row_mut(y).iter_mut().enumerate() {
            // A linear congruential generator with Knuth's constants for MMIX.
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            *value = pixel(state, x, y);
        }
    }
    Framed { outer, size }
}
