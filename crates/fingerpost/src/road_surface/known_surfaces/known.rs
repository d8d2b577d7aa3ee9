//! Known surfaces: what roads have looked like, with names for people.

use std::sync::Arc;

use fingerpost_vision::histogram::Histogram;
use serde::{Deserialize, Serialize};
use thiserror::Error;

use super::tones::TONES;

/// A file of known surfaces that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SurfacesError {
    /// The file is of another version.
    #[error("the known surfaces are of version {found}, and version {expected} is read; learn them anew")]
    Version {
        /// Version of the file.
        found: u32,
        /// Version that is read.
        expected: u32,
    },
    /// There are more surfaces than any bank holds.
    #[error(
        "there are {found} known surfaces, and at most {MOST_SURFACES} are read; take out those that are not met any more"
    )]
    TooMany {
        /// How many there are.
        found: usize,
    },
    /// A surface's histogram cannot be one.
    #[error(
        "the surface {name:?} has a bin {bin} of mass {mass}; give bins below {bins} and masses from 0 to {MOST_MASS:e}"
    )]
    Histogram {
        /// Name of the surface.
        name: String,
        /// The bin.
        bin: usize,
        /// Its mass.
        mass: f64,
        /// Number of bins.
        bins: usize,
    },
}

/// Most surfaces of a file: as many as a bank may be set to hold. Each is a whole histogram in memory.
const MOST_SURFACES: usize = 64;
/// Largest mass of a bin: more than the pixels of a long drive, and sums of it stay exact.
const MOST_MASS: f64 = 1e12;
/// Version of the file's form.
const VERSION: u32 = 1;

/// Known surfaces as a file has them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceFile {
    /// Version of the form: 1.
    pub version: u32,
    /// The surfaces.
    pub surfaces: Vec<SurfaceRecord>,
}

impl SurfaceFile {
    /// The surfaces of a file.
    ///
    /// # Errors
    /// What the text lacks or has too much.
    pub fn from_json(text: &str) -> serde_json::Result<Self> {
        serde_json::from_str(text)
    }

    /// The file's text.
    ///
    /// # Errors
    /// A mass that is not finite.
    pub fn to_json(&self) -> serde_json::Result<String> {
        serde_json::to_string(self)
    }
}

/// A known surface as a file has it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceRecord {
    /// What people call it; any text.
    pub name: String,
    /// Frames that it was learned from.
    pub frames: u64,
    /// Bins that are not empty with their masses: a bin is 32 times the brightness (0 to 31) plus the tint (0 to 7: grey, ever
    /// more coloured; from 8 on four hues for each level of saturation).
    pub histogram: Vec<(usize, f64)>,
}

/// A surface that the road has had.
#[derive(Debug)]
pub(super) struct KnownSurface {
    pub(super) name: Arc<str>,
    /// Mass 1.
    pub(super) histogram: Histogram,
    /// Frames learned from.
    pub(super) frames: u64,
    /// Frames since it was last under way.
    pub(super) unseen_frames: u64,
}

/// Masses below this are not kept in files: a millionth of the surface.
const LEAST_MASS: f64 = 1e-6;

impl SurfaceFile {
    pub(super) fn of(surfaces: &[KnownSurface]) -> Self {
        let record = |surface: &KnownSurface| SurfaceRecord {
            name: surface.name.to_string(),
            frames: surface.frames,
            histogram: surface
                .histogram
                .masses()
                .iter()
                .enumerate()
                .filter(|(_, mass)| **mass >= LEAST_MASS)
                .map(|(bin, mass)| (bin, (mass / LEAST_MASS).round() * LEAST_MASS))
                .collect(),
        };
        Self { version: VERSION, surfaces: surfaces.iter().map(record).collect() }
    }

    pub(super) fn surfaces(&self) -> Result<Vec<KnownSurface>, SurfacesError> {
        if self.version != VERSION {
            return Err(SurfacesError::Version { found: self.version, expected: VERSION });
        }
        if self.surfaces.len() > MOST_SURFACES {
            return Err(SurfacesError::TooMany { found: self.surfaces.len() });
        }
        self.surfaces.iter().map(SurfaceRecord::surface).collect()
    }
}

impl SurfaceRecord {
    fn surface(&self) -> Result<KnownSurface, SurfacesError> {
        let bins = TONES.count();
        let refused = |bin, mass| SurfacesError::Histogram { name: self.name.clone(), bin, mass, bins };
        let mut masses = vec![0.0; bins];
        for &(bin, mass) in &self.histogram {
            let place = masses.get_mut(bin).ok_or(refused(bin, mass))?;
            if !(0.0..=MOST_MASS).contains(&mass) {
                return Err(refused(bin, mass));
            }
            *place = mass;
        }
        let mut histogram = Histogram::from_masses(TONES, masses).map_err(|_| refused(bins, 0.0))?;
        histogram.normalise();
        Ok(KnownSurface {
            name: self.name.as_str().into(),
            histogram,
            frames: self.frames,
            unseen_frames: u64::MAX,
        })
    }
}

/// How alike two histograms of mass 1 are, 0 to 1: the Bhattacharyya coefficient.
pub(super) fn likeness(left: &Histogram, right: &Histogram) -> f64 {
    left.masses().iter().zip(right.masses()).map(|(left, right)| (left * right).sqrt()).sum()
}

/// What a surface looks like, in a few numbers.
#[derive(Debug, Clone, Copy)]
struct Look {
    /// Mean grey, 0 to 255.
    brightness: f64,
    /// Share of pixels with a hue, 0 to 1, and of those that have a warm one, and a green one.
    coloured: f64,
    warm: f64,
    green: f64,
    /// Mean tint of the pixels without a hue, 0 (grey) to 7.
    paleness: f64,
}

impl Look {
    fn of(histogram: &Histogram) -> Self {
        let tints = usize::from(TONES.saturation);
        let mut look = Self { brightness: 0.0, coloured: 0.0, warm: 0.0, green: 0.0, paleness: 0.0 };
        for (bin, &mass) in histogram.masses().iter().enumerate() {
            let (brightness, tint) = (bin / tints, bin % tints);
            look.brightness += mass * (8.0 * brightness as f64 + 4.0);
            match tint.checked_sub(8) {
                None => look.paleness += mass * tint as f64,
                Some(coloured) => {
                    look.coloured += mass;
                    match coloured % 4 {
                        // Hues of 0 to 90 degrees: red, brown, yellow.
                        0 => look.warm += mass,
                        1 => look.green += mass,
                        _ => {}
                    }
                }
            }
        }
        look.paleness /= (1.0 - look.coloured).max(1e-6);
        look
    }
}

/// What a surface is called by its look alone. People may call it otherwise in the file.
///
/// Coloured for the greater part: dirt where most of that is brown or yellow, grass where it is green, else coloured. Else by
/// its mean grey: below 24 night, below 64 asphalt in shadow; from 150 on concrete; of those between, gravel where greys are
/// tinted (a mean saturation of about an eighth), else asphalt.
pub(super) fn name_of(histogram: &Histogram) -> &'static str {
    let look = Look::of(histogram);
    if look.coloured > 0.5 {
        return match (look.warm > 0.5 * look.coloured, look.green > 0.5 * look.coloured) {
            (true, _) => "dirt",
            (_, true) => "grass",
            _ => "coloured",
        };
    }
    match look.brightness {
        grey if grey < 24.0 => "night",
        grey if grey < 64.0 => "asphalt in shadow",
        grey if grey >= 150.0 => "concrete",
        _ if look.paleness > 4.0 => "gravel",
        _ => "asphalt",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(surfaces: usize, mass: f64) -> SurfaceFile {
        let record =
            SurfaceRecord { name: "asphalt".to_owned(), frames: 1, histogram: vec![(1, mass), (2, mass)] };
        SurfaceFile { version: VERSION, surfaces: vec![record; surfaces] }
    }

    #[test]
    fn what_is_read_is_as_many_surfaces_of_mass_1_as_a_bank_holds() {
        for mass in [1e-300, 1e-6, 0.5, 1.0, 1e12] {
            for surface in file(2, mass).surfaces().unwrap() {
                let sum: f64 = surface.histogram.masses().iter().sum();
                assert!((sum - 1.0).abs() < 1e-9, "{mass}: {sum}");
            }
        }
        for mass in [-1.0, 1.1e12, 1.7e308, f64::INFINITY, f64::NAN] {
            let refused = file(1, mass).surfaces();
            assert!(matches!(refused, Err(SurfacesError::Histogram { bin: 1, .. })), "{mass}");
        }
        assert_eq!(file(64, 1.0).surfaces().map(|surfaces| surfaces.len()), Ok(64));
        for found in [65, 1000, 600_000] {
            assert_eq!(file(found, 1.0).surfaces().unwrap_err(), SurfacesError::TooMany { found });
        }
    }
}
