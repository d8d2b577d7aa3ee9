//! The colours of the road, learned as the drive goes: a few Gaussians, one a surface or a light.
//!
//! Dahlkamp et al., "Self-supervised monocular road detection in desert terrain", 2006: every frame's sample joins the
//! Gaussian that it resembles, or founds a new one in place of the weakest. A sample that is partly in the sun and partly
//! in the shade is two samples.

use fingerpost_vision::colour_clusters::ColourCluster;
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
pub(super) type Colour = Vector3<f64>;

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
}

/// A sample's part in one light.
struct Part {
    share: f64,
    mean: Colour,
    covariance: Matrix3<f64>,
}

impl Surfaces {
    pub(super) fn new(most: usize) -> Self {
        Self { known: Vec::with_capacity(most), most: most.max(1) }
    }

    pub(super) fn forget(&mut self) {
        self.known.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.known.len()
    }

    /// Takes a sample in; returns how many new surfaces it founded.
    pub(super) fn learn(&mut self, sample: &[Colour]) -> usize {
        self.known.iter_mut().for_each(|surface| surface.standing *= STANDING_KEPT);
        match lights_between(sample) {
            None => self.take(part(sample, sample.len(), |_| true)),
            Some(limit) => {
                self.take(part(sample, sample.len(), |brightness| brightness <= limit))
                    + self.take(part(sample, sample.len(), |brightness| brightness > limit))
            }
        }
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
fn lights_between(sample: &[Colour]) -> Option<f64> {
    let mean_where = |is_wanted: &dyn Fn(f64) -> bool| {
        let wanted = sample.iter().map(|colour| colour.x).filter(|&brightness| is_wanted(brightness));
        let (count, sum) = wanted.fold((0_usize, 0.0), |(count, sum), b| (count + 1, sum + b));
        (count as f64 / sample.len().max(1) as f64, sum / count.max(1) as f64)
    };
    let (_, mut limit) = mean_where(&|_| true);
    let mut apart = 0.0;
    for _ in 0..SPLIT_ROUNDS {
        let (dark_share, dark) = mean_where(&|brightness| brightness <= limit);
        let (bright_share, bright) = mean_where(&|brightness| brightness > limit);
        if dark_share.min(bright_share) < MIN_LIGHT_SHARE {
            return None;
        }
        (limit, apart) = (0.5 * (dark + bright), bright - dark);
    }
    (apart > LIGHTS_APART).then_some(limit)
}

/// Mean and covariance of the part of a sample whose brightness is wanted, and its share of `all`.
fn part(sample: &[Colour], all: usize, is_wanted: impl Fn(f64) -> bool) -> Option<Part> {
    let wanted = || sample.iter().filter(|colour| is_wanted(colour.x));
    let count = wanted().count();
    if count == 0 {
        return None;
    }
    let mean = wanted().sum::<Colour>() / count as f64;
    let mut covariance = Matrix3::zeros();
    for colour in wanted() {
        let step = colour - mean;
        covariance += step * step.transpose();
    }
    Some(Part { share: count as f64 / all as f64, mean, covariance: covariance / count as f64 })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(brightness: impl Fn(usize) -> f64) -> Vec<Colour> {
        (0..100).map(|i| Vector3::new(brightness(i), 0.01 * (i % 3) as f64, 0.01 * (i % 5) as f64)).collect()
    }

    #[test]
    fn sun_and_shade_are_two_surfaces() {
        let mut surfaces = Surfaces::new(4);
        assert_eq!(surfaces.learn(&sample(|i| if i < 40 { 3.0 } else { 4.5 })), 2);
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let brightness: Vec<f32> = clusters.iter().map(|cluster| cluster.mean[0]).collect();
        assert_eq!(brightness, [3.0, 4.5]);
    }

    #[test]
    fn the_same_road_joins_and_the_weakest_makes_room() {
        let mut surfaces = Surfaces::new(2);
        assert_eq!(surfaces.learn(&sample(|_| 2.0)), 1);
        assert_eq!(surfaces.learn(&sample(|_| 4.0)), 1);
        for _ in 0..5 {
            assert_eq!(surfaces.learn(&sample(|_| 4.0)), 0);
        }
        assert_eq!(surfaces.learn(&sample(|_| 6.0)), 1);
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let mut brightness: Vec<f32> = clusters.iter().map(|cluster| cluster.mean[0]).collect();
        brightness.sort_by(f32::total_cmp);
        assert_eq!(brightness, [4.0, 6.0]);
    }

    #[test]
    fn whitening_makes_a_standard_deviation_one() {
        let mut surfaces = Surfaces::new(1);
        surfaces.learn(&sample(|i| 3.0 + 0.2 * f64::from(u8::from(i % 2 == 0))));
        let mut clusters = Vec::new();
        surfaces.write_to(&mut clusters);
        let deviation = (0.1_f64 * 0.1 + FLOOR[0]).sqrt();
        assert!((f64::from(clusters[0].whitening[0]) - 1.0 / deviation).abs() < 1e-3);
    }

    #[test]
    fn an_empty_sample_teaches_nothing() {
        let mut surfaces = Surfaces::new(3);
        assert_eq!((surfaces.learn(&[]), surfaces.len()), (0, 0));
    }
}
