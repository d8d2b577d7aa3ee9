//! A server with a few pages, and what asks it.

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use fingerpost_server::{Answer, Handler, Limits, LocalServer, Request};

/// Longer than any answer takes, on a machine that does much else.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// A page, a picture larger than the system's buffers of a connection, and whatever is sent sent back.
struct Pages;

impl Handler for Pages {
    fn answer(&self, request: Request<'_>) -> Answer {
        match (request.method, request.path) {
            ("GET", "/") => Answer::text("text/html", "page"),
            ("GET", "/picture") => Answer { status: 200, content_type: "image/png", body: vec![7; 32 << 20] },
            ("POST", "/edit") => Answer::json(200, &request.body.len()),
            _ => Answer::refused(404, "there is no such page"),
        }
    }
}

/// A server that serves until the test ends.
pub(crate) struct Served {
    port: u16,
    stop: Arc<AtomicBool>,
    thread: thread::JoinHandle<()>,
}

impl Served {
    /// With the limits that there are by default.
    pub(crate) fn start() -> Self {
        Self::within(Limits::default())
    }

    /// Within other limits.
    pub(crate) fn within(limits: Limits) -> Self {
        let server = LocalServer::open(0, limits).unwrap();
        let port = server.address().trim_end_matches('/').rsplit(':').next().unwrap().parse().unwrap();
        let pages = Arc::new(Pages);
        let stop = Arc::new(AtomicBool::new(false));
        let stops = Arc::clone(&stop);
        Self { port, stop, thread: thread::spawn(move || server.serve(&pages, &stops).unwrap()) }
    }

    /// A new connection.
    pub(crate) fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream
    }

    /// A request's text with this server's address in place of HOST.
    pub(crate) fn addressed(&self, request: &str) -> String {
        request.replace("HOST", &format!("127.0.0.1:{}", self.port))
    }

    /// A new connection on which a request was sent.
    pub(crate) fn send(&self, request: &str) -> TcpStream {
        let mut stream = self.connect();
        stream.write_all(self.addressed(request).as_bytes()).unwrap();
        stream
    }

    /// The status line that answers a request.
    pub(crate) fn status(&self, request: &str) -> String {
        self.answered(request).unwrap()
    }

    /// The status line that answers a request; none where the connection is closed without one.
    pub(crate) fn answered(&self, request: &str) -> std::io::Result<String> {
        let mut begin = [0; 12];
        self.send(request).read_exact(&mut begin)?;
        Ok(String::from_utf8(begin.to_vec()).unwrap())
    }

    /// Ends the server, and says how long that took.
    pub(crate) fn end(self) -> Duration {
        let since = Instant::now();
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
        since.elapsed()
    }
}

/// A request that is answered with 200.
pub(crate) const PAGE: &str = "GET / HTTP/1.1\r\nHost: HOST\r\n\r\n";
