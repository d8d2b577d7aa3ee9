//! How well an edge was read, and the evidence of it.

use fingerpost_geometry::{Camera, Pixel};

use super::{Reading, Tracer};
use crate::Side;
use crate::lane_filter::{EdgePoint, LaneFilter};
use crate::paint::PaintEdge;
use crate::paint_odds::{BarLooks, LineOdds, PLACE_M};
use crate::road_view::RoadView;

/// Paint up to this distance is near, metres: there a bar is several pixels wide, and a broken line shows a dash.
const NEAR_M: f64 = 20.0;
/// Points with less weight than this in the fit count as outliers.
pub(crate) const USED_WEIGHT: f64 = 0.3;

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

/// How well an edge was read.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Quality {
    /// Rows with paint that the fit used.
    pub(crate) used: usize,
    /// Length of road with such paint, metres.
    pub(crate) painted_m: f64,
    /// The part of it that is near.
    pub(crate) near_m: f64,
    /// Rows with paint that it did not use.
    pub(crate) outliers: usize,
    /// Root mean square distance of the used paint from the fit, in its standard deviations.
    pub(crate) residual_sigmas: f64,
    /// Spread of the paint's width in metres against its mean.
    pub(crate) width_spread: f64,
    /// Logarithm of the odds that it is painted.
    pub(crate) log_odds: f64,
}

impl Tracer {
    /// How well a side was read in the last fit.
    pub(crate) fn quality(&self, camera: &Camera, filter: &LaneFilter, side: Side) -> Quality {
        let view = RoadView::new(camera, filter.pitch_rad());
        let mut quality = Quality::default();
        let (mut squares, mut widths, mut width_squares) = (0.0, 0.0, 0.0);
        let mut points = self.points.iter().filter(|point| point.side == side);
        let readings = &self.readings[side.index()];
        let mut line = LineOdds::default();
        for (index, reading) in readings.iter().enumerate() {
            let Some(paint) = reading.paint else { continue };
            let Some(point) = points.next() else { break };
            if point.weight < USED_WEIGHT {
                quality.outliers += 1;
                continue;
            }
            quality.used += 1;
            line.add_seen(
                (reading.ahead_m / PLACE_M) as usize,
                &BarLooks::at(&paint, reading.px_per_m, point),
            );
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
        quality.log_odds = line.log_odds();
        if quality.used > 0 {
            let count = quality.used as f64;
            quality.residual_sigmas = (squares / count).sqrt();
            let mean = widths / count;
            quality.width_spread = (width_squares / count - mean * mean).max(0.0).sqrt() / mean.max(1e-6);
        }
        quality
    }

    /// Where the last fit used a side's paint.
    pub(crate) fn used(&self, side: Side) -> impl Iterator<Item = (&Reading, &PaintEdge, &EdgePoint)> {
        let painted =
            self.readings[side.index()].iter().filter_map(|reading| Some((reading, reading.paint.as_ref()?)));
        let points = self.points.iter().filter(move |point| point.side == side);
        let used = painted.zip(points).filter(|(_, point)| point.weight >= USED_WEIGHT);
        used.map(|((reading, paint), point)| (reading, paint, point))
    }

    /// Appends what was looked for and found.
    pub(crate) fn evidence(&self, sides: &[Side], traced: &mut Vec<TracedPoint>) {
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
