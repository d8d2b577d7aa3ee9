//! Another detector, with the surface under way named by the bank of known surfaces.

use fingerpost_vision::picture::Plane;
use fingerpost_vision::road_network::RoadNetwork;

use super::{BankConfig, RoadDetector, RoadError, RoadEvidence, RoadInput, SurfaceFile, SurfaceMemory};

/// A detector whose evidence names the surface under way; its probabilities are those of the other detector alone.
pub(super) struct Named {
    surfaces: SurfaceMemory,
    seeing: Box<dyn RoadDetector>,
}

impl Named {
    pub(super) fn new(config: &BankConfig, seeing: Box<dyn RoadDetector>) -> Result<Self, RoadError> {
        Ok(Self { surfaces: SurfaceMemory::new(config)?, seeing })
    }
}

impl RoadDetector for Named {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let mut evidence = self.seeing.estimate(input, probability)?;
        evidence.bank = Some(self.surfaces.consider(&input)?.0);
        Ok(evidence)
    }

    fn know(&mut self, surfaces: &SurfaceFile) -> Result<(), RoadError> {
        self.surfaces.know(surfaces)
    }

    fn known_surfaces(&self) -> Option<SurfaceFile> {
        Some(self.surfaces.file())
    }

    fn network(&self) -> Option<&RoadNetwork> {
        self.seeing.network()
    }

    fn reset(&mut self) {
        self.surfaces.forget();
        self.seeing.reset();
    }
}
