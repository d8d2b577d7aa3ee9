//! Logs as `candump -L` of can-utils writes them, plain or compressed with gzip.
//!
//! A line is `(SECONDS) INTERFACE ID#DATA`, with `ID##FLAGS DATA` (flags one digit, no space) for CAN FD; `R` or `T` may
//! follow for received or sent. Frames that carry no data (requests, errors) are left out.

use std::io::{self, BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use flate2::bufread::MultiGzDecoder;
use thiserror::Error;

use super::frame::{CanFrame, CanId, LogFrame};
use crate::file::{FileError, InputFile};

/// First bytes of a file compressed with gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];
/// Bit of an identifier that marks a frame of the interface itself about an error.
const ERROR_BIT: u32 = 0x2000_0000;
/// Digits of a 29-bit identifier and of an 11-bit one.
const EXTENDED_DIGITS: usize = 8;
const STANDARD_DIGITS: usize = 3;
/// Bytes of a line at the most; one of CAN FD has 200. What goes on for longer is no log, and need not fit into memory.
const MOST_LINE_BYTES: u64 = 4096;
/// Bytes after which a line is no line of any file, but an input without an end.
const MOST_SKIPPED_BYTES: u64 = 1 << 30;
/// Largest time to either side of zero, seconds: 1970 and 317 years.
const LARGEST_S: f64 = 1e10;
/// How far a log's clock may step back, seconds: frames of several interfaces are written a little out of step, and a clock that
/// is set by the network is moved by less while it runs.
const MOST_OUT_OF_STEP_S: f64 = 1.0;

/// A log that cannot be used.
#[derive(Debug, Error)]
pub enum CanLogError {
    /// It cannot be read.
    #[error(transparent)]
    File(#[from] FileError),
    /// No line of it is one of a log.
    #[error("{} is no CAN log: none of its {lines} lines is one of `candump -L`, such as (12.345) can0 123#11223344", .path.display())]
    NoFrames {
        /// The file.
        path: PathBuf,
        /// Its lines.
        lines: u64,
    },
    /// Its clock steps back.
    #[error(
        "{} steps back in time at line {line}, from {from_s:.3} to {to_s:.3} s: its clock was set, or it is several logs; cut it \
         there",
        .path.display()
    )]
    Backwards {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: u64,
        /// The latest time before it, seconds.
        from_s: f64,
        /// Its time, seconds.
        to_s: f64,
    },
    /// It goes on as a bus does.
    #[error(
        "{} has not ended after {waited_s} s, in which its clock went on by {passed_s:.1} s: it is no log but a bus under way; record it \
         first (candump -L), give the interface itself (socketcan:can0), or wait longer (--timeout-s)",
        .path.display()
    )]
    Endless {
        /// The pipe or device.
        path: PathBuf,
        /// How long it was read, seconds.
        waited_s: f64,
        /// Time from its first frame to its last one, seconds.
        passed_s: f64,
    },
    /// It says more than can be held.
    #[error("{} has more than {most} values of the signals that are read; cut out the drive", .path.display())]
    TooManySamples {
        /// The file.
        path: PathBuf,
        /// How many values are held at the most.
        most: usize,
    },
}

/// The frames of a log, read line by line.
pub struct CanLogFrames {
    path: PathBuf,
    reader: Box<dyn BufRead>,
    line: Vec<u8>,
    /// Lines so far.
    pub lines: u64,
    /// Lines so far that are none of a log's, such as one that was cut off.
    pub unreadable_lines: u64,
    /// The first and the latest time so far, seconds of the log's clock.
    first_s: Option<f64>,
    latest_s: f64,
    /// When it was opened, and how long it is waited for; of pipes and devices, which may have no end.
    waiting: Option<(Instant, Duration)>,
}

/// Opens a log.
///
/// # Errors
/// [`CanLogError::File`] when it cannot be read.
pub fn read_can_log(path: &Path) -> Result<CanLogFrames, CanLogError> {
    let file = InputFile::open(path)?;
    let waiting = file.longest_wait().map(|longest| (Instant::now(), longest));
    let mut file = BufReader::new(file);
    let compressed = file.fill_buf().map_err(FileError::reading(path))?.starts_with(&GZIP);
    let reader: Box<dyn BufRead> =
        if compressed { Box::new(BufReader::new(MultiGzDecoder::new(file))) } else { Box::new(file) };
    Ok(CanLogFrames {
        path: path.to_owned(),
        reader,
        line: Vec::new(),
        lines: 0,
        unreadable_lines: 0,
        first_s: None,
        latest_s: f64::NEG_INFINITY,
        waiting,
    })
}

impl CanLogFrames {
    /// The next data frame; none at the log's end.
    ///
    /// # Errors
    /// [`CanLogError`] when the file cannot be read on, its clock steps back by more than a second, it has ended and no line of
    /// it was one of a log, or it is a pipe that has been waited for, or read no faster than it records, for the longest wait.
    pub fn next_frame(&mut self) -> Result<Option<LogFrame<'_>>, CanLogError> {
        loop {
            self.line.clear();
            let read = read_line(&mut *self.reader, &mut self.line);
            if read.map_err(|cause| self.unread(cause))? == 0 {
                let nothing = self.lines > 0 && self.unreadable_lines == self.lines;
                return if nothing || self.lines == 0 {
                    Err(CanLogError::NoFrames { path: self.path.clone(), lines: self.lines })
                } else {
                    Ok(None)
                };
            }
            self.lines += 1;
            self.check_end()?;
            match str::from_utf8(&self.line).ok().and_then(parse_candump_line) {
                Some(Some(frame)) => {
                    let (from_s, to_s) = (self.latest_s, frame.t_s);
                    if to_s < from_s - MOST_OUT_OF_STEP_S {
                        let (path, line) = (self.path.clone(), self.lines);
                        return Err(CanLogError::Backwards { path, line, from_s, to_s });
                    }
                    self.first_s.get_or_insert(to_s);
                    self.latest_s = from_s.max(to_s);
                    break;
                }
                Some(None) => {}
                None => self.unreadable_lines += 1,
            }
        }
        // Read once more, because a frame that lends the line's text cannot leave a loop that fills the line again.
        Ok(str::from_utf8(&self.line).ok().and_then(parse_candump_line).flatten())
    }
}

impl CanLogFrames {
    /// Refuses what gives lines without a wait and whose clock goes on no faster than they are read: a log was recorded more slowly.
    fn check_end(&self) -> Result<(), CanLogError> {
        let Some((began, longest)) = self.waiting else { return Ok(()) };
        if began.elapsed() < longest || self.passed_s() > began.elapsed().as_secs_f64() {
            return Ok(());
        }
        Err(self.endless(longest))
    }

    /// Why nothing more is read. A pipe that gave lines and was waited for as long as anybody is a bus under way.
    fn unread(&self, cause: io::Error) -> CanLogError {
        match self.waiting {
            Some((_, longest)) if self.lines > 0 && cause.kind() == io::ErrorKind::TimedOut => {
                self.endless(longest)
            }
            _ => FileError::reading(&self.path)(cause).into(),
        }
    }

    fn endless(&self, longest: Duration) -> CanLogError {
        let (path, waited_s) = (self.path.clone(), longest.as_secs_f64());
        CanLogError::Endless { path, waited_s, passed_s: self.passed_s() }
    }

    /// Time from the first frame to the last so far, seconds.
    fn passed_s(&self) -> f64 {
        self.first_s.map_or(0.0, |first_s| self.latest_s - first_s)
    }
}

/// Reads up to the end of a line; of one that is too long the rest is passed over, up to a gigabyte, and `line` is left empty.
fn read_line(reader: &mut dyn BufRead, line: &mut Vec<u8>) -> io::Result<usize> {
    let mut read = (&mut *reader).take(MOST_LINE_BYTES).read_until(b'\n', line)?;
    if read as u64 == MOST_LINE_BYTES && !line.ends_with(b"\n") {
        line.clear();
        let mut rest = (&mut *reader).take(MOST_SKIPPED_BYTES);
        let skipped = rest.skip_until(b'\n')?;
        if rest.limit() == 0 {
            return Err(io::Error::new(io::ErrorKind::InvalidData, "a line of it has no end"));
        }
        read += skipped;
    }
    Ok(read)
}

/// The frame of a line; `Some(None)` for one without data, none for a line that is no log's, and for a time beyond 1e10 seconds.
pub fn parse_candump_line(line: &str) -> Option<Option<LogFrame<'_>>> {
    let mut words = line.split_ascii_whitespace();
    let t_s: f64 = words.next()?.strip_prefix('(')?.strip_suffix(')')?.parse().ok()?;
    let interface = words.next()?;
    let (id, rest) = words.next()?.split_once('#')?;
    if t_s.is_nan()
        || t_s.abs() > LARGEST_S
        || !matches!((words.next(), words.next()), (None | Some("R" | "T"), None))
    {
        return None;
    }
    // A number of Rust's may begin with a sign.
    if !id.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        return None;
    }
    let number = u32::from_str_radix(id, 16).ok()?;
    let is_request = rest.starts_with('R');
    if is_request || (id.len() == EXTENDED_DIGITS && number & ERROR_BIT != 0) {
        return Some(None);
    }
    let id = match id.len() {
        EXTENDED_DIGITS => CanId::Extended(number),
        STANDARD_DIGITS => CanId::Standard(u16::try_from(number).ok()?),
        _ => return None,
    };
    if !id.is_possible() {
        return None;
    }
    let digits = match rest.strip_prefix('#') {
        // CAN FD: the first digit holds flags.
        Some(flagged) => flagged.get(1..)?,
        // A length code above 8 may follow a full frame.
        None => rest.split_once('_').map_or(rest, |(digits, _)| digits),
    };
    Some(Some(LogFrame { t_s, interface, frame: frame(id, digits)? }))
}

fn frame(id: CanId, digits: &str) -> Option<CanFrame> {
    let (pairs, []) = digits.as_bytes().as_chunks::<2>() else { return None };
    let mut data = [0; 64];
    for (byte, [high, low]) in data.get_mut(..pairs.len())?.iter_mut().zip(pairs) {
        let digit = |letter: u8| char::from(letter).to_digit(16).map(|digit| digit as u8);
        *byte = digit(*high)? << 4 | digit(*low)?;
    }
    CanFrame::new(id, &data[..pairs.len()])
}
