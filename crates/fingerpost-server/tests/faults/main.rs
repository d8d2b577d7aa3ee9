//! What no browser sends: after every fault the next good request is answered. A process of its own, whose memory is measured.

// A helper that unwraps is part of the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../server/served.rs"]
mod served;

use std::fs;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use fingerpost_server::Limits;
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

use served::{PAGE, PATIENCE, Served};

/// Requests that are tried; each comes over the loopback address in well under a millisecond.
const MUTATED_REQUESTS: u32 = 3000;
/// Memory that the test's process may take beside what it has at first, MiB: a hundred bodies of the largest size.
const MEMORY_MIB: u64 = 128;

/// The most memory that this process has taken so far, MiB.
fn peak_memory_mib() -> u64 {
    let status = fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() / 1024
}

/// Requests from nearly right to senseless.
fn requests() -> impl Strategy<Value = Vec<u8>> {
    let method =
        prop_oneof![Just("GET"), Just("POST"), Just("HEAD"), Just("PUT"), Just("\0"), Just("GETGETGET")];
    let path = prop_oneof![
        Just("/".to_owned()),
        Just("/edit".to_owned()),
        Just("http://evil.example/".to_owned()),
        Just("*".to_owned()),
        "/[%a-z0-9./?#]{0,40}",
        (0_usize..40_000).prop_map(|length| format!("/{}", "a".repeat(length))),
    ];
    let length = prop_oneof![
        Just("0".to_owned()),
        Just("7".to_owned()),
        Just("-1".to_owned()),
        Just("9223372036854775807".to_owned()),
        Just("18446744073709551615".to_owned()),
        Just("18446744073709551616".to_owned()),
        Just("1e3".to_owned()),
        Just("7, 7".to_owned()),
        "[0-9]{1,30}",
    ];
    let header = prop_oneof![
        Just("Host: HOST".to_owned()),
        Just("Host: HOST".to_owned()),
        Just("Content-Type: application/json".to_owned()),
        Just("Transfer-Encoding: chunked".to_owned()),
        Just("Connection: close".to_owned()),
        Just("Connection: upgrade".to_owned()),
        Just("Expect: 100-continue".to_owned()),
        Just("Origin: null".to_owned()),
        length.prop_map(|length| format!("Content-Length: {length}")),
        "[A-Za-z-]{1,12}:[ -~]{0,30}",
        (0_usize..30_000).prop_map(|length| format!("X: {}", "y".repeat(length))),
    ];
    let body = prop_oneof![
        Just(b"{}".to_vec()),
        Just(b"FFFFFFFFFFFFFFFE\r\n".to_vec()),
        Just(b"3\r\nabc\r\n0\r\n\r\n".to_vec()),
        Just(b"1;x=y\r\na\r\n".to_vec()),
        prop::collection::vec(any::<u8>(), 0..200),
        Just(vec![b'1'; 1 << 17]),
    ];
    let end = prop_oneof![Just("\r\n"), Just("\r\n"), Just("\r\n"), Just("\n"), Just("\r"), Just("")];
    (method, path, prop::collection::vec(header, 0..90), end, body).prop_map(
        |(method, path, headers, end, body)| {
            let mut request = format!("{method} {path} HTTP/1.1{end}");
            headers.iter().for_each(|header| request += &format!("{header}{end}"));
            request += end;
            [request.into_bytes(), body].concat()
        },
    )
}

#[test]
fn after_any_request_the_next_good_one_is_answered() {
    let served = Served::start();
    let before_mib = peak_memory_mib();
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let mut runner = TestRunner::new_with_rng(Config::default(), rng);
    let requests = requests();
    let mut open: Vec<TcpStream> = Vec::new();
    for tried in 0..MUTATED_REQUESTS {
        let request = requests.new_tree(&mut runner).unwrap().current();
        let mut stream = served.connect();
        // The server may close in the middle of what it refuses.
        let _ = stream.write_all(served.addressed(&String::from_utf8_lossy(&request)).as_bytes());
        match tried % 3 {
            0 => drop(stream),
            1 => stream.shutdown(Shutdown::Write).unwrap_or_default(),
            _ => open.push(stream),
        }
        open.drain(..open.len().saturating_sub(30));
        if tried % 10 == 0 {
            assert_eq!(served.status(PAGE), "HTTP/1.1 200", "after request {tried}");
        }
    }
    assert_eq!(served.status(PAGE), "HTTP/1.1 200");
    let taken_mib = peak_memory_mib() - before_mib;
    assert!(taken_mib < MEMORY_MIB, "{taken_mib} MiB");
    drop(open);
    assert!(served.end() < PATIENCE);
}

#[test]
fn lengths_that_no_body_has_are_refused_and_take_no_memory() {
    let served = Served::start();
    let before_mib = peak_memory_mib();
    for length in ["1048577", "4294967296", "9223372036854775807", "18446744073709551614"] {
        let head = "POST /edit HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\n";
        let status = served.status(&format!("{head}Content-Length: {length}\r\n\r\n{{"));
        // The last one is beyond what the server's own arithmetic holds.
        assert!(["HTTP/1.1 413", "HTTP/1.1 431"].contains(&status.as_str()), "{length}: {status}");
    }
    assert!(peak_memory_mib() - before_mib < MEMORY_MIB);
    served.end();
}

#[test]
fn a_body_in_pieces_ends_at_the_limit() {
    let served = Served::start();
    let head = "POST /edit HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\nTransfer-Encoding: chunked\r\n\r\n";
    let mut stream = served.send(head);
    let piece = [b"10000\r\n".to_vec(), vec![b' '; 0x10000], b"\r\n".to_vec()].concat();
    let mut answer = [0; 12];
    // Sixteen pieces are the limit; a server that took all of them in would never answer.
    for _ in 0..64 {
        if stream.write_all(&piece).is_err() {
            break;
        }
    }
    match stream.read_exact(&mut answer) {
        Ok(()) => assert_eq!(&answer, b"HTTP/1.1 413", "{}", String::from_utf8_lossy(&answer)),
        // A connection that is closed on what is still being sent may lose the answer; one that stays open was not refused.
        Err(cause) => {
            let waited = [ErrorKind::WouldBlock, ErrorKind::TimedOut].contains(&cause.kind());
            assert!(!waited, "the body is taken in without an end");
        }
    }
    assert_eq!(served.status(PAGE), "HTTP/1.1 200");
    served.end();
}

#[test]
fn idle_connections_make_room_for_new_ones() {
    let served = Served::start();
    let connections = Limits::default().connections;
    let idle: Vec<TcpStream> = (0..10 * connections).map(|_| served.connect()).collect();
    let begun: Vec<TcpStream> = (0..2 * connections).map(|_| served.send("GET / HT")).collect();
    assert_eq!(served.status(PAGE), "HTTP/1.1 200");
    drop((idle, begun));
    assert!(served.end() < PATIENCE);
}

#[test]
fn where_all_are_busy_a_new_one_is_turned_away_and_later_served() {
    let limits = Limits { connections: 4, request_time: Duration::from_secs(2), ..Limits::default() };
    let served = Served::within(limits);
    let unfinished =
        "POST /edit HTTP/1.1\r\nHost: HOST\r\nContent-Type: application/json\r\nContent-Length: 9\r\n\r\n{";
    let busy: Vec<TcpStream> = (0..limits.connections).map(|_| served.send(unfinished)).collect();
    // Until a head is read its connection is an idle one.
    thread::sleep(Duration::from_millis(500));
    let since = Instant::now();
    let (mut turned_away, mut is_served) = (0, false);
    while since.elapsed() < PATIENCE && !is_served {
        // The answer may be lost where the connection is closed on a request that nobody has read.
        match served.answered(PAGE).as_deref() {
            Ok("HTTP/1.1 200") => is_served = true,
            Ok("HTTP/1.1 503") | Err(_) => turned_away += 1,
            Ok(other) => panic!("{other}"),
        }
        thread::sleep(Duration::from_millis(100));
    }
    assert!(is_served, "requests that take too long make room");
    assert!(turned_away > 0);
    drop(busy);
    served.end();
}

#[test]
fn who_trickles_a_head_is_closed() {
    let limits = Limits { idle_time: Duration::from_millis(400), ..Limits::default() };
    let served = Served::within(limits);
    let mut slow = served.send("GET / HTTP/1.1\r\n");
    let since = Instant::now();
    // A closed connection takes one more write at most.
    while slow.write_all(b"X: y\r\n").is_ok() && since.elapsed() < PATIENCE {
        thread::sleep(Duration::from_millis(50));
    }
    assert!(since.elapsed() < PATIENCE, "it was let go on");
    served.end();
}

#[test]
fn requests_that_come_at_once_are_answered_in_their_order() {
    let served = Served::start();
    let last = "GET /none HTTP/1.1\r\nHost: HOST\r\nConnection: close\r\n\r\n";
    let mut answers = String::new();
    served.send(&[PAGE, PAGE, last].concat()).read_to_string(&mut answers).unwrap();
    let statuses: Vec<&str> = answers.split("HTTP/1.1 ").skip(1).map(|answer| &answer[..3]).collect();
    assert_eq!(statuses, ["200", "200", "404"]);
    served.end();
}
