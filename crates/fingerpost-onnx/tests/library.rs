//! A library that is not there, or is none, in a program of its own: the first library that is loaded stays.

// A failed assumption of a test is a failed test.
#![allow(clippy::unwrap_used)]

use std::path::Path;

use fingerpost_onnx::{NetworkError, OnnxRuntime};

#[test]
fn what_is_no_library_is_named() {
    let own = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    for library in [Path::new("/nowhere/libonnxruntime.so"), &own] {
        let error = OnnxRuntime::load(library).unwrap_err();
        assert!(matches!(error, NetworkError::Library { .. }), "{error}");
        assert!(error.to_string().contains(&library.display().to_string()), "{error}");
    }
}
