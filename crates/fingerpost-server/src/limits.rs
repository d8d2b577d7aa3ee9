//! What a server grants those who connect to it.

use std::time::Duration;

/// Bounds of a server; the product of the connections and what each may hold bounds its memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Connections at once (default 64: browsers open six to an address, and a person has a few pages open). One more closes
    /// the one that has been idle for longest; where none is idle it is answered with 503.
    pub connections: usize,
    /// Bytes of a request's body (default 1 MiB: an edge of a thousand points is a twentieth of it); a larger one is answered
    /// with 413 and not read.
    pub body_bytes: usize,
    /// Bytes of a request's head (default 16 KiB, at least 8 KiB: browsers send one or two); a larger one is answered with 431.
    pub head_bytes: usize,
    /// Header lines of a request (default 64: browsers send about twenty); more are answered with 431.
    pub header_lines: usize,
    /// How long a whole request may take from its head's end to its answer (default 30 s: a picture that ffmpeg has to fetch
    /// takes a few).
    pub request_time: Duration,
    /// How long a connection may stay without a whole request's head coming in or an answer being taken (default 30 s: a
    /// browser opens another one at once).
    pub idle_time: Duration,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            connections: 64,
            body_bytes: 1 << 20,
            head_bytes: 16 << 10,
            header_lines: 64,
            request_time: Duration::from_secs(30),
            idle_time: Duration::from_secs(30),
        }
    }
}
