//! ONNX Runtime, loaded while the program runs.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ort::environment::Environment;

use crate::error::{NetworkError, one_line};

/// The loaded library, in which networks run.
#[derive(Debug, Clone)]
pub struct OnnxRuntime {
    library: PathBuf,
    environment: Environment,
}

/// ONNX Runtime allows one environment a process, which then stays.
static LOADED: Mutex<Option<OnnxRuntime>> = Mutex::new(None);

impl OnnxRuntime {
    /// Loads the shared library `library`: a path, or a name that the system's loader finds. The first library that is
    /// loaded stays for the whole process; asked for again, it is handed out again.
    ///
    /// # Errors
    /// [`NetworkError::Library`] when it cannot be loaded, is too old, or another is in use.
    pub fn load(library: &Path) -> Result<Self, NetworkError> {
        let refused =
            |reason: String| NetworkError::Library { library: library.display().to_string(), reason };
        let mut loaded = LOADED.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(runtime) = &*loaded {
            return if runtime.library == library {
                Ok(runtime.clone())
            } else {
                Err(refused(format!("{} is in use and stays", runtime.library.display())))
            };
        }
        let builder = ort::init_from(library).map_err(|error| refused(system_reason(&error)))?;
        let builder = builder.with_name("fingerpost").with_telemetry(false);
        let environment = builder.build().map_err(|error| refused(one_line(&error)))?;
        Ok(loaded.insert(Self { library: library.to_owned(), environment }).clone())
    }

    pub(crate) const fn environment(&self) -> &Environment {
        &self.environment
    }
}

/// Why a library cannot be loaded; of a file that the system refuses, what the system says.
fn system_reason(error: &ort::LoadDynamicError) -> String {
    match error {
        ort::LoadDynamicError::Dlopen { error, .. } => one_line(error.source().unwrap_or(error)),
        other => one_line(other),
    }
}
