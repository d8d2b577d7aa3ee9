//! Reading an edge's places from the picture, row by row, where the lane is expected.

use fingerpost_geometry::{Camera, Pixel};
use fingerpost_vision::picture::RgbImage;
use nalgebra::Point2;

use super::Side;
use super::lane_filter::{EdgePoint, LaneFilter};
use super::paint::{PaintEdge, PaintFinder, PaintSearch};
use super::region::LaneRegion;
use super::road_view::RoadView;
use super::sections::{LineCandidate, extended};

/// Rows between two readings near the vehicle and at the far end, share of the picture's height.
const NEAR_ROWS_SHARE: f64 = 0.011;
const FAR_ROWS_SHARE: f64 = 0.0042;
/// Standard deviation of a place's column, pixels, and what is added for a blurred far edge, share of a marking's width.
const COLUMN_SIGMA_PX: f64 = 0.6;
/// How much the road's unevenness moves an edge, metres.
const GROUND_SIGMA_M: f64 = 0.012;
/// Steps weaker than this share of the edge's strong ones are something else: a seam, worn rubber, what an old line left.
const FAINT_SHARE: f64 = 0.33;
/// From this share down their places count less and less.
const WEAK_SHARE: f64 = 0.6;
/// How fast the memory of the strong steps fades, per frame.
const STRENGTH_KEPT: f64 = 0.97;
/// How much of a frame's width of the paint enters its memory.
const WIDTH_SHARE: f64 = 0.1;
/// Widths that paint has against its usual one; what is narrower or wider is something else.
const WIDTHS: [f64; 2] = [0.5, 1.8];
/// Share of the steps that are not among the strong ones.
const STRONG_QUANTILE: f64 = 0.75;
/// Farthest reach of a search, metres across the lane, and least, pixels.
const MOST_REACH_M: f64 = 0.45;
const LEAST_REACH_PX: f64 = 3.0;
/// Paint up to this distance is near, metres: there a bar is several pixels wide, and a broken line shows a dash.
const NEAR_M: f64 = 20.0;
/// Rows in which a candidate is looked at.
const CANDIDATE_ROWS: usize = 10;
/// Share of the rows with paint that must show a second line for a marking to be double, and below which it is none, where
/// there are so many.
const DOUBLE_SHARE: f64 = 0.25;
const SINGLE_SHARE: f64 = 0.1;
const SINGLE_ROWS: usize = 8;
/// How much further a search reaches that starts from a straight line, metres.
const SEED_EXTRA_M: f64 = 0.10;
/// Share of the way to the second line of a double marking that a search reaches at most.
const SECOND_SHARE: f64 = 0.4;
/// Where the inner line of a double marking can be, metres inside the outer one's inner edge.
const INNER_M: [f64; 2] = [0.12, 0.50];
/// Every so many rows are looked at for it.
const INNER_STEP: usize = 2;
/// What it must show: rows, a length, and how far its rows may lie apart, metres.
const INNER_ROWS: usize = 4;
const INNER_LENGTH_M: f64 = 1.5;
const INNER_SPREAD_M: f64 = 0.05;
/// Searches reach so many standard deviations.
const REACH_SIGMAS: f64 = 2.5;

/// What was found at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Traced {
    /// Paint whose edge the lane follows.
    Used,
    /// Paint that does not lie where the rest of the edge does.
    Outlier,
    /// No paint.
    Nothing,
}

/// A place at which paint was looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TracedPoint {
    /// The side of the vehicle.
    pub side: Side,
    /// Where it was found, or else expected.
    pub pixel: Pixel,
    /// Distance ahead, metres.
    pub ahead_m: f64,
    /// How far to either side it was looked for, pixels.
    pub reach_px: f64,
    /// What was found.
    pub found: Traced,
}

/// How far to either side of its expected place an edge is looked for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Reach {
    /// As far as it may be off, and more, because all that is known is a straight line.
    Seed,
    /// As far as it may be off, but not as far as the second line of a double marking.
    Follow(PaintLook),
}

/// What the paint of an edge looks like.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PaintLook {
    /// How much brighter than the road its clearer rows are, levels.
    pub(super) step: f64,
    /// Width of its line, metres; 0 before any has been seen.
    pub(super) width_m: f64,
    /// How far outside its inner edge that of a second line runs, metres, where there is one.
    pub(super) second_m: Option<f64>,
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

/// Paint that a candidate bounds.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct PaintAlong {
    /// Sum of the steps of the rows that show some, levels.
    pub(super) sum: f64,
    /// Those rows.
    pub(super) rows: usize,
}

impl PaintAlong {
    /// How much brighter than the road it is, levels.
    pub(super) fn step(self) -> f64 {
        self.sum / self.rows.max(1) as f64
    }
}

/// How well an edge was read.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Quality {
    /// Rows with paint that the fit used.
    pub(super) used: usize,
    /// Length of road with such paint, metres.
    pub(super) painted_m: f64,
    /// The part of it that is near.
    pub(super) near_m: f64,
    /// Rows with paint that it did not use.
    pub(super) outliers: usize,
    /// Root mean square distance of the used paint from the fit, in its standard deviations.
    pub(super) residual_sigmas: f64,
    /// Spread of the paint's width in metres against its mean.
    pub(super) width_spread: f64,
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
    /// Chooses the rows to be read, from the base upwards.
    pub(super) fn lay_rows(&mut self, region: &LaneRegion) {
        self.rows.clear();
        let height = region.base_row as f64;
        let span = (region.base_row - region.top_row) as f64;
        let mut row = height - 1.0;
        while row >= region.top_row as f64 {
            self.rows.push(row as usize);
            let near = (row - region.top_row as f64) / span;
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

    /// How much paint a candidate bounds in its own section.
    pub(super) fn paint_along(
        &mut self,
        view: &RoadView<'_>,
        frame: &RgbImage,
        candidate: &LineCandidate,
    ) -> PaintAlong {
        let mut along = PaintAlong::default();
        for index in 0..CANDIDATE_ROWS {
            let share = (index as f64 + 0.5) / CANDIDATE_ROWS as f64;
            let rows = candidate.upper_px.v - candidate.lower_px.v;
            let row = (candidate.lower_px.v + share * rows).round();
            let on_line = Pixel::new(extended(candidate, row), row);
            let beside = Pixel::new(on_line.u + 1.0, row);
            let (Some(place), Some(next)) = (view.ground_of_pixel(on_line), view.ground_of_pixel(beside))
            else {
                continue;
            };
            let px_per_m = 1.0 / (place.y - next.y).max(1e-4);
            let search = PaintSearch {
                side: candidate.side,
                expected_u: on_line.u,
                reach_px: LEAST_REACH_PX,
                px_per_m,
            };
            if (0.0..frame.height() as f64).contains(&row)
                && let Some(paint) = self.paint.find(frame.row(row as usize), &search)
            {
                along.sum += paint.step;
                along.rows += 1;
            }
        }
        along
    }

    /// How far inside a side's edge another line runs, metres; none where no such line is seen. The inner line of a double
    /// marking may have gaps, so that the outer one was taken for it.
    pub(super) fn inner_line_m(
        &mut self,
        camera: &Camera,
        filter: &LaneFilter,
        frame: &RgbImage,
        side: Side,
        strength: f64,
    ) -> Option<f64> {
        let view = RoadView::new(camera, filter.pitch_rad());
        self.inner.clear();
        let readings = &self.readings[side.index()];
        for (index, reading) in readings.iter().enumerate().step_by(INNER_STEP) {
            let inward_m = 0.5 * (INNER_M[0] + INNER_M[1]);
            let left_m = filter.left_at(side, reading.ahead_m) + side.outward() * inward_m;
            let place = Point2::new(reading.ahead_m, left_m);
            let Some(expected) = view.pixel_of_ground(place) else { continue };
            let search = PaintSearch {
                side,
                expected_u: expected.u,
                reach_px: 0.5 * (INNER_M[1] - INNER_M[0]) * reading.px_per_m,
                px_per_m: reading.px_per_m,
            };
            let row = frame.row(reading.row as usize);
            let found = self.paint.find(row, &search).filter(|paint| paint.step >= WEAK_SHARE * strength);
            let Some(paint) = found else { continue };
            let inside_m = side.outward() * (reading.expected_u - paint.u) / reading.px_per_m;
            let next = readings.get(index + INNER_STEP).map_or(reading.ahead_m, |next| next.ahead_m);
            self.inner.push([inside_m, (next - reading.ahead_m).max(0.0)]);
        }
        if self.inner.is_empty() {
            return None;
        }
        let middle = self.inner.len() / 2;
        let (_, &mut [median_m, _], _) =
            self.inner.select_nth_unstable_by(middle, |a, b| a[0].total_cmp(&b[0]));
        let agreeing = self.inner.iter().filter(|found| (found[0] - median_m).abs() < INNER_SPREAD_M);
        let (count, length_m) = agreeing.fold((0, 0.0), |(count, sum), found| (count + 1, sum + found[1]));
        let most_agree = 2 * count > self.inner.len();
        (count >= INNER_ROWS && length_m >= INNER_LENGTH_M && most_agree && INNER_M[0] < median_m)
            .then_some(median_m)
    }

    /// What the paint of a side looks like, given how it looked in the frame before.
    pub(super) fn look(&mut self, side: Side, before: PaintLook) -> PaintLook {
        let readings = &self.readings[side.index()];
        self.steps.clear();
        self.steps.extend(readings.iter().filter_map(|reading| Some(reading.paint?.step)));
        let mut look = PaintLook { step: STRENGTH_KEPT * before.step, ..before };
        if self.steps.is_empty() {
            return look;
        }
        let rank = (STRONG_QUANTILE * (self.steps.len() - 1) as f64) as usize;
        let (_, strong, _) = self.steps.select_nth_unstable_by(rank, f64::total_cmp);
        look.step = strong.max(look.step);
        self.steps.clear();
        let strong = readings.iter().filter_map(|reading| {
            let paint = reading.paint.filter(|paint| paint.step >= WEAK_SHARE * look.step)?;
            Some(paint.width_px / reading.px_per_m)
        });
        self.steps.extend(strong);
        if !self.steps.is_empty() {
            let middle = self.steps.len() / 2;
            let (_, width_m, _) = self.steps.select_nth_unstable_by(middle, f64::total_cmp);
            let share = if before.width_m > 0.0 { WIDTH_SHARE } else { 1.0 };
            look.width_m += share * (*width_m - look.width_m);
        }
        look
    }

    /// Drops what does not look like a side's paint; of a double marking, what shows no second line beside it, because that
    /// may be the second line itself.
    pub(super) fn drop_unlike(&mut self, side: Side, look: &mut PaintLook) {
        let readings = &mut self.readings[side.index()];
        for reading in readings.iter_mut() {
            let px_per_m = reading.px_per_m;
            reading.paint = reading.paint.filter(|paint| {
                // A pixel more or less is no difference; before any has been seen every width is right.
                let [least, most] = WIDTHS.map(|share| share * look.width_m * px_per_m);
                let widths = if look.width_m > 0.0 { least - 1.0..=most + 1.0 } else { 0.0..=f64::INFINITY };
                paint.step >= FAINT_SHARE * look.step && widths.contains(&paint.width_px)
            });
        }
        self.steps.clear();
        self.steps.extend(readings.iter().filter_map(Reading::second_m));
        let painted = readings.iter().filter(|reading| reading.paint.is_some()).count();
        let doubled = self.steps.len() as f64;
        if self.steps.len() >= INNER_ROWS && doubled >= DOUBLE_SHARE * painted as f64 {
            let middle = self.steps.len() / 2;
            look.second_m = Some(*self.steps.select_nth_unstable_by(middle, f64::total_cmp).1);
        } else if painted >= SINGLE_ROWS && doubled < SINGLE_SHARE * painted as f64 {
            look.second_m = None;
        }
        if look.second_m.is_some() {
            readings.iter_mut().filter(|r| r.second_m().is_none()).for_each(|reading| reading.paint = None);
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
            self.points.extend(self.readings[side.index()].iter().filter_map(|reading| {
                let paint = reading.paint?;
                let ground_px = GROUND_SIGMA_M * reading.px_per_m;
                Some(EdgePoint {
                    side,
                    pixel: Pixel::new(paint.u, reading.row),
                    sigma_px: COLUMN_SIGMA_PX.hypot(ground_px) * (weak / paint.step).max(1.0),
                    weight: 0.0,
                })
            }));
        }
        filter.update(camera, &mut self.points);
    }

    /// The points of the last fit.
    pub(super) fn points(&self) -> &[EdgePoint] {
        &self.points
    }

    /// How well a side was read in the last fit.
    pub(super) fn quality(&self, camera: &Camera, filter: &LaneFilter, side: Side) -> Quality {
        let view = RoadView::new(camera, filter.pitch_rad());
        let mut quality = Quality::default();
        let (mut squares, mut widths, mut width_squares) = (0.0, 0.0, 0.0);
        let mut points = self.points.iter().filter(|point| point.side == side);
        let readings = &self.readings[side.index()];
        for (index, reading) in readings.iter().enumerate() {
            let Some(paint) = reading.paint else { continue };
            let Some(point) = points.next() else { break };
            if point.weight < USED_WEIGHT {
                quality.outliers += 1;
                continue;
            }
            quality.used += 1;
            let next = readings.get(index + 1).map_or(reading.ahead_m, |next| next.ahead_m);
            let length_m = (next - reading.ahead_m).max(0.0);
            quality.painted_m += length_m;
            if reading.ahead_m <= NEAR_M {
                quality.near_m += length_m;
            }
            let width_m = paint.width_px / reading.px_per_m;
            widths += width_m;
            width_squares += width_m * width_m;
            if let Some(place) = view.ground_of_pixel(point.pixel) {
                let off_m = place.y - filter.left_at(side, place.x);
                squares += (off_m * reading.px_per_m / point.sigma_px).powi(2);
            }
        }
        if quality.used > 0 {
            let count = quality.used as f64;
            quality.residual_sigmas = (squares / count).sqrt();
            let mean = widths / count;
            quality.width_spread = (width_squares / count - mean * mean).max(0.0).sqrt() / mean.max(1e-6);
        }
        quality
    }

    /// Appends what was looked for and found.
    pub(super) fn evidence(&self, sides: &[Side], traced: &mut Vec<TracedPoint>) {
        for &side in sides {
            let mut points = self.points.iter().filter(|point| point.side == side);
            traced.extend(self.readings[side.index()].iter().map(|reading| {
                let weight = reading.paint.and_then(|_| points.next()).map(|point| point.weight);
                TracedPoint {
                    side,
                    pixel: Pixel::new(reading.paint.map_or(reading.expected_u, |paint| paint.u), reading.row),
                    ahead_m: reading.ahead_m,
                    reach_px: reading.reach_px,
                    found: match weight {
                        None => Traced::Nothing,
                        Some(weight) if weight < USED_WEIGHT => Traced::Outlier,
                        Some(_) => Traced::Used,
                    },
                }
            }));
        }
    }
}

/// Points with less weight than this in the fit count as outliers.
pub(super) const USED_WEIGHT: f64 = 0.3;
