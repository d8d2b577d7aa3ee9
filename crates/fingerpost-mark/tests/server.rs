//! The server on the loopback address, as browsers and others meet it.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used)]

use std::io::{Read, Write};
use std::net::{Ipv4Addr, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::{Duration, Instant};

use fingerpost_format::MarksFile;
use fingerpost_mark::{Cause, Desk, Keeper, LaneMarks, MarkServer, Picture, Pictures};

/// Longer than any answer takes, shorter than a person waits.
const PATIENCE: Duration = Duration::from_secs(10);

/// A picture larger than the system's buffers of a connection.
struct LargePicture;

impl Pictures for LargePicture {
    fn picture(&self, _: u64) -> Result<Picture, Cause> {
        Ok(Picture { content_type: "image/png", bytes: vec![7; 32 << 20] })
    }
}

struct NoShelf;

impl Keeper for NoShelf {
    fn keep(&mut self, _: &MarksFile) -> Result<(), Cause> {
        Ok(())
    }

    fn export(&mut self, _: &LaneMarks) -> Result<Vec<String>, Cause> {
        Ok(Vec::new())
    }
}

/// A server that serves until the test ends.
struct Served {
    port: u16,
    stop: Arc<AtomicBool>,
    thread: thread::JoinHandle<()>,
}

impl Served {
    fn start() -> Self {
        let server = MarkServer::open(0).unwrap();
        let port = server.address().trim_end_matches('/').rsplit(':').next().unwrap().parse().unwrap();
        let marks = LaneMarks::new("drive", [640, 480], 3);
        let desk = Arc::new(Desk::new(marks, Box::new(LargePicture), Box::new(NoShelf)));
        let stop = Arc::new(AtomicBool::new(false));
        let stops = Arc::clone(&stop);
        Self { port, stop, thread: thread::spawn(move || server.serve(&desk, &stops)) }
    }

    fn send(&self, request: &str) -> TcpStream {
        let mut stream = TcpStream::connect((Ipv4Addr::LOCALHOST, self.port)).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.replace("HOST", &format!("127.0.0.1:{}", self.port)).as_bytes()).unwrap();
        stream
    }

    /// The status line that answers a request.
    fn status(&self, request: &str) -> String {
        let mut begin = [0; 12];
        self.send(request).read_exact(&mut begin).unwrap();
        String::from_utf8(begin.to_vec()).unwrap()
    }

    /// Ends the server, and says how long that took.
    fn end(self) -> Duration {
        let since = Instant::now();
        self.stop.store(true, Ordering::Relaxed);
        self.thread.join().unwrap();
        since.elapsed()
    }
}

const PAGE: &str = "GET / HTTP/1.1\r\nHost: HOST\r\n\r\n";

fn edit(body: &str, length: usize) -> String {
    format!(
        "POST /api/edit HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}"
    )
}

/// An edit that is answered.
fn whole_edit() -> String {
    let points: Vec<String> = (0..200).map(|i| format!("[{i}.5, {}.0]", 479 - i)).collect();
    let body = format!("{{\"side\": \"left\", \"frame\": 0, \"points_px\": [{}]}}", points.join(", "));
    assert!(body.len() > 2048, "the server takes short ones in before it asks who may send them");
    edit(&body, body.len())
}

#[test]
fn unfinished_bodies_hold_up_nobody_else() {
    let served = Served::start();
    let unfinished: Vec<TcpStream> = (0..12).map(|_| served.send(&edit("{\"side\":", 5000))).collect();
    // Refused ones too are only over when their body is.
    let foreign = edit("{", 5000).replace("application/json", "text/plain");
    let refused: Vec<TcpStream> = (0..12).map(|_| served.send(&foreign)).collect();
    thread::sleep(Duration::from_millis(500));
    for _ in 0..3 {
        assert_eq!(served.status(PAGE), "HTTP/1.1 200");
        assert_eq!(served.status(&whole_edit()), "HTTP/1.1 200");
    }
    assert!(served.end() < PATIENCE, "the program ends while they are open");
    drop((unfinished, refused));
}

#[test]
fn an_unfinished_body_is_answered_when_it_ends() {
    let served = Served::start();
    let request = whole_edit();
    let (first, rest) = request.split_at(request.len() - 100);
    let mut stream = served.send(first);
    thread::sleep(Duration::from_millis(300));
    stream.write_all(rest.as_bytes()).unwrap();
    let mut begin = [0; 12];
    stream.read_exact(&mut begin).unwrap();
    assert_eq!(&begin, b"HTTP/1.1 200");
    served.end();
}

#[test]
fn answers_that_are_not_read_hold_up_nobody_else() {
    let served = Served::start();
    let picture = "GET /api/frames/1/picture HTTP/1.1\r\nHost: HOST\r\n\r\n";
    let unread: Vec<TcpStream> = (0..6).map(|_| served.send(picture)).collect();
    thread::sleep(Duration::from_millis(500));
    assert_eq!(served.status(PAGE), "HTTP/1.1 200");
    assert_eq!(served.status(picture), "HTTP/1.1 200");
    assert!(served.end() < PATIENCE);
    drop(unread);
}
