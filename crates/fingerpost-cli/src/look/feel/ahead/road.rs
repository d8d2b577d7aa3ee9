//! The road surface, found ahead.

use fingerpost::road_surface::{RoadDetector, RoadError, RoadEvidence, RoadInput, RoadSurface};
use fingerpost::vision::picture::Plane;
use fingerpost::vision::road_network::RoadNetwork;

use super::notes::{Reader, Writer};

/// What a detector found in a frame.
#[derive(Debug)]
pub(super) struct RoadNote {
    surface: RoadSurface,
    evidence: RoadEvidence,
    /// After the last frame; none of a detector that asks none.
    network: Option<RoadNetwork>,
}

/// A detector whose findings are written down.
pub(super) struct NotedRoad {
    pub(super) detector: Box<dyn RoadDetector>,
    pub(super) notes: Writer<RoadNote>,
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
        let found = self.detector.detect(input, surface);
        let network = self.detector.network().filter(|_| self.notes.is_at_last());
        self.notes.write(match &found {
            Ok(evidence) => Ok(RoadNote {
                surface: surface.clone(),
                evidence: evidence.clone(),
                network: network.cloned(),
            }),
            Err(cause) => Err(cause.to_string()),
        });
        found
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.detector.network()
    }

    fn reset(&mut self) {
        self.detector.reset();
    }
}

/// What was written down, said again frame by frame.
pub(super) struct RepeatedRoad(pub(super) Reader<RoadNote>);

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
        let note = self.0.next().map_err(|reason| RoadError::Network { reason })?;
        surface.clone_from(&note.surface);
        Ok(note.evidence.clone())
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.0.current()?.network.as_ref()
    }

    fn reset(&mut self) {
        self.0.begin_again();
    }
}
