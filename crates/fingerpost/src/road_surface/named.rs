//! Another detector for each perspective, with the surface under way named by the bank of known surfaces.

use fingerpost_vision::picture::Plane;
use fingerpost_vision::road_network::RoadNetwork;

use super::{
    BankConfig, Perspective, RoadDetector, RoadError, RoadEvidence, RoadInput, SurfaceFile, SurfaceMemory,
};

/// A detector whose evidence names the surface under way; its probabilities are those of the perspective's detector alone.
pub(super) struct Named {
    surfaces: SurfaceMemory,
    in_camera: Box<dyn RoadDetector>,
    in_ground: Box<dyn RoadDetector>,
}

impl Named {
    pub(super) fn new(
        config: &BankConfig,
        in_camera: Box<dyn RoadDetector>,
        in_ground: Box<dyn RoadDetector>,
    ) -> Result<Self, RoadError> {
        Ok(Self { surfaces: SurfaceMemory::new(config)?, in_camera, in_ground })
    }
}

impl RoadDetector for Named {
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError> {
        let seeing = match input.perspective {
            Perspective::Camera { .. } => &mut self.in_camera,
            Perspective::Ground { .. } => &mut self.in_ground,
        };
        let mut evidence = seeing.estimate(input, probability)?;
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
        self.in_ground.network()
    }

    fn reset(&mut self) {
        self.surfaces.forget();
        self.in_camera.reset();
        self.in_ground.reset();
    }
}
