//! The road surface of a stretch, found once: most of a frame's time goes into it, and settings of later stages leave it as it is.

use std::sync::{Arc, Mutex, PoisonError};

use fingerpost::road_surface::{RoadDetector, RoadError, RoadEvidence, RoadInput, RoadSurface};
use fingerpost::vision::picture::Plane;
use fingerpost::vision::road_network::RoadNetwork;
use fingerpost_format::TriedSettings;

/// Tables of the stages behind the road surface in a frame, whose output nothing before them reads in the next one.
const LATER_STAGES: [&str; 8] =
    ["feature_mask", "match", "track", "route_progress", "driving_line", "centreline", "lanes", "advice"];

/// Whether all of these settings are of stages behind the road surface.
pub(super) fn leave_the_road(changed: &TriedSettings) -> bool {
    changed.keys().all(|key| key.split('.').next().is_some_and(|table| LATER_STAGES.contains(&table)))
}

/// What a detector found in each frame that it was asked about, in their order.
#[derive(Debug, Default)]
pub(super) struct FoundRoad {
    frames: Vec<(RoadSurface, RoadEvidence)>,
    /// The network after the last frame; none of a detector that asks none.
    pub(super) network: Option<RoadNetwork>,
}

/// What is written down while a stretch is run.
pub(super) type RoadNotes = Arc<Mutex<FoundRoad>>;

/// A detector whose findings are written down.
pub(super) struct NotedRoad {
    pub(super) detector: Box<dyn RoadDetector>,
    pub(super) notes: RoadNotes,
}

impl RoadDetector for NotedRoad {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        self.detector.estimate(input, probability)
    }

    fn detect(&mut self, input: RoadInput<'_>, surface: &mut RoadSurface) -> Result<RoadEvidence, RoadError> {
        let evidence = self.detector.detect(input, surface)?;
        let mut notes = self.notes.lock().unwrap_or_else(PoisonError::into_inner);
        notes.frames.push((surface.clone(), evidence.clone()));
        Ok(evidence)
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.detector.network()
    }

    fn reset(&mut self) {
        self.detector.reset();
    }
}

/// What was written down, said again frame by frame.
pub(super) struct RepeatedRoad {
    found: Arc<FoundRoad>,
    next: usize,
}

impl RepeatedRoad {
    /// Of a stretch from its first frame on.
    pub(super) const fn of(found: Arc<FoundRoad>) -> Self {
        Self { found, next: 0 }
    }
}

impl RoadDetector for RepeatedRoad {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let mut surface = RoadSurface::default();
        let evidence = self.detect(input, &mut surface)?;
        probability.clone_from(&surface.probability);
        Ok(evidence)
    }

    fn detect(&mut self, _: RoadInput<'_>, surface: &mut RoadSurface) -> Result<RoadEvidence, RoadError> {
        // A frame more than were written down would be another stretch's: nothing is known of it.
        let (found, evidence) = self.found.frames.get(self.next).cloned().unwrap_or_default();
        self.next += 1;
        *surface = found;
        Ok(evidence)
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.found.network.as_ref()
    }

    fn reset(&mut self) {
        self.next = 0;
    }
}
