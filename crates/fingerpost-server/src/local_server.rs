//! The server: an accept loop, a task a connection, a thread for what a handler does.

use std::convert::Infallible;
use std::io::{self, Write};
use std::net::{Ipv4Addr, TcpListener};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use http_body_util::{BodyExt, Full, Limited};
use hyper::body::{Body, Bytes, Incoming};
use hyper::header::{CONTENT_TYPE, HeaderName, HeaderValue};
use hyper::service::service_fn;
use hyper::{Response, StatusCode};
use hyper_util::rt::TokioIo;
use thiserror::Error;
use tokio::net::TcpStream;
use tokio::task::JoinSet;
use tokio::time::sleep;

use super::connections::{Connections, Place};
use super::guard;
use super::{Answer, Handler, Limits, Request};

/// How often a server without work looks whether it is to stop.
const STOP_POLL: Duration = Duration::from_millis(100);
/// How long requests under way may go on once the server is to stop: an edit is saved within it, and a person who presses
/// Ctrl-C waits no longer than a second.
const LAST_REQUESTS: Duration = Duration::from_millis(500);
/// How long to wait where the system has no room for another connection.
const NO_ROOM: Duration = Duration::from_millis(50);
/// Threads in which handlers work: as many requests as a browser sends at once, and some.
const HANDLER_THREADS: usize = 8;
/// A page takes nothing from elsewhere, runs nothing but its own script and may not be framed.
const HEADERS: [(&str, &str); 5] = [
    (
        "content-security-policy",
        "default-src 'self'; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cache-control", "no-store"),
];
/// The answer to a connection that has no place.
const NO_PLACE: &[u8] =
    b"HTTP/1.1 503 Service Unavailable\r\nConnection: close\r\nRetry-After: 1\r\nContent-Length: 0\r\n\r\n";

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
        cause: io::Error,
    },
    /// The system refuses what a server needs beside its port.
    #[error("the page cannot be served ({cause}); close other programs, or raise the limit of open files")]
    System {
        /// What the system says.
        cause: io::Error,
    },
}

/// A server on 127.0.0.1.
///
/// Requests must name this address in `Host`, and in `Origin` where they have one, so that no page of another site can
/// reach it through a name of its own; what is sent must be JSON, which such a page may not send.
#[derive(Debug)]
pub struct LocalServer {
    listener: TcpListener,
    port: u16,
    limits: Limits,
}

impl LocalServer {
    /// Opens the port; 0 stands for any that is free.
    ///
    /// # Errors
    /// [`ServerError::Port`] when it cannot be opened.
    pub fn open(port: u16, limits: Limits) -> Result<Self, ServerError> {
        let refused = |cause| ServerError::Port { port, cause };
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).map_err(refused)?;
        listener.set_nonblocking(true).map_err(refused)?;
        let port = listener.local_addr().map_err(refused)?.port();
        Ok(Self { listener, port, limits })
    }

    /// Where a browser finds the page.
    pub fn address(&self) -> String {
        format!("http://127.0.0.1:{}/", self.port)
    }

    /// Answers requests until `stop` is set; then those under way are ended within a second.
    ///
    /// # Errors
    /// [`ServerError::System`] when the system has no threads or files for it.
    pub fn serve<H: Handler>(self, handler: &Arc<H>, stop: &AtomicBool) -> Result<(), ServerError> {
        let system = |cause| ServerError::System { cause };
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_io()
            .enable_time()
            .max_blocking_threads(HANDLER_THREADS)
            .build()
            .map_err(system)?;
        let served = runtime.block_on(self.accept(handler, stop)).map_err(system);
        runtime.shutdown_timeout(LAST_REQUESTS);
        served
    }

    async fn accept<H: Handler>(self, handler: &Arc<H>, stop: &AtomicBool) -> io::Result<()> {
        let listener = tokio::net::TcpListener::from_std(self.listener)?;
        let connections = Arc::new(Connections::default());
        let mut tasks = JoinSet::new();
        while !stop.load(Ordering::Relaxed) {
            while tasks.try_join_next().is_some() {}
            let accepted = tokio::select! {
                accepted = listener.accept() => accepted,
                () = sleep(STOP_POLL) => continue,
            };
            let stream = match accepted {
                Ok((stream, _)) => stream,
                Err(_) => {
                    // Too many open files, or a connection that is gone already: neither is a reason to end.
                    connections.make_room();
                    sleep(NO_ROOM).await;
                    continue;
                }
            };
            match connections.take(&self.limits) {
                Some(place) => {
                    let connection = Connection {
                        place: Arc::new(place),
                        handler: Arc::clone(handler),
                        port: self.port,
                        limits: self.limits,
                    };
                    tasks.spawn(connection.serve(stream));
                }
                None => turn_away(stream),
            }
        }
        let last = tokio::time::Instant::now() + LAST_REQUESTS;
        while connections.are_busy() && tokio::time::Instant::now() < last {
            sleep(Duration::from_millis(10)).await;
        }
        Ok(())
    }
}

/// Says that there is no place, as far as the system takes it at once.
fn turn_away(stream: TcpStream) {
    // Whoever does not hear it finds the connection closed.
    let _ = stream.into_std().and_then(|mut stream| stream.write_all(NO_PLACE));
}

/// One connection.
struct Connection<H> {
    place: Arc<Place>,
    handler: Arc<H>,
    port: u16,
    limits: Limits,
}

impl<H: Handler> Connection<H> {
    async fn serve(self, stream: TcpStream) {
        let place = Arc::clone(&self.place);
        let limits = self.limits;
        let this = Arc::new(self);
        let service = service_fn(move |request| {
            let this = Arc::clone(&this);
            async move {
                this.place.begin_request();
                let response = this.respond(request).await;
                this.place.end_request();
                Ok::<_, Infallible>(response)
            }
        });
        let served = hyper::server::conn::http1::Builder::new()
            .max_buf_size(limits.head_bytes.max(8192))
            .max_headers(limits.header_lines)
            .serve_connection(TokioIo::new(stream), service);
        tokio::select! {
            // A client that breaks off, or that speaks no HTTP, needs no more than its connection's end.
            _ = served => {}
            () = place.has_to_close(&limits) => {}
        }
    }

    async fn respond(&self, request: hyper::Request<Incoming>) -> Response<Full<Bytes>> {
        let (head, body) = request.into_parts();
        if let Some((status, text)) = guard::refusal(self.port, &head.method, &head.headers) {
            return response(Answer::refused(status.as_u16(), &text));
        }
        let too_large =
            || Answer::refused(StatusCode::PAYLOAD_TOO_LARGE.as_u16(), "a request is smaller than this");
        if body.size_hint().lower() > self.limits.body_bytes as u64 {
            return response(too_large());
        }
        let body = match Limited::new(body, self.limits.body_bytes).collect().await {
            Ok(body) => body.to_bytes(),
            Err(cause) if cause.is::<http_body_util::LengthLimitError>() => return response(too_large()),
            Err(cause) => return response(Answer::refused(400, &cause.to_string())),
        };
        let handler = Arc::clone(&self.handler);
        let answered = tokio::task::spawn_blocking(move || {
            handler.answer(Request { method: head.method.as_str(), path: head.uri.path(), body: &body })
        });
        response(answered.await.unwrap_or_else(|_| {
            Answer::refused(
                500,
                "the program failed at this request; it goes on, and its standard error says why",
            )
        }))
    }
}

fn response(answer: Answer) -> Response<Full<Bytes>> {
    let mut response = Response::new(Full::new(Bytes::from(answer.body)));
    *response.status_mut() = StatusCode::from_u16(answer.status).unwrap_or(StatusCode::INTERNAL_SERVER_ERROR);
    let headers = response.headers_mut();
    // A type that no header can hold is left to the browser's guess, which "nosniff" forbids.
    let content_type = HeaderValue::from_str(answer.content_type);
    headers.extend(content_type.ok().map(|value| (CONTENT_TYPE, value)));
    for (name, value) in HEADERS {
        headers.insert(HeaderName::from_static(name), HeaderValue::from_static(value));
    }
    response
}
