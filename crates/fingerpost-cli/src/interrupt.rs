//! Ctrl-C: the first ends the work in hand cleanly, the second ends the program.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::{Context, Result};

/// Exit code of a program that a second Ctrl-C ended, as shells count it.
const KILLED_BY_INTERRUPT: i32 = 130;

/// Whether the user wants the work to end.
#[derive(Debug, Clone)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

impl Interrupt {
    /// Listens from now on; once a program.
    pub(crate) fn listen() -> Result<Self> {
        let wanted = Arc::new(AtomicBool::new(false));
        let heard = Arc::clone(&wanted);
        ctrlc::set_handler(move || {
            if heard.swap(true, Ordering::SeqCst) {
                process::exit(KILLED_BY_INTERRUPT);
            }
        })
        .context("Ctrl-C cannot be listened to")?;
        Ok(Self(wanted))
    }

    /// What is set when Ctrl-C is pressed.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// Whether Ctrl-C was pressed.
    pub(crate) fn wanted(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}
