//! The pipeline: one frame in, where the next junction is and how to drive through it out.

mod ego;
mod lane_watch;
mod output;
mod parts;
mod passed_over;

use fingerpost_control::FuzzyError;
use fingerpost_geometry::{Camera, GeometryError, View};
use fingerpost_map::{LatLon, RoadGraph, Route, TangentPlane};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::road_network::RoadNetwork;
use fingerpost_vision::span::SpanError;
use nalgebra::Point2;
use thiserror::Error;

use crate::advice::{Advice, AdviceStage};
use crate::calibration_check::{self, CalibrationFault};
use crate::camera_state::{CameraEvidence, CameraState, CameraWatch};
use crate::centreline::{Centreline, CentrelineError, CentrelineEvidence, CentrelineFinder};
use crate::config::Config;
use crate::declared::ConfigError;
use crate::feature_masks::PlacedMasks;
use crate::fix::{FixEvidence, FixInput, FixStage, MapFix, NearPlace};
use crate::ground_view::{GroundPicture, GroundView, GroundViewError};
use crate::lanes::departure::{DepartureEvidence, DepartureOutput};
use crate::lanes::{Lane, LaneError, LaneEvidence, LaneInput};
use crate::matching::FeatureMatcher;
use crate::motion::{Motion, MotionDoubt, MotionError, MotionEvidence};
use crate::mount::MountEstimate;
use crate::road_surface::{Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, RoadSurface};
use crate::track::{BeliefTracker, Moved, ShownSurface, State, TrackEvidence, TrackOutput, TrackerSetting};
use crate::vehicle_signals::{SignalsEvidence, VehicleSamples, VehicleState};

use self::ego::Ego;
use self::lane_watch::LaneWatch;

pub use self::parts::Parts;

/// What else is known when a frame is taken.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sensors {
    /// GPS position, where there is one.
    pub gps: Option<LatLon>,
    /// Newest values of the vehicle's own signals; none without a bus.
    pub signals: Option<VehicleSamples>,
    /// Seconds since the frame before; none in the first one and where frames have no times.
    pub dt_s: Option<f64>,
}

/// The stages, in the order of the data.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Stage {
    /// Picture to ground view.
    GroundView,
    /// Ground views to ego-motion.
    Motion,
    /// The camera's own motion to the mount's estimate.
    Mount,
    /// Ground view to road probability.
    Road,
    /// Masks, match and track.
    Match,
    /// Motion to the place on the map.
    Fix,
    /// Driving line in the vehicle frame.
    DrivingLine,
    /// Road probability and driving line to the road's middle and the direction to steer in.
    Centreline,
    /// The lane by its markings.
    Lanes,
    /// The sentence that says why, and the line that leads to steering angle and speed.
    Advice,
}

/// What the method says after a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameOutput {
    /// What the camera's picture was good for.
    pub camera: CameraEvidence,
    /// State and followed feature.
    pub track: TrackOutput,
    /// Motion since the frame before; [`Motion::unknown`] where what was measured is not believed.
    pub motion: Option<Motion>,
    /// Why what was measured is wrong by what else the picture shows; none where nothing speaks against it.
    pub motion_doubt: Option<MotionDoubt>,
    /// The vehicle's motion and its driver's intent, from its bus or from the camera.
    pub vehicle: VehicleState,
    /// The road's middle by its surface alone; none where its edges are not sound.
    pub centreline: Option<Centreline>,
    /// Where the camera looks against the calibration; none for a camera known by points.
    pub mount: Option<MountEstimate>,
    /// Where the vehicle is on the map; none without one.
    pub fix: Option<MapFix>,
    /// Driving line through the followed feature: points in the vehicle frame, metres.
    pub driving_line: Vec<Point2<f64>>,
    /// Its signed curvature at each point, 1/m, positive to the left.
    pub driving_line_curvature_per_m: Vec<f64>,
    /// The lane in which the vehicle is; none where lanes are not looked for.
    pub lane: Option<Lane>,
    /// How the vehicle moves towards the lane's edges; none for a camera known by points and where no lane is looked for.
    pub departure: Option<DepartureOutput>,
    /// Steering angle and speed for a controller.
    pub advice: Advice,
    /// What was decided and what decided it.
    pub why: String,
}

/// What the method saw and why it decided.
#[derive(Debug)]
pub struct FrameEvidence<'a> {
    /// The ground view.
    pub ground: &'a GroundPicture,
    /// The validity mask.
    pub validity: &'a Plane<u8>,
    /// The road surface.
    pub surface: &'a RoadSurface,
    /// How it was found.
    pub road: RoadEvidence,
    /// The network that looked at the frame; none of a detector that asks none.
    pub network: Option<&'a RoadNetwork>,
    /// How the road's middle was found.
    pub centreline: &'a CentrelineEvidence,
    /// How the motion was found.
    pub motion: Option<&'a MotionEvidence>,
    /// Where speed, yaw rate and turn signal came from; none without a bus.
    pub signals: Option<SignalsEvidence>,
    /// How the tracker decided.
    pub track: &'a TrackEvidence,
    /// How the lane was found.
    pub lanes: Option<&'a LaneEvidence>,
    /// How a departure from it was judged.
    pub departure: Option<DepartureEvidence>,
    /// The masks of the followed feature, or else of the one searched for, where they matched best.
    pub masks: Option<PlacedMasks<'a>>,
    /// What was made of measurements of the vehicle's place; none without a map.
    pub fix: Option<FixEvidence>,
}

/// A pipeline that cannot be set up, or a frame that cannot be processed.
#[derive(Debug, Error)]
pub enum PipelineError {
    /// A setting is out of range.
    #[error("configuration: {0}")]
    Config(#[from] ConfigError),
    /// The calibration cannot be that of a camera above this road.
    #[error("calibration: {0}")]
    Calibration(#[from] CalibrationFault),
    /// The ground view cannot be made.
    #[error(transparent)]
    GroundView(#[from] GroundViewError),
    /// The road surface cannot be found.
    #[error(transparent)]
    Road(#[from] RoadError),
    /// The road's middle cannot be found.
    #[error(transparent)]
    Centreline(#[from] CentrelineError),
    /// The motion cannot be found.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// The advice's rules cannot be used.
    #[error("advice.rules: {0}")]
    Advice(#[from] FuzzyError),
    /// The lane cannot be looked for.
    #[error(transparent)]
    Lane(#[from] LaneError),
    /// The route's features have no shape.
    #[error("route: {0}")]
    Route(#[from] GeometryError),
    /// A mask cannot be drawn.
    #[error("route feature: {0}")]
    Mask(#[from] SpanError),
    /// Pictures do not fit together.
    #[error(transparent)]
    Picture(#[from] PictureError),
}

/// The whole method with its state.
pub struct Pipeline {
    view: GroundView,
    camera_watch: CameraWatch,
    detector: Box<dyn RoadDetector>,
    centreline: CentrelineFinder,
    camera: Camera,
    ego: Ego,
    matcher: Box<dyn FeatureMatcher>,
    tracker: BeliefTracker,
    lanes: LaneWatch,
    advice: AdviceStage,
    map: Option<TangentPlane>,
    /// None without a map.
    fix: Option<FixStage>,
    config: Config,
    ground: GroundPicture,
    surface: RoadSurface,
    track_evidence: TrackEvidence,
    output: FrameOutput,
}

impl Pipeline {
    /// A pipeline for `camera`, at `start_m` along `route` where both are known.
    ///
    /// # Errors
    /// [`PipelineError`] when configuration, camera or route cannot be used.
    pub fn new(
        config: &Config,
        camera: &Camera,
        route: Option<&Route>,
        start_m: Option<f64>,
    ) -> Result<Self, PipelineError> {
        Self::with_parts(config, camera, route, start_m, Parts::default())
    }

    /// The same with stages of the program's own in place of the configuration's.
    ///
    /// # Errors
    /// [`PipelineError`] when configuration, camera or route cannot be used.
    pub fn with_parts(
        config: &Config,
        camera: &Camera,
        route: Option<&Route>,
        start_m: Option<f64>,
        mut parts: Parts,
    ) -> Result<Self, PipelineError> {
        config.check()?;
        calibration_check::check(camera, &config.ground_view)?;
        let view = GroundView::new(&config.ground_view, config.road_surface.backprojection.bins(), camera)?;
        let setting = TrackerSetting {
            track: &config.track,
            masks: &config.feature_mask,
            driving_line: &config.driving_line,
            vehicle: &config.vehicle,
            progress: &config.route_progress,
            grid: view.grid(),
            nearest_seen_m: view.nearest_seen_m(),
            viewpoint: view.viewpoint(),
            row_rad: view.row_rad(),
        };
        let tracker = BeliefTracker::new(setting, route, start_m)?;
        let state = if tracker.stops().is_empty() { State::NoRoute } else { State::Searching };
        let track = TrackOutput { state, ..TrackOutput::default() };
        Ok(Self {
            camera_watch: CameraWatch::default(),
            detector: parts.take_road_detector(config)?,
            centreline: CentrelineFinder::new(&config.centreline, &config.vehicle, &view)?,
            camera: camera.clone(),
            ego: Ego::new(config, camera, &view, parts.take_motion_estimator(config)?),
            matcher: parts.take_matcher(config, view.grid()),
            tracker,
            lanes: LaneWatch::new(parts.take_lane_finder(config)?),
            advice: AdviceStage::new(&config.advice_setting())?,
            map: route.and_then(|route| route.line.first()).map(|first| TangentPlane::new(first.at)),
            fix: None,
            config: config.clone(),
            ground: view.black_picture(),
            surface: RoadSurface::default(),
            track_evidence: TrackEvidence::default(),
            output: FrameOutput { track, ..FrameOutput::default() },
            view,
        })
    }

    /// Says in every frame from now on where the vehicle is on this map, known to be near a place or anywhere.
    pub fn locate_on(&mut self, graph: &RoadGraph, near: Option<NearPlace>) {
        let stage = FixStage::new(graph, self.config.vehicle.traffic, near);
        self.fix = Some(stage.with_route(self.tracker.stops(), self.map.as_ref()));
    }

    /// Takes one frame in. `finished` is told after each stage, so that the caller can time them. Output and evidence
    /// stay with the pipeline, which reuses their memory in the next frame.
    ///
    /// # Errors
    /// [`PipelineError`] when the frame does not fit the camera; the state is then as before the frame.
    pub fn step(
        &mut self,
        frame: &RgbImage,
        sensors: Sensors,
        finished: &mut dyn FnMut(Stage),
    ) -> Result<(&FrameOutput, FrameEvidence<'_>), PipelineError> {
        self.view.render(frame, &mut self.ground)?;
        let camera = self.camera_watch.look_at(frame);
        finished(Stage::GroundView);
        if camera.state != CameraState::Clear {
            return Ok(self.pass_over(camera, sensors));
        }
        self.output.camera = camera;
        self.take_in(frame, sensors, finished)
    }

    /// Takes in a frame that shows something, of which the ground view is made.
    fn take_in(
        &mut self,
        frame: &RgbImage,
        sensors: Sensors,
        finished: &mut dyn FnMut(Stage),
    ) -> Result<(&FrameOutput, FrameEvidence<'_>), PipelineError> {
        let Self { config, view, ground, surface, tracker, fix, track_evidence, output, .. } = self;
        let (validity, Sensors { gps, signals, .. }) = (view.validity(), sensors);
        let ego = self.ego.step((&self.camera, frame), (view, ground), sensors, finished)?;
        let motion = ego.motion.as_ref();

        let sample = config.road_surface.sample_region(view);
        let perspective = Perspective::Ground { view, frame };
        let input = RoadInput { picture: ground, validity, sample, perspective, motion };
        let road = self.detector.detect(input, surface)?;
        finished(Stage::Road);

        let summed = self.matcher.lay(surface)?;
        let gps_in_map = self.map.as_ref().zip(gps).map(|(map, gps)| map.map_from_wgs84(gps));
        let moved = Moved { motion, camera: ego.camera, dt_s: ego.dt_s, speed_mps: ego.vehicle.speed_mps };
        let shown = ShownSurface { surface, seen: validity, laid: summed };
        tracker.step(moved, shown, gps_in_map, &mut output.track, track_evidence)?;
        finished(Stage::Match);

        let fix_evidence = fix.as_mut().map(|stage| {
            let input = FixInput { gps, followed: output.track.followed.as_ref() };
            let (fix, evidence) = stage.step(sensors.dt_s, &ego.vehicle, motion, input);
            output.fix = fix;
            finished(Stage::Fix);
            evidence
        });
        (output.motion, output.motion_doubt) = (ego.motion, ego.motion_doubt);
        output.vehicle = ego.vehicle;
        output.mount = matches!(self.camera.view(), View::Calibrated { .. }).then_some(ego.mount);
        output.place_driving_line(tracker.stops());
        finished(Stage::DrivingLine);

        let guide = output.guide(tracker.stops());
        let (centreline, centreline_evidence) =
            self.centreline.find_guided(surface, motion, guide.as_ref())?;
        output.centreline = centreline;
        finished(Stage::Centreline);

        let input =
            LaneInput { frame, dt_s: ego.dt_s, vehicle: &ego.vehicle, pitch_change: ego.pitch_change };
        let lanes = self.lanes.step(config, &self.camera, &input, tracker, output)?;
        finished(Stage::Lanes);

        let evidence = FrameEvidence {
            ground,
            validity: validity.plane(),
            surface,
            road,
            network: self.detector.network(),
            centreline: centreline_evidence,
            motion: ego.motion_evidence,
            signals: signals.map(|_| ego.signals_evidence),
            track: track_evidence,
            lanes: lanes.evidence,
            departure: lanes.departure,
            masks: tracker.placed_masks(&output.track, track_evidence, view.grid()),
            fix: fix_evidence,
        };
        output.explain(&evidence, &lanes, tracker.stops());
        output.advise(&mut self.advice, tracker.stops(), sensors.dt_s);
        finished(Stage::Advice);
        Ok((output, evidence))
    }

    /// The raster and table of the ground view.
    pub const fn view(&self) -> &GroundView {
        &self.view
    }

    /// The road detector.
    pub fn road_detector(&self) -> &dyn RoadDetector {
        &*self.detector
    }

    /// The road detector, to be given what is known from earlier drives.
    pub fn road_detector_mut(&mut self) -> &mut dyn RoadDetector {
        &mut *self.detector
    }

    /// The tracker with the features of the route.
    pub const fn tracker(&self) -> &BeliefTracker {
        &self.tracker
    }

    /// The texts of the rules that the advice goes by, in their order; none of controllers without rules.
    pub fn advice_rules(&self) -> impl Iterator<Item = &str> {
        self.advice.rules()
    }

    /// The configuration in force.
    pub const fn config(&self) -> &Config {
        &self.config
    }
}
