//! Positions of a GPS receiver: a GPX track, its NMEA 0183 sentences, or the reports of gpsd.
//!
//! Of a log's lines those of one kind are taken, the one that says most: gpsd's reports of position (TPV, as `gpspipe -w` writes
//! them), else RMC sentences, which have a date, else GGA, which have a time of day alone. What else is in the log, comments,
//! other sentences, bytes of another protocol, is passed over; sentences and reports that are damaged are counted.

use nmea::ParseResult;
use nmea::sentences::FixType;
use nmea::sentences::rmc::RmcStatusOfFix;
use serde::Deserialize;
use thiserror::Error;

use crate::gpx::{DAY_S, POINT_BYTES, parse_time_s};
use crate::{GpxError, GpxPoint, LatLon, parse_gpx_within};

/// What a log holds.
#[derive(Debug, Clone, PartialEq)]
pub struct GpsLog {
    /// Its positions, in its order; without those that the receiver itself calls no fix.
    pub points: Vec<GpxPoint>,
    /// Sentences and reports of position that are damaged: a checksum that does not fit, a line cut short.
    pub damaged: usize,
}

/// Why a log gives no positions.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GpsLogError {
    /// It begins as XML, but is no GPX track.
    #[error(transparent)]
    Gpx(#[from] GpxError),
    /// More positions than may be held.
    #[error(
        "the GPS log has more positions than the {limit_mb} MB of memory hold that it may take; cut out the drive, or allow more \
         (--max-input-mib)"
    )]
    TooLarge {
        /// The memory that it may take, megabytes.
        limit_mb: usize,
    },
    /// There are sentences or reports, none of them with a position.
    #[error(
        "the GPS log has no position: {without_fix} reports without a fix, {damaged} damaged; record it again where the receiver \
         sees the sky"
    )]
    NoFix {
        /// Reports in which the receiver says that it has no fix.
        without_fix: usize,
        /// Reports that could not be read.
        damaged: usize,
    },
    /// Nothing that is understood.
    #[error(
        "there is neither a GPX track, nor NMEA sentences RMC or GGA, nor gpsd's reports; record it as one of them, as with gpspipe -w"
    )]
    NoLog,
}

/// Kinds of report, the most telling first.
const KINDS: usize = 3;
const GPSD: usize = 0;
const RMC: usize = 1;
const GGA: usize = 2;

/// What one line says.
enum Line {
    Position(usize, GpxPoint),
    WithoutFix,
    Damaged,
    Other,
}

/// Reads the positions of a GPX document or of a receiver's log into at most `memory_bytes`.
///
/// # Errors
/// [`GpsLogError`] when there is no position in it, or too many.
pub fn parse_gps_log_within(bytes: &[u8], memory_bytes: usize) -> Result<GpsLog, GpsLogError> {
    let start = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    if start.starts_with(b"<") {
        let text = str::from_utf8(bytes).map_err(|error| GpxError::Broken {
            at_byte: error.valid_up_to() as u64,
            cause: "it is not UTF-8".to_owned(),
        })?;
        return Ok(GpsLog { points: parse_gpx_within(text, memory_bytes)?, damaged: 0 });
    }
    let mut points: [Vec<GpxPoint>; KINDS] = Default::default();
    let (mut without_fix, mut damaged) = (0, 0);
    for line in bytes.split(|byte| *byte == b'\n') {
        match read_line(line) {
            Line::Position(kind, point) => points[kind].push(point),
            Line::WithoutFix => without_fix += 1,
            Line::Damaged => damaged += 1,
            Line::Other => {}
        }
        if points.iter().map(Vec::len).sum::<usize>() > memory_bytes / POINT_BYTES {
            return Err(GpsLogError::TooLarge { limit_mb: memory_bytes / 1_000_000 });
        }
    }
    let [_, _, by_clock] = &mut points;
    add_days(by_clock);
    match points.into_iter().find(|points| !points.is_empty()) {
        Some(points) => Ok(GpsLog { points, damaged }),
        None if without_fix + damaged > 0 => Err(GpsLogError::NoFix { without_fix, damaged }),
        None => Err(GpsLogError::NoLog),
    }
}

/// Reads a line; what stands before its report, such as a time, is passed over.
fn read_line(line: &[u8]) -> Line {
    let Some(start) = line.iter().position(|byte| matches!(byte, b'$' | b'{')) else { return Line::Other };
    let line = line[start..].trim_ascii_end();
    if line.starts_with(b"{") { read_gpsd(line) } else { read_nmea(line) }
}

/// The parts of gpsd's reports that are used.
#[derive(Deserialize)]
struct GpsdReport {
    class: String,
    #[serde(default)]
    mode: u8,
    time: Option<String>,
    lat: Option<f64>,
    lon: Option<f64>,
}

/// gpsd's `mode` of a position: 2 has latitude and longitude, 3 an altitude too; less is no fix.
const LEAST_MODE: u8 = 2;

fn read_gpsd(line: &[u8]) -> Line {
    let Ok(report) = serde_json::from_slice::<GpsdReport>(line) else {
        let has_class = line.windows(5).any(|part| part == b"\"TPV\"");
        return if has_class { Line::Damaged } else { Line::Other };
    };
    if report.class != "TPV" {
        return Line::Other;
    }
    let (Some(lat), Some(lon), true) = (report.lat, report.lon, report.mode >= LEAST_MODE) else {
        return Line::WithoutFix;
    };
    match LatLon::new(lat, lon) {
        Ok(at) => {
            Line::Position(GPSD, GpxPoint { at, time_s: report.time.as_deref().and_then(parse_time_s) })
        }
        Err(_) => Line::Damaged,
    }
}

fn read_nmea(line: &[u8]) -> Line {
    // "$", two letters that name the system of satellites, three that name the sentence.
    let kind = match line.get(3..6) {
        Some(b"RMC") => RMC,
        Some(b"GGA") => GGA,
        _ => return Line::Other,
    };
    let sentence = str::from_utf8(line).ok().and_then(|text| nmea::parse_str(text).ok());
    let (at, time_s) = match sentence {
        Some(ParseResult::RMC(rmc)) => {
            let is_fix = rmc.status_of_fix != RmcStatusOfFix::Invalid;
            let time = rmc.fix_date.zip(rmc.fix_time).map(|(date, time)| date.and_time(time).and_utc());
            let time_s = time.map(|time| time.timestamp_micros() as f64 * 1e-6);
            (rmc.lat.zip(rmc.lon).filter(|_| is_fix), time_s)
        }
        Some(ParseResult::GGA(gga)) => {
            let is_fix = !matches!(gga.fix_type, None | Some(FixType::Invalid));
            (gga.latitude.zip(gga.longitude).filter(|_| is_fix), gga.fix_time.map(seconds_of_day))
        }
        _ => return Line::Damaged,
    };
    let Some((lat, lon)) = at else { return Line::WithoutFix };
    LatLon::new(lat, lon).map_or(Line::Damaged, |at| Line::Position(kind, GpxPoint { at, time_s }))
}

fn seconds_of_day(time: impl chrono::Timelike) -> f64 {
    f64::from(time.num_seconds_from_midnight()) + f64::from(time.nanosecond()) * 1e-9
}

/// Times of day go on after midnight: one that is more than half a day before the last is the next day's.
fn add_days(points: &mut [GpxPoint]) {
    let (mut day_s, mut last_s) = (0.0, f64::NEG_INFINITY);
    for time_s in points.iter_mut().filter_map(|point| point.time_s.as_mut()) {
        if *time_s + day_s < last_s - 0.5 * DAY_S as f64 {
            day_s += DAY_S as f64;
        }
        *time_s += day_s;
        last_s = *time_s;
    }
}
