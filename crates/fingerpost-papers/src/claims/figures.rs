//! Figures of a run against the truth: what the claims about features, surface and motion are made of.

use fingerpost::ground_view::GroundView;
use fingerpost_format::{FrameRecord, TruthRecord};
use nalgebra::{Isometry2, Point2, Vector2};

/// Features between these distances ahead count as to be followed, metres: nearer they leave the view of the camera, and
/// farther the papers' view of 15 to 20 m does not show their arms whole.
const TO_BE_FOLLOWED_M: [f64; 2] = [5.0, 12.0];
/// A feature is followed when it is this near to its true place, metres: half a car's width either side of the way.
const FOLLOWED_WITHIN_M: f64 = 1.0;
/// Places of the ground view at which the road is compared lie so far apart, metres.
const PLACES_APART_M: f64 = 0.5;

/// A place at which the road is compared.
pub struct Place {
    /// Column and row of the ground view.
    pub pixel: (usize, usize),
    /// Metres forward and left.
    pub p_in_vehicle: Point2<f64>,
}

/// Where the vehicle really is.
pub fn map_from_vehicle(truth: &TruthRecord) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(truth.x_m, truth.y_m), truth.heading_rad)
}

/// Places of the view that the camera sees, in a raster of metres that is the same for every scale.
pub fn places(view: &GroundView) -> Vec<Place> {
    let grid = view.grid();
    let steps = |from_m: f64, to_m: f64| {
        let count = ((to_m - from_m) / PLACES_APART_M).floor() as usize;
        (0..count).map(move |step| from_m + (step as f64 + 0.5) * PLACES_APART_M)
    };
    let (near, far, half) = (grid.near_m(), grid.far_m(), grid.half_width_m());
    let all = steps(near, far).flat_map(|x| steps(-half, half).map(move |y| Point2::new(x, y)));
    let seen = all.filter_map(|p_in_vehicle| {
        let pixel = grid.ground_from_vehicle(p_in_vehicle);
        let pixel = (pixel.column.round() as usize, pixel.row.round() as usize);
        let seen = view.validity().plane().get(pixel.0, pixel.1).is_some_and(|seen| seen != 0);
        seen.then_some(Place { pixel, p_in_vehicle })
    });
    seen.collect()
}

/// The truth of a record's frame: frames count from zero without gaps.
fn truth_of<'a>(record: &FrameRecord, truth: &'a [TruthRecord]) -> Option<&'a TruthRecord> {
    truth.get(usize::try_from(record.frame).ok()?)
}

/// Share of the frames with a feature to be followed in which it is, percent; none where there is no such frame.
pub fn followed_pct(records: &[FrameRecord], truth: &[TruthRecord]) -> Option<f64> {
    let (mut wanted, mut followed) = (0_u32, 0_u32);
    for record in records {
        let Some(truth) = truth_of(record, truth) else { continue };
        let (Some(forward_m), Some(left_m)) = (truth.feature_forward_m, truth.feature_left_m) else {
            continue;
        };
        if !(TO_BE_FOLLOWED_M[0]..=TO_BE_FOLLOWED_M[1]).contains(&forward_m) {
            continue;
        }
        wanted += 1;
        let is_near = record.feature.as_ref().is_some_and(|feature| {
            Some(feature.id) == truth.feature_id
                && libm::hypot(feature.forward_m - forward_m, feature.left_m - left_m) <= FOLLOWED_WITHIN_M
        });
        followed += u32::from(is_near);
    }
    (wanted > 0).then(|| 100.0 * f64::from(followed) / f64::from(wanted))
}

/// How much of the way is measured wrongly, percent: the errors of all steps forward against the way driven. To the side the mean
/// flow of a region ahead moves in every turn, however well it is measured. A step that was not measured is wrong as a whole.
/// None where the vehicle stands.
pub fn way_error_pct(records: &[FrameRecord], truth: &[TruthRecord]) -> Option<f64> {
    let (mut wrong_m, mut way_m) = (0.0, 0.0);
    for pair in records.windows(2) {
        let [Some(before), Some(now)] = [&pair[0], &pair[1]].map(|record| truth_of(record, truth)) else {
            continue;
        };
        let step = (map_from_vehicle(before).inverse() * map_from_vehicle(now)).translation.vector;
        way_m += step.norm();
        wrong_m += (pair[1].motion.map_or(0.0, |motion| motion.forward_m) - step.x).abs();
    }
    (way_m > 0.0).then(|| 100.0 * wrong_m / way_m)
}
