//! What the ground of each street is made of: roads, pavements and verges of many tones.
//!
//! Everything follows from the seed, the road (its chain of strokes) and, beside it, the distance along it.

use super::lane::LocalPlace;
use super::pattern::Pattern;
use super::varied::Look;
use super::{Colour, Footprint};
use crate::conditions::Streetscape;
use crate::noise::{Stream, floor_int, mix, unit};

/// Length of a roadside whose pavement is of one kind, metres.
const SIDE_STRETCH_M: f32 = 70.0;
/// Brightness of a ground against its kind's, factors: wet clay to sun-bleached sand.
const SHADES: [f64; 2] = [0.6, 1.6];
/// How far red and blue of a grey ground are off, share: bluish basalt to brownish gravel.
const TINT: f64 = 0.08;
/// Albedo of asphalt: fresh 0.05, after years 0.15 to 0.2, of light stone up to 0.35 (Pomerantz et al., LBNL-43429, 2000).
const ASPHALT: [f64; 2] = [0.05, 0.35];
/// Albedo of concrete and of slabs, of the same source.
const CONCRETE: [f64; 2] = [0.2, 0.5];
/// Share of the made roads with a gutter that looks different, its width, metres (a channel block of 125 mm to a tray of half a metre), and its
/// brightness against the road: from silt to clean concrete.
const GUTTERS: f64 = 0.5;
const GUTTER_M: [f64; 2] = [0.12, 0.5];
const GUTTER_SHADE: [f64; 2] = [0.55, 1.3];
/// Brightness of a pavement of the road's own kind against the road.
const ALIKE: [f64; 2] = [0.85, 1.15];

/// Grounds that nobody made, by their share: gravel, quarry ground, sand, clay, earth.
const UNMADE: [(f64, Colour); 5] = [
    (2.0, [0.33, 0.305, 0.265]),
    (1.0, [0.46, 0.44, 0.40]),
    (1.5, [0.50, 0.42, 0.31]),
    (1.5, [0.33, 0.165, 0.105]),
    (2.0, [0.235, 0.17, 0.11]),
];
/// Small stones: granite, sandstone, brick.
const STONES: [(f64, Colour); 3] =
    [(2.0, [0.24, 0.24, 0.245]), (1.0, [0.40, 0.33, 0.24]), (1.5, [0.29, 0.135, 0.095])];
/// Vegetation: lush, ordinary, olive, straw, brown.
const VEGETATION: [(f64, Colour); 5] = [
    (1.5, [0.07, 0.16, 0.03]),
    (2.0, [0.135, 0.195, 0.062]),
    (1.5, [0.16, 0.165, 0.07]),
    (1.5, [0.40, 0.34, 0.18]),
    (1.0, [0.22, 0.165, 0.10]),
];

/// What a road is made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoadGround {
    pub(super) look: Look,
    pub(super) pattern: Pattern,
    /// How far its edge wanders, metres.
    pub(super) ragged_m: f32,
    /// Width of its gutter, metres, and its brightness against the road.
    pub(super) gutter: Option<(f32, f32)>,
}

/// What a pavement is made of.
#[derive(Debug, Clone, Copy)]
pub(super) enum PavementGround {
    /// The road's own, so much brighter.
    Road(f32),
    /// Slabs, stones or asphalt.
    Laid(Colour, Pattern),
    /// Grass or soil, as the verge.
    Verge,
}

/// The seed's grounds.
#[derive(Debug, Clone, Copy)]
pub(super) struct Materials {
    seed: u64,
    reach: f64,
    unmade: f64,
    ragged_m: f64,
    pub(super) snow: f32,
    pub(super) leaves: f32,
    /// Two kinds of vegetation that take turns, and the soil between.
    pub(super) vegetation: [Colour; 2],
    pub(super) soil: Colour,
    /// Brightness of kerb stones against the usual ones.
    pub(super) kerb: f32,
}

impl Materials {
    /// None where all grounds are the usual ones.
    pub(super) fn new(seed: u64, streetscape: &Streetscape) -> Option<Self> {
        if *streetscape == Streetscape::USUAL {
            return None;
        }
        let mut stream = Stream::new(seed, 0x4d41_5445);
        let mut shaded = |kinds: &[(f64, Colour)]| {
            let kind = stream.choose(kinds).unwrap_or([0.2; 3]);
            let shade = stream.between(SHADES[0], SHADES[1]) as f32;
            kind.map(|c| c * shade)
        };
        let vegetation = [shaded(&VEGETATION), shaded(&VEGETATION)];
        let soil = shaded(&UNMADE);
        Some(Self {
            seed,
            reach: streetscape.materials,
            unmade: streetscape.unmade,
            ragged_m: streetscape.ragged_m,
            snow: streetscape.snow as f32,
            leaves: streetscape.leaves as f32,
            vegetation,
            soil,
            kerb: stream.between(0.5, 2.2) as f32,
        })
    }

    /// The ground of a road; none where it is the usual one.
    pub(super) fn road(&self, chain: u32) -> Option<RoadGround> {
        let mut stream = Stream::new(self.seed ^ 0x524f_4144, u64::from(chain));
        if stream.unit() < self.unmade {
            return Some(self.unmade(&mut stream));
        }
        if stream.unit() >= self.reach {
            return None;
        }
        let ground = |base: Colour, wear: f32, pattern: Pattern| RoadGround {
            look: Look { base, wear, loose: false },
            pattern,
            ragged_m: 0.0,
            gutter: None,
        };
        let wear = stream.between(0.4, 1.3) as f32;
        let made = match stream.choose(&[(8.0, 0), (1.0, 1), (1.5, 2)]) {
            Some(1) => {
                let side_m = stream.between(3.0, 6.0) as f32;
                ground(grey(&mut stream, CONCRETE), 0.6 * wear, Pattern::Slabs { side_m })
            }
            Some(2) => {
                let stone = stream.choose(&STONES).unwrap_or([0.24; 3]);
                let shade = stream.between(SHADES[0], SHADES[1]) as f32;
                ground(stone.map(|c| c * shade), 0.5 * wear, setts(&mut stream))
            }
            _ => ground(grey(&mut stream, ASPHALT), wear, Pattern::Plain),
        };
        let [width_m, shade] = [GUTTER_M, GUTTER_SHADE].map(|[low, high]| stream.between(low, high) as f32);
        let gutter = (stream.unit() < GUTTERS).then_some((width_m, shade));
        Some(RoadGround { gutter, ..made })
    }

    fn unmade(&self, stream: &mut Stream) -> RoadGround {
        let base = stream.choose(&UNMADE).unwrap_or([0.3; 3]);
        let shade = stream.between(SHADES[0], SHADES[1]) as f32;
        let pattern =
            stream.choose(&[(1.0, Pattern::Plain), (1.0, Pattern::Ruts), (0.7, Pattern::GrassBetween)]);
        RoadGround {
            look: Look { base: base.map(|c| c * shade), wear: stream.between(0.5, 1.6) as f32, loose: true },
            pattern: pattern.unwrap_or(Pattern::Plain),
            ragged_m: (self.ragged_m * stream.unit()) as f32,
            gutter: None,
        }
    }

    /// The ground of the pavement beside a place.
    pub(super) fn pavement(&self, place: &LocalPlace) -> PavementGround {
        let number = floor_int(place.along_m / SIDE_STRETCH_M);
        let side = u64::from(place.left_m > 0.0);
        let place_hash = mix((u64::from(place.chain) << 32) | u64::from(number as u32));
        let mut stream = Stream::new(self.seed ^ 0x5041_5645 ^ side, place_hash);
        match stream.choose(&[(3.0, 0), (2.0, 1), (3.0, 2), (3.0, 3), (1.0, 4), (1.0, 5)]) {
            Some(0) => PavementGround::Road(stream.between(ALIKE[0], ALIKE[1]) as f32),
            Some(1) => PavementGround::Laid(grey(&mut stream, ASPHALT), Pattern::Plain),
            Some(2) => {
                let side_m = stream.between(0.3, 0.9) as f32;
                PavementGround::Laid(grey(&mut stream, CONCRETE), Pattern::Slabs { side_m })
            }
            Some(3) => {
                let stone = stream.choose(&STONES).unwrap_or([0.24; 3]);
                let shade = stream.between(SHADES[0], SHADES[1]) as f32;
                PavementGround::Laid(stone.map(|c| c * shade), setts(&mut stream))
            }
            Some(4) => {
                let loose = stream.choose(&UNMADE).unwrap_or([0.3; 3]);
                PavementGround::Laid(loose, Pattern::Plain)
            }
            _ => PavementGround::Verge,
        }
    }

    /// A sett's own brightness, or a slab's.
    pub(super) fn laid(
        &self,
        colour: Colour,
        pattern: Pattern,
        place: &LocalPlace,
        footprint: &Footprint,
    ) -> Colour {
        pattern.laid(colour, place, place.extents_m(footprint), |column, row| {
            unit(mix(self.seed ^ mix((u64::from(column as u32) << 32) | u64::from(row as u32))))
        })
    }
}

/// A grey that is not quite one.
fn grey(stream: &mut Stream, [low, high]: [f64; 2]) -> Colour {
    let tone = libm::exp(stream.between(libm::log(low), libm::log(high)));
    let tint = stream.between(-TINT, TINT);
    [tone * (1.0 + tint), tone, tone * (1.0 - tint)].map(|c| c as f32)
}

/// Setts and pavers, from small cobbles to bricks laid lengthwise.
fn setts(stream: &mut Stream) -> Pattern {
    let size_m =
        stream.choose(&[(1.0, [0.10, 0.10]), (1.0, [0.16, 0.16]), (1.0, [0.10, 0.20]), (1.0, [0.20, 0.10])]);
    Pattern::Setts { size_m: size_m.unwrap_or([0.1, 0.1]) }
}
