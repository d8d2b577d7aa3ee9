//! The method with some settings on a drive, frame by frame as the drive is rendered, and what it comes to.

use anyhow::Result;
use fingerpost::{Pipeline, Sensors};
use fingerpost_eval::{FeatureIdentity, RoadLabels, RoadScores, evaluate_junctions, stage_time};
use fingerpost_format::{FrameRecord, TrackState, TruthRecord};
use fingerpost_papers::claims::{
    MaskReading, Measured, Place, Planned, RENDERED_FPS, SparseFlow, Variant, followed_pct, map_from_vehicle,
    places, way_error_pct,
};
use fingerpost_record::{FrameTime, broken_record, feature_identities, frame_record};
use fingerpost_sim::{SimFrame, Simulator};

use crate::picture_scaling::PictureScaling;
use crate::stage_clock::{FrameClock, stage_name};

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
            places: places(pipeline.view()),
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
