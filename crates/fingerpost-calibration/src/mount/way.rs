//! The way of a drive in heights of the camera, which a known way turns into a height.

use nalgebra::Vector3;

use super::road_plane::RoadPlane;
use super::{Estimated, LEAST_ROAD, Look};

/// Share of a measured length that texture and waves of the road leave uncertain.
const LENGTH_FLOOR: f64 = 0.01;

/// A way in heights of the camera.
#[derive(Debug, Clone, Copy)]
pub(super) struct Way {
    pub(super) heights: f64,
    sigma_share: f64,
}

impl Way {
    pub(super) fn height(&self, way_m: f64) -> Estimated {
        let value = way_m / self.heights;
        Estimated { value, sigma: value * self.sigma_share }
    }
}

/// The way of the whole drive in heights of the camera, when the road's normal is `normal`: as each frame shows it, and
/// where one does not, as its neighbours do.
pub(super) fn way(looks: &[Look], normal: &Vector3<f64>) -> Option<Way> {
    let seen: Vec<Option<f64>> = looks
        .iter()
        .map(|look| match (&look.plane, &look.sighting) {
            (Some(plane), _) => Some(plane.way_with_normal(normal)),
            // A vehicle that stands makes no way.
            (None, Some(sighting)) if !sighting.moves => Some(0.0),
            _ => None,
        })
        .collect();
    let count = seen.iter().flatten().filter(|way| **way > 0.0).count();
    if count < LEAST_ROAD {
        return None;
    }
    let steps: Vec<f64> = (1..seen.len()).map(|frame| middle_of_neighbours(&seen, frame)).collect();
    let heights: f64 = steps.iter().sum();
    // Differences of neighbours show the noise of a frame.
    let noise: f64 =
        seen.iter().skip(1).zip(&steps).filter_map(|(seen, step)| Some((*seen)? - step)).map(|d| d * d).sum();
    let sigma = libm::hypot(noise.sqrt() / heights, LENGTH_FLOOR);
    Some(Way { heights, sigma_share: sigma })
}

/// Median of what a frame and its two neighbours to either side show; of the nearest that show something where they do not.
fn middle_of_neighbours(seen: &[Option<f64>], frame: usize) -> f64 {
    for reach in 2..seen.len().max(3) {
        let near = &seen[frame.saturating_sub(reach)..(frame + reach + 1).min(seen.len())];
        let mut values: Vec<f64> = near.iter().flatten().copied().collect();
        if !values.is_empty() {
            values.sort_unstable_by(f64::total_cmp);
            return values[values.len() / 2];
        }
    }
    0.0
}

/// Way of a frame in heights of the camera, the median.
pub(super) fn typical_way(roads: &[RoadPlane], normal: &Vector3<f64>) -> Option<f64> {
    let mut ways: Vec<f64> = roads.iter().map(|plane| plane.way_with_normal(normal)).collect();
    ways.sort_unstable_by(f64::total_cmp);
    ways.get(ways.len() / 2).copied()
}
