//! Positions of a GPS receiver: a GPX track, its NMEA 0183 sentences, or the reports of gpsd.
//!
//! Of a log's lines those of one kind are taken, the one that says most: gpsd's reports of position (TPV, as `gpspipe -w` writes
//! them), else RMC sentences, which have a date, else GGA, which have a time of day alone. What else is in the log, comments,
//! other sentences, bytes of another protocol, is passed over; sentences and reports that are damaged are counted.
//!
//! Checksums may be left out (NMEA 0183): in a log without any its sentences are believed when they have all of their fields, and counted;
//! in one that has some, a sentence without is damaged.

use std::borrow::Cow;
use std::str::Lines;

use nmea::ParseResult;
use nmea::sentences::FixType;
use nmea::sentences::rmc::RmcStatusOfFix;
use serde::Deserialize;
use thiserror::Error;

use crate::gpx::{DAY_S, POINT_BYTES, not_a_time, parse_time_s};
use crate::passed_over::{PassedOver, UnreadPlace};
use crate::text_encoding::{DecodedText, text_of};
use crate::{GpxError, GpxPoint, GpxTrack, LatLon, parse_gpx_within};

/// What a log holds.
#[derive(Debug, Clone, PartialEq)]
pub struct GpsLog {
    /// Its positions, in its order; without those that the receiver itself calls no fix.
    pub points: Vec<GpxPoint>,
    /// What their times count from.
    pub clock: GpsClock,
    /// Sentences and reports of position that are damaged: a checksum that does not fit, a line cut short; of a GPX track, points that
    /// cannot be read. And times that cannot be read, and reports of gpsd without any, whose points are there without one.
    pub damaged: PassedOver,
    /// Sentences that gave a position or said that there is none, and whose damage would not be seen: they have no checksum.
    pub unchecked: usize,
}

/// What the times of a log count from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GpsClock {
    /// 1970-01-01 00:00 UTC.
    Utc,
    /// The midnight before the first position, UTC, of a day that the log does not say.
    Midnight,
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
        "the GPS log has no position: in {without_fix} reports the receiver has no fix; record it again where the receiver sees the sky"
    )]
    NoFix {
        /// Reports in which the receiver says that it has no fix.
        without_fix: usize,
    },
    /// There are sentences or reports, and those that are not without a fix are damaged.
    #[error(
        "the GPS log has no position: {damaged} of its reports are damaged, {first}; in {without_fix} the receiver has no fix; record it \
         again, or copy it again as it is"
    )]
    Damaged {
        /// Reports that could not be read.
        damaged: usize,
        /// The first of them.
        first: UnreadPlace,
        /// Reports in which the receiver says that it has no fix.
        without_fix: usize,
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
    /// A position of gpsd, and what is wrong with its time.
    Untimed(LatLon, String),
    WithoutFix,
    Damaged(String),
    Other,
}

/// Reads the positions of a GPX document or of a receiver's log into at most `memory_bytes`.
///
/// # Errors
/// [`GpsLogError`] when there is no position in it, or too many.
pub fn parse_gps_log_within(bytes: &[u8], memory_bytes: usize) -> Result<GpsLog, GpsLogError> {
    // A replaced letter is in a name, which is not used, or in a number, which is then said to be none.
    let DecodedText { text, .. } = text_of(bytes);
    if text.trim_start().starts_with('<') {
        let GpxTrack { points, passed_over } = parse_gpx_within(&text, memory_bytes)?;
        return Ok(GpsLog { points, clock: GpsClock::Utc, damaged: passed_over, unchecked: 0 });
    }
    let checks = Checks::of(text.lines());
    let mut points: [Vec<GpxPoint>; KINDS] = Default::default();
    let (mut without_fix, mut unchecked, mut damaged) = (0, 0, PassedOver::default());
    for (number, line) in (1..).zip(text.lines()) {
        let report = report_in(line);
        let read = report.map_or(Line::Other, |report| read_report(report, checks));
        let is_sentence = report.is_some_and(|report| report.starts_with('$'));
        let is_read = matches!(read, Line::Position(..) | Line::WithoutFix);
        unchecked += usize::from(checks == Checks::None && is_sentence && is_read);
        match read {
            Line::Position(kind, point) => points[kind].push(point),
            Line::Untimed(at, cause) => {
                points[GPSD].push(GpxPoint { at, time_s: None });
                damaged.add(|| UnreadPlace { line: number, cause });
            }
            Line::WithoutFix => without_fix += 1,
            Line::Damaged(cause) => damaged.add(|| UnreadPlace { line: number, cause }),
            Line::Other => {}
        }
        if points.iter().map(Vec::len).sum::<usize>() > memory_bytes / POINT_BYTES {
            return Err(GpsLogError::TooLarge { limit_mb: memory_bytes / 1_000_000 });
        }
    }
    let [_, _, by_clock] = &mut points;
    add_days(by_clock);
    match (0..).zip(points).find(|(_, points)| !points.is_empty()) {
        Some((kind, points)) => {
            let clock = if kind == GGA { GpsClock::Midnight } else { GpsClock::Utc };
            Ok(GpsLog { points, clock, damaged, unchecked })
        }
        None => Err(match (damaged.first, without_fix) {
            (Some(first), _) => GpsLogError::Damaged { damaged: damaged.count, first, without_fix },
            (None, 1..) => GpsLogError::NoFix { without_fix },
            (None, 0) => GpsLogError::NoLog,
        }),
    }
}

/// Whether the sentences of a log have checksums.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Checks {
    /// Some have.
    Some,
    /// None has.
    None,
}

impl Checks {
    fn of(lines: Lines<'_>) -> Self {
        let mut sentences = lines.filter_map(report_in).filter(|report| kind_of(report).is_some());
        if sentences.any(|sentence| sentence.contains('*')) { Self::Some } else { Self::None }
    }
}

/// The report in a line; what stands before it, such as a time, is passed over.
fn report_in(line: &str) -> Option<&str> {
    Some(line[line.find(['$', '{'])?..].trim_ascii_end())
}

fn read_report(report: &str, checks: Checks) -> Line {
    if report.starts_with('{') { read_gpsd(report) } else { read_nmea(report, checks) }
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

fn read_gpsd(line: &str) -> Line {
    let report = match serde_json::from_str::<GpsdReport>(line) {
        Ok(report) => report,
        Err(cause) if line.contains("\"TPV\"") => return Line::Damaged(cause.to_string()),
        Err(_) => return Line::Other,
    };
    if report.class != "TPV" {
        return Line::Other;
    }
    let (Some(lat), Some(lon), true) = (report.lat, report.lon, report.mode >= LEAST_MODE) else {
        return Line::WithoutFix;
    };
    let at = match LatLon::new(lat, lon) {
        Ok(at) => at,
        Err(cause) => return Line::Damaged(cause.to_string()),
    };
    match report.time.as_deref().map(|time| parse_time_s(time).ok_or_else(|| not_a_time(time))) {
        Some(Ok(time_s)) => Line::Position(GPSD, GpxPoint { at, time_s: Some(time_s) }),
        Some(Err(cause)) => Line::Untimed(at, cause),
        None => Line::Untimed(at, "a report of position has no time".to_owned()),
    }
}

/// What a sentence is: "$", two letters that name the system of satellites, three that name the sentence.
fn kind_of(sentence: &str) -> Option<usize> {
    match sentence.get(3..6) {
        Some("RMC") if sentence.starts_with('$') => Some(RMC),
        Some("GGA") if sentence.starts_with('$') => Some(GGA),
        _ => None,
    }
}

/// Commas of a whole sentence at the least, of RMC up to the magnetic variation and of GGA.
const LEAST_COMMAS: [usize; KINDS] = [0, 11, 14];

/// The sentence with the checksum that it was written without, if it may be; else as it is.
fn with_checksum(sentence: &str, kind: usize, checks: Checks) -> Option<Cow<'_, str>> {
    if sentence.contains('*') {
        return Some(Cow::Borrowed(sentence));
    }
    let is_whole = sentence.bytes().filter(|byte| *byte == b',').count() >= LEAST_COMMAS[kind];
    let sum = sentence.bytes().skip(1).fold(0, |sum, byte| sum ^ byte);
    (checks == Checks::None && is_whole).then(|| Cow::Owned(format!("{sentence}*{sum:02X}")))
}

fn read_nmea(line: &str, checks: Checks) -> Line {
    let Some(kind) = kind_of(line) else { return Line::Other };
    let Some(checked) = with_checksum(line, kind, checks) else {
        return Line::Damaged(match checks {
            Checks::Some => "a sentence is cut short before its checksum".to_owned(),
            Checks::None => "a sentence without a checksum lacks some of its fields".to_owned(),
        });
    };
    let (at, time_s) = match nmea::parse_str(&checked) {
        Ok(ParseResult::RMC(rmc)) => {
            let is_fix = rmc.status_of_fix != RmcStatusOfFix::Invalid;
            let time = rmc.fix_date.zip(rmc.fix_time).map(|(date, time)| date.and_time(time).and_utc());
            let time_s = time.map(|time| time.timestamp_micros() as f64 * 1e-6);
            (rmc.lat.zip(rmc.lon).filter(|_| is_fix), time_s)
        }
        Ok(ParseResult::GGA(gga)) => {
            let is_fix = !matches!(gga.fix_type, None | Some(FixType::Invalid));
            (gga.latitude.zip(gga.longitude).filter(|_| is_fix), gga.fix_time.map(seconds_of_day))
        }
        Ok(_) => return Line::Other,
        Err(cause) => return Line::Damaged(cause.to_string()),
    };
    let Some((lat, lon)) = at else { return Line::WithoutFix };
    match LatLon::new(lat, lon) {
        Ok(at) => Line::Position(kind, GpxPoint { at, time_s }),
        Err(cause) => Line::Damaged(cause.to_string()),
    }
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
