//! The server: a thread that waits for viewers, and one for each of them.

use std::io;
use std::net::{Ipv4Addr, Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use fingerpost_map::Route;
use thiserror::Error;
use tungstenite::WebSocket;

use super::connection;
use super::handshakes::Handshakes;
use super::origin::Origin;
use super::viewer::Viewer;
use crate::recording::{FrameMessages, RecordingError, route_message};

/// Viewers at once; each takes a thread and the machine's time.
const MOST_VIEWERS: usize = 8;
/// How often a new viewer is looked for.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Times so long that viewers have at the end to take what still waits for them: a run that is told to end does within a second.
const LOOKS_AT_END: u32 = 25;

/// A server that cannot begin.
#[derive(Debug, Error)]
pub enum LiveError {
    /// The port cannot be listened on.
    #[error(
        "port {port} of this machine cannot be served on ({cause}); choose another port, or 0 for any that is free"
    )]
    Listen {
        /// The port.
        port: u16,
        /// What the system says.
        cause: io::Error,
    },
    /// The route has no message.
    #[error(transparent)]
    Route(#[from] RecordingError),
}

/// What the threads share.
#[derive(Debug)]
pub(crate) struct Shared {
    pub(crate) name: String,
    pub(crate) port: u16,
    /// Sites whose pages may connect, beside those that always may.
    pub(crate) origins: Vec<Origin>,
    pub(crate) route: Option<Vec<u8>>,
    /// Nothing more comes.
    ended: AtomicBool,
    viewers: Mutex<Vec<Arc<Viewer>>>,
}

impl Shared {
    pub(crate) fn has_ended(&self) -> bool {
        self.ended.load(Ordering::Acquire)
    }

    fn viewers(&self) -> std::sync::MutexGuard<'_, Vec<Arc<Viewer>>> {
        self.viewers.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Serves frames to the viewers that are connected.
#[derive(Debug)]
pub struct LiveView {
    shared: Arc<Shared>,
    waiting: Option<JoinHandle<()>>,
}

impl LiveView {
    /// Begins to serve a drive along `route` on a port of the loopback address; 0 takes any that is free. Programs may connect, and pages
    /// of Foxglove, of this machine and of `origins`.
    ///
    /// # Errors
    /// [`LiveError`] when the port cannot be listened on, or the route has no message.
    pub fn begin(
        name: &str,
        port: u16,
        origins: &[Origin],
        route: Option<&Route>,
    ) -> Result<Self, LiveError> {
        let listen = |cause| LiveError::Listen { port, cause };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        let shared = Arc::new(Shared {
            name: name.to_owned(),
            port: listener.local_addr().map_err(listen)?.port(),
            origins: origins.to_vec(),
            route: route.map(route_message).transpose()?,
            ended: AtomicBool::new(false),
            viewers: Mutex::default(),
        });
        let theirs = Arc::clone(&shared);
        let waiting = thread::spawn(move || wait_for_viewers(&listener, &theirs));
        Ok(Self { shared, waiting: Some(waiting) })
    }

    /// The address that viewers connect to.
    pub fn address(&self) -> String {
        format!("ws://{}:{}", Ipv4Addr::LOCALHOST, self.shared.port)
    }

    /// Whether anybody is connected.
    pub fn has_viewers(&self) -> bool {
        !self.shared.viewers().is_empty()
    }

    /// Gives a frame's messages to those who are connected; waits for nobody.
    pub fn send(&self, frame: &Arc<FrameMessages>) {
        self.shared.viewers().iter().for_each(|viewer| viewer.add(frame));
    }
}

/// Ends the server when viewers have what waits for them.
impl Drop for LiveView {
    fn drop(&mut self) {
        self.shared.ended.store(true, Ordering::Release);
        // A thread that ended early has said nothing that could be told here.
        let _ = self.waiting.take().map(JoinHandle::join);
    }
}

/// A viewer's thread, and its connection, to be cut where it holds up the end.
struct Connection {
    thread: JoinHandle<()>,
    stream: Option<TcpStream>,
}

/// Takes viewers in until nothing more comes.
fn wait_for_viewers(listener: &TcpListener, shared: &Arc<Shared>) {
    let mut connections: Vec<Connection> = Vec::new();
    let mut handshakes = Handshakes::default();
    while !shared.has_ended() {
        connections.retain(|connection| !connection.thread.is_finished());
        let accepted = listener.accept();
        let at_once = accepted.as_ref().is_ok();
        let new = accepted.ok().and_then(|(stream, _)| handshakes.begin(stream, shared));
        for socket in new.into_iter().chain(handshakes.agreed()) {
            if connections.len() == MOST_VIEWERS {
                connection::turn_away(socket);
                continue;
            }
            let (theirs, stream) = (Arc::clone(shared), socket.get_ref().try_clone().ok());
            let thread = thread::spawn(move || serve(socket, &theirs));
            connections.push(Connection { thread, stream });
        }
        // Nobody, or a connection that broke off before it was taken.
        if !at_once {
            thread::sleep(LOOK_EVERY);
        }
    }
    for _ in 0..LOOKS_AT_END {
        if connections.iter().all(|connection| connection.thread.is_finished()) {
            break;
        }
        thread::sleep(LOOK_EVERY);
    }
    for Connection { thread, stream } in connections {
        // A connection that is closed already needs no cutting.
        let _ = stream.map(|stream| stream.shutdown(Shutdown::Both));
        let _ = thread.join();
    }
}

/// Serves one viewer for as long as it stays.
fn serve(mut socket: WebSocket<TcpStream>, shared: &Arc<Shared>) {
    // Why a viewer left is its own matter.
    if connection::greet(&mut socket, shared).is_err() {
        return;
    }
    let viewer = Arc::new(Viewer::default());
    shared.viewers().push(Arc::clone(&viewer));
    let _ = connection::serve(socket, &viewer, shared);
    shared.viewers().retain(|other| !Arc::ptr_eq(other, &viewer));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_port_that_is_taken_is_named() {
        let first = LiveView::begin("test", 0, &[], None).unwrap();
        let error = LiveView::begin("test", first.shared.port, &[], None).unwrap_err().to_string();
        assert!(error.contains(&first.shared.port.to_string()) && error.contains("another port"), "{error}");
    }
}
