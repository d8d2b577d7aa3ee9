//! The stages of a configuration that the method itself does not have: the papers' own, and the detector of a network that a user brings.

use anyhow::Result;
use fingerpost::Config;
use fingerpost::pipeline::Parts;
#[cfg(feature = "onnx")]
use fingerpost::road_surface::Onnx;
use fingerpost::road_surface::{RoadDetector, RoadSurfaceConfig};

/// All stages that are to be given to a pipeline of this configuration.
pub(crate) fn parts(config: &Config) -> Result<Parts> {
    let mut parts = fingerpost_papers::parts(config)?;
    if config.road_surface.needs_onnx() {
        parts.road_detector = Some(road_detector(&config.road_surface)?);
    }
    Ok(parts)
}

/// The road detector of these settings; where it needs a network, that is loaded.
pub(crate) fn road_detector(config: &RoadSurfaceConfig) -> Result<Box<dyn RoadDetector>> {
    #[cfg(feature = "onnx")]
    if config.needs_onnx() {
        let network = Onnx::new(crate::onnx::network(&config.onnx)?);
        return Ok(config.detector_with(Some(Box::new(network)))?);
    }
    Ok(fingerpost_papers::road_detector(config)?)
}
