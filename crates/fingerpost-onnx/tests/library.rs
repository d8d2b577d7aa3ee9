//! A library that is not there, in a program of its own: the first library that is loaded stays.

// A failed assumption of a test is a failed test.
#![allow(clippy::unwrap_used)]

use fingerpost_onnx::{NetworkError, OnnxRuntime};

#[test]
fn a_missing_library_is_named() {
    let error = OnnxRuntime::load("/nowhere/libonnxruntime.so").unwrap_err();
    assert!(matches!(error, NetworkError::Library { .. }), "{error}");
    assert!(error.to_string().contains("/nowhere/libonnxruntime.so"), "{error}");
}
