//! The pipeline: one frame in, where the next junction is and how to drive through it out.

mod passed_over;

use fingerpost_geometry::{Camera, GeometryError, View};
use fingerpost_map::{LatLon, Route, TangentPlane};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::{Plane, RgbImage};
use fingerpost_vision::span::SpanError;
use nalgebra::Point2;
use thiserror::Error;

use crate::calibration_check::{self, CalibrationFault};
use crate::camera_state::{CameraEvidence, CameraState, CameraWatch};
use crate::centreline::{Centreline, CentrelineError, CentrelineEvidence, CentrelineFinder};
use crate::config::{Config, ConfigError};
use crate::feature_masks::PlacedMasks;
use crate::ground_view::{GroundPicture, GroundView, GroundViewError};
use crate::lanes::departure::{DepartureEvidence, DepartureOutput, DepartureWarning};
use crate::lanes::{Lane, LaneError, LaneEvidence, LaneFinder, LaneInput};
use crate::matching::Matcher;
use crate::motion::{Motion, MotionError, MotionEstimator, MotionEvidence};
use crate::mount::{AttitudeWatch, MountEstimate, MountFilter};
use crate::road_surface::{Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, RoadSurface};
use crate::track::{
    FeatureTracker, Moved, RouteStop, ShownSurface, State, TrackEvidence, TrackOutput, TrackerSetting,
};
use crate::vehicle_signals::{SignalsEvidence, SignalsInput, VehicleSamples, VehicleSignals, VehicleState};
use crate::why::Why;

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
    /// Road probability to the road's middle.
    Centreline,
    /// Masks, match and track.
    Match,
    /// Driving line in the vehicle frame.
    DrivingLine,
    /// The lane by its markings.
    Lanes,
}

/// What the method says after a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct FrameOutput {
    /// What the camera's picture was good for.
    pub camera: CameraEvidence,
    /// State and followed feature.
    pub track: TrackOutput,
    /// Motion since the frame before.
    pub motion: Option<Motion>,
    /// The vehicle's motion and its driver's intent, from its bus or from the camera.
    pub vehicle: VehicleState,
    /// The road's middle by its surface alone; none where its edges are not sound.
    pub centreline: Option<Centreline>,
    /// Where the camera looks against the calibration; none for a camera known by points.
    pub mount: Option<MountEstimate>,
    /// Driving line through the followed feature: points in the vehicle frame, metres.
    pub driving_line: Vec<Point2<f64>>,
    /// Its signed curvature at each point, 1/m, positive to the left.
    pub driving_line_curvature_per_m: Vec<f64>,
    /// The lane in which the vehicle is; none where lanes are not looked for.
    pub lane: Option<Lane>,
    /// How the vehicle moves towards the lane's edges; none for a camera known by points and where no lane is looked for.
    pub departure: Option<DepartureOutput>,
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

/// After a longer time two pictures show other road, seconds: at 50 km/h 14 m of the default view's 16 lie behind.
const LONGEST_STEP_S: f64 = 1.0;

/// The whole method with its state.
pub struct Pipeline {
    view: GroundView,
    camera_watch: CameraWatch,
    /// Seconds of the frames that showed nothing, behind the last one that did; none where it was the last.
    unseen_s: Option<f64>,
    detector: Box<dyn RoadDetector>,
    centreline: CentrelineFinder,
    motion: Box<dyn MotionEstimator>,
    camera: Camera,
    attitude: AttitudeWatch,
    mount: MountFilter,
    signals: VehicleSignals,
    matcher: Matcher,
    tracker: Box<dyn FeatureTracker>,
    lanes: Option<LaneFinder>,
    departure: DepartureWarning,
    map: Option<TangentPlane>,
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
        config.check()?;
        Self::with_road_detector(config, camera, route, start_m, config.road_surface.detector()?)
    }

    /// The same with another road detector than the configuration's.
    ///
    /// # Errors
    /// [`PipelineError`] when configuration, camera or route cannot be used.
    pub fn with_road_detector(
        config: &Config,
        camera: &Camera,
        route: Option<&Route>,
        start_m: Option<f64>,
        detector: Box<dyn RoadDetector>,
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
        let tracker = config.track.tracker(setting, route, start_m)?;
        let state = if tracker.stops().is_empty() { State::NoRoute } else { State::Searching };
        let track = TrackOutput { state, ..TrackOutput::default() };
        Ok(Self {
            camera_watch: CameraWatch::default(),
            unseen_s: None,
            detector,
            centreline: CentrelineFinder::new(&config.centreline, &config.vehicle, &view)?,
            motion: config.motion.estimator()?,
            camera: camera.clone(),
            attitude: AttitudeWatch::new(camera),
            mount: MountFilter::new(&config.mount, view.viewpoint().foot.x),
            signals: VehicleSignals::new(&config.can),
            matcher: Matcher::new(&config.matching, view.grid()),
            tracker,
            lanes: config.lanes.finder()?,
            departure: DepartureWarning::default(),
            map: route.and_then(|route| route.line.first()).map(|first| TangentPlane::new(first.at)),
            config: config.clone(),
            ground: view.black_picture(),
            surface: RoadSurface::default(),
            track_evidence: TrackEvidence::default(),
            output: FrameOutput { track, ..FrameOutput::default() },
            view,
        })
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
        let Self { config, view, ground, surface, tracker, track_evidence, output, .. } = self;
        let validity = view.validity();
        output.camera = camera;
        let unseen_s = self.unseen_s.take();

        let attitude = self.attitude.look_at(&self.camera, frame)?.unwrap_or_default();
        finished(Stage::Mount);

        let Sensors { gps, signals, dt_s } = sensors;
        let since_shown_s = dt_s.map(|dt_s| dt_s + unseen_s.unwrap_or(0.0));
        let (motion, motion_evidence) = self.motion.estimate(view, ground, &attitude)?.unzip();
        let is_gap = since_shown_s.is_some_and(|since_s| since_s > LONGEST_STEP_S);
        let motion = motion.map(|motion| if is_gap { Motion::unknown() } else { motion });
        let camera = motion_evidence.map(|evidence| evidence.camera);
        // A frame whose picture shows nothing still lets the suspension swing back.
        if let Some(motion) = &motion {
            self.mount.observe(&attitude, motion);
        }
        // A motion over frames that showed nothing took longer than this frame.
        let of_frame = motion.as_ref().filter(|_| unseen_s.is_none());
        let (vehicle, signals_evidence) =
            self.signals.step(SignalsInput { samples: signals, motion: of_frame, dt_s });
        let dt_s = since_shown_s;
        finished(Stage::Motion);

        let sample = config.road_surface.sample_region(view);
        let perspective = Perspective::Ground { view, frame };
        let input = RoadInput { picture: ground, validity, sample, perspective, motion: motion.as_ref() };
        let road = self.detector.detect(input, surface)?;
        finished(Stage::Road);

        let (centreline, centreline_evidence) = self.centreline.find(surface, motion.as_ref())?;
        finished(Stage::Centreline);

        let laid = self.matcher.laid_with(surface, (&ground.grey, validity))?;
        let gps_in_map = self.map.as_ref().zip(gps).map(|(map, gps)| map.map_from_wgs84(gps));
        let moved = Moved { motion: motion.as_ref(), camera, dt_s, speed_mps: vehicle.speed_mps };
        let shown = ShownSurface { surface, seen: validity, laid };
        tracker.step(moved, shown, gps_in_map, &mut output.track, track_evidence)?;
        finished(Stage::Match);

        output.motion = motion;
        output.vehicle = vehicle;
        output.centreline = centreline;
        output.mount = matches!(self.camera.view(), View::Calibrated { .. }).then(|| self.mount.estimate());
        output.place_driving_line(tracker.stops());
        finished(Stage::DrivingLine);

        let pitch_change = attitude.pitch_change;
        let lane_input = LaneInput { frame, dt_s, vehicle: &output.vehicle, pitch_change };
        let turns_through = self.lanes.is_some() && tracker.turns_through(&output.track);
        let lanes = match &mut self.lanes {
            Some(finder) if turns_through => {
                finder.reset();
                self.departure = DepartureWarning::default();
                output.lane = None;
                None
            }
            Some(finder) => Some(finder.find(&self.camera, &lane_input, &mut output.lane)?),
            None => None,
        };
        let on_road = output.lane.as_ref().filter(|_| output.mount.is_some()).map(Lane::on_road);
        let (departure, departure_evidence) = on_road
            .map(|lane| {
                let (limits, vehicle) = (&config.lanes.departure, &config.vehicle);
                self.departure.step(limits, vehicle, &lane, &output.vehicle, dt_s.unwrap_or(0.0))
            })
            .unzip();
        output.departure = departure;
        Why {
            track: &output.track,
            evidence: track_evidence,
            stops: tracker.stops(),
            config: &config.track,
            mount: output.mount.as_ref(),
            signals: signals.is_some().then_some(&signals_evidence),
            lane: output.lane.as_ref().zip(lanes),
            turns_through,
            departure: output.departure.as_ref(),
        }
        .write_to(&mut output.why);
        finished(Stage::Lanes);

        let evidence = FrameEvidence {
            ground,
            validity: validity.plane(),
            surface,
            road,
            centreline: centreline_evidence,
            motion: motion_evidence,
            signals: signals.map(|_| signals_evidence),
            track: track_evidence,
            lanes,
            departure: departure_evidence,
            masks: tracker.placed_masks(&output.track, track_evidence, view.grid()),
        };
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
    pub fn tracker(&self) -> &dyn FeatureTracker {
        &*self.tracker
    }

    /// The configuration in force.
    pub const fn config(&self) -> &Config {
        &self.config
    }
}

impl FrameOutput {
    /// Lays the followed feature's driving line where the feature is; the part behind the vehicle is left out.
    fn place_driving_line(&mut self, stops: &[RouteStop]) {
        self.driving_line.clear();
        self.driving_line_curvature_per_m.clear();
        let Some(followed) = &self.track.followed else { return };
        let Some(line) = stops.get(followed.index).and_then(|stop| stop.line.as_ref()) else { return };
        let in_vehicle = line.points.iter().map(|p_in_feature| followed.vehicle_from_feature * p_in_feature);
        let points =
            in_vehicle.zip(&line.curvature_per_m).skip_while(|(p_in_vehicle, _)| p_in_vehicle.x < 0.0);
        for (p_in_vehicle, curvature_per_m) in points {
            self.driving_line.push(p_in_vehicle);
            self.driving_line_curvature_per_m.push(*curvature_per_m);
        }
    }
}
