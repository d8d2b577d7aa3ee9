//! The road detector of a configuration, with the network that it asks for.

use anyhow::Result;
use fingerpost::road_surface::{RoadDetector, RoadSurfaceConfig};

/// The detector of these settings; where it needs a network, that is loaded.
pub(crate) fn road_detector(config: &RoadSurfaceConfig) -> Result<Box<dyn RoadDetector>> {
    #[cfg(feature = "onnx")]
    if config.needs_network() {
        return Ok(config.detector_with(Some(crate::onnx::network(&config.onnx)?))?);
    }
    Ok(config.detector()?)
}
