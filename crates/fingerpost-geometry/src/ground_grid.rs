//! The ground view's raster: which pixel of the top-down picture is which place on the road.

use nalgebra::Point2;

use crate::GeometryError;
use crate::error::check_range;

/// A place in the `ground` frame: pixels, origin at the centre of the top-left pixel, far is up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundPixel {
    /// Pixels to the right.
    pub column: f64,
    /// Pixels down, towards the vehicle.
    pub row: f64,
}

/// The part of the road plane that the ground view shows, and its scale (paper 2, section 3.1).
///
/// ```
/// use fingerpost_geometry::GroundGrid;
/// use nalgebra::Point2;
/// let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
/// assert_eq!((grid.columns(), grid.rows()), (400, 320));
/// let pixel = grid.ground_from_vehicle(Point2::new(10.0, 2.0));
/// assert!((pixel.column - 159.5).abs() < 1e-9 && (pixel.row - 199.5).abs() < 1e-9);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GroundGrid {
    near_m: f64,
    far_m: f64,
    half_width_m: f64,
    metres_per_pixel: f64,
    columns: usize,
    rows: usize,
}

/// Largest side of a ground view, pixels; beyond it neither time nor memory suffices on the machines this is for.
const MAX_SIDE_PX: f64 = 4096.0;

impl GroundGrid {
    /// A ground view from `near_m` to `far_m` ahead of the vehicle's origin and `half_width_m` to either side.
    ///
    /// # Errors
    /// [`GeometryError::OutOfRange`] for limits that leave no picture or one over 4096 pixels.
    pub fn new(
        near_m: f64,
        far_m: f64,
        half_width_m: f64,
        metres_per_pixel: f64,
    ) -> Result<Self, GeometryError> {
        check_range(
            "ground_view.metres_per_pixel",
            metres_per_pixel,
            0.005,
            1.0,
            "0.005 to 1 metre a pixel",
        )?;
        check_range("ground_view.near_m", near_m, -10.0, 200.0, "-10 to 200 metres ahead")?;
        check_range(
            "ground_view.far_m",
            far_m,
            near_m + 1.0,
            300.0,
            "1 metre beyond near_m, up to 300 metres",
        )?;
        check_range("ground_view.half_width_m", half_width_m, 0.5, 100.0, "0.5 to 100 metres")?;
        let (columns, rows) =
            ((2.0 * half_width_m / metres_per_pixel).round(), ((far_m - near_m) / metres_per_pixel).round());
        let sides = "a ground view of 16 to 4096 pixels; change its limits or metres_per_pixel";
        check_range("ground_view columns", columns, 16.0, MAX_SIDE_PX, sides)?;
        check_range("ground_view rows", rows, 16.0, MAX_SIDE_PX, sides)?;
        let (columns, rows) = (columns as usize, rows as usize);
        Ok(Self { near_m, far_m, half_width_m, metres_per_pixel, columns, rows })
    }

    /// Width of the ground view, pixels.
    pub const fn columns(&self) -> usize {
        self.columns
    }

    /// Height of the ground view, pixels.
    pub const fn rows(&self) -> usize {
        self.rows
    }

    /// Scale, metres per pixel.
    pub const fn metres_per_pixel(&self) -> f64 {
        self.metres_per_pixel
    }

    /// Distance of the lower edge ahead of the vehicle's origin, metres.
    pub const fn near_m(&self) -> f64 {
        self.near_m
    }

    /// Distance of the upper edge ahead of the vehicle's origin, metres.
    pub const fn far_m(&self) -> f64 {
        self.far_m
    }

    /// Distance of the left and right edge from the vehicle's centre line, metres.
    pub const fn half_width_m(&self) -> f64 {
        self.half_width_m
    }

    /// The pixel that shows a place (vehicle frame, metres); it may lie outside the view.
    pub fn ground_from_vehicle(&self, p_in_vehicle: Point2<f64>) -> GroundPixel {
        GroundPixel {
            column: (self.half_width_m - p_in_vehicle.y) / self.metres_per_pixel - 0.5,
            row: (self.far_m - p_in_vehicle.x) / self.metres_per_pixel - 0.5,
        }
    }

    /// The place (vehicle frame, metres) that a pixel shows.
    pub fn vehicle_from_ground(&self, pixel: GroundPixel) -> Point2<f64> {
        Point2::new(
            self.far_m - (pixel.row + 0.5) * self.metres_per_pixel,
            self.half_width_m - (pixel.column + 0.5) * self.metres_per_pixel,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_is_up_and_left_is_left() {
        let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let at = |x, y| grid.ground_from_vehicle(Point2::new(x, y));
        assert!(at(19.0, 0.0).row < at(5.0, 0.0).row);
        assert!(at(10.0, 3.0).column < at(10.0, -3.0).column);
        let corner = grid.vehicle_from_ground(GroundPixel { column: 0.0, row: 0.0 });
        assert!((corner - Point2::new(19.975, 9.975)).norm() < 1e-12, "the corner pixel's centre");
        let back = grid.vehicle_from_ground(at(7.3, -2.1));
        assert!((back - Point2::new(7.3, -2.1)).norm() < 1e-12);
    }

    #[test]
    fn impossible_views_are_refused() {
        assert!(GroundGrid::new(20.0, 4.0, 10.0, 0.05).is_err());
        assert!(GroundGrid::new(4.0, 20.0, 10.0, 0.0).is_err());
        assert!(GroundGrid::new(4.0, f64::NAN, 10.0, 0.05).is_err());
        assert!(GroundGrid::new(4.0, 290.0, 10.0, 0.05).is_err(), "5720 rows");
    }
}
