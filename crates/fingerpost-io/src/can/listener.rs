//! Signals from a bus through Linux's SocketCAN.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use socketcan::{CanAnyFrame, CanFdSocket, EmbeddedFrame, ExtendedId, Id, Socket};
use thiserror::Error;

use super::frame::{CanFrame, CanId};
use super::layout::SignalLayout;

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

/// The newest value of a signal, and when it came.
type Newest = Option<(f64, Instant)>;

/// Listens to a bus in a thread of its own and keeps the newest value of each signal.
#[derive(Debug)]
pub struct CanListener {
    newest: Arc<Mutex<Vec<Newest>>>,
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
        let newest = Arc::new(Mutex::new(vec![None; signals.len()]));
        let ended = Arc::new(AtomicBool::new(false));
        let (kept, over) = (Arc::clone(&newest), Arc::clone(&ended));
        let thread = std::thread::spawn(move || {
            while !over.load(Ordering::Relaxed) {
                // Nothing within the wait, or a bus that is down for a while: the signals grow old, and that is seen.
                let Some(frame) = socket.read_frame().ok().as_ref().and_then(data_frame) else { continue };
                let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
                for (signal, newest) in signals.iter().zip(kept.iter_mut()) {
                    if let Some(value) = signal.decode(&frame) {
                        *newest = Some((value, Instant::now()));
                    }
                }
            }
        });
        Ok(Self { newest, ended, thread: Some(thread) })
    }

    /// The newest value of a signal, by its place among those that are listened for, and its age in seconds.
    pub fn newest(&self, signal: usize) -> Option<(f64, f64)> {
        let newest = self.newest.lock().unwrap_or_else(PoisonError::into_inner);
        let (value, came) = (*newest.get(signal)?)?;
        Some((value, came.elapsed().as_secs_f64()))
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
