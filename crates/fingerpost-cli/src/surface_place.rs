//! The road surface at a place ahead of the vehicle.

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::picture::Plane;
use nalgebra::Point2;

/// The probability of road at a place of the vehicle frame, 0 to 1; none where the camera does not show it.
pub(crate) fn probability_at(
    grid: &GroundGrid,
    probability: &Plane<u8>,
    validity: &Plane<u8>,
    [forward_m, left_m]: [f64; 2],
) -> Option<f64> {
    let pixel = grid.ground_from_vehicle(Point2::new(forward_m, left_m));
    if pixel.column < -0.5 || pixel.row < -0.5 {
        return None;
    }
    let (column, row) = (pixel.column.round() as usize, pixel.row.round() as usize);
    validity.get(column, row).filter(|&seen| seen != 0)?;
    probability.get(column, row).map(|p| f64::from(p) / 255.0)
}
