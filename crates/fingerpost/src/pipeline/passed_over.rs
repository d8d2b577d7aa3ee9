//! Frames whose picture shows nothing, or nothing new.

use super::lane_watch::LaneFrame;
use super::{FrameEvidence, FrameOutput, Pipeline, Sensors};
use crate::camera_state::{CameraEvidence, CameraState};
use crate::centreline::Centreline;
use crate::fix::FixInput;
use crate::motion::Motion;
use crate::road_surface::RoadEvidence;
use crate::track::{Decision, TrackEvidence};

impl Pipeline {
    /// Takes in a frame whose picture shows nothing, or nothing new: only the bus says anything. What was seen before is
    /// neither confirmed nor denied; it is given out again while the vehicle stands and the picture repeats.
    pub(super) fn pass_over(
        &mut self,
        camera: CameraEvidence,
        sensors: Sensors,
    ) -> (&FrameOutput, FrameEvidence<'_>) {
        let Self { view, ground, surface, tracker, fix, track_evidence, output, .. } = self;
        let Sensors { signals, gps, dt_s } = sensors;
        let (vehicle, signals_evidence) = self.ego.pass_over(sensors);
        let fix_evidence = fix.as_mut().map(|stage| {
            let (fix, evidence) = stage.step(dt_s, &vehicle, None, FixInput { gps, followed: None });
            output.fix = fix;
            evidence
        });
        let stood = if vehicle.speed_mps.is_some() { vehicle.stands() } else { output.vehicle.stands() };
        let repeats = camera.state == CameraState::Frozen && stood;
        output.track.begin_frame();
        output.centreline = output.centreline.map(Centreline::unseen);
        if !repeats {
            output.track.followed = None;
            output.vehicle = vehicle;
            output.centreline = None;
            output.lane = None;
            output.departure = None;
            output.place_driving_line(tracker.stops());
        }
        output.camera = camera;
        (output.motion, output.motion_doubt) = (Some(Motion::unknown()), None);
        *track_evidence = TrackEvidence { decision: Decision::NothingShown, ..TrackEvidence::default() };
        if surface.probability.size() != view.validity().plane().size() {
            let (columns, rows) = view.validity().plane().size();
            surface.probability.reset(columns, rows, 0);
        }
        let centreline = self.centreline.pass_over();
        let evidence = FrameEvidence {
            ground,
            validity: view.validity().plane(),
            surface,
            road: RoadEvidence::default(),
            network: None,
            centreline,
            motion: None,
            signals: signals.map(|_| signals_evidence),
            track: track_evidence,
            lanes: None,
            departure: None,
            masks: None,
            fix: fix_evidence,
        };
        output.explain(&evidence, &LaneFrame::default(), tracker.stops());
        output.advise(&mut self.advice, tracker.stops(), dt_s);
        (output, evidence)
    }
}
