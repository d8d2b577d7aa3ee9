//! The road's plane in the camera frame, from pairs of rays that meet it.
//!
//! Between two frames with rotation R and direction t of travel the ray p becomes the direction R p - m t, where m is the
//! way over the depth. Depths on a plane are linear in the ray: m = n . p s / h with the plane's normal n, the way s and the
//! camera's height h. So m is measured for each pair and a vector fitted to it: its direction is the road's normal, its
//! length the way in heights of the camera. Weights leave out what stands on the road.
//!
//! Near the vehicle a fast road moves too far to be followed, or a compressed video keeps it where it was, and a corner is found again
//! where it had been; so is one of a vehicle ahead. Nothing is seen through the road: what is nearer to not having moved at all than to
//! moving as the plane does is none of it.

use fingerpost::attitude::{CameraMotion, RayPair};
use nalgebra::{Matrix3, Vector3};

use super::angles::MAD_TO_SIGMA;

/// The plane as one pair of frames shows it.
#[derive(Debug, Clone, Copy)]
pub(super) struct RoadPlane {
    /// Normal towards the road in the older camera frame, times the way in heights of the camera.
    pub(super) way: Vector3<f64>,
    /// Its information (inverse covariance).
    pub(super) information: Matrix3<f64>,
}

/// One pair's share.
#[derive(Debug, Clone, Copy)]
struct Parallax {
    ray: Vector3<f64>,
    /// Way over depth, and the flow in radians for a unit of it.
    way_over_depth: f64,
    flow_rad: f64,
}

/// Memory of the fit.
#[derive(Debug, Default)]
pub(super) struct PlaneFit {
    parallaxes: Vec<Parallax>,
    sizes: Vec<f64>,
}

/// The road that is looked at, metres ahead of the camera and to its sides.
pub(super) const AHEAD_M: [f64; 2] = [2.0, 25.0];
const ASIDE_M: f64 = 3.5;
const LEAST_PAIRS: usize = 12;
/// Of them those that move as the plane does: twice the unknowns.
const LEAST_MOVED: usize = 6;
const ITERATIONS: usize = 12;
const WEIGHT_SIGMAS: f64 = 2.0;
/// Least standard deviation of a flow along its line, radians: a few hundredths of a pixel.
const SIGMA_FLOOR_RAD: f64 = 1e-4;
/// Standard deviation of the normal about the one that is expected, radians: keeps a road without texture near it.
const NORMAL_SIGMA_RAD: f64 = 0.05;

impl PlaneFit {
    /// Fits the plane to the pairs that would lie on the road if its normal in the camera frame were `expected`.
    pub(super) fn fit(
        &mut self,
        pairs: &[RayPair],
        motion: &CameraMotion,
        expected: Vector3<f64>,
        height_m: f64,
    ) -> Option<RoadPlane> {
        let travel = motion.travel.into_inner();
        let turn = motion.current_from_previous.to_rotation_matrix();
        let forward = (travel - expected * travel.dot(&expected)).try_normalize(1e-6)?;
        let right = expected.cross(&forward);
        self.parallaxes.clear();
        for pair in pairs {
            let depth = height_m / pair.previous.dot(&expected);
            let (ahead, aside) = (depth * pair.previous.dot(&forward), depth * pair.previous.dot(&right));
            if !(depth > 0.0 && (AHEAD_M[0]..=AHEAD_M[1]).contains(&ahead) && aside.abs() <= ASIDE_M) {
                continue;
            }
            let (turned, across) = (turn * pair.previous, travel.cross(&pair.current));
            let flow_rad = across.norm();
            let way_over_depth = turned.cross(&pair.current).dot(&across) / (flow_rad * flow_rad);
            if flow_rad > 1e-3 && way_over_depth > 0.0 {
                self.parallaxes.push(Parallax { ray: pair.previous, way_over_depth, flow_rad });
            }
        }
        if self.parallaxes.len() < LEAST_PAIRS {
            return None;
        }
        // The way alone, by the median, begins the fit.
        self.sizes.clear();
        self.sizes.extend(self.parallaxes.iter().map(|p| p.way_over_depth / p.ray.dot(&expected)));
        let mut way = expected * median(&mut self.sizes);
        let mut information = Matrix3::zeros();
        for _ in 0..ITERATIONS {
            self.sizes.clear();
            let moved = self.parallaxes.iter().filter(|parallax| parallax.moves_with(&way));
            self.sizes.extend(moved.map(|parallax| parallax.residual(&way).abs()));
            if self.sizes.len() < LEAST_MOVED {
                return None;
            }
            let sigma = (MAD_TO_SIGMA * median(&mut self.sizes)).max(SIGMA_FLOOR_RAD);
            let length = way.norm();
            let across = Matrix3::identity() - expected * expected.transpose();
            information = across / (NORMAL_SIGMA_RAD * length).powi(2);
            let mut right_side = information * (expected * length);
            for parallax in self.parallaxes.iter().filter(|parallax| parallax.moves_with(&way)) {
                let x = parallax.residual(&way) / (WEIGHT_SIGMAS * sigma);
                let weight = (1.0 + x * x).powi(-2) * (parallax.flow_rad / sigma).powi(2);
                information += weight * parallax.ray * parallax.ray.transpose();
                right_side += weight * parallax.way_over_depth * parallax.ray;
            }
            way = information.cholesky()?.solve(&right_side);
        }
        way.iter().all(|value| value.is_finite()).then_some(RoadPlane { way, information })
    }
}

impl Parallax {
    /// Flow that a plane leaves unexplained, radians.
    fn residual(&self, way: &Vector3<f64>) -> f64 {
        (self.way_over_depth - way.dot(&self.ray)) * self.flow_rad
    }

    /// Whether that is less than what no motion at all would leave.
    fn moves_with(&self, way: &Vector3<f64>) -> bool {
        self.residual(way).abs() < self.way_over_depth * self.flow_rad
    }
}

impl RoadPlane {
    /// The way in heights of the camera when the plane's normal is known to be `normal`.
    pub(super) fn way_with_normal(&self, normal: &Vector3<f64>) -> f64 {
        let toward = self.information * normal;
        toward.dot(&self.way) / toward.dot(normal)
    }
}

fn median(values: &mut [f64]) -> f64 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use nalgebra::{Unit, UnitQuaternion};

    use super::*;

    /// Pairs of a level camera that drives `way` heights ahead over the road; of those nearer than `stuck_m` every one but each
    /// `seen_each`-th is found again where it had been.
    fn pairs(way: f64, stuck_m: f64, seen_each: usize) -> Vec<RayPair> {
        // As dense in the picture near the vehicle as far from it.
        let ahead_m = |row: i32| 1.0 / (0.22 - 0.006 * f64::from(row));
        let places = (0..30).flat_map(|row| (-3..=3).map(move |column| (ahead_m(row), f64::from(column))));
        let rays = places.enumerate().map(|(index, (ahead_m, aside_m))| {
            let road = Vector3::new(aside_m, 1.2, ahead_m);
            let travelled = if ahead_m < stuck_m && index % seen_each != 0 { 0.012 } else { 1.2 * way };
            // Two pixels of noise that repeats in what moved.
            let noise_rad = if travelled < 0.1 { 1e-4 } else { 2e-3 };
            let noise = noise_rad * ((index * 7 % 11) as f64 / 5.0 - 1.0);
            let current = road - travelled * Vector3::z();
            RayPair {
                previous: road.normalize(),
                current: (current.normalize() + noise * Vector3::x() + noise * Vector3::y()).normalize(),
            }
        });
        rays.collect()
    }

    #[test]
    fn what_stays_where_it_was_is_no_road() {
        let motion = CameraMotion {
            current_from_previous: UnitQuaternion::identity(),
            travel: Unit::new_unchecked(Vector3::z()),
            rotation_sigma_rad: Vector3::repeat(1e-4),
            travel_sigma_rad: [1e-3; 2],
            agreeing: 0.8,
            telling: 30,
        };
        for way in [0.2, 0.5, 0.98, 1.5] {
            for (stuck_m, seen_each) in [(0.0, 1), (5.5, 1000), (6.5, 1000), (7.2, 1000), (8.0, 3)] {
                let pairs = pairs(way, stuck_m, seen_each);
                let plane = PlaneFit::default().fit(&pairs, &motion, Vector3::y(), 1.2).expect("a road");
                let found = plane.way_with_normal(&Vector3::y());
                assert!((found / way - 1.0).abs() < 0.05, "{way} as {found}, stuck to {stuck_m} m");
            }
        }
    }
}
