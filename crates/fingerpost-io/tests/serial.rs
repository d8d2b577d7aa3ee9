//! A receiver at a serial port, for which a pseudo-terminal stands in.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::fs::File;
use std::io::Write;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;
use std::time::{Duration, Instant};

use fingerpost_io::{LineListener, is_serial_port};
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};

/// The lines that come within ten seconds, up to so many.
fn lines(listener: &LineListener, count: usize) -> Vec<Vec<u8>> {
    let (started, mut lines) = (Instant::now(), Vec::new());
    while lines.len() < count && started.elapsed() < Duration::from_secs(10) {
        lines.extend(listener.drain().into_iter().map(|(line, _)| line.trim_ascii_end().to_vec()));
        std::thread::sleep(Duration::from_millis(10));
    }
    lines
}

/// Expected: nothing while the receiver is silent; each line once, whole, however it is cut up on the wire; and after a pause it goes on.
#[test]
fn sentences_come_whole_and_in_their_order() {
    let receiver = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY).unwrap();
    grantpt(&receiver).unwrap();
    unlockpt(&receiver).unwrap();
    let name = ptsname(&receiver, Vec::new()).unwrap();
    let port = Path::new(std::ffi::OsStr::from_bytes(name.to_bytes()));
    assert!(is_serial_port(port) && !is_serial_port(Path::new("/dev/zero")));
    let listener = LineListener::device(port).unwrap();
    let mut receiver = File::from(receiver);
    assert!(listener.drain().is_empty());
    receiver.write_all(b"$GPGGA,1*00\r\n$GPRMC,").unwrap();
    assert_eq!(lines(&listener, 1), [b"$GPGGA,1*00"]);
    receiver.write_all(b"2*00\r\n$GPGGA,3*00\r\n").unwrap();
    assert_eq!(lines(&listener, 2), [b"$GPRMC,2*00", b"$GPGGA,3*00"]);
}
