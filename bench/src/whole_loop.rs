//! The localisation loop, frame by frame without decoding: Fingerpost's own stages against those of an OpenCV program that
//! does the same work: ground view, road surface, two matches of a crossroads' four masks, and motion.

use std::time::Instant;

use anyhow::Result;
use fingerpost::Config;
use fingerpost::attitude::AttitudeObservation;
use fingerpost::feature_masks::{FeatureMaskConfig, MaskCache, MaskCurve};
use fingerpost::feature_model::{ArmModel, FeatureModel};
use fingerpost::ground_view::{GroundPicture, GroundView};
use fingerpost::matching::Matcher;
use fingerpost::motion::{Motion, MotionEstimator};
use fingerpost::road_surface::{Perspective, RoadDetector, RoadInput, RoadSurface};
use fingerpost_geometry::{GroundPixel, Polyline};
use fingerpost_map::{ArmRole, FeatureKind};
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Point2};
use serde_json::json;

use crate::footage::Footage;
use crate::measure::{Effort, Measured, median};
use crate::peer::{Array, OpenCv};
use crate::results::{Row, Section};
use crate::trapezium::Trapezium;

/// Sides of the ground view, pixels.
const SIDES_PX: [usize; 2] = [512, 256];
/// How many times as fast as the OpenCV program the loop is promised to be.
const PROMISED: f64 = 5.0;
/// Side of the region whose flow the OpenCV program measures, pixels.
const FLOW_SIDE_PX: usize = 128;
/// Frames in a turn.
const FRAMES_PER_TURN: usize = 10;
/// Fingerpost's stages, and which of the OpenCV program's do the same.
const STAGES: [(&str, &[&str]); 5] = [
    ("ground view, grey, bins", &["warp", "colour"]),
    ("road surface", &["histogram", "back-projection"]),
    ("match of four masks", &["match"]),
    ("motion", &["motion"]),
    ("match again where the motion leads", &["match again"]),
];

/// Measures the loop at every size.
pub fn whole_loop(opencv: &mut OpenCv, effort: Effort, footage: &Footage) -> Result<Section> {
    let mut section = Section::new(
        "Whole loop",
        "one thread, without decoding, the same frames in turns; the OpenCV program's motion is the mean of Farneback's flow",
    );
    for side_px in SIDES_PX {
        let trapezium = Trapezium::new(footage.size(), side_px)?;
        section.rows.extend(compare(opencv, effort, footage, &trapezium)?);
    }
    Ok(section)
}

fn compare(
    opencv: &mut OpenCv,
    effort: Effort,
    footage: &Footage,
    trapezium: &Trapezium,
) -> Result<Vec<Row>> {
    let (width, height) = footage.size();
    let bytes: Vec<u8> = footage.frames.iter().flat_map(|frame| frame.as_slice()).copied().collect();
    let frames = Array::of_u8(&[footage.frames.len(), height, width, RgbImage::CHANNELS], &bytes);
    let inputs: Vec<Array> = [frames].into_iter().chain(trapezium.maps()).collect();
    opencv.prepare("localisation", &json!({"flow_side": FLOW_SIDE_PX}), &inputs)?;
    let mut ours = Loop::new(trapezium)?;
    let mut our_times = vec![Vec::new(); STAGES.len() + 1];
    let mut their_times = vec![Vec::new(); STAGES.len() + 1];
    let mut next = footage.frames.iter().cycle();
    for _ in 0..effort.rounds {
        let theirs = opencv.time(FRAMES_PER_TURN)?;
        for frame in 0..theirs.calls_ms.len() {
            for ((_, names), times) in STAGES.iter().zip(&mut their_times) {
                let of_stage = theirs.stages_ms.iter().filter(|(name, _)| names.contains(&name.as_str()));
                times.push(of_stage.map(|(_, laps)| laps[frame]).sum());
            }
        }
        their_times[STAGES.len()].extend(theirs.calls_ms);
        // The first is not timed, as on the other side.
        for turn in 0..=FRAMES_PER_TURN {
            let Some(frame) = next.next() else { break };
            let laps_ms = ours.step(frame)?;
            if turn > 0 {
                our_times.iter_mut().zip(laps_ms).for_each(|(times, lap_ms)| times.push(lap_ms));
                our_times[STAGES.len()].push(laps_ms.iter().sum());
            }
        }
    }
    let size = format!("{width} x {height} to {0} x {0}", trapezium.side_px);
    let names = STAGES.iter().map(|(name, _)| *name).chain(["WHOLE LOOP"]);
    let rows = names.zip(our_times.iter_mut().zip(&mut their_times)).map(|(name, (ours, theirs))| {
        let promised = (name == "WHOLE LOOP").then_some(PROMISED);
        let measured =
            |name: &str, times: &mut Vec<f64>| Measured { name: name.to_owned(), median_ms: median(times) };
        Row::new(name, &size, vec![measured("Fingerpost", ours), measured("OpenCV", theirs)], promised)
    });
    Ok(rows.collect())
}

/// Fingerpost's stages on a crossroads that stays in the middle of the view.
pub struct Loop {
    config: Config,
    view: GroundView,
    ground: GroundPicture,
    detector: Box<dyn RoadDetector>,
    surface: RoadSurface,
    matcher: Matcher,
    masks: MaskCache,
    motion: Box<dyn MotionEstimator>,
    moved: Option<Motion>,
    node: Isometry2<f64>,
}

impl Loop {
    pub fn new(trapezium: &Trapezium) -> Result<Self> {
        let config = Config {
            ground_view: trapezium.config.clone(),
            // Arms a 24th of the view wide, as the OpenCV program draws them.
            feature_mask: FeatureMaskConfig {
                arm_width_share: trapezium.side_m() / 24.0 / Config::default().vehicle.width_m,
                ..FeatureMaskConfig::default()
            },
            ..Config::default()
        };
        let view = GroundView::new(
            &config.ground_view,
            config.road_surface.backprojection.bins(),
            &trapezium.camera,
        )?;
        let feature = crossroads(trapezium.side_m())?;
        let curve = MaskCurve::new(&config.feature_mask, &config.vehicle, &feature)?;
        let masks = MaskCache::new(
            &config.feature_mask,
            config.track.kerb_radius_m,
            &config.vehicle,
            view.grid(),
            &feature,
            curve.as_ref(),
        );
        let middle = 0.5 * trapezium.side_px as f64;
        let p_in_vehicle = view.grid().vehicle_from_ground(GroundPixel { column: middle, row: middle });
        Ok(Self {
            detector: config.road_surface.detector()?,
            matcher: Matcher::new(&config.matching, view.grid()),
            motion: config.motion.estimator()?,
            moved: None,
            node: Isometry2::new(p_in_vehicle.coords, 0.0),
            ground: view.black_picture(),
            surface: RoadSurface::default(),
            masks,
            view,
            config,
        })
    }

    /// Takes a frame through all stages; milliseconds of each.
    pub fn step(&mut self, frame: &RgbImage) -> Result<[f64; STAGES.len()]> {
        let mut laps_ms = [0.0; STAGES.len()];
        let mut last = Instant::now();
        let mut lap = |stage: usize| {
            let now = Instant::now();
            laps_ms[stage] = now.duration_since(last).as_secs_f64() * 1e3;
            last = now;
        };
        self.view.render(frame, &mut self.ground)?;
        lap(0);
        let sample = self.config.road_surface.sample_region(&self.view);
        let validity = self.view.validity();
        let perspective = Perspective::Ground { view: &self.view, frame };
        let input =
            RoadInput { picture: &self.ground, validity, sample, perspective, motion: self.moved.as_ref() };
        self.detector.detect(input, &mut self.surface)?;
        lap(1);
        let laid = self.matcher.laid(&self.surface, self.surface.known())?;
        laid.probability(&mut self.masks, &self.node)?;
        lap(2);
        self.moved = self
            .motion
            .estimate(&self.view, &self.ground, &AttitudeObservation::default())?
            .map(|(output, _)| output.motion);
        let previous_from_current =
            self.moved.map_or_else(Isometry2::identity, |motion| motion.previous_from_current);
        lap(3);
        laid.probability(&mut self.masks, &(previous_from_current.inverse() * self.node))?;
        lap(4);
        Ok(laps_ms)
    }
}

/// A right turn at a crossroads whose arms leave a view of `side_m` metres.
fn crossroads(side_m: f64) -> Result<FeatureModel> {
    let arm = |role, label: &str, forward: f64, left: f64| -> Result<ArmModel> {
        let end = Point2::new(forward, left) * (2.0 * side_m);
        Ok(ArmModel {
            role,
            label: label.into(),
            course: Polyline::new([Point2::origin(), end])?,
            width_m: 6.0,
            mouth_m: 3.0,
            leaves_after_m: None,
        })
    };
    Ok(FeatureModel {
        id: 0,
        name: "crossroads".to_owned(),
        kind: FeatureKind::Junction,
        route_m: 0.0,
        arms: vec![
            arm(ArmRole::Approach, "approach", -1.0, 0.0)?,
            arm(ArmRole::Exit, "exit", 0.0, -1.0)?,
            arm(ArmRole::Side, "side_1", 0.0, 1.0)?,
        ],
        map_from_feature: Isometry2::identity(),
    })
}
