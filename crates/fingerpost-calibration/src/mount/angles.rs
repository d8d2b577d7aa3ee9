//! Pitch, yaw and roll as means over a drive, with standard deviations that its waves and pushes leave.

use fingerpost::attitude::{Sighting, angles_of_travel};
use fingerpost_geometry::Mount;
use nalgebra::Vector3;

use super::road_plane::RoadPlane;
use super::{DEGREE, Estimated, LEAST_ROAD};

/// Frames that share what a wave of the road or a push of the brakes does to them.
const BLOCK: usize = 10;
/// Standard deviation that no number of frames takes away: how far a vehicle's mean direction of travel is from the road's
/// plane and from its own axis (load, tyres, a side slope).
const TRAVEL_FLOOR_RAD: f64 = 0.1 * DEGREE;
/// The same of the road's plane: a street is crowned by 2.5 %, of which a lane shows a part, and its slope changes ahead.
const ROAD_PITCH_FLOOR_RAD: f64 = 0.3 * DEGREE;
const ROAD_ROLL_FLOOR_RAD: f64 = 0.7 * DEGREE;
/// Place of the camera ahead of the rear axle, metres, where the calibration has none, and how far off it may be: in a bend
/// the camera moves towards the outside by this over the radius.
const USUAL_X_M: f64 = 1.5;
const X_SIGMA_M: f64 = 1.0;
/// Median absolute deviation to standard deviation of a Gaussian.
pub(super) const MAD_TO_SIGMA: f64 = 1.4826;
/// Frames further from the mean count as being there.
const OUTLIER_SIGMAS: f64 = 3.0;
const ITERATIONS: usize = 5;

/// Pitch from the directions of travel.
pub(super) fn pitch_of_travel(moving: &[&Sighting], roll_rad: f64) -> Estimated {
    let seen: Vec<Estimated> = moving
        .iter()
        .map(|sighting| Estimated {
            value: angles_of_travel(&sighting.motion.travel, roll_rad).0,
            sigma: sighting.motion.travel_sigma_rad[0],
        })
        .collect();
    mean_of_drive(&seen, TRAVEL_FLOOR_RAD)
}

/// Yaw from the directions of travel: where the road bends, the camera, ahead of the rear axle, moves towards the outside.
pub(super) fn yaw_of_travel(straight: &[&Sighting], mount: &Mount, way_m: f64) -> Estimated {
    let yaw = |sighting: &&Sighting| angles_of_travel(&sighting.motion.travel, mount.roll_rad).1;
    let middle = straight.iter().map(yaw).sum::<f64>() / straight.len() as f64;
    let x_m = if mount.x_m > 0.0 { mount.x_m } else { USUAL_X_M };
    // A line through yaw over curvature, its slope known roughly.
    let curvature = |sighting: &&Sighting| sighting.turn_rad / way_m;
    let mean = straight.iter().map(curvature).sum::<f64>() / straight.len() as f64;
    let (mut information, mut product) = ((TRAVEL_FLOOR_RAD / X_SIGMA_M).powi(2), 0.0);
    for sighting in straight {
        let from_mean = curvature(sighting) - mean;
        information += from_mean * from_mean;
        product += from_mean * (yaw(sighting) - middle + x_m * from_mean);
    }
    let lever_m = product / information - x_m;
    let seen: Vec<Estimated> = straight
        .iter()
        .map(|sighting| Estimated {
            value: yaw(sighting) - lever_m * curvature(sighting),
            sigma: sighting.motion.travel_sigma_rad[1],
        })
        .collect();
    mean_of_drive(&seen, TRAVEL_FLOOR_RAD)
}

/// Pitch and roll of the road's planes; none where too few frames show one.
pub(super) fn road_angles(roads: &[RoadPlane]) -> Option<(Estimated, Estimated)> {
    if roads.len() < LEAST_ROAD {
        return None;
    }
    let angle = |of: fn((f64, f64)) -> f64, floor: f64| {
        let seen: Vec<Estimated> = roads
            .iter()
            .map(|plane| {
                let spread = plane.information.try_inverse().map_or(f64::INFINITY, |c| c.diagonal().max());
                Estimated { value: of(angles_of_normal(&plane.way)), sigma: spread.sqrt() / plane.way.norm() }
            })
            .collect();
        mean_of_drive(&seen, floor)
    };
    Some((
        angle(|(pitch_rad, _)| pitch_rad, ROAD_PITCH_FLOOR_RAD),
        angle(|(_, roll_rad)| roll_rad, ROAD_ROLL_FLOOR_RAD),
    ))
}

/// Pitch and roll of a mount that sees the road's normal (camera frame, towards the road) there.
fn angles_of_normal(normal: &Vector3<f64>) -> (f64, f64) {
    let level = Mount::level(1.0).vehicle_from_camera().rotation * normal.normalize();
    (libm::asin(level.x.clamp(-1.0, 1.0)), libm::atan2(-level.y, -level.z))
}

/// Mean over a drive, with outliers weighed down, and its standard deviation: that of the means of blocks of frames, because
/// neighbouring frames share their errors.
fn mean_of_drive(seen: &[Estimated], floor: f64) -> Estimated {
    let mut values: Vec<f64> = seen.iter().map(|frame| frame.value).collect();
    values.sort_unstable_by(f64::total_cmp);
    let median = values[values.len() / 2];
    values.iter_mut().for_each(|value| *value = (*value - median).abs());
    values.sort_unstable_by(f64::total_cmp);
    let scatter = (MAD_TO_SIGMA * values[values.len() / 2]).max(1e-4);
    let mut mean = median;
    let weight = |frame: &Estimated, mean: f64| {
        let away = (frame.value - mean).abs() / (OUTLIER_SIGMAS * scatter);
        let robust = if away > 1.0 { 1.0 / away } else { 1.0 };
        robust / (scatter * scatter + frame.sigma * frame.sigma)
    };
    let mean_about = |frames: &[Estimated], about: f64| {
        let total: f64 = frames.iter().map(|frame| weight(frame, about)).sum();
        (frames.iter().map(|frame| weight(frame, about) * frame.value).sum::<f64>() / total, total)
    };
    for _ in 0..ITERATIONS {
        mean = mean_about(seen, mean).0;
    }
    let blocks: Vec<(f64, f64)> = seen.chunks(BLOCK).map(|block| mean_about(block, mean)).collect();
    let total: f64 = blocks.iter().map(|(_, weight)| weight).sum();
    let squares: f64 = blocks.iter().map(|(block, weight)| (weight * (block - mean)).powi(2)).sum();
    let count = blocks.len() as f64;
    let of_mean = if count > 1.0 { (squares * count / (count - 1.0)).sqrt() / total } else { scatter };
    Estimated { value: mean, sigma: libm::hypot(of_mean, floor) }
}

/// Two estimates of the same angle as one.
pub(super) fn joined(a: Estimated, b: Estimated) -> Estimated {
    let (of_a, of_b) = (a.sigma.powi(-2), b.sigma.powi(-2));
    Estimated {
        value: (of_a * a.value + of_b * b.value) / (of_a + of_b),
        sigma: (of_a + of_b).sqrt().recip(),
    }
}
