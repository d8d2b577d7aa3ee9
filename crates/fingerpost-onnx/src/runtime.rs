//! ONNX Runtime, loaded while the program runs.

use std::path::Path;

use ort::environment::Environment;

use crate::error::NetworkError;

/// The loaded library, in which networks run; a program has one at a time.
#[derive(Debug, Clone)]
pub struct OnnxRuntime {
    environment: Environment,
}

impl OnnxRuntime {
    /// Loads the shared library `library`; an empty name is that of the environment variable `ORT_DYLIB_PATH`, or else
    /// the system's. The library that is loaded first stays for the whole program.
    ///
    /// # Errors
    /// [`NetworkError::Library`] when it cannot be loaded, is too old, or another is in use.
    pub fn load(library: &str) -> Result<Self, NetworkError> {
        let refused = |reason: String| NetworkError::Library {
            library: if library.is_empty() { "its usual place".to_owned() } else { library.to_owned() },
            reason,
        };
        let builder = if library.is_empty() {
            ort::init()
        } else {
            ort::init_from(Path::new(library)).map_err(|error| refused(error.to_string()))?
        };
        let builder = builder.with_name("fingerpost").with_telemetry(false);
        Ok(Self { environment: builder.build().map_err(|error| refused(error.to_string()))? })
    }

    pub(crate) const fn environment(&self) -> &Environment {
        &self.environment
    }
}
