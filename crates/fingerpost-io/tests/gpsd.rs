//! The real gpsd, fed by gpsfake with the sentences of a receiver. Without the programs this fails.
#![allow(clippy::unwrap_used, clippy::expect_used, reason = "a failed expectation is a failed test")]

use std::fmt::Write;
use std::net::TcpListener;
use std::os::unix::process::CommandExt;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use fingerpost_io::LineListener;
use serde_json::Value;

/// A sentence with its checksum.
fn sentence(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// Half a minute of a receiver that goes to the east at 48 degrees 59 minutes north, a fix a second.
fn log() -> String {
    let mut log = String::new();
    for second in 0..30 {
        let (time, east) = (format!("1200{second:02}.00"), format!("00823.{:04},E", 4500 + 10 * second));
        let gga = format!("GPGGA,{time},4859.0000,N,{east},1,08,1.0,110.0,M,47.0,M,,");
        let rmc = format!("GPRMC,{time},A,4859.0000,N,{east},10.0,90.0,251125,,,A");
        write!(log, "{}{}", sentence(&gga), sentence(&rmc)).unwrap();
    }
    log
}

/// gpsfake with its gpsd, which end with it.
struct Fake(Child);

impl Fake {
    fn start(port: u16) -> (Self, tempfile::TempDir) {
        let folder = tempfile::tempdir().unwrap();
        let log_path = folder.path().join("log.nmea");
        std::fs::write(&log_path, log()).unwrap();
        let started = Command::new("gpsfake")
            .args(["-c", "0.05", "-q", "-P", &port.to_string()])
            .arg(&log_path)
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .process_group(0)
            .spawn();
        (Self(started.expect("this test needs gpsfake and gpsd: apt-get install gpsd gpsd-clients")), folder)
    }
}

impl Drop for Fake {
    fn drop(&mut self) {
        // Its whole group, gpsd with it.
        let _ = Command::new("kill").args(["--", &format!("-{}", self.0.id())]).status();
        let _ = self.0.wait();
    }
}

/// Expected: gpsd answers, and its reports of position come as lines of JSON, those of the receiver's places in their order.
#[test]
fn positions_come_from_gpsd_as_it_reports_them() {
    // A port that nobody has at the moment.
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    let (_fake, _folder) = Fake::start(port);
    let started = Instant::now();
    let listener = loop {
        match LineListener::gpsd(&format!("127.0.0.1:{port}")) {
            Ok(listener) => break listener,
            Err(refused) => assert!(started.elapsed() < Duration::from_secs(20), "{refused}"),
        }
        std::thread::sleep(Duration::from_millis(50));
    };
    let mut longitudes = Vec::new();
    while longitudes.len() < 5 && started.elapsed() < Duration::from_secs(30) {
        for (line, _) in listener.drain() {
            let report: Value = serde_json::from_slice(&line).unwrap();
            if report["class"] == "TPV" && report["mode"].as_u64() >= Some(2) && report["time"].is_string() {
                assert!((report["lat"].as_f64().unwrap() - 48.983_333).abs() < 1e-5, "{report}");
                longitudes.push(report["lon"].as_f64().unwrap());
            }
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(longitudes.len() >= 5, "{longitudes:?}");
    assert!(longitudes.iter().all(|lon_deg| (8.3908..8.3958).contains(lon_deg)), "{longitudes:?}");
    // gpsfake begins its log anew at its end.
    assert!(longitudes.windows(2).filter(|pair| pair[1] >= pair[0]).count() + 1 >= longitudes.len() - 1);
}
