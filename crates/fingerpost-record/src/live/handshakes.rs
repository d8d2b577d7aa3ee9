//! Connections that have not said yet what they want.
//!
//! They have no thread and no viewer's place: the thread that waits for viewers looks at all of them in turn. Each has a time to come to
//! its end, and of too many the oldest goes, so that connections which say nothing keep nobody out.

use std::collections::VecDeque;
use std::net::TcpStream;
use std::sync::Arc;
use std::time::{Duration, Instant};

use tungstenite::handshake::MidHandshake;
use tungstenite::handshake::server::ServerHandshake;
use tungstenite::{HandshakeError, WebSocket};

use super::agreement::Agreement;
use super::connection;
use super::live_view::Shared;

/// How long a connection may take to say what it wants, whatever it sends meanwhile.
const PATIENCE: Duration = Duration::from_secs(5);
/// Connections at once; each holds at most the 64 kB of a request that tungstenite reads. A viewer is looked at as soon as it comes,
/// so that it is pushed out only where as many come in the same moment.
const MOST: usize = 64;

/// What tungstenite knows of a handshake that waits for more of its request.
type Begun = MidHandshake<ServerHandshake<TcpStream, Agreement>>;

/// The connections, the oldest first.
#[derive(Default)]
pub(crate) struct Handshakes {
    waiting: VecDeque<(Begun, Instant)>,
}

impl Handshakes {
    /// Takes in a connection.
    pub(crate) fn begin(&mut self, stream: TcpStream, shared: &Arc<Shared>) -> Option<WebSocket<TcpStream>> {
        // On some systems a connection takes this over from the listener, on others not.
        stream.set_nonblocking(true).ok()?;
        stream.set_nodelay(true).ok()?;
        let config = Some(connection::config());
        let begun = tungstenite::accept_hdr_with_config(stream, Agreement::new(shared), config);
        self.go_on(begun, Instant::now())
    }

    /// Looks at every connection once, and gives those that have agreed; the others stay or are let go.
    pub(crate) fn agreed(&mut self) -> Vec<WebSocket<TcpStream>> {
        let in_time = |since: &Instant| since.elapsed() < PATIENCE;
        let waiting = std::mem::take(&mut self.waiting);
        let waiting = waiting.into_iter().filter(|(_, since)| in_time(since));
        waiting.filter_map(|(begun, since)| self.go_on(begun.handshake(), since)).collect()
    }

    /// A connection that has agreed; one that has more to say waits, and one that has failed is gone.
    fn go_on(
        &mut self,
        result: Result<WebSocket<TcpStream>, HandshakeError<ServerHandshake<TcpStream, Agreement>>>,
        since: Instant,
    ) -> Option<WebSocket<TcpStream>> {
        match result {
            Ok(socket) => Some(socket),
            Err(HandshakeError::Interrupted(begun)) => {
                if self.waiting.len() == MOST {
                    self.waiting.pop_front();
                }
                self.waiting.push_back((begun, since));
                None
            }
            Err(HandshakeError::Failure(_)) => None,
        }
    }
}
