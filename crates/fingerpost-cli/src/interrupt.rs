//! Signals that end the program: the first ends the work in hand cleanly, the second ends the program.

use std::fs;
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use anyhow::{Context, Result};
use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM, SIGXFSZ};
use signal_hook::iterator::Signals;

use crate::output;

/// What shells add to a signal's number for the exit code of a program that it ended.
const KILLED_BY_SIGNAL: i32 = 128;
/// Exit code of a program whose work did not end well, as of one that ends the work in hand.
const FAILED: i32 = 1;

/// Whether the user or the system wants the work to end.
#[derive(Debug, Clone)]
pub(crate) struct Interrupt(Arc<AtomicBool>);

/// Signals before the work begins: what is read and made ready leaves nothing behind, so that the first signal ends the program, which
/// says so.
#[derive(Debug)]
pub(crate) struct Preparation {
    wanted: Arc<AtomicBool>,
    is_over: Arc<AtomicBool>,
}

impl Preparation {
    /// Listens from now on to Ctrl-C, to SIGTERM, and to SIGHUP where that is not ignored, as under nohup; once a program.
    pub(crate) fn listen() -> Result<Self> {
        let (wanted, is_over) = (Arc::new(AtomicBool::new(false)), Arc::new(AtomicBool::new(false)));
        let (heard, working) = (Arc::clone(&wanted), Arc::clone(&is_over));
        let ending: &[i32] = if is_ignored(SIGHUP) { &[SIGINT, SIGTERM] } else { &[SIGINT, SIGTERM, SIGHUP] };
        let mut signals = Signals::new(ending).context("signals cannot be listened to")?;
        let listen = move || {
            for signal in signals.forever() {
                let is_second = heard.swap(true, Ordering::SeqCst);
                if is_second {
                    process::exit(KILLED_BY_SIGNAL + signal);
                }
                if !working.load(Ordering::SeqCst) {
                    output::error("fingerpost: interrupted before the first result; nothing was written");
                    process::exit(FAILED);
                }
            }
        };
        thread::Builder::new().name("signals".to_owned()).spawn(listen).context("no thread for signals")?;
        Ok(Self { wanted, is_over })
    }

    /// Whether the work in hand is to end, from now on.
    pub(crate) fn work_begins(self) -> Interrupt {
        self.is_over.store(true, Ordering::SeqCst);
        Interrupt(self.wanted)
    }
}

impl Interrupt {
    /// Listens from now on, the work having begun; once a program.
    pub(crate) fn listen() -> Result<Self> {
        Ok(Preparation::listen()?.work_begins())
    }

    /// What is set when the work is to end.
    pub(crate) fn flag(&self) -> &AtomicBool {
        &self.0
    }

    /// The same for whoever looks at it longer.
    pub(crate) fn shared_flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0)
    }

    /// Whether the work is to end.
    pub(crate) fn wanted(&self) -> bool {
        self.0.load(Ordering::SeqCst)
    }
}

/// Makes a file that reaches its size limit (`ulimit -f`) an error of writing, as a full disk is, instead of the end of
/// the program.
pub(crate) fn survive_file_size_limit() -> Result<()> {
    // Nobody looks at the flag: being handled is what keeps the signal from ending the program.
    signal_hook::flag::register(SIGXFSZ, Arc::new(AtomicBool::new(false)))
        .context("the signal of the file size limit cannot be handled")?;
    Ok(())
}

/// Whether the program was started with a signal ignored; where the system does not say, it was not.
fn is_ignored(signal: i32) -> bool {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
