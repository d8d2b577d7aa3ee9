//! Reading an edge's places from the picture, row by row, where the lane is expected.
//!
//! What the paint looks like says which places are the edge's (`look`), a line inside it that a marking is double
//! (`inner_line`), and the fit how well it was read (`quality`); `candidate` measures the paint along a line not yet followed.

mod candidate;
mod inner_line;
mod look;
mod quality;

use std::ops::Range;

use fingerpost_geometry::{Camera, Pixel};
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point2;

use super::Side;
use super::lane_filter::{EdgePoint, LaneFilter};
use super::paint::{PaintEdge, PaintFinder, PaintSearch};
use super::region::LaneRegion;
use super::road_view::RoadView;

pub(super) use self::candidate::PaintAlong;
pub(super) use self::look::PaintLook;
pub(super) use self::quality::{Quality, USED_WEIGHT};
pub use self::quality::{Traced, TracedPoint};

/// Rows between two readings near the vehicle and at the far end, share of the picture's height.
const NEAR_ROWS_SHARE: f64 = 0.011;
const FAR_ROWS_SHARE: f64 = 0.0042;
/// Standard deviation of a place's column, pixels, and what is added for a blurred far edge, share of a marking's width.
const COLUMN_SIGMA_PX: f64 = 0.6;
/// How much the road's unevenness moves an edge, metres.
const GROUND_SIGMA_M: f64 = 0.012;
/// The place of a step weaker than this share of the edge's strong ones counts less and less.
const WEAK_SHARE: f64 = 0.6;
/// Paint that ends on both sides within this length of road is a speck: a reflector beside a line, a stone, metres.
const SPECK_M: f64 = 0.5;
/// How far beside its line's edge a speck may lie, metres.
const SPECK_SIGMA_M: f64 = 0.1;
/// Farthest reach of a search, metres across the lane, and least, pixels.
const MOST_REACH_M: f64 = 0.45;
const LEAST_REACH_PX: f64 = 3.0;
/// Where the inner line of a double marking can be, metres inside the outer one's inner edge.
const INNER_M: [f64; 2] = [0.12, 0.50];
/// Rows that must show a second line for it to be one.
const INNER_ROWS: usize = 4;
/// How much further a search reaches that starts from a straight line, metres.
const SEED_EXTRA_M: f64 = 0.10;
/// Share of the way to the second line of a double marking that a search reaches at most.
const SECOND_SHARE: f64 = 0.4;
/// Searches reach so many standard deviations.
const REACH_SIGMAS: f64 = 2.5;

/// How far to either side of its expected place an edge is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Reach {
    /// As far as it may be off, and more, because all that is known is a straight line.
    Seed,
    /// As far as it may be off, but not as far as the second line of a double marking.
    Follow(PaintLook),
}

/// Paint found in a row.
#[derive(Debug, Clone, Copy)]
pub(super) struct Reading {
    pub(super) row: f64,
    pub(super) ahead_m: f64,
    pub(super) expected_u: f64,
    pub(super) reach_px: f64,
    pub(super) px_per_m: f64,
    pub(super) paint: Option<PaintEdge>,
}

impl Reading {
    /// How far outside its inner edge another line's runs, metres, where one does as in a double marking.
    fn second_m(&self) -> Option<f64> {
        let second_m = self.paint?.second_px? / self.px_per_m;
        (INNER_M[0]..=INNER_M[1]).contains(&second_m).then_some(second_m)
    }
}

/// Reads edges, with the buffers that it needs.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    paint: PaintFinder,
    rows: Vec<usize>,
    /// Of either side.
    pub(super) readings: [Vec<Reading>; 2],
    points: Vec<EdgePoint>,
    steps: Vec<f64>,
    /// Of a line inside an edge: how far inside, and the length of road that a row stands for, metres.
    inner: Vec<[f64; 2]>,
}

impl Tracer {
    /// How many rows are read at the most.
    pub(super) const fn row_count(&self) -> usize {
        self.rows.len()
    }

    /// Chooses the rows to be read, from the base upwards.
    pub(super) fn lay_rows(&mut self, region: &LaneRegion) {
        self.rows.clear();
        let height = region.base_row as f64;
        let span = (region.base_row - region.read_top_row) as f64;
        let mut row = height - 1.0;
        while row >= region.read_top_row as f64 {
            self.rows.push(row as usize);
            let near = (row - region.read_top_row as f64) / span;
            row -= (height * (FAR_ROWS_SHARE + near * (NEAR_ROWS_SHARE - FAR_ROWS_SHARE))).max(1.0);
        }
    }

    /// Reads one edge along the filter's lane.
    pub(super) fn read(
        &mut self,
        camera: &Camera,
        filter: &LaneFilter,
        frame: &RgbImage,
        side: Side,
        reach: Reach,
    ) {
        let view = RoadView::new(camera, filter.pitch_rad());
        let middle = (camera.width() - 1) as f64 / 2.0;
        let readings = &mut self.readings[side.index()];
        readings.clear();
        for &row in &self.rows {
            let Some(below) = view.ground_of_pixel(Pixel::new(middle, row as f64)) else { continue };
            let place = Point2::new(below.x, filter.left_at(side, below.x));
            let ends = [0.25, -0.25].map(|d| view.pixel_of_ground(Point2::new(place.x, place.y + d)));
            let (Some(expected), [Some(left), Some(right)]) = (view.pixel_of_ground(place), ends) else {
                continue;
            };
            let px_per_m = 2.0 * (right.u - left.u);
            // With a rolled camera or a bent lens the place lies in another row; the next one makes up for it.
            let row_read = expected.v.round();
            if px_per_m <= 0.0 || !(0.0..frame.height() as f64).contains(&row_read) {
                continue;
            }
            let sigma_m = filter.left_sigma_m(side, place.x);
            let reach_m = match reach {
                Reach::Seed => REACH_SIGMAS * sigma_m + SEED_EXTRA_M,
                Reach::Follow(look) => {
                    let most_m = look.second_m.map_or(MOST_REACH_M, |second_m| SECOND_SHARE * second_m);
                    (REACH_SIGMAS * sigma_m).min(most_m)
                }
            };
            let reach_px = (reach_m.min(MOST_REACH_M) * px_per_m).max(LEAST_REACH_PX);
            let second_px = match reach {
                Reach::Follow(look) => look.second_m.map_or(f64::INFINITY, |second_m| second_m * px_per_m),
                Reach::Seed => f64::INFINITY,
            };
            // So far away the lines of a double marking cannot be told apart.
            if second_px < 2.0 * LEAST_REACH_PX {
                continue;
            }
            let search = PaintSearch { side, expected_u: expected.u, reach_px, px_per_m };
            let paint = self.paint.find(frame.row(row_read as usize), &search);
            let paint = paint.filter(|paint| (paint.u - expected.u).abs() <= reach_px + 1.0);
            readings.push(Reading {
                row: row_read,
                ahead_m: place.x,
                expected_u: expected.u,
                reach_px,
                px_per_m,
                paint,
            });
        }
    }

    /// Takes what was read of `sides` into the filter; `looks` are those of the left and right paint. The points stay for
    /// [`Self::quality`] and [`Self::evidence`].
    pub(super) fn fit(
        &mut self,
        camera: &Camera,
        filter: &mut LaneFilter,
        sides: &[Side],
        looks: [PaintLook; 2],
    ) {
        self.points.clear();
        for &side in sides {
            let weak = WEAK_SHARE * looks[side.index()].step;
            let readings = &self.readings[side.index()];
            for piece in pieces(readings) {
                let is_speck = length_m(readings, &piece) < SPECK_M;
                let speck_m = if is_speck { SPECK_SIGMA_M } else { 0.0 };
                self.points.extend(readings[piece].iter().filter_map(|reading| {
                    let paint = reading.paint?;
                    let faint = (weak / paint.step).max(1.0);
                    Some(EdgePoint {
                        side,
                        pixel: Pixel::new(paint.u, reading.row),
                        sigma_px: libm::hypot(COLUMN_SIGMA_PX, GROUND_SIGMA_M * reading.px_per_m) * faint,
                        column_sigma_px: libm::hypot(COLUMN_SIGMA_PX, speck_m * reading.px_per_m) * faint,
                        weight: 0.0,
                    })
                }));
            }
        }
        filter.update(camera, &mut self.points);
    }

    /// The points of the last fit.
    pub(super) fn points(&self) -> &[EdgePoint] {
        &self.points
    }
}

/// The rows in a row that show paint.
fn pieces(readings: &[Reading]) -> impl Iterator<Item = Range<usize>> {
    let mut next = 0;
    std::iter::from_fn(move || {
        let first = next + readings.get(next..)?.iter().position(|reading| reading.paint.is_some())?;
        let count = readings[first..].iter().position(|reading| reading.paint.is_none());
        next = count.map_or(readings.len(), |count| first + count);
        Some(first..next)
    })
}

/// The length of road that the rows of a piece stand for, metres; endless where it goes on beyond the last row.
fn length_m(readings: &[Reading], piece: &Range<usize>) -> f64 {
    readings.get(piece.end).map_or(f64::INFINITY, |after| after.ahead_m - readings[piece.start].ahead_m)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::PaintSides;

    /// Rows half a metre apart that show paint where `painted` has a mark.
    fn readings(painted: &str) -> Vec<Reading> {
        let paint =
            PaintEdge { u: 0.0, width_px: 8.0, step: 100.0, second_px: None, sides: PaintSides::default() };
        let reading = |(index, mark): (usize, char)| Reading {
            row: 400.0 - index as f64,
            ahead_m: 6.0 + 0.5 * index as f64,
            expected_u: 0.0,
            reach_px: 10.0,
            px_per_m: 100.0,
            paint: (mark == '#').then_some(paint),
        };
        painted.chars().enumerate().map(reading).collect()
    }

    #[test]
    fn paint_lies_in_pieces_and_the_last_one_may_go_on() {
        let readings = readings("..###.#..##");
        let found: Vec<_> =
            pieces(&readings).map(|piece| (piece.clone(), length_m(&readings, &piece))).collect();
        assert_eq!(found, [(2..5, 1.5), (6..7, 0.5), (9..11, f64::INFINITY)]);
        assert_eq!(pieces(&[]).count(), 0);
    }
}
