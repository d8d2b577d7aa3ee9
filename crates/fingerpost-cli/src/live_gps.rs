//! Positions of a receiver that is listened to, at a serial port or through gpsd.

use std::path::Path;

use anyhow::Result;
use fingerpost_io::{LineListener, is_serial_port};
use fingerpost_map::{LatLon, parse_gps_log_within};

/// What stands before host and port of a gpsd.
const GPSD: &str = "gpsd://";
/// Where gpsd listens as a rule.
const GPSD_ADDRESS: &str = "127.0.0.1:2947";
/// A position older than this says nothing of the frame at hand, seconds: receivers give one a second.
const NEW_S: f64 = 1.0;
/// Memory for the reading of a line, bytes.
const LINE_BYTES: usize = 65_536;
const DAY_S: f64 = 86_400.0;
/// Times of one position differ by less than this between a receiver's sentences, seconds: they have hundredths.
const SAME_TIME_S: f64 = 0.005;

/// A receiver that is listened to.
#[derive(Debug)]
pub(crate) struct LiveGps {
    listener: LineListener,
    positions: Positions,
}

impl LiveGps {
    /// Listens where `name` is a serial device or, as gpsd://HOST:PORT, a gpsd; none where it is the name of a file.
    pub(crate) fn open(name: &Path) -> Result<Option<Self>> {
        let listener = match name.to_str().and_then(|text| text.strip_prefix(GPSD)) {
            Some("") => LineListener::gpsd(GPSD_ADDRESS)?,
            Some(address) => LineListener::gpsd(address)?,
            None if is_serial_port(name) => LineListener::device(name)?,
            None => return Ok(None),
        };
        Ok(Some(Self { listener, positions: Positions::default() }))
    }

    /// The newest position, if it has not been given yet and came within the last second.
    pub(crate) fn newest(&mut self) -> Option<LatLon> {
        let mut newest = None;
        for (line, came) in self.listener.drain() {
            let Some(at) = self.positions.next(&line) else { continue };
            newest = Some(at).filter(|_| came.elapsed().as_secs_f64() <= NEW_S);
        }
        newest
    }
}

/// The positions of a receiver's lines, each once.
#[derive(Debug, Default)]
struct Positions {
    /// Time of day of the last one, seconds.
    last_s: Option<f64>,
}

impl Positions {
    /// The position of the next line, if it is not the last one again: receivers say each in several sentences, and some repeat it.
    fn next(&mut self, line: &[u8]) -> Option<LatLon> {
        let point = parse_gps_log_within(line, LINE_BYTES).ok()?.points.pop()?;
        let time_s = point.time_s.map(time_of_day_s);
        if time_s.zip(self.last_s).is_some_and(|(time_s, last_s)| (time_s - last_s).abs() <= SAME_TIME_S) {
            return None;
        }
        self.last_s = time_s;
        Some(point.at)
    }
}

/// Whether lines come from a name for as long as they are asked for.
pub(crate) fn is_live(name: &Path) -> bool {
    name.to_str().is_some_and(|text| text.starts_with(GPSD)) || is_serial_port(name)
}

/// Sentences with a date and those without agree in this.
fn time_of_day_s(time_s: f64) -> f64 {
    time_s.rem_euclid(DAY_S)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sentence(body: &str) -> String {
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r")
    }

    fn gga(time: &str, east: &str) -> String {
        sentence(&format!("GPGGA,{time},4859.0000,N,{east},E,1,08,1.0,110.0,M,47.0,M,,"))
    }

    fn rmc(time: &str, east: &str) -> String {
        sentence(&format!("GPRMC,{time},A,4859.0000,N,{east},E,10.0,90.0,251125,,,A"))
    }

    /// Expected: a position that several sentences say, or that a stuck receiver repeats, comes once; what is damaged, or no position,
    /// does not come; after a silence the next one does.
    #[test]
    fn every_position_comes_once() {
        let mut positions = Positions::default();
        let lines = [
            gga("120000.00", "00823.4500"),
            rmc("120000.00", "00823.4500"),
            rmc("120000.00", "00823.4500"),
            "$GPRMC,120001.00,A,4859.0000,N,008".to_owned(),
            sentence("GPGSV,1,1,00"),
            rmc("120001.00", "00823.4600"),
            gga("120001.00", "00823.4600"),
            gga("120101.00", "00823.5000"),
        ];
        let given: Vec<f64> =
            lines.iter().filter_map(|line| positions.next(line.as_bytes())).map(|at| at.lon_deg).collect();
        let minutes: Vec<f64> =
            given.iter().map(|lon_deg| ((lon_deg - 8.0) * 60.0 * 100.0).round() / 100.0).collect();
        assert_eq!(minutes, [23.45, 23.46, 23.5]);
    }

    #[test]
    fn files_are_no_receivers_and_gpsd_is_named_by_its_address() {
        assert!(!is_live(Path::new("track.gpx")) && is_live(Path::new("gpsd://127.0.0.1:2947")));
        assert!(LiveGps::open(Path::new("track.gpx")).unwrap().is_none());
        let refused = LiveGps::open(Path::new("gpsd://127.0.0.1:1")).unwrap_err().to_string();
        assert!(refused.contains("127.0.0.1:1 does not answer"), "{refused}");
    }
}
