//! The network of a configuration, read from its file and run in ONNX Runtime.

use std::env::{consts, var_os};
use std::path::PathBuf;

use anyhow::{Context, Result, bail};
use fingerpost::road_surface::{OnnxConfig, UserNetwork};
use fingerpost_onnx::{OnnxRuntime, SegmentationNetwork};

/// Names the shared library of ONNX Runtime where the configuration does not.
const LIBRARY_VARIABLE: &str = "FINGERPOST_ONNX_LIBRARY";

/// Loads the network.
pub(crate) fn network(config: &OnnxConfig) -> Result<Box<dyn UserNetwork>> {
    if config.model.is_empty() {
        bail!("road_surface.onnx.model names no network; give the path of its ONNX file");
    }
    let model = fingerpost_io::read_bytes(config.model.as_ref())?;
    let runtime = OnnxRuntime::load(&library(config))?;
    let network = SegmentationNetwork::new(&runtime, config, &model).with_context(|| config.model.clone())?;
    Ok(Box::new(network))
}

/// Where ONNX Runtime is: by the configuration, by the environment, or wherever the system's loader looks.
fn library(config: &OnnxConfig) -> PathBuf {
    if !config.library.is_empty() {
        return PathBuf::from(&config.library);
    }
    match var_os(LIBRARY_VARIABLE) {
        Some(library) if !library.is_empty() => library.into(),
        _ => format!("{}onnxruntime{}", consts::DLL_PREFIX, consts::DLL_SUFFIX).into(),
    }
}
