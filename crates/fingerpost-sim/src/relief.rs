//! The ground's gentle waves, and hills.
//!
//! A sum of plane sine waves 23 to 80 m long, and where there are hills of two longer ones. The vehicle stands on the exact sum; the renderer looks it up in a raster
//! of one metre, which is a few millimetres off at most.

use std::f64::consts::TAU;

use nalgebra::{Point2, Vector2};

use crate::noise::Stream;

/// Lengths of the waves, metres: long enough that a road could follow them.
const WAVE_LENGTHS_M: [f64; 5] = [80.0, 61.0, 43.0, 31.0, 23.0];
/// Height falls with this power of the length, so that shorter waves are not steeper.
const HEIGHT_POWER: i32 = 2;

/// Lengths of the waves that hills are made of, metres: crests as of residential streets, over which a driver sees 30 to 50 m
/// of road.
const HILL_LENGTHS_M: [f64; 2] = [150.0, 90.0];

#[derive(Debug, Clone, Copy)]
struct Wave {
    amplitude_m: f64,
    wave_vector: Vector2<f64>,
    phase_rad: f64,
}

/// Height of the ground above the map's plane.
#[derive(Debug, Clone)]
pub(crate) struct Relief {
    waves: Vec<Wave>,
    hilly: bool,
}

impl Relief {
    /// Waves whose longest has this amplitude, metres; none at zero.
    pub(crate) fn new(seed: u64, amplitude_m: f64) -> Self {
        let mut stream = Stream::new(seed, 0x5245_4c49);
        let waves = WAVE_LENGTHS_M.iter().enumerate().map(|(i, &length_m)| {
            // Golden-angle directions cover the compass evenly.
            let (sin, cos) = libm::sincos(stream.between(0.0, 0.4) + 2.399_963 * i as f64);
            Wave {
                amplitude_m: amplitude_m * (length_m / WAVE_LENGTHS_M[0]).powi(HEIGHT_POWER),
                wave_vector: Vector2::new(cos, sin) * (TAU / length_m),
                phase_rad: stream.between(0.0, TAU),
            }
        });
        Self { waves: if amplitude_m > 0.0 { waves.collect() } else { Vec::new() }, hilly: false }
    }

    /// The same on hills of at most this slope; none at zero.
    pub(crate) fn with_hills(mut self, seed: u64, slope: f64) -> Self {
        let mut stream = Stream::new(seed, 0x4849_4c4c);
        for length_m in HILL_LENGTHS_M {
            let (sin, cos) = libm::sincos(stream.between(0.0, TAU));
            let phase_rad = stream.between(0.0, TAU);
            // Where both are steepest the slopes add up.
            let amplitude_m = slope / HILL_LENGTHS_M.len() as f64 * length_m / TAU;
            let wave_vector = Vector2::new(cos, sin) * (TAU / length_m);
            if slope > 0.0 {
                self.waves.push(Wave { amplitude_m, wave_vector, phase_rad });
            }
        }
        self.hilly = slope > 0.0;
        self
    }

    /// Bound of the slope anywhere.
    fn steepest(&self) -> f64 {
        self.waves.iter().map(|wave| wave.amplitude_m * wave.wave_vector.norm()).sum()
    }

    /// Height at a place of the map, metres.
    pub(crate) fn height_m(&self, p_in_map: Point2<f64>) -> f64 {
        self.waves
            .iter()
            .map(|wave| wave.amplitude_m * libm::sin(wave.wave_vector.dot(&p_in_map.coords) + wave.phase_rad))
            .sum()
    }

    /// Whether there is nothing but a plane.
    pub(crate) fn is_flat(&self) -> bool {
        self.waves.is_empty()
    }
}

/// Cells of the height raster, metres: a 23 m wave sags 7 mm between them at 0.1 m of amplitude.
const CELL_M: f32 = 1.0;

/// Heights on a square grid, looked up bilinearly.
#[derive(Debug, Clone)]
pub(crate) struct ReliefRaster {
    origin: [f32; 2],
    columns: usize,
    rows: usize,
    heights_m: Vec<f32>,
    /// Where there are hills, a bound of the ground's slope.
    pub(crate) hill_slope: Option<f32>,
}

impl ReliefRaster {
    /// The relief over the rectangle from `low` to `high` (map frame, metres); level outside.
    pub(crate) fn new(relief: &Relief, low: Point2<f64>, high: Point2<f64>) -> Self {
        if relief.is_flat() {
            return Self { origin: [0.0; 2], columns: 0, rows: 0, heights_m: Vec::new(), hill_slope: None };
        }
        let size = (high - low) / f64::from(CELL_M);
        let (columns, rows) = (size.x.ceil() as usize + 2, size.y.ceil() as usize + 2);
        let heights_m = (0..rows * columns)
            .map(|i| {
                let cell = Vector2::new((i % columns) as f64, (i / columns) as f64) * f64::from(CELL_M);
                relief.height_m(low + cell) as f32
            })
            .collect();
        let hill_slope = relief.hilly.then(|| relief.steepest() as f32);
        Self { origin: [low.x as f32, low.y as f32], columns, rows, heights_m, hill_slope }
    }

    /// Whether there is nothing but a plane.
    pub(crate) fn is_flat(&self) -> bool {
        self.heights_m.is_empty()
    }

    /// Height at a place of the map, metres.
    #[inline]
    pub(crate) fn height_m(&self, x: f32, y: f32) -> f32 {
        let (column, row) = ((x - self.origin[0]) / CELL_M, (y - self.origin[1]) / CELL_M);
        if !(column >= 0.0
            && row >= 0.0
            && column < (self.columns as f32 - 1.0)
            && row < (self.rows as f32 - 1.0))
        {
            return 0.0;
        }
        let (c, r) = (column as i32 as usize, row as i32 as usize);
        let (fx, fy) = (column - c as f32, row - r as f32);
        let i = r * self.columns + c;
        let (top, bottom) =
            (&self.heights_m[i..i + 2], &self.heights_m[i + self.columns..i + self.columns + 2]);
        let near = top[0] + (top[1] - top[0]) * fx;
        let far = bottom[0] + (bottom[1] - bottom[0]) * fx;
        near + (far - near) * fy
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_raster_follows_the_waves() {
        let relief = Relief::new(4, 0.3);
        let raster = ReliefRaster::new(&relief, Point2::new(-50.0, -40.0), Point2::new(60.0, 70.0));
        let (mut worst, mut highest) = (0.0_f64, 0.0_f64);
        for i in 0..500 {
            let p = Point2::new(-49.0 + 0.213 * f64::from(i), 68.0 - 0.207 * f64::from(i));
            let exact = relief.height_m(p);
            worst = worst.max((exact - f64::from(raster.height_m(p.x as f32, p.y as f32))).abs());
            highest = highest.max(exact.abs());
        }
        assert!(worst < 0.005, "{worst} m off");
        assert!(highest > 0.1, "the waves are there");
    }

    #[test]
    fn hills_are_as_steep_as_they_are_called_and_no_steeper() {
        let relief = Relief::new(4, 0.0).with_hills(4, 0.08);
        let mut steepest = 0.0_f64;
        for i in 0..200_000 {
            let p = Point2::new(0.7 * f64::from(i % 500), 1.1 * f64::from(i / 500));
            let slope = |x: f64, y: f64| (relief.height_m(p + Vector2::new(x, y)) - relief.height_m(p)) / 0.1;
            steepest = steepest.max(libm::hypot(slope(0.1, 0.0), slope(0.0, 0.1)));
        }
        assert!((0.07..0.0805).contains(&steepest), "{steepest}");
        assert!(Relief::new(4, 0.0).with_hills(4, 0.0).is_flat());
    }

    #[test]
    fn no_amplitude_is_flat() {
        let relief = Relief::new(4, 0.0);
        assert!(relief.is_flat() && relief.height_m(Point2::new(3.0, 4.0)).abs() < 1e-12);
        assert!(ReliefRaster::new(&relief, Point2::new(0.0, 0.0), Point2::new(9.0, 9.0)).is_flat());
    }
}
