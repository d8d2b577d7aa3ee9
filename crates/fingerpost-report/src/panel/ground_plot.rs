//! A ground view laid on a canvas: where places on the road come to lie, metre lines, what is not seen.

use fingerpost_geometry::{GroundGrid, GroundPixel};
use fingerpost_vision::picture::{Plane, Rect};
use nalgebra::Point2;

use crate::draw::{Canvas, Paint, TextSize, text_width_px};
use crate::palette::{self, Rgb};

/// Distance between metre lines, metres.
const LINE_STEP_M: f64 = 5.0;
/// Pixels of the canvas from one hatch line of the unseen part to the next.
const HATCH_PX: f64 = 9.0;

/// The raster of the ground view on an area of a canvas.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GroundPlot<'a> {
    pub(crate) grid: &'a GroundGrid,
    pub(crate) area: Rect,
}

impl<'a> GroundPlot<'a> {
    pub(crate) const fn new(grid: &'a GroundGrid, area: Rect) -> Self {
        Self { grid, area }
    }

    /// Pixels of the canvas along a pixel of the ground view.
    pub(crate) fn scale(&self) -> f64 {
        self.area.width as f64 / self.grid.columns() as f64
    }

    /// Where a pixel of the ground view lies on the canvas.
    pub(crate) fn at_pixel(&self, [column, row]: [f64; 2]) -> [f64; 2] {
        let scale_y = self.area.height as f64 / self.grid.rows() as f64;
        [
            self.area.x as f64 + (column + 0.5) * self.scale() - 0.5,
            self.area.y as f64 + (row + 0.5) * scale_y - 0.5,
        ]
    }

    /// Where a place on the road (vehicle frame, metres) lies on the canvas.
    pub(crate) fn at(&self, p_in_vehicle: Point2<f64>) -> [f64; 2] {
        let GroundPixel { column, row } = self.grid.ground_from_vehicle(p_in_vehicle);
        self.at_pixel([column, row])
    }

    /// The four corners of a rectangle of the ground view and the first again.
    pub(crate) fn outline(&self, rect: Rect) -> [[f64; 2]; 5] {
        let (left, top) = (rect.x as f64 - 0.5, rect.y as f64 - 0.5);
        let (right, bottom) = (left + rect.width as f64, top + rect.height as f64);
        [[left, top], [right, top], [right, bottom], [left, bottom], [left, top]].map(|c| self.at_pixel(c))
    }

    /// Fills the area with a colour for every seen pixel and a hatch for the others.
    pub(crate) fn raster(
        &self,
        canvas: &mut Canvas,
        validity: &Plane<u8>,
        colour_at: impl Fn(usize, usize) -> Rgb,
    ) {
        let period = (HATCH_PX / self.scale()).round().max(2.0) as usize;
        canvas.picture(self.area, (self.grid.columns(), self.grid.rows()), |column, row| {
            match validity.get(column, row) {
                Some(seen) if seen != 0 => colour_at(column, row),
                _ if (column + row) % period < period.div_ceil(5) => palette::UNSEEN_HATCH,
                _ => palette::UNSEEN,
            }
        });
    }

    /// Faint lines every five metres ahead and to the sides, with their distances.
    pub(crate) fn metre_lines(&self, canvas: &mut Canvas) {
        let grid = self.grid;
        let paint = Paint::glaze(palette::GRID_LINE, 0.22);
        // Lines on the very edge would have no room for their label.
        let multiples = |from: f64, to: f64| {
            (from / LINE_STEP_M + 1e-9).ceil() as i64..=(to / LINE_STEP_M - 1e-9).floor() as i64
        };
        canvas.clipped(self.area, |canvas| {
            let right = (self.area.x + self.area.width) as f64;
            let bottom = (self.area.y + self.area.height) as f64;
            for k in multiples(grid.near_m(), grid.far_m()) {
                let forward_m = LINE_STEP_M * k as f64;
                let y = self.at(Point2::new(forward_m, 0.0))[1];
                canvas.polyline(&[[self.area.x as f64, y], [right, y]], 1.0, paint);
                let text = format!("{forward_m:.0} m");
                canvas.label([self.area.x as f64, y - 8.0], TextSize::Small, palette::TEXT, &text);
            }
            for k in multiples(-grid.half_width_m(), grid.half_width_m()) {
                let left_m = LINE_STEP_M * k as f64;
                let x = self.at(Point2::new(grid.near_m(), left_m))[0];
                canvas.polyline(&[[x, self.area.y as f64], [x, bottom]], 1.0, paint);
                if k != 0 {
                    let text = format!("{:.0} {}", left_m.abs(), if k > 0 { "left" } else { "right" });
                    let half = 0.5 * text_width_px(TextSize::Small, &text) as f64;
                    canvas.label([x - half - 3.0, bottom], TextSize::Small, palette::TEXT_DIM, &text);
                }
            }
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_lie_where_their_pixels_are_drawn() {
        let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let plot = GroundPlot::new(&grid, Rect { x: 100, y: 50, width: 200, height: 160 });
        let [x, y] = plot.at(Point2::new(12.0, 5.0));
        assert!((x - 149.5).abs() < 1e-9, "5 m left is a quarter of the width: {x}");
        assert!((y - 129.5).abs() < 1e-9, "12 m ahead is the middle: {y}");

        let mut canvas = Canvas::new(400, 300, [0; 3]);
        let seen = Plane::new(400, 320, 1);
        plot.raster(
            &mut canvas,
            &seen,
            |column, row| if column < 100 && row < 160 { [255; 3] } else { [0; 3] },
        );
        let image = canvas.into_image();
        assert_eq!(image.get(149, 129), Some([255; 3]), "left of it and beyond");
        assert_eq!(image.get(150, 129), Some([0; 3]));
        assert_eq!(image.get(149, 130), Some([0; 3]));
    }
}
