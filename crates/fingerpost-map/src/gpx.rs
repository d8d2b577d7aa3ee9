//! GPX tracks: places, and when they were passed.
//!
//! GPX 1.0 and 1.1 (Topografix). A file's track points are taken, of all tracks and segments in their order; where it has
//! none its route points, else its waypoints. Elevation and everything else is passed over. A point without a place costs itself, a time
//! that cannot be read its own point's; both are counted.

use quick_xml::events::{BytesStart, Event};
use quick_xml::reader::Reader;
use thiserror::Error;

use crate::passed_over::{PassedOver, UnreadPlace};
use crate::xml_attributes::{Attributes, MOST_DEPTH};
use crate::{LatLon, OsmData};

/// A point of a GPX track.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GpxPoint {
    /// Where.
    pub at: LatLon,
    /// When, seconds since 1970-01-01 00:00 UTC; `None` where the file does not say.
    pub time_s: Option<f64>,
}

/// What a GPX document holds.
#[derive(Debug, Clone, PartialEq)]
pub struct GpxTrack {
    /// Its points, in its order.
    pub points: Vec<GpxPoint>,
    /// Points that could not be read, and times, whose points are there without one.
    pub passed_over: PassedOver,
}

/// Why text is no GPX track.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum GpxError {
    /// Not well formed, or cut short.
    #[error("the GPX is broken at byte {at_byte}: {cause}; export the track again")]
    Broken {
        /// Where reading stopped, bytes from the start.
        at_byte: u64,
        /// What is wrong there.
        cause: String,
    },
    /// More points than may be held.
    #[error(
        "the GPX has more points than the {limit_mb} MB of memory hold that it may take; cut out the drive, or allow more (--max-input-mib)"
    )]
    TooLarge {
        /// The memory that it may take, megabytes.
        limit_mb: usize,
    },
    /// Points, of which none has a place.
    #[error("none of the {count} points of the GPX can be read, {first}; export the track again")]
    NoneReadable {
        /// How many there are.
        count: usize,
        /// The first of them.
        first: UnreadPlace,
    },
    /// No points.
    #[error("the GPX holds no track, route or waypoints; export the track itself")]
    NoPoints,
}

/// The elements that hold points, in the order of preference.
const POINT_ELEMENTS: [&str; 3] = ["trkpt", "rtept", "wpt"];

/// Bytes of a text that are kept: a time has thirty.
const MOST_TEXT_BYTES: usize = 1000;
/// Bytes that a point takes: a list that grows is copied into one of twice its size, and for a moment both are there.
pub(crate) const POINT_BYTES: usize = 3 * size_of::<GpxPoint>();

/// Reads the points of a GPX document, as many as fit into the memory that a map may take where nothing else is said.
///
/// # Errors
/// As [`parse_gpx_within`].
pub fn parse_gpx(text: &str) -> Result<GpxTrack, GpxError> {
    parse_gpx_within(text, OsmData::MEMORY_BYTES)
}

/// Reads the points of a GPX document into at most `memory_bytes`; at most 64 elements may stand within each other.
///
/// # Errors
/// [`GpxError`] when it is not well formed, has too many points, or none that can be read.
pub fn parse_gpx_within(text: &str, memory_bytes: usize) -> Result<GpxTrack, GpxError> {
    let mut reader = Reader::from_str(text);
    let mut document = Document::default();
    let most_points = memory_bytes / POINT_BYTES;
    loop {
        let at_byte = reader.buffer_position();
        let line = || 1 + text.bytes().take(at_byte as usize).filter(|byte| *byte == b'\n').count();
        let step = match reader.read_event() {
            Ok(Event::Start(element)) => document.open(&element, line),
            Ok(Event::Empty(element)) => document.open(&element, line).map(|()| document.close(line)),
            Ok(Event::End(_)) => {
                document.close(line);
                Ok(())
            }
            Ok(Event::Text(text)) => {
                document.add(&text);
                Ok(())
            }
            Ok(Event::Eof) => break,
            Ok(_) => Ok(()),
            Err(error) => Err(error.to_string()),
        };
        step.map_err(|cause| GpxError::Broken { at_byte, cause })?;
        if document.points.iter().map(Vec::len).sum::<usize>() > most_points {
            return Err(GpxError::TooLarge { limit_mb: memory_bytes / 1_000_000 });
        }
    }
    document.finish().map_err(|cause| GpxError::Broken { at_byte: text.len() as u64, cause })?
}

#[derive(Default)]
struct Document {
    /// Names of the open elements.
    open: Vec<String>,
    /// Text since the last tag.
    text: String,
    /// The point whose element is open, and its place in [`POINT_ELEMENTS`].
    point: Option<(usize, GpxPoint)>,
    points: [Vec<GpxPoint>; 3],
    passed_over: PassedOver,
    is_gpx: bool,
}

impl Document {
    fn open(&mut self, element: &BytesStart<'_>, line: impl Fn() -> usize) -> Result<(), String> {
        let name = element.local_name().as_ref().to_owned();
        if self.open.is_empty() {
            if name != "gpx" {
                return Err(format!("the document is <{name}>, not <gpx>"));
            }
            self.is_gpx = true;
        }
        if self.open.len() == MOST_DEPTH {
            return Err(format!("more than {MOST_DEPTH} elements stand within each other"));
        }
        if let Some(sort) = POINT_ELEMENTS.iter().position(|point| *point == name) {
            match place(element) {
                Ok(at) => self.point = Some((sort, GpxPoint { at, time_s: None })),
                Err(cause) => self.passed_over.add(|| UnreadPlace { line: line(), cause }),
            }
        }
        self.open.push(name);
        self.text.clear();
        Ok(())
    }

    /// Takes text between tags; what is longer than any time is none.
    fn add(&mut self, text: &str) {
        let most = MOST_TEXT_BYTES.saturating_sub(self.text.len());
        self.text.extend(text.chars().take(most));
    }

    fn close(&mut self, line: impl Fn() -> usize) {
        let name = self.open.pop();
        let is_point = |name: &str| POINT_ELEMENTS.contains(&name);
        match name.as_deref() {
            Some(name) if is_point(name) => {
                if let Some((sort, point)) = self.point.take() {
                    self.points[sort].push(point);
                }
            }
            // Extensions may hold times of their own.
            Some("time") if self.open.last().is_some_and(|parent| is_point(parent)) => {
                if let Some((_, point)) = &mut self.point {
                    point.time_s = parse_time_s(&self.text);
                    if point.time_s.is_none() {
                        let cause = not_a_time(&self.text);
                        self.passed_over.add(|| UnreadPlace { line: line(), cause });
                    }
                }
            }
            _ => {}
        }
        self.text.clear();
    }

    fn finish(self) -> Result<Result<GpxTrack, GpxError>, String> {
        if !self.is_gpx {
            return Err("there is no <gpx> element".to_owned());
        }
        if !self.open.is_empty() {
            return Err("the document ends in the middle; it is cut short".to_owned());
        }
        let passed_over = self.passed_over;
        Ok(match self.points.into_iter().find(|points| !points.is_empty()) {
            Some(points) => Ok(GpxTrack { points, passed_over }),
            None => Err(match passed_over.first {
                Some(first) => GpxError::NoneReadable { count: passed_over.count, first },
                None => GpxError::NoPoints,
            }),
        })
    }
}

/// That a text is no time: words of a message.
pub(crate) fn not_a_time(text: &str) -> String {
    format!("time {:?} is not ISO 8601", shortened(text.trim()))
}

/// Letters of a value that a message repeats.
const REPEATED_LETTERS: usize = 40;

fn shortened(value: &str) -> String {
    value.chars().take(REPEATED_LETTERS).collect()
}

fn place(point: &BytesStart<'_>) -> Result<LatLon, String> {
    let attributes = Attributes::of(point)?;
    let at = LatLon::new(attributes.number("lat")?, attributes.number("lon")?);
    at.map_err(|error| error.to_string())
}

/// Seconds in a day.
pub(crate) const DAY_S: i64 = 86_400;
/// The zone farthest from UTC is 14 hours ahead (Line Islands).
const MOST_ZONE_HOURS: i64 = 14;

/// An ISO 8601 date and time ("2011-10-03T12:55:34.5Z", "...+02:00") of the years 1 to 9999 as seconds since 1970-01-01 00:00
/// UTC; a time without a zone is UTC, as GPX has it. A leap second (60) may end any hour: no table
/// of them is kept, and in zones of half an hour they end other ones in local time. `None` for
/// anything else: days that the calendar does not have, 24:00, zones beyond 14 hours.
pub(crate) fn parse_time_s(text: &str) -> Option<f64> {
    let (date, clock) = text.trim().split_once(['T', 't', ' '])?;
    let [year, month, day] = numbers::<3>(date, '-')?;
    let zone_at = clock.find(['Z', 'z', '+', '-']).unwrap_or(clock.len());
    let (clock, zone) = clock.split_at(zone_at);
    let (clock, second) = clock.rsplit_once(':')?;
    let [hour, minute] = numbers::<2>(clock, ':')?;
    // Digits with at most one decimal sign: what else reads as a number is none on a clock.
    let is_plain = second.bytes().all(|byte| byte.is_ascii_digit() || matches!(byte, b'.' | b','));
    let second: f64 = second.replace(',', ".").parse().ok().filter(|_| is_plain)?;
    let seconds_of_minute = if minute == 59 { 61.0 } else { 60.0 };
    let in_range = (1..=9999).contains(&year)
        && (1..=12).contains(&month)
        && (1..=days_of_month(year, month)).contains(&day)
        && (0..=23).contains(&hour)
        && (0..=59).contains(&minute)
        && (0.0..seconds_of_minute).contains(&second);
    if !in_range {
        return None;
    }
    let zone_s = match zone {
        "" | "Z" | "z" => 0,
        _ => {
            // "+02:00", "+0200" and "+02".
            let [hours, minutes] = match zone[1..].trim().split_at_checked(2)? {
                (hours, "") => [numbers::<1>(hours, ':')?[0], 0],
                (hours, minutes) => {
                    let minutes = minutes.strip_prefix(':').unwrap_or(minutes);
                    [
                        numbers::<1>(hours, ':')?[0],
                        numbers::<1>(minutes, ':').filter(|_| minutes.len() == 2)?[0],
                    ]
                }
            };
            if hours > MOST_ZONE_HOURS || minutes > 59 {
                return None;
            }
            (hours * 60 + minutes) * 60 * if zone.starts_with('-') { -1 } else { 1 }
        }
    };
    let whole_s = days_since_1970(year, month, day) * DAY_S + (hour * 60 + minute) * 60 - zone_s;
    Some(whole_s as f64 + second)
}

/// Numbers of one to four digits between separators; more digits and signs are no date's and no clock's.
fn numbers<const N: usize>(text: &str, separator: char) -> Option<[i64; N]> {
    let number = |part: &str| {
        let is_plain = (1..=4).contains(&part.len()) && part.bytes().all(|byte| byte.is_ascii_digit());
        part.parse().ok().filter(|_| is_plain)
    };
    let parts: Option<Vec<i64>> = text.split(separator).map(number).collect();
    parts?.try_into().ok()
}

/// Days of a month of the Gregorian calendar, month 1 to 12.
fn days_of_month(year: i64, month: i64) -> i64 {
    let (next_year, next_month) = if month == 12 { (year + 1, 1) } else { (year, month + 1) };
    days_since_1970(next_year, next_month, 1) - days_since_1970(year, month, 1)
}

/// Days from 1970-01-01 to a date of the Gregorian calendar: years are counted from March, so that the leap day is the
/// last day of its year and the months before it have a fixed pattern of lengths.
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    /// Days from 0000-03-01 to 1970-01-01.
    const MARCH_OF_YEAR_0: i64 = 719_468;
    let years = if month > 2 { year } else { year - 1 };
    let months_from_march = (month + 9) % 12;
    let days_before_month = (153 * months_from_march + 2) / 5;
    let leap_days = years.div_euclid(4) - years.div_euclid(100) + years.div_euclid(400);
    years * 365 + leap_days + days_before_month + day - 1 - MARCH_OF_YEAR_0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_known_instants() {
        // `date -u -d 2011-10-03T12:55:34Z +%s`, and leap days by the same.
        for (text, expected_s) in [
            ("1970-01-01T00:00:00Z", 0.0),
            ("2011-10-03T12:55:34Z", 1_317_646_534.0),
            ("2011-10-03T14:55:34.25+02:00", 1_317_646_534.25),
            ("2011-10-03T07:25:34-05:30", 1_317_646_534.0),
            ("2011-10-03T14:55:34+0200", 1_317_646_534.0),
            ("2011-10-03t14:55:34+02", 1_317_646_534.0),
            ("2011-10-03 12:55:34,5z", 1_317_646_534.5),
            ("2000-02-29T23:59:59", 951_868_799.0),
            ("2024-03-01T00:00:00Z", 1_709_251_200.0),
        ] {
            let seen_s = parse_time_s(text).unwrap();
            assert!((seen_s - expected_s).abs() < 1e-6, "{text}: {seen_s}");
        }
        for text in ["", "yesterday", "2011-10-03", "2011-13-03T00:00:00Z", "2011-10-03T12:60:00Z"] {
            assert_eq!(parse_time_s(text), None, "{text}");
        }
    }

    #[test]
    fn days_and_clocks_that_do_not_exist_are_no_times() {
        let lengths = [31, 28, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31];
        for year in [1900, 1999, 2000, 2011, 2024] {
            let is_leap = year % 4 == 0 && (year % 100 != 0 || year % 400 == 0);
            for (month, length) in (1..).zip(lengths) {
                let days = length + i64::from(is_leap && month == 2);
                for day in 0..=32 {
                    let read = parse_time_s(&format!("{year}-{month:02}-{day:02}T00:00:00Z"));
                    assert_eq!(read.is_some(), (1..=days).contains(&day), "{year}-{month}-{day}");
                }
            }
        }
        for text in [
            "2011-02-31T24:59:60.9",
            "2011-10-03T24:00:00Z",
            "2011-10-03T12:58:60Z",
            "2011-10-03T12:00:61Z",
            "2011-10-03T12:00:-1Z",
            "2011-10-03T12:00:1e1Z",
            "2011-10-03T12:00:NaNZ",
            "2011-10-03T12:00:00+15:00",
            "2011-10-03T12:00:00+02:60",
            "2011-10-03T12:00:00+2",
            "2011-10-03T12:00:00+02:0",
            "2011-10-03T12:00:00+02:000",
            "2011-10-03T12:00:00+\u{e9}\u{e9}",
            "2011-10-03T12:00:0,0.0Z",
            "99999999999999-10-03T12:00:00Z",
            "2011-10-9223372036854775807T12:00:00Z",
            "-2011-10-03T12:00:00Z",
            "2011-10-03T12:00:00+9223372036854775807:00",
        ] {
            assert_eq!(parse_time_s(text), None, "{text}");
        }
        assert!(parse_time_s("2016-12-31T23:59:60.5Z").is_some(), "a leap second");
    }
}
