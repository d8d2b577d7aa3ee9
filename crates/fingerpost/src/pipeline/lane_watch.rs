//! The lane by its markings, and whether it is being left.

use fingerpost_geometry::Camera;

use super::FrameOutput;
use crate::config::Config;
use crate::lanes::departure::{DepartureEvidence, DepartureWarning};
use crate::lanes::{Lane, LaneDetector, LaneError, LaneEvidence, LaneInput};
use crate::track::BeliefTracker;

/// The lane finder, where lanes are looked for, and the departure warning behind it.
pub(super) struct LaneWatch {
    finder: Option<Box<dyn LaneDetector>>,
    departure: DepartureWarning,
}

/// How it came to its output.
#[derive(Default)]
pub(super) struct LaneFrame<'a> {
    pub(super) evidence: Option<&'a LaneEvidence>,
    pub(super) departure: Option<DepartureEvidence>,
    /// Lanes were not looked for, because the vehicle turns through a junction.
    pub(super) turns_through: bool,
}

impl LaneWatch {
    pub(super) fn new(finder: Option<Box<dyn LaneDetector>>) -> Self {
        Self { finder, departure: DepartureWarning::default() }
    }

    /// Looks for the lane in one frame of a vehicle that follows what `tracker` follows.
    ///
    /// # Errors
    /// [`LaneError`] when the picture does not fit the camera.
    pub(super) fn step(
        &mut self,
        config: &Config,
        camera: &Camera,
        input: &LaneInput<'_>,
        tracker: &BeliefTracker,
        output: &mut FrameOutput,
    ) -> Result<LaneFrame<'_>, LaneError> {
        output.departure = None;
        let Some(finder) = &mut self.finder else { return Ok(LaneFrame::default()) };
        // Lanes end where the vehicle turns through a junction, and lines cross its way.
        if tracker.turns_through(&output.track) {
            finder.reset();
            self.departure = DepartureWarning::default();
            output.lane = None;
            return Ok(LaneFrame { turns_through: true, ..LaneFrame::default() });
        }
        let evidence = finder.find(camera, input, &mut output.lane)?;
        let on_road = output.lane.as_ref().filter(|_| output.mount.is_some()).map(Lane::on_road);
        let (departure, departure_evidence) = on_road
            .map(|lane| {
                let (limits, dt_s) = (&config.lanes.departure, input.dt_s.unwrap_or(0.0));
                self.departure.step(limits, &config.vehicle, &lane, input.vehicle, dt_s)
            })
            .unzip();
        output.departure = departure;
        Ok(LaneFrame { evidence: Some(evidence), departure: departure_evidence, turns_through: false })
    }
}
