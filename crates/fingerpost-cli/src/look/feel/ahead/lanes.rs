//! The lane, found ahead as if the vehicle never turned through a junction.

use fingerpost::lanes::{Lane, LaneDetector, LaneError, LaneEvidence, LaneInput};
use fingerpost_geometry::Camera;

use super::notes::{Reader, Writer};

/// What a finder found in a frame.
#[derive(Debug)]
pub(super) struct LaneNote {
    lane: Option<Lane>,
    /// Of the last frame, the only one that is drawn; else empty.
    evidence: LaneEvidence,
}

/// A finder whose findings are written down.
pub(super) struct NotedLanes {
    pub(super) finder: Box<dyn LaneDetector>,
    pub(super) notes: Writer<LaneNote>,
}

impl LaneDetector for NotedLanes {
    fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        let found = self.finder.find(camera, input, lane);
        let is_drawn = self.notes.is_at_last();
        self.notes.write(match &found {
            Ok(evidence) => Ok(LaneNote {
                lane: lane.clone(),
                evidence: if is_drawn { (*evidence).clone() } else { LaneEvidence::default() },
            }),
            Err(cause) => Err(cause.to_string()),
        });
        found
    }

    fn reset(&mut self) {
        self.finder.reset();
    }
}

/// What was written down, said again frame by frame. Once the vehicle turns through a junction, where lanes are forgotten, a finder of its own
/// begins anew.
pub(super) struct RepeatedLanes {
    pub(super) notes: Reader<LaneNote>,
    /// One that has seen no frame.
    pub(super) finder: Box<dyn LaneDetector>,
    pub(super) source: LaneSource,
}

/// Where lanes come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum LaneSource {
    /// What was written down.
    Notes,
    /// The finder itself.
    Finder,
}

impl LaneDetector for RepeatedLanes {
    fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        if self.source == LaneSource::Notes
            && let Ok(note) = self.notes.next()
        {
            lane.clone_from(&note.lane);
            return Ok(&note.evidence);
        }
        // A frame that a finder refused is refused again.
        self.finder.find(camera, input, lane)
    }

    fn reset(&mut self) {
        self.source = LaneSource::Finder;
        self.finder.reset();
    }
}
