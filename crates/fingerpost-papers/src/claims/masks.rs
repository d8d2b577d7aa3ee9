//! Sub-masks against one whole mask (paper 1, V-C): the same arms over the same surface, read both ways.
//!
//! Places where the route's next feature is, by truth, stand against places of the same route where it is not. A reading is as
//! good as it tells the one from the other, whatever threshold is chosen.

use fingerpost::feature_masks::{MaskCache, MaskCurve, node_pixel};
use fingerpost::feature_model::FeatureModel;
use fingerpost::matching::{LaidSurface, Match, Matcher, Participation};
use fingerpost::road_surface::RoadSurface;
use fingerpost::{Config, Pipeline};
use fingerpost_format::TruthRecord;
use fingerpost_geometry::{GeometryError, GroundGrid, Polyline};
use fingerpost_map::Route;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::span::{SpanError, SpanMask};
use nalgebra::Isometry2;
use thiserror::Error;

use super::figures::map_from_vehicle;

/// A feature so far ahead is read where it is, metres: in view with its arms.
const THERE_M: [f64; 2] = [6.0, 14.0];
/// Where a feature is read that is not there, metres ahead on the route: the middle of those.
const ELSEWHERE_AHEAD_M: f64 = 10.0;
/// Nothing that is on the route may be this near to such a place, metres: arms are seen up to the view's side, 10 m.
const ELSEWHERE_CLEAR_M: f64 = 20.0;
/// Share of the true places that a threshold is to let pass.
const PASSING: f64 = 0.95;

/// A mask that cannot be read.
#[derive(Debug, Error)]
pub enum ReadingError {
    /// The surface cannot be laid out.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// The mask cannot be drawn.
    #[error(transparent)]
    Mask(#[from] SpanError),
}

/// A feature with its masks.
struct Shape {
    model: FeatureModel,
    masks: MaskCache,
}

/// One place read both ways.
#[derive(Debug, Clone, Copy)]
struct Reading {
    is_there: bool,
    /// By the smallest of the sub-masks, and by all of them as one mask.
    p: [f64; 2],
}

/// All readings of a drive.
pub struct MaskReading {
    grid: GroundGrid,
    matcher: Matcher,
    line: Polyline,
    shapes: Vec<Shape>,
    matched: Match,
    readings: Vec<Reading>,
}

impl MaskReading {
    /// Nothing read yet of the features of `route`, with the settings of `config`.
    ///
    /// # Errors
    /// [`GeometryError`] when the route or a feature has no shape.
    pub fn new(config: &Config, route: &Route, pipeline: &Pipeline) -> Result<Self, GeometryError> {
        let grid = *pipeline.view().grid();
        let kerb_radius_m = config.track.kerb_radius_m;
        let shape = |model: &FeatureModel| -> Result<Shape, GeometryError> {
            let (mask, vehicle) = (&config.feature_mask, &config.vehicle);
            let curve = MaskCurve::new(mask, vehicle, model)?;
            let masks = MaskCache::new(mask, kerb_radius_m, vehicle, &grid, model, curve.as_ref());
            Ok(Shape { model: model.clone(), masks })
        };
        Ok(Self {
            matcher: Matcher::new(&config.matching, &grid),
            line: route.polyline()?,
            shapes: pipeline
                .tracker()
                .stops()
                .iter()
                .map(|stop| shape(&stop.model))
                .collect::<Result<_, _>>()?,
            grid,
            matched: Match::default(),
            readings: Vec::new(),
        })
    }

    /// Reads the route's next feature where it is, or where nothing is.
    ///
    /// # Errors
    /// [`ReadingError`] when a mask cannot be drawn or superimposed on the surface.
    pub fn read(&mut self, surface: &RoadSurface, truth: &TruthRecord) -> Result<(), ReadingError> {
        let vehicle = map_from_vehicle(truth);
        let along_m = self.line.nearest(vehicle.translation.vector.into()).along_m;
        let Some(next) = self.shapes.iter().position(|shape| shape.model.route_m > along_m) else {
            return Ok(());
        };
        let elsewhere_m = along_m + ELSEWHERE_AHEAD_M;
        let apart_m = |shape: &Shape| (shape.model.route_m - elsewhere_m).abs();
        let ahead_m = self.shapes[next].model.route_m - along_m;
        let (is_there, map_from_feature) = if (THERE_M[0]..=THERE_M[1]).contains(&ahead_m) {
            (true, self.shapes[next].model.map_from_feature)
        } else if self.shapes.iter().all(|shape| apart_m(shape) > ELSEWHERE_CLEAR_M)
            && elsewhere_m < self.line.length_m()
        {
            (false, self.line.frame_at(elsewhere_m))
        } else {
            return Ok(());
        };
        let vehicle_from_feature = vehicle.inverse() * map_from_feature;
        let laid = self.matcher.laid(surface, surface.known())?;
        let (shape, matched) = (&mut self.shapes[next], &mut self.matched);
        let p = read_both_ways(&laid, &self.grid, &mut shape.masks, matched, &vehicle_from_feature)?;
        self.readings.extend(p.map(|p| Reading { is_there, p }));
        Ok(())
    }

    /// How well either reading tells the places apart, by name.
    pub fn values(self) -> Vec<(&'static str, f64)> {
        let names = [["told_0", "falsely_0"], ["told_1", "falsely_1"]];
        let mut values = Vec::new();
        for (way, [told, falsely]) in names.into_iter().enumerate() {
            let of = |is_there: bool| -> Vec<f64> {
                self.readings.iter().filter(|r| r.is_there == is_there).map(|r| r.p[way]).collect()
            };
            let (there, elsewhere) = (of(true), of(false));
            values.extend(told_apart_pct(&there, &elsewhere).map(|pct| (told, pct)));
            values.extend(falsely_pct(there, &elsewhere).map(|pct| (falsely, pct)));
        }
        values
    }
}

/// P(F) by equation 2, and by equation 1 over one mask of all the arms that take part.
fn read_both_ways(
    laid: &LaidSurface<'_>,
    grid: &GroundGrid,
    masks: &mut MaskCache,
    matched: &mut Match,
    vehicle_from_feature: &Isometry2<f64>,
) -> Result<Option<[f64; 2]>, ReadingError> {
    laid.explain(masks, vehicle_from_feature, matched)?;
    let (column, row) = node_pixel(grid, vehicle_from_feature);
    let drawn = masks.at(vehicle_from_feature.rotation.angle())?;
    let parts = drawn.subs.iter().zip(&matched.subs);
    let taking_part = parts.filter(|(_, sub)| sub.participation == Participation::TakesPart);
    let whole = taking_part.fold(SpanMask::default(), |whole, (sub, _)| whole.union(&sub.spans));
    Ok(matched
        .p
        .zip(laid.sums().cover(&whole, column, row).probability())
        .map(|(least, whole)| [least, whole]))
}

/// How often a place where the feature is reads higher than one where it is not, percent: the area under the receiver operating
/// characteristic. Equal readings count half.
fn told_apart_pct(there: &[f64], elsewhere: &[f64]) -> Option<f64> {
    let higher = there.iter().flat_map(|there| {
        elsewhere.iter().map(move |elsewhere| match there.total_cmp(elsewhere) {
            std::cmp::Ordering::Greater => 1.0,
            std::cmp::Ordering::Equal => 0.5,
            std::cmp::Ordering::Less => 0.0,
        })
    });
    let pairs = there.len() * elsewhere.len();
    (pairs > 0).then(|| 100.0 * higher.sum::<f64>() / pairs as f64)
}

/// Share of the places without the feature that pass the highest threshold that lets [`PASSING`] of the others pass, percent.
fn falsely_pct(mut there: Vec<f64>, elsewhere: &[f64]) -> Option<f64> {
    there.sort_by(f64::total_cmp);
    let missed = ((1.0 - PASSING) * there.len() as f64).floor() as usize;
    let threshold = *there.get(missed)?;
    let passing = elsewhere.iter().filter(|p| **p >= threshold).count();
    (!elsewhere.is_empty()).then(|| 100.0 * passing as f64 / elsewhere.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_that_are_told_apart_are_counted() {
        let there = [0.9, 0.8, 0.8, 0.7];
        assert_eq!(told_apart_pct(&there, &[0.1, 0.2]), Some(100.0));
        assert_eq!(told_apart_pct(&there, &[0.8]), Some(50.0));
        assert_eq!(told_apart_pct(&there, &[]), None);
        assert_eq!(falsely_pct(there.to_vec(), &[0.7, 0.6]), Some(50.0));
        assert_eq!(falsely_pct(Vec::new(), &[0.7]), None);
    }
}
