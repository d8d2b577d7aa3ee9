//! From the map's plane to a picture of it.

use maud::{Markup, html};
use nalgebra::Point2;

use super::chart::{joined, px, ticks};
use crate::series::{MAX_POINTS, thinned_path};

/// Room that a map has on a page, picture units.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sheet {
    pub(crate) width: f64,
    pub(crate) max_height: f64,
    pub(crate) margin: f64,
}

impl Sheet {
    /// The width of a page.
    pub(crate) const PAGE: Self = Self { width: 960.0, max_height: 520.0, margin: 34.0 };
}

/// Map frame to picture, north up.
pub(crate) struct Fit {
    sheet: Sheet,
    low: [f64; 2],
    high: [f64; 2],
    px_per_m: f64,
}

impl Fit {
    /// All points inside the sheet's margins.
    pub(crate) fn new(sheet: Sheet, points: impl IntoIterator<Item = Point2<f64>>) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for (axis, value) in [point.x, point.y].into_iter().enumerate() {
                (low[axis], high[axis]) = (low[axis].min(value), high[axis].max(value));
            }
        }
        let room = [sheet.width, sheet.max_height].map(|side| side - 2.0 * sheet.margin);
        // A route along one axis has no extent on the other.
        let px_per_m = (room[0] / (high[0] - low[0]).max(1.0)).min(room[1] / (high[1] - low[1]).max(1.0));
        Self { sheet, low, high, px_per_m }
    }

    /// Picture units for each metre.
    pub(crate) fn px_per_m(&self) -> f64 {
        self.px_per_m
    }

    pub(crate) fn at(&self, p_in_map: Point2<f64>) -> [f64; 2] {
        let Sheet { width, margin, .. } = self.sheet;
        let spare = width - 2.0 * margin - (self.high[0] - self.low[0]) * self.px_per_m;
        [
            margin + 0.5 * spare + (p_in_map.x - self.low[0]) * self.px_per_m,
            margin + (self.high[1] - p_in_map.y) * self.px_per_m,
        ]
    }

    /// Whether a line between two places of the picture may be seen in it.
    pub(crate) fn shows(&self, from: [f64; 2], to: [f64; 2]) -> bool {
        let size = [self.sheet.width, self.height()];
        (0..2).all(|axis| from[axis].max(to[axis]) >= 0.0 && from[axis].min(to[axis]) <= size[axis])
    }

    /// Height of the picture without the room for the scale bar.
    pub(crate) fn height(&self) -> f64 {
        2.0 * self.sheet.margin + (self.high[1] - self.low[1]) * self.px_per_m
    }

    /// The picture's `viewBox`, with the scale bar.
    pub(crate) fn view_box(&self) -> String {
        format!("0 0 {} {}", px(self.sheet.width), px(self.height() + 14.0))
    }

    pub(crate) fn path(&self, points: impl Iterator<Item = Point2<f64>>) -> String {
        let step = self.sheet.width / MAX_POINTS as f64;
        joined(thinned_path(points.map(|p| self.at(p)), step).into_iter())
    }

    /// A bar of a round length, about a fifth of the width.
    pub(crate) fn scale_bar(&self) -> Markup {
        // At most a third of it apart, there is a round number besides zero.
        let lengths = ticks(0.0, 0.2 * self.sheet.width / self.px_per_m, 3);
        let length_m = lengths.last().copied().unwrap_or(1.0);
        let (x, y) = (self.sheet.margin, self.height() + 2.0);
        html! {
            line class="scale" x1=(px(x)) x2=(px(x + length_m * self.px_per_m)) y1=(px(y)) y2=(px(y)) {}
            text x=(px(x)) y=(px(y - 5.0)) { (length_m) " m" }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn north_is_up_and_a_scale_bar_has_a_length_on_maps_of_any_size() {
        for kilometres in 1..100 {
            let side_m = 1e3 * f64::from(kilometres);
            let fit = Fit::new(Sheet::PAGE, [Point2::origin(), Point2::new(2.0 * side_m, side_m)]);
            assert!(fit.at(Point2::new(0.0, side_m))[1] < fit.at(Point2::origin())[1]);
            assert!(!fit.scale_bar().into_string().contains(">0 m<"), "{kilometres} km");
        }
    }

    #[test]
    fn lines_outside_the_picture_are_not_shown() {
        let fit = Fit::new(Sheet::PAGE, [Point2::origin(), Point2::new(100.0, 100.0)]);
        let shows = |from: [f64; 2], to: [f64; 2]| fit.shows(from, to);
        assert!(shows([-10.0, 5.0], [2000.0, 5.0]), "it crosses the picture");
        assert!(!shows([-10.0, 5.0], [-1.0, 500.0]) && !shows([5.0, 2000.0], [900.0, 3000.0]));
    }
}
