//! The method with some settings on a drive, frame by frame as the drive is rendered, and what it comes to.

use std::collections::BTreeMap;

use anyhow::Result;
use fingerpost::{Pipeline, Sensors};
use fingerpost_eval::{FeatureIdentity, RoadLabels, RoadScores, evaluate_junctions, stage_time};
use fingerpost_format::{FrameRecord, TrackState, TruthRecord};
use fingerpost_record::{FrameTime, broken_record, feature_identities, frame_record};
use fingerpost_sim::{SimFrame, Simulator};
use nalgebra::{Isometry2, Point2, Vector2};

use super::axes::Variant;
use super::drives::{Planned, RENDERED_FPS};
use super::masks::MaskReading;
use super::sparse_flow::SparseFlow;
use crate::picture_scaling::PictureScaling;
use crate::stage_clock::{FrameClock, stage_name};

/// What was measured, by name.
pub(super) type Measured = BTreeMap<String, f64>;

/// Features between these distances ahead count as to be followed, metres: nearer they leave the view of the camera, and
/// farther the papers' view of 15 to 20 m does not show their arms whole.
const TO_BE_FOLLOWED_M: [f64; 2] = [5.0, 12.0];
/// A feature is followed when it is this near to its true place, metres: half a car's width either side of the way.
const FOLLOWED_WITHIN_M: f64 = 1.0;
/// Places of the ground view at which the road is compared lie so far apart, metres.
const PLACES_APART_M: f64 = 0.5;
/// Names of road and all else in the comparison.
const LABELS: RoadLabels = RoadLabels { road: 1, void: None };

/// One run on a drive.
pub(super) struct Run {
    variant: Variant,
    pipeline: Pipeline,
    scaling: Option<PictureScaling>,
    features: Vec<FeatureIdentity>,
    last_t_s: Option<f64>,
    places: Vec<Place>,
    road: RoadScores,
    masks: Option<MaskReading>,
    records: Vec<FrameRecord>,
}

/// A place at which the road is compared.
struct Place {
    pixel: (usize, usize),
    p_in_vehicle: Point2<f64>,
}

/// Where the vehicle really is.
pub(super) fn map_from_vehicle(truth: &TruthRecord) -> Isometry2<f64> {
    Isometry2::new(Vector2::new(truth.x_m, truth.y_m), truth.heading_rad)
}

impl Run {
    /// Before the first frame.
    pub(super) fn new(variant: Variant, planned: &Planned) -> Result<Self> {
        let scaling = PictureScaling::to_width(&planned.camera, variant.width)?;
        let camera = scaling.as_ref().map_or(&planned.camera, PictureScaling::camera);
        let mut parts = fingerpost_papers::parts(&variant.config)?;
        if variant.sparse_flow {
            parts.motion_estimator = Some(Box::new(SparseFlow::new(&variant.config.road_surface)));
        }
        let (config, route) = (&variant.config, Some(&planned.route));
        let pipeline = Pipeline::with_parts(config, camera, route, Some(planned.start_m), parts)?;
        let masks = variant.reads_masks.then(|| MaskReading::new(config, &planned.route, &pipeline));
        Ok(Self {
            features: feature_identities(pipeline.tracker().stops()),
            places: places(&pipeline),
            masks: masks.transpose()?,
            pipeline,
            scaling,
            last_t_s: None,
            road: RoadScores::new(LABELS),
            records: Vec::new(),
            variant,
        })
    }

    /// Takes a rendered frame in, if it is one of those that are used.
    pub(super) fn take(&mut self, index: usize, frame: &SimFrame, simulator: &Simulator) -> Result<()> {
        if !index.is_multiple_of(self.variant.every) {
            return Ok(());
        }
        let time = FrameTime { frame: index as u64, t_s: index as f64 / RENDERED_FPS };
        let mut clock = FrameClock::start();
        let mut picture = &frame.picture;
        if let Some(scaling) = &mut self.scaling {
            scaling.shrink(picture);
            picture = scaling.picture();
            clock = FrameClock::start();
        }
        let dt_s = self.last_t_s.replace(time.t_s).map(|last_s| time.t_s - last_s);
        let sensors = Sensors { dt_s, ..Sensors::default() };
        let done = self.pipeline.step(picture, sensors, &mut |stage| clock.finished(stage_name(stage)));
        let record = match done {
            Ok((output, evidence)) => {
                let mut record = frame_record(time, output, &evidence, &self.features, clock.stage_ms);
                // What is not measured takes no memory.
                record.driving_line_m = Vec::new();
                record.driving_line_curvature_per_m = Vec::new();
                let vehicle = map_from_vehicle(&frame.truth);
                let found = &evidence.surface.probability;
                let seen = self.places.iter().filter_map(|place| {
                    let (column, row) = place.pixel;
                    Some((found.get(column, row)?, simulator.is_on_road(vehicle * place.p_in_vehicle)))
                });
                let (found, road): (Vec<u8>, Vec<u8>) =
                    seen.map(|(p, is_road)| (p, u8::from(is_road))).unzip();
                self.road.add(&found, &road)?;
                if let Some(masks) = &mut self.masks {
                    masks.read(evidence.surface, &frame.truth)?;
                }
                record
            }
            Err(cause) => broken_record(time, self.records.last(), TrackState::Searching, cause.to_string()),
        };
        self.records.push(record);
        Ok(())
    }

    /// What the run comes to against the truth of all frames.
    pub(super) fn finish(self, truth: &[TruthRecord], measured: &mut Measured) -> Result<()> {
        let ids: Vec<i64> = self.features.iter().map(|feature| feature.id).collect();
        let junctions = evaluate_junctions(&self.records, truth, &ids)?.summary;
        let found = junctions.features_detected as f64 / junctions.features_total as f64;
        let values = [
            ("road", self.road.best().ok().map(|best| 100.0 * best.max_f)),
            ("followed", followed_pct(&self.records, truth)),
            ("found", Some(100.0 * found).filter(|found| found.is_finite())),
            ("false", Some(junctions.false_detections as f64)),
            ("place_error", junctions.position_error_m.map(|error| error.p50)),
            ("way_error", way_error_pct(&self.records, truth)),
            ("ms", stage_time(self.records.iter().map(method_ms)).map(|time| time.median)),
        ];
        let masks = self.masks.map(MaskReading::values).into_iter().flatten();
        let values = values.into_iter().filter_map(|(name, value)| Some((name, value?)));
        let named = |(name, value): (&str, f64)| (format!("{}.{name}", self.variant.name), value);
        measured.extend(values.chain(masks).map(named));
        Ok(())
    }
}

/// Time that the method took for a frame, without making pictures smaller, which a camera can do itself.
fn method_ms(record: &FrameRecord) -> f64 {
    record.stage_ms.values().sum()
}

/// Places of the view that the camera sees, in a raster of metres that is the same for every scale.
fn places(pipeline: &Pipeline) -> Vec<Place> {
    let (view, grid) = (pipeline.view(), pipeline.view().grid());
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
fn followed_pct(records: &[FrameRecord], truth: &[TruthRecord]) -> Option<f64> {
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
fn way_error_pct(records: &[FrameRecord], truth: &[TruthRecord]) -> Option<f64> {
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
