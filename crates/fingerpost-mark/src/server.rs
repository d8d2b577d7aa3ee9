//! Page and desk served on the loopback address, to this machine alone.

use std::io::{Cursor, Read};
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use thiserror::Error;
use tiny_http::{Header, Response, Server};

use crate::desk::{Answer, Desk, Request};

/// How often a server without work looks whether it is to stop.
const STOP_POLL: Duration = Duration::from_millis(100);
/// What a request may carry; an edge of a thousand points is a twentieth of it.
const MOST_BYTES: u64 = 1 << 20;
/// The page takes nothing from elsewhere, runs nothing but its own script and may not be framed.
const HEADERS: [(&str, &str); 5] = [
    (
        "Content-Security-Policy",
        "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    ("X-Content-Type-Options", "nosniff"),
    ("Referrer-Policy", "no-referrer"),
    ("Cross-Origin-Resource-Policy", "same-origin"),
    ("Cache-Control", "no-store"),
];

/// A server that cannot be started.
#[derive(Debug, Error)]
pub enum ServerError {
    /// The port is not to be had.
    #[error(
        "port {port} of this machine cannot be opened ({cause}); choose another --port, or 0 for any that is free"
    )]
    Port {
        /// The port.
        port: u16,
        /// What the system says.
        cause: String,
    },
}

/// A server on 127.0.0.1.
///
/// Requests must name this address in `Host`, and in `Origin` where they have one, so that no page of another site can
/// reach it through a name of its own; edits must be JSON, which such a page may not send.
pub struct MarkServer {
    server: Server,
    port: u16,
}

impl std::fmt::Debug for MarkServer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("MarkServer").field("port", &self.port).finish_non_exhaustive()
    }
}

impl MarkServer {
    /// Opens the port; 0 stands for any that is free.
    ///
    /// # Errors
    /// [`ServerError::Port`] when it cannot be opened.
    pub fn open(port: u16) -> Result<Self, ServerError> {
        let server = Server::http((Ipv4Addr::LOCALHOST, port))
            .map_err(|cause| ServerError::Port { port, cause: cause.to_string() })?;
        let port = server.server_addr().to_ip().map_or(port, |address| address.port());
        Ok(Self { server, port })
    }

    /// Where a browser finds the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers requests until `stop` is set.
    ///
    /// Each is answered in a thread of its own: one whose body never ends, or whose answer is never read, holds up no other.
    /// Such a thread ends with its connection, and is not waited for.
    pub fn serve(&self, desk: &Arc<Desk>, stop: &AtomicBool) {
        while !stop.load(Ordering::Relaxed) {
            match self.server.recv_timeout(STOP_POLL) {
                Ok(Some(request)) => {
                    let (desk, port) = (Arc::clone(desk), self.port);
                    // Where the system has no thread left, the request goes unanswered and the browser says so.
                    let _ = thread::Builder::new().spawn(move || answer(request, &desk, port));
                }
                Ok(None) => {}
                // The port is gone; there is nothing left to answer.
                Err(_) => return,
            }
        }
    }
}

fn answer(mut request: tiny_http::Request, desk: &Desk, port: u16) {
    let method = request.method().as_str().to_owned();
    let path = request.url().split(['?', '#']).next().unwrap_or_default().to_owned();
    let header = |name: &'static str| {
        let found = request.headers().iter().find(|header| header.field.equiv(name));
        found.map(|header| header.value.as_str().to_owned())
    };
    let guarded = Guarded {
        method: &method,
        host: header("Host"),
        origin: header("Origin"),
        content_type: header("Content-Type"),
    };
    let answer = guarded.refusal(port).unwrap_or_else(|| match body(&mut request) {
        Ok(body) => desk.answer(Request { method: &method, path: &path, body: &body }),
        Err(refusal) => refusal,
    });
    // A browser that has gone away needs no answer.
    let _ = request.respond(response(answer));
}

/// What decides whether a request is answered at all.
struct Guarded<'a> {
    method: &'a str,
    host: Option<String>,
    origin: Option<String>,
    content_type: Option<String>,
}

impl Guarded<'_> {
    fn refusal(&self, port: u16) -> Option<Answer> {
        let hosts = [format!("127.0.0.1:{port}"), format!("localhost:{port}")];
        let own = |name: &str| hosts.iter().any(|host| host == name);
        if !self.host.as_deref().is_some_and(own) {
            return Some(Answer::refused(403, &format!("open http://127.0.0.1:{port}/ on this machine")));
        }
        let origin = self.origin.as_deref();
        if origin.is_some_and(|origin| !origin.strip_prefix("http://").is_some_and(own)) {
            return Some(Answer::refused(403, "another site's page may not mark"));
        }
        let json = self.content_type.as_deref().is_some_and(|kind| kind.starts_with("application/json"));
        (self.method == "POST" && !json).then(|| Answer::refused(415, "send JSON"))
    }
}

fn body(request: &mut tiny_http::Request) -> Result<Vec<u8>, Answer> {
    let mut body = Vec::new();
    match request.as_reader().take(MOST_BYTES + 1).read_to_end(&mut body) {
        Ok(_) if body.len() as u64 > MOST_BYTES => Err(Answer::refused(413, "an edit is smaller than this")),
        Ok(_) => Ok(body),
        Err(cause) => Err(Answer::refused(400, &cause.to_string())),
    }
}

fn response(answer: Answer) -> Response<Cursor<Vec<u8>>> {
    let fixed = HEADERS.into_iter().chain([("Content-Type", answer.content_type)]);
    let headers = fixed.filter_map(|(name, value)| Header::from_bytes(name, value).ok());
    let length = answer.body.len();
    let body = Cursor::new(answer.body);
    Response::new(answer.status.into(), headers.collect(), body, Some(length), None)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn status(
        method: &str,
        host: Option<&str>,
        origin: Option<&str>,
        content_type: Option<&str>,
    ) -> Option<u16> {
        let owned = |text: Option<&str>| text.map(str::to_owned);
        let guarded =
            Guarded { method, host: owned(host), origin: owned(origin), content_type: owned(content_type) };
        guarded.refusal(8420).map(|refusal| refusal.status)
    }

    #[test]
    fn only_this_machines_own_page_is_answered() {
        let own = Some("127.0.0.1:8420");
        assert_eq!(status("GET", own, None, None), None);
        assert_eq!(status("GET", Some("localhost:8420"), None, None), None);
        assert_eq!(status("POST", own, Some("http://127.0.0.1:8420"), Some("application/json")), None);
        for host in [
            None,
            Some("evil.example"),
            Some("127.0.0.1"),
            Some("127.0.0.1:80"),
            Some("127.0.0.1:8420.evil.example"),
        ] {
            assert_eq!(status("GET", host, None, None), Some(403), "{host:?}");
        }
        for origin in ["http://evil.example", "https://127.0.0.1:8420", "null"] {
            assert_eq!(status("POST", own, Some(origin), Some("application/json")), Some(403), "{origin}");
        }
        assert_eq!(status("POST", own, None, Some("text/plain")), Some(415));
        assert_eq!(status("POST", own, None, None), Some(415));
    }
}
