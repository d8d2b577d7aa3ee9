//! The colours of the road, learned as the drive goes: a few Gaussians, one a surface or a light.
//!
//! Dahlkamp et al., "Self-supervised monocular road detection in desert terrain", 2006: every frame's sample joins the
//! Gaussian that it resembles, or founds a new one in place of the weakest. A sample that is partly in the sun and partly
//! in the shade is two samples.

use fingerpost_vision::colour_clusters::ColourCluster;
use fingerpost_vision::moments::{Moments, sums_about};
use nalgebra::{Cholesky, Matrix3, Vector3};

/// Variances that every Gaussian has at least: brightness, red-green, blue-green. A tenth in brightness and a fiftieth in
/// chromaticity is what a road varies by within a few metres of evenly lit asphalt.
const FLOOR: [f64; 3] = [0.1 * 0.1, 0.02 * 0.02, 0.02 * 0.02];
/// Squared Mahalanobis distance up to which a sample joins a Gaussian: three standard deviations.
const JOIN_SQUARED: f64 = 9.0;
/// Share by which a sample moves its Gaussian at the least: light changes within a second.
const MIN_SHARE: f64 = 0.15;
/// Frames that a Gaussian's standing can amount to.
const MAX_STANDING: f64 = 20.0;
/// What is left of the standing after a frame: a surface not seen for a few hundred frames is the first to go.
const STANDING_KEPT: f64 = 0.99;
/// Difference in log-brightness between sun and shade: half a sun's light at the least would be 0.7, penumbras are less.
const LIGHTS_APART: f64 = 0.35;
/// Share of the sample that a second light must have.
const MIN_LIGHT_SHARE: f64 = 0.15;
/// Rounds of the split into two lights; it settles in three or four.
const SPLIT_ROUNDS: usize = 5;

/// A colour in [`fingerpost_vision::log_colour`]'s space.
type Colour = Vector3<f64>;

#[derive(Debug, Clone, Copy)]
struct Surface {
    /// Frames that it rests on, those long past counting less.
    standing: f64,
    mean: Colour,
    covariance: Matrix3<f64>,
}

/// The surfaces known so far.
#[derive(Debug)]
pub(super) struct Surfaces {
    known: Vec<Surface>,
    most: usize,
    /// The colours of a part of the sample.
    part: [Vec<f32>; 3],
}

/// The colours of a sample, one list a component.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample<'a> {
    pub(super) brightness: &'a [f32],
    pub(super) red_green: &'a [f32],
    pub(super) blue_green: &'a [f32],
}

/// A sample's part in one light.
struct Part {
    share: f64,
    mean: Colour,
    covariance: Matrix3<f64>,
}

impl Surfaces {
    pub(super) fn new(most: usize) -> Self {
        Self { known: Vec::with_capacity(most), most: most.max(1), part: Default::default() }
    }

    pub(super) fn forget(&mut self) {
        self.known.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.known.len()
    }

    /// Takes a sample in; returns how many new surfaces it founded.
    pub(super) fn learn(&mut self, sample: Sample<'_>) -> usize {
        self.known.iter_mut().for_each(|surface| surface.standing *= STANDING_KEPT);
        for part in &mut self.part {
            // So that no later frame needs more memory.
            part.clear();
            part.reserve(sample.brightness.len());
        }
        match lights_between(sample.brightness) {
            None => self.take(Part::of([sample.brightness, sample.red_green, sample.blue_green], 1.0)),
            Some(limit) => {
                let dark = self.part_where(sample, |brightness| brightness <= limit);
                let bright = self.part_where(sample, |brightness| brightness > limit);
                self.take(dark) + self.take(bright)
            }
        }
    }

    /// The part of a sample whose brightness is wanted.
    fn part_where(&mut self, sample: Sample<'_>, is_wanted: impl Fn(f64) -> bool) -> Option<Part> {
        for (values, part) in
            [sample.brightness, sample.red_green, sample.blue_green].into_iter().zip(&mut self.part)
        {
            let wanted = values.iter().zip(sample.brightness).filter(|(_, b)| is_wanted(f64::from(**b)));
            part.clear();
            part.extend(wanted.map(|(value, _)| value));
        }
        let share = self.part[0].len() as f64 / sample.brightness.len().max(1) as f64;
        Part::of(self.part.each_ref().map(Vec::as_slice), share)
    }

    fn take(&mut self, part: Option<Part>) -> usize {
        let Some(Part { share, mean, covariance }) = part else { return 0 };
        let nearest = self
            .known
            .iter_mut()
            .map(|surface| (surface.squared_distance(&mean), surface))
            .min_by(|(a, _), (b, _)| a.total_cmp(b));
        if let Some((_, surface)) = nearest.filter(|(squared, _)| *squared < JOIN_SQUARED) {
            let weight = (share / (surface.standing + share)).max(MIN_SHARE);
            let step = mean - surface.mean;
            surface.covariance = (1.0 - weight) * surface.covariance
                + weight * covariance
                + weight * (1.0 - weight) * step * step.transpose();
            surface.mean += weight * step;
            surface.standing = (surface.standing + share).min(MAX_STANDING);
            return 0;
        }
        if self.known.len() >= self.most {
            let weakest = (0..self.known.len())
                .min_by(|&a, &b| self.known[a].standing.total_cmp(&self.known[b].standing));
            weakest.map(|weakest| self.known.swap_remove(weakest));
        }
        self.known.push(Surface { standing: share, mean, covariance });
        1
    }

    /// The surfaces as the picture kernel wants them, in place of what `clusters` held.
    pub(super) fn write_to(&self, clusters: &mut Vec<ColourCluster>) {
        clusters.clear();
        clusters.extend(self.known.iter().filter_map(Surface::cluster));
    }
}

impl Surface {
    fn spread(&self) -> Option<Cholesky<f64, nalgebra::U3>> {
        Cholesky::new(self.covariance + Matrix3::from_diagonal(&Vector3::from(FLOOR)))
    }

    fn squared_distance(&self, colour: &Colour) -> f64 {
        let step = colour - self.mean;
        self.spread().map_or(f64::INFINITY, |spread| step.dot(&spread.solve(&step)))
    }

    fn cluster(&self) -> Option<ColourCluster> {
        let whitening = self.spread()?.l().solve_lower_triangular(&Matrix3::identity())?;
        let at = |row: usize, column: usize| whitening[(row, column)] as f32;
        Some(ColourCluster {
            mean: self.mean.map(|value| value as f32).into(),
            whitening: [at(0, 0), at(1, 0), at(1, 1), at(2, 0), at(2, 1), at(2, 2)],
        })
    }
}

/// The brightness between sun and shade, where the sample has both.
fn lights_between(brightness: &[f32]) -> Option<f64> {
    let mean = |(count, sum): (usize, f64)| sum / count.max(1) as f64;
    let share = |(count, _): (usize, f64)| count as f64 / brightness.len().max(1) as f64;
    let [all, _] = sums_about(brightness, f64::INFINITY);
    let (mut limit, mut apart) = (mean(all), 0.0);
    for _ in 0..SPLIT_ROUNDS {
        let [dark, bright] = sums_about(brightness, limit);
        if share(dark).min(share(bright)) < MIN_LIGHT_SHARE {
            return None;
        }
        (limit, apart) = (0.5 * (mean(dark) + mean(bright)), mean(bright) - mean(dark));
    }
    (apart > LIGHTS_APART).then_some(limit)
}

impl Part {
    /// Of these colours, a `share` of the sample.
    fn of(colours: [&[f32]; 3], share: f64) -> Option<Self> {
        let Moments { mean, covariance } = Moments::of(colours)?;
        Some(Self { share, mean: mean.into(), covariance: covariance.into() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Takes in a hundred colours of that brightness.
    fn learn(surfaces: &mut Surfaces, brightness: impl Fn(usize) -> f32) -> usize {
        let values = |of: &dyn Fn(usize) -> f32| (0..100).map(of).collect::<Vec<f32>>();
        let (red_green, blue_green) =
            (values(&|i| 0.01 * (i % 3) as f32), values(&|i| 0.01 * (i % 5) as f32));
        let brightness = values(&brightness);
        let sample = Sample { brightness: &brightness, red_green: &red_green, blue_green: &blue_green };
        surfaces.learn(sample)
    }

    #[test]
    fn sun_and_shade_are_two_surfaces() {
        let mut surfaces = Surfaces::new(4);
        assert_eq!(learn(&mut surfaces, |i| if i < 40 { 3.0 } else { 4.5 }), 2);
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let brightness: Vec<f32> = clusters.iter().map(|cluster| cluster.mean[0]).collect();
        assert_eq!(brightness, [3.0, 4.5]);
    }

    #[test]
    fn the_same_road_joins_and_the_weakest_makes_room() {
        let mut surfaces = Surfaces::new(2);
        assert_eq!(learn(&mut surfaces, |_| 2.0), 1);
        assert_eq!(learn(&mut surfaces, |_| 4.0), 1);
        for _ in 0..5 {
            assert_eq!(learn(&mut surfaces, |_| 4.0), 0);
        }
        assert_eq!(learn(&mut surfaces, |_| 6.0), 1);
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let mut brightness: Vec<f32> = clusters.iter().map(|cluster| cluster.mean[0]).collect();
        brightness.sort_by(f32::total_cmp);
        assert_eq!(brightness, [4.0, 6.0]);
    }

    #[test]
    fn whitening_makes_a_standard_deviation_one() {
        let mut surfaces = Surfaces::new(1);
        learn(&mut surfaces, |i| 3.0 + 0.2 * f32::from(u8::from(i % 2 == 0)));
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let deviation = (0.1_f64 * 0.1 + FLOOR[0]).sqrt();
        assert!((f64::from(clusters[0].whitening[0]) - 1.0 / deviation).abs() < 1e-3);
    }

    #[test]
    fn an_empty_sample_teaches_nothing() {
        let mut surfaces = Surfaces::new(3);
        let nothing = Sample { brightness: &[], red_green: &[], blue_green: &[] };
        assert_eq!((surfaces.learn(nothing), surfaces.len()), (0, 0));
    }
}
