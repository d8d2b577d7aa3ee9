//! A start for the flow: which of many motions explains the new ground view best, roughly.
//!
//! Dense flow finds displacements up to a few window widths; a vehicle at 15 m/s and ten frames a second moves 30
//! pixels. Candidates are compared by the mean absolute difference of grey over a coarse grid of pixels.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::picture::{Plane, Rect};
use nalgebra::{Isometry2, Vector2};

/// Every how many pixels grey is compared; about a quarter of the texture's size at 0.05 m a pixel.
const STRIDE_PX: usize = 4;
/// Farthest the vehicle is taken to move in a frame, metres: 50 m/s at ten frames a second would be 5.
const MAX_FORWARD_M: f64 = 4.0;
/// How far it may roll back, metres.
const MAX_BACKWARD_M: f64 = 0.6;
/// Sideways reach, metres.
const MAX_LEFT_M: f64 = 0.3;
/// Reach of the turn, radians: 50 degrees a second at ten frames a second.
const MAX_YAW_RAD: f64 = 0.09;
const STEP_M: f64 = 0.15;
const STEP_YAW_RAD: f64 = 0.03;

/// Mean absolute difference of grey when the road moved by `current_from_previous`; none when too little overlaps.
pub(super) fn difference(
    grid: &GroundGrid,
    (previous, current): (&Plane<u8>, &Plane<u8>),
    validity: &Plane<u8>,
    region: Rect,
    current_from_previous: &Isometry2<f64>,
) -> Option<f64> {
    let previous_from_current = current_from_previous.inverse();
    let place = |column: usize, row: usize| -> GroundPixel {
        let pixel = GroundPixel { column: column as f64, row: row as f64 };
        grid.ground_from_vehicle(previous_from_current * grid.vehicle_from_ground(pixel))
    };
    let (origin, right, below) =
        (place(region.x, region.y), place(region.x + 1, region.y), place(region.x, region.y + 1));
    let (mut sum, mut count, mut all) = (0_u64, 0_u64, 0_u64);
    for dy in (0..region.height).step_by(STRIDE_PX) {
        for dx in (0..region.width).step_by(STRIDE_PX) {
            all += 1;
            let (x, y) = (dx as f64, dy as f64);
            let column =
                origin.column + x * (right.column - origin.column) + y * (below.column - origin.column);
            let row = origin.row + x * (right.row - origin.row) + y * (below.row - origin.row);
            if column < 0.0 || row < 0.0 {
                continue;
            }
            let (column, row) = ((column + 0.5) as usize, (row + 0.5) as usize);
            if validity.get(column, row) != Some(1) {
                continue;
            }
            if let (Some(a), Some(b)) = (previous.get(column, row), current.get(region.x + dx, region.y + dy))
            {
                sum += u64::from(a.abs_diff(b));
                count += 1;
            }
        }
    }
    (2 * count > all).then(|| sum as f64 / count as f64)
}

/// The motion `current_from_previous` with the smallest difference over the whole reach.
pub(super) fn search(
    grid: &GroundGrid,
    pictures: (&Plane<u8>, &Plane<u8>),
    validity: &Plane<u8>,
    region: Rect,
) -> Isometry2<f64> {
    let mut best = (f64::INFINITY, Isometry2::identity());
    let steps = |low: f64, high: f64, step: f64| {
        let count = ((high - low) / step).round() as usize;
        (0..=count).map(move |i| low + (high - low) * i as f64 / count as f64)
    };
    for yaw in steps(-MAX_YAW_RAD, MAX_YAW_RAD, STEP_YAW_RAD) {
        for left in steps(-MAX_LEFT_M, MAX_LEFT_M, STEP_M) {
            for forward in steps(-MAX_BACKWARD_M, MAX_FORWARD_M, STEP_M) {
                let motion = Isometry2::new(Vector2::new(forward, left), yaw).inverse();
                match difference(grid, pictures, validity, region, &motion) {
                    Some(value) if value < best.0 => best = (value, motion),
                    _ => {}
                }
            }
        }
    }
    best.1
}
