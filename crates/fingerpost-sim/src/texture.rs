//! Tiles of ground texture, made once and looked up at the pixel's own fineness.
//!
//! Each tile repeats every [`TILE_PX`] texels and carries its halved copies (a pyramid), so that a far pixel averages
//! instead of flickering. Two look-ups of one tile at unlike scales and angles hide the repetition.

use crate::noise::{Stream, cell_hash, floor_int, mix, unit};

/// Side of a tile, texels; a power of two, so that wrapping is a mask.
const TILE_PX: usize = 512;
/// Metres a texel of the finest level: grains of 3 cm are what flow holds on to.
const TEXEL_M: f32 = 0.03;
/// Levels of the pyramid: down to 16 texels a side.
const LEVELS: usize = 6;

/// Steps of stored texels: values reach about 1.4, a level of brightness is a tenth of a grey level apart.
const STEPS: f32 = 90.0;
/// What is added to stored texels, so that they are positive.
const BIAS: f32 = 128.0;

/// A repeating square of two channels about zero: brightness and hue variation.
#[derive(Debug, Clone)]
pub(crate) struct Texture {
    /// Two biased bytes a texel, so that the finest level stays in a core's own cache.
    levels: Vec<Vec<u16>>,
}

/// What a tile shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Grain {
    /// Fine chippings with cracks and tar seams.
    Asphalt,
    /// Tufts and blades.
    Grass,
    /// Stones of mixed size.
    Soil,
}

impl Texture {
    /// The tile of a seed.
    pub(crate) fn new(seed: u64, grain: Grain) -> Self {
        let seed = mix(seed ^ mix(grain as u64 + 77));
        // Amplitude for each halving of the feature size, from 64 texels (2 m) to 1 texel (3 cm).
        let amplitudes: [f32; 7] = match grain {
            Grain::Asphalt => [0.12, 0.14, 0.16, 0.18, 0.22, 0.26, 0.30],
            Grain::Grass => [0.22, 0.22, 0.22, 0.26, 0.34, 0.40, 0.36],
            Grain::Soil => [0.20, 0.22, 0.24, 0.28, 0.34, 0.34, 0.26],
        };
        let mut base = vec![[0.0_f32; 2]; TILE_PX * TILE_PX];
        for (octave, &amplitude) in amplitudes.iter().enumerate() {
            add_octave(&mut base, mix(seed ^ octave as u64), 64 >> octave, amplitude);
        }
        if grain == Grain::Asphalt {
            add_cracks(&mut base, seed);
        }
        let mut levels = Vec::new();
        for level in 0..LEVELS {
            let byte = |value: f32| u16::from((value * STEPS + BIAS).round() as u8);
            levels.push(base.iter().map(|&[tone, hue]| byte(tone) | (byte(hue) << 8)).collect());
            base = halved(&base, TILE_PX >> level);
        }
        Self { levels }
    }

    /// Brightness and hue variation at a place (metres) for a pixel that covers `footprint_m` of ground.
    #[inline]
    pub(crate) fn sample(&self, x_m: f32, y_m: f32, footprint_m: f32) -> [f32; 2] {
        let fineness = footprint_m * (1.0 / TEXEL_M);
        // The exponent of the ratio is the level's number.
        let exponent = (fineness.max(1.0).to_bits() >> 23) - 127;
        let Some(level) = self.levels.get(exponent as usize) else {
            // A pixel above the coarsest level's size sees the average, which is none.
            return [0.0, 0.0];
        };
        let size = TILE_PX >> exponent;
        // In 1/256 of a texel of that level; both channels are blended at once, in two lanes of 16 bits.
        let scale = (256.0 / TEXEL_M) * f32::from_bits((127 - exponent) << 23);
        let (x, y) = ((x_m * scale) as i32, (y_m * scale) as i32);
        let (fx, fy) = ((x & 0xFF) as u32, (y & 0xFF) as u32);
        let wrap = |i: i32| (i & (size as i32 - 1)) as usize;
        let (c0, c1) = (wrap(x >> 8), wrap((x >> 8) + 1));
        let (r0, r1) = (wrap(y >> 8) * size, wrap((y >> 8) + 1) * size);
        let lanes = |i: usize| {
            let texel = u32::from(level[i]);
            (texel | (texel << 8)) & 0x00FF_00FF
        };
        let row = |r: usize| ((lanes(r + c0) * (256 - fx) + lanes(r + c1) * fx) >> 8) & 0x00FF_00FF;
        let both = row(r0) * (256 - fy) + row(r1) * fy;
        let value = |lane: u32| (lane as i32 as f32 + 128.0) * (1.0 / (256.0 * STEPS)) - BIAS / STEPS;
        [value(both & 0xFFFF), value(both >> 16)]
    }
}

fn add_octave(base: &mut [[f32; 2]], seed: u64, period: usize, amplitude: f32) {
    let cells = (TILE_PX / period) as i32;
    let knot = |c: i32, r: i32, channel: u64| {
        2.0 * unit(cell_hash(seed ^ (channel << 56), c.rem_euclid(cells), r.rem_euclid(cells))) - 1.0
    };
    for (i, texel) in base.iter_mut().enumerate() {
        let (x, y) = ((i % TILE_PX) as f32 / period as f32, (i / TILE_PX) as f32 / period as f32);
        let (c, r) = (floor_int(x), floor_int(y));
        let ease = |t: f32| t * t * (3.0 - 2.0 * t);
        let (fx, fy) = (ease(x - c as f32), ease(y - r as f32));
        for (channel, value) in texel.iter_mut().enumerate() {
            let channel = channel as u64;
            let top = knot(c, r, channel) * (1.0 - fx) + knot(c + 1, r, channel) * fx;
            let bottom = knot(c, r + 1, channel) * (1.0 - fx) + knot(c + 1, r + 1, channel) * fx;
            *value += amplitude * (top * (1.0 - fy) + bottom * fy);
        }
    }
}

/// Wandering dark lines: cracks (thin) and tar seams (wider, longer).
fn add_cracks(base: &mut [[f32; 2]], seed: u64) {
    let mut stream = Stream::new(seed, 9);
    for line in 0..26 {
        let (width, length, depth) = if line < 6 { (2_i32, 330, 0.55) } else { (1, 120, 0.45) };
        let (mut x, mut y) = (stream.between(0.0, TILE_PX as f64), stream.between(0.0, TILE_PX as f64));
        let mut heading = stream.between(0.0, std::f64::consts::TAU);
        for _ in 0..length {
            heading += stream.between(-0.25, 0.25);
            (x, y) = (x + libm::cos(heading), y + libm::sin(heading));
            for dx in 0..width {
                for dy in 0..width {
                    let column = (x as i32 + dx).rem_euclid(TILE_PX as i32) as usize;
                    let row = (y as i32 + dy).rem_euclid(TILE_PX as i32) as usize;
                    let texel = &mut base[row * TILE_PX + column][0];
                    *texel = texel.min(-depth);
                }
            }
        }
    }
}

fn halved(finer: &[[f32; 2]], size: usize) -> Vec<[f32; 2]> {
    let half = size / 2;
    (0..half * half)
        .map(|i| {
            let at = 2 * (i / half) * size + 2 * (i % half);
            let mean = |k: usize| {
                0.25 * (finer[at][k] + finer[at + 1][k] + finer[at + size][k] + finer[at + size + 1][k])
            };
            [mean(0), mean(1)]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spread(texture: &Texture, footprint_m: f32) -> f32 {
        let values: Vec<f32> =
            (0..2000).map(|i| texture.sample(i as f32 * 0.171, i as f32 * 0.093, footprint_m)[0]).collect();
        let mean = values.iter().sum::<f32>() / values.len() as f32;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f32>() / values.len() as f32).sqrt()
    }

    #[test]
    fn detail_fades_with_the_footprint() {
        let texture = Texture::new(5, Grain::Asphalt);
        let (near, middle, far) = (spread(&texture, 0.01), spread(&texture, 0.3), spread(&texture, 5.0));
        assert!(near > 0.15, "{near}");
        assert!(middle < 0.7 * near, "{middle} against {near}");
        assert!(far < 1e-6, "{far}");
    }

    #[test]
    fn tiles_repeat_without_a_seam() {
        let texture = Texture::new(5, Grain::Grass);
        let side = TILE_PX as f32 * TEXEL_M;
        let (one, next) = (texture.sample(0.4, 1.1, 0.0), texture.sample(0.4 - side, 1.1 + side, 0.0));
        assert!((one[0] - next[0]).abs() < 1e-3 && (one[1] - next[1]).abs() < 1e-3);
    }
}
