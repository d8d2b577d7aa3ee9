//! How unlike a known set of colours each pixel is: the distance to the nearest of a few Gaussians.
//!
//! P. C. Mahalanobis, "On the generalised distance in statistics", 1936.

use crate::elementary::exp_minus;
use crate::error::{PictureError, check_size};
use crate::log_colour::LogColour;
use crate::picture::Plane;
use crate::simd::{CodePath, simd_kernel};

/// Squared distance where no cluster is known.
pub const FARTHEST: f32 = 1e6;

/// Partial sums, on every path: a register of the widest.
const LANES: usize = 16;

/// A Gaussian in the space of [`LogColour`]: brightness, red-green, blue-green.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ColourCluster {
    /// The middle.
    pub mean: [f32; 3],
    /// Lower triangle, row by row, of the matrix that makes the differences from the mean white: the inverse of the
    /// covariance's Cholesky factor.
    pub whitening: [f32; 6],
}

/// Fills `target` with the squared Mahalanobis distance of each pixel to the nearest of `clusters`, at most [`FARTHEST`].
///
/// # Errors
/// [`PictureError::SizeMismatch`] when the two differ in size.
pub fn nearest_squared(
    colour: &LogColour,
    clusters: &[ColourCluster],
    target: &mut Plane<f32>,
) -> Result<(), PictureError> {
    nearest_squared_on(CodePath::fastest(), colour, clusters, target)
}

/// Mean likeness of colours, 0 to 1, by their squared Mahalanobis distances: the Gaussian's height, 1 in its middle; 0 of no
/// colours.
#[must_use]
pub fn mean_likeness(squared_distances: &[f32]) -> f32 {
    likeness_sum(CodePath::fastest(), squared_distances) / squared_distances.len().max(1) as f32
}

fn nearest_squared_on(
    path: CodePath,
    colour: &LogColour,
    clusters: &[ColourCluster],
    target: &mut Plane<f32>,
) -> Result<(), PictureError> {
    check_size("distance target", colour.size(), target.size())?;
    target.as_mut_slice().fill(FARTHEST);
    for y in 0..target.height() {
        for cluster in clusters {
            lower_to_distance(
                path,
                colour.brightness.row(y),
                colour.red_green.row(y),
                colour.blue_green.row(y),
                cluster,
                target.row_mut(y),
            );
        }
    }
    Ok(())
}

simd_kernel! {
    fn lower_to_distance(
        brightness: &[f32], red_green: &[f32], blue_green: &[f32], cluster: &ColourCluster, out: &mut [f32],
    ) {
        let width = out.len();
        let (brightness, red_green, blue_green) =
            (&brightness[..width], &red_green[..width], &blue_green[..width]);
        let ColourCluster { mean: [m0, m1, m2], whitening: [a, b, c, d, e, f] } = *cluster;
        for x in 0..width {
            let (p, q, r) = (brightness[x] - m0, red_green[x] - m1, blue_green[x] - m2);
            let (u, v, w) = (a * p, b * p + c * q, d * p + e * q + f * r);
            let squared = u * u + v * v + w * w;
            out[x] = if squared < out[x] { squared } else { out[x] };
        }
    }
}

simd_kernel! {
    fn likeness_sum(squared_distances: &[f32]) -> f32 {
        let mut sums = [0.0; LANES];
        let (blocks, rest) = squared_distances.as_chunks::<LANES>();
        for block in blocks {
            for lane in 0..LANES {
                sums[lane] += exp_minus(0.5 * block[lane]);
            }
        }
        sums.iter_mut().zip(rest).for_each(|(sum, &squared)| *sum += exp_minus(0.5 * squared));
        sums.iter().sum()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::test_pictures::config;

    proptest! {
        #![proptest_config(config(60))]

        #[test]
        fn likeness_is_the_mean_of_gaussians_on_every_path(
            squared in prop::collection::vec(0.0..30.0_f32, 0..70),
        ) {
            let expected: f64 = squared.iter().map(|&squared| libm::exp(-0.5 * f64::from(squared))).sum();
            for path in CodePath::available() {
                let found = likeness_sum(path, &squared);
                prop_assert!((f64::from(found) - expected).abs() < 1e-4);
                prop_assert!((found - likeness_sum(CodePath::PORTABLE, &squared)).abs() <= 0.0);
            }
            let mean = expected / squared.len().max(1) as f64;
            prop_assert!((f64::from(mean_likeness(&squared)) - mean).abs() < 1e-4);
        }

        #[test]
        fn the_nearest_cluster_counts_on_every_path(
            pixels in prop::collection::vec(prop::array::uniform3(-2.0..6.0_f32), 0..70),
            clusters in prop::collection::vec(
                (prop::array::uniform3(-2.0..6.0_f32), prop::array::uniform6(-9.0..9.0_f32)), 0..4,
            ),
        ) {
            let plane =
                |i: usize| Plane::from_vec(pixels.len(), 1, pixels.iter().map(|p| p[i]).collect()).unwrap();
            let colour = LogColour { brightness: plane(0), red_green: plane(1), blue_green: plane(2) };
            let clusters: Vec<ColourCluster> =
                clusters.into_iter().map(|(mean, whitening)| ColourCluster { mean, whitening }).collect();
            let mut first: Option<Plane<f32>> = None;
            for path in CodePath::available() {
                let mut target = Plane::new(pixels.len(), 1, 0.0);
                nearest_squared_on(path, &colour, &clusters, &mut target).unwrap();
                for (pixel, &found) in pixels.iter().zip(target.as_slice()) {
                    let expected = clusters.iter().map(|cluster| {
                        let d: Vec<f64> =
                            (0..3).map(|i| f64::from(pixel[i]) - f64::from(cluster.mean[i])).collect();
                        let w = cluster.whitening.map(f64::from);
                        (w[0] * d[0]).powi(2)
                            + (w[1] * d[0] + w[2] * d[1]).powi(2)
                            + (w[3] * d[0] + w[4] * d[1] + w[5] * d[2]).powi(2)
                    });
                    let expected = expected.fold(f64::from(FARTHEST), f64::min);
                    prop_assert!((f64::from(found) - expected).abs() <= 1e-4 * expected + 1e-2);
                }
                prop_assert!(first.as_ref().is_none_or(|first| first.as_slice() == target.as_slice()));
                first = Some(target);
            }
        }
    }
}
