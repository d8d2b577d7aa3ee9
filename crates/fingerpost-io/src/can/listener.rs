//! Signals from a bus through Linux's SocketCAN.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use socketcan::{CanAnyFrame, CanFdSocket, EmbeddedFrame, ExtendedId, Id, Socket};
use thiserror::Error;

use super::frame::{CanFrame, CanId};
use super::layout::{SignalLayout, SignalReading};

/// How long a read waits for a frame before it looks whether to end.
const READ_WAIT: Duration = Duration::from_millis(100);

/// A bus that cannot be listened to.
#[derive(Debug, Error)]
pub enum CanListenerError {
    /// The interface cannot be opened.
    #[error(
        "CAN interface {interface:?} cannot be opened ({cause}); see with `ip link` that it exists and is up"
    )]
    Open {
        /// Its name.
        interface: String,
        /// What the system says.
        cause: String,
    },
}

/// What has come of a signal.
#[derive(Debug, Clone, Copy, Default)]
struct Heard {
    /// The newest value, and when it came.
    newest: Option<(f64, Instant)>,
    /// Messages that say that it has none.
    no_values: u64,
}

/// Listens to a bus in a thread of its own and keeps the newest value of each signal.
#[derive(Debug)]
pub struct CanListener {
    heard: Arc<Mutex<Vec<Heard>>>,
    ended: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl CanListener {
    /// Starts to listen for these signals on an interface such as `can0`.
    ///
    /// # Errors
    /// [`CanListenerError::Open`] when there is no such interface, or it is down.
    pub fn open(interface: &str, signals: Vec<SignalLayout>) -> Result<Self, CanListenerError> {
        let open_error = |cause: String| CanListenerError::Open { interface: interface.to_owned(), cause };
        let socket = CanFdSocket::open(interface).map_err(|cause| open_error(cause.to_string()))?;
        socket.set_read_timeout(READ_WAIT).map_err(|cause| open_error(cause.to_string()))?;
        let heard = Arc::new(Mutex::new(vec![Heard::default(); signals.len()]));
        let ended = Arc::new(AtomicBool::new(false));
        let (kept, over) = (Arc::clone(&heard), Arc::clone(&ended));
        let thread = std::thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                // Nothing within the wait, or a bus that is down for a while: the signals grow old, and that is seen.
                let Some(frame) = socket.read_frame().ok().as_ref().and_then(data_frame) else { continue };
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                for (signal, heard) in signals.iter().zip(kept.iter_mut()) {
                    match signal.decode(&frame) {
                        Some(SignalReading::Value(value)) => heard.newest = Some((value, Instant::now())),
                        Some(SignalReading::NoValue(_)) => heard.no_values += 1,
                        None => {}
                    }
                }
            }
        });
        Ok(Self { heard, ended, thread: Some(thread) })
    }

    fn heard(&self, signal: usize) -> Heard {
        let heard = self.heard.lock().unwrap_or_else(PoisonError::into_inner);
        heard.get(signal).copied().unwrap_or_default()
    }

    /// The newest value of a signal, by its place among those that are listened for, and its age in seconds.
    pub fn newest(&self, signal: usize) -> Option<(f64, f64)> {
        let (value, came) = self.heard(signal).newest?;
        Some((value, came.elapsed().as_secs_f64()))
    }

    /// Messages so far that say of a signal that it has no value.
    pub fn no_values(&self, signal: usize) -> u64 {
        self.heard(signal).no_values
    }
}

impl Drop for CanListener {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // A thread that has panicked has nothing left to end.
            let _ = thread.join();
        }
    }
}

/// The frame with its data; none for requests and errors.
fn data_frame(frame: &CanAnyFrame) -> Option<CanFrame> {
    let (id, data) = match frame {
        CanAnyFrame::Normal(frame) => (frame.id(), frame.data()),
        CanAnyFrame::Fd(frame) => (frame.id(), frame.data()),
        CanAnyFrame::Remote(_) | CanAnyFrame::Error(_) => return None,
    };
    let id = match id {
        Id::Standard(id) => CanId::Standard(id.as_raw()),
        Id::Extended(id) => CanId::Extended(ExtendedId::as_raw(&id)),
    };
    CanFrame::new(id, data)
}
