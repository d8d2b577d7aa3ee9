//! Who is slow holds up nobody else.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::thread;
use std::time::Duration;

use crate::served::{PAGE, PATIENCE, Served};

fn edit(body: &str, length: usize) -> String {
    format!(
        "POST /edit HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\nContent-Length: {length}\r\n\r\n{body}"
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
    let picture = "GET /picture HTTP/1.1\r\nHost: HOST\r\n\r\n";
    let unread: Vec<TcpStream> = (0..6).map(|_| served.send(picture)).collect();
    thread::sleep(Duration::from_millis(500));
    assert_eq!(served.status(PAGE), "HTTP/1.1 200");
    assert_eq!(served.status(picture), "HTTP/1.1 200");
    assert!(served.end() < PATIENCE);
    drop(unread);
}
