//! What is read off the stages' results for the output of a frame.

use super::lane_watch::LaneFrame;
use super::{FrameEvidence, FrameOutput};
use crate::advice::{AdviceInput, AdviceStage};
use crate::centreline::Guide;
use crate::track::RouteStop;
use crate::why::Why;

impl FrameOutput {
    /// What the followed feature says of the road.
    pub(super) fn guide(&self, stops: &[RouteStop]) -> Option<Guide<'_>> {
        let followed = self.track.followed.as_ref()?;
        let pose = (&followed.vehicle_from_feature, &followed.covariance);
        Some(Guide::new(&stops.get(followed.index)?.model, pose, &self.driving_line))
    }

    /// Says in one sentence what was decided in the frame and what decided it.
    pub(super) fn explain(
        &mut self,
        evidence: &FrameEvidence<'_>,
        lanes: &LaneFrame<'_>,
        stops: &[RouteStop],
    ) {
        let Self { camera, motion_doubt, track, mount, lane, departure, why, .. } = self;
        let FrameEvidence { track: of_track, signals, lanes: of_lanes, centreline, road, fix, .. } = evidence;
        Why {
            camera,
            motion_doubt: *motion_doubt,
            track,
            evidence: of_track,
            stops,
            mount: mount.as_ref(),
            signals: signals.as_ref(),
            lane: lane.as_ref().zip(*of_lanes),
            turns_through: lanes.turns_through,
            centreline,
            by_colours: road.by_colours,
            departure: departure.as_ref(),
            fix: fix.as_ref(),
        }
        .write_to(why);
    }

    /// Puts the advice for the frame in place of the one before.
    pub(super) fn advise(&mut self, stage: &mut AdviceStage, stops: &[RouteStop], dt_s: Option<f64>) {
        let Self { motion, motion_doubt, vehicle, track, centreline, lane, advice, .. } = self;
        let input = AdviceInput {
            motion: motion.as_ref(),
            motion_doubt: *motion_doubt,
            speed_mps: vehicle.speed_mps,
            track,
            stops,
            centreline: centreline.as_ref(),
            lane: lane.as_ref(),
            dt_s,
        };
        stage.advise(&input, advice);
    }

    /// Lays the followed feature's driving line where the feature is; the part behind the vehicle is left out.
    pub(super) fn place_driving_line(&mut self, stops: &[RouteStop]) {
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
