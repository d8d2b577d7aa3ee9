//! Who may connect while a drive is run, and that nobody keeps others out.

// Functions shared by tests fail their test by panicking.
#![allow(clippy::unwrap_used)]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use fingerpost_record::live::{LiveView, Origin};

/// Viewers at once.
const VIEWERS: usize = 8;
/// How long a test waits for what should come at once.
const PATIENCE: Duration = Duration::from_secs(60);

/// A server, and where it is.
fn server(origins: &[Origin]) -> (LiveView, String) {
    let live = LiveView::begin("test", 0, origins, None).unwrap();
    let address = live.address().strip_prefix("ws://").unwrap().to_owned();
    (live, address)
}

fn connect(address: &str) -> TcpStream {
    let stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream
}

/// A handshake with more header lines.
fn request(host: &str, more: &str) -> String {
    format!(
        "GET / HTTP/1.1\r\nHost: {host}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Protocol: foxglove.sdk.v1\r\n{more}\r\n"
    )
}

/// The status that a handshake is answered with; none where the connection is closed without one.
fn status(stream: &mut TcpStream) -> Option<u16> {
    let mut line = [0; 12];
    stream.read_exact(&mut line).ok()?;
    std::str::from_utf8(&line).unwrap().strip_prefix("HTTP/1.1 ").unwrap().parse().ok()
}

fn answer(address: &str, host: &str, more: &str) -> Option<u16> {
    let mut stream = connect(address);
    stream.write_all(request(host, more).as_bytes()).unwrap();
    status(&mut stream)
}

/// What follows an answer's head: the first bytes of the first frame of WebSocket.
fn first_frame(stream: &mut TcpStream) -> [u8; 4] {
    let mut head = Vec::new();
    while !head.ends_with(b"\r\n\r\n") {
        let mut byte = [0];
        stream.read_exact(&mut byte).unwrap();
        head.push(byte[0]);
    }
    let mut frame = [0; 4];
    stream.read_exact(&mut frame).unwrap();
    frame
}

#[test]
fn pages_of_other_sites_are_refused_and_programs_are_not() {
    let (_live, address) = server(&["https://viewer.example".parse().unwrap()]);
    assert_eq!(answer(&address, &address, ""), Some(101), "a program that says no origin");
    let status_of = |origin: &str| answer(&address, &address, &format!("Origin: {origin}\r\n"));
    for origin in ["https://app.foxglove.dev", "file://", "http://localhost:8080", "https://viewer.example"] {
        assert_eq!(status_of(origin), Some(101), "{origin}");
    }
    for origin in
        ["https://evil.example", "null", "http://app.foxglove.dev", "https://viewer.example.evil.example", ""]
    {
        assert_eq!(status_of(origin), Some(403), "{origin}");
    }
    // A page whose name was made to lead here has its own origin's name as host.
    assert_eq!(answer(&address, "evil.example", "Origin: http://localhost\r\n"), Some(403));
    let twice = "Origin: http://localhost\r\nOrigin: https://evil.example\r\n";
    assert_eq!(answer(&address, &address, twice), Some(400));
    assert_eq!(answer(&address, &address, &format!("Host: {address}\r\n")), Some(400));
}

#[test]
fn connections_that_say_nothing_or_little_keep_nobody_out() {
    let (_live, address) = server(&[]);
    let mut idle: Vec<TcpStream> = (0..3 * VIEWERS).map(|_| connect(&address)).collect();
    for stream in idle.iter_mut().take(VIEWERS) {
        stream.write_all(b"GET / HTTP/1.1\r\nHost: ").unwrap();
    }
    assert_eq!(answer(&address, &address, ""), Some(101));
    // One that was slow is served when it has said all.
    let slow = &mut idle[0];
    slow.write_all(request(&address, "").split_once("Host: ").unwrap().1.as_bytes()).unwrap();
    assert_eq!(status(slow), Some(101));
}

#[test]
fn of_too_many_connections_that_say_nothing_the_oldest_goes() {
    let (_live, address) = server(&[]);
    let mut first = connect(&address);
    let _more: Vec<TcpStream> = (0..64).map(|_| connect(&address)).collect();
    assert_eq!(first.read(&mut [0]).unwrap_or_default(), 0, "it is closed");
    assert_eq!(answer(&address, &address, ""), Some(101));
}

#[test]
fn one_viewer_too_many_is_told_to_try_again_later() {
    let (_live, address) = server(&[]);
    let join = || {
        let mut stream = connect(&address);
        stream.write_all(request(&address, "").as_bytes()).unwrap();
        let frame = first_frame(&mut stream);
        (stream, frame)
    };
    let viewers: Vec<_> = (0..VIEWERS).map(|_| join()).collect();
    assert!(viewers.iter().all(|(_, frame)| frame[0] == 0x81), "each gets a text first");
    let (_stream, [kind, _, high, low]) = join();
    assert_eq!((kind, u16::from_be_bytes([high, low])), (0x88, 1013), "RFC 6455's registry: try again later");
    drop(viewers);
    // Their places are free when their ends have been heard of.
    while join().1[0] != 0x81 {}
}
