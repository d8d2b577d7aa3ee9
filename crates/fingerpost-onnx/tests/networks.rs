//! Networks in ONNX Runtime itself, loaded from the library that `FINGERPOST_ONNX_LIBRARY` names.

// A failed assumption of a test is a failed test.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::collections::BTreeSet;
use std::path::Path;

use fingerpost::road_surface::{ChannelOrder, OnnxConfig, TensorLayout, UserNetwork};
use fingerpost_onnx::{NetworkError, OnnxRuntime, SegmentationNetwork};
use fingerpost_vision::picture::{Plane, RgbImage};

/// Made by `tools/golden/onnx_network.py`: green is road.
const MODEL: &[u8] = include_bytes!("models/green_is_road.onnx");

fn runtime() -> OnnxRuntime {
    let library = std::env::var("FINGERPOST_ONNX_LIBRARY").expect("FINGERPOST_ONNX_LIBRARY names no library");
    OnnxRuntime::load(Path::new(&library)).unwrap()
}

fn config() -> OnnxConfig {
    OnnxConfig { width_px: 64, height_px: 32, ..OnnxConfig::default() }
}

/// Left half green, right half red.
fn frame() -> RgbImage {
    let (width, height) = (128, 80);
    let row = (0..width).flat_map(|x| if x < width / 2 { [20, 220, 20] } else { [220, 20, 20] });
    let row: Vec<u8> = row.collect();
    RgbImage::from_vec(width, height, row.repeat(height)).unwrap()
}

#[test]
fn a_network_finds_its_road() {
    let mut network = SegmentationNetwork::new(&runtime(), &config(), MODEL).unwrap();
    let mut probability = Plane::default();
    network.segment(&frame(), &mut probability).unwrap();
    assert_eq!(probability.size(), (32, 16));
    let expected = 255.0 / (1.0 + libm::exp(-8.0 * 200.0 / 255.0_f64));
    assert_eq!(probability.get(3, 8).unwrap(), expected.round() as u8);
    assert_eq!(probability.get(28, 8).unwrap(), 255 - expected.round() as u8);
    // A frame of another size, with the channels the other way round: blue and green stay, red moves.
    let bgr = OnnxConfig { channels: ChannelOrder::Bgr, ..config() };
    let mut network = SegmentationNetwork::new(&runtime(), &bgr, MODEL).unwrap();
    network.segment(&RgbImage::new(200, 100), &mut probability).unwrap();
    assert_eq!(probability.get(5, 5), Some(128));
}

#[test]
fn what_does_not_fit_is_refused_before_the_drive() {
    let refused =
        |config: OnnxConfig, model: &[u8]| SegmentationNetwork::new(&runtime(), &config, model).unwrap_err();
    assert!(matches!(refused(config(), b"no network"), NetworkError::Model { .. }));
    let classes = OnnxConfig { road_classes: BTreeSet::from([2]), ..config() };
    assert!(matches!(refused(classes, MODEL), NetworkError::Setting { key: "road_classes", .. }));
    let classes = OnnxConfig { road_classes: BTreeSet::new(), ..config() };
    assert!(matches!(refused(classes, MODEL), NetworkError::Setting { key: "road_classes", .. }));
    let size = OnnxConfig { width_px: 0, ..config() };
    assert!(matches!(refused(size, MODEL), NetworkError::Config(_)));
    let error = refused(OnnxConfig { output: "masks".into(), ..config() }, MODEL);
    assert!(error.to_string().contains("scores"), "{error}");
    let layout = OnnxConfig { layout: TensorLayout::Nhwc, ..config() };
    let error = refused(layout, MODEL).to_string();
    assert!(error.contains("1 x 3 x ? x ? of f32") && error.contains("1 x 32 x 64 x 3"), "{error}");
}

#[test]
fn the_library_that_is_loaded_stays() {
    runtime();
    let error = OnnxRuntime::load(Path::new("/elsewhere/libonnxruntime.so")).unwrap_err();
    assert!(error.to_string().contains("is in use"), "{error}");
}
