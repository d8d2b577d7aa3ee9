//! What ffmpeg says while it decodes: the form of every frame, which frames are damaged, and complaints.
//!
//! ffmpeg fits every frame to the size of the first, and starts to count anew where the form changes, which makes it drop
//! frames; the pictures do not tell. So its filter `showinfo` writes a line for each frame as the decoder gave it, before the
//! frame goes on. When a picture has come, its line has been written, and lines are taken in before a picture is handed on:
//! what is found does not depend on who is faster.

use std::{
    collections::VecDeque,
    fmt,
    io::{self, ErrorKind, Read},
    process::ChildStderr,
    sync::{Arc, Mutex, MutexGuard, PoisonError},
    thread,
};

use thiserror::Error;

use crate::address::without_credentials;

/// What makes ffmpeg write a line for every frame, and mark every line with its level.
pub(super) const LOG_ARGUMENTS: [&str; 4] = ["-hide_banner", "-nostats", "-v", "repeat+level+info"];
/// The filter that writes the lines, without sums over all pixels.
pub(super) const FRAME_LINES: &str = "showinfo=checksum=0";

/// Bytes that are read at once.
const BLOCK_BYTES: usize = 4096;
/// Bytes that are kept of a line: those of frames have less than two hundred.
const KEPT_LINE_BYTES: usize = 1024;

/// What ffmpeg says, shared by who takes pictures and a thread that keeps ffmpeg from waiting for a reader.
#[derive(Debug, Clone)]
pub(super) struct DecodeLog(Arc<Mutex<Shared>>);

#[derive(Debug)]
struct Shared {
    #[cfg(unix)]
    stderr: ChildStderr,
    #[cfg(unix)]
    ended: bool,
    lines: Lines,
}

/// What ffmpeg says of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct FrameNotes {
    /// Its index.
    pub(super) frame: u64,
    /// Whether parts of it had to be made up.
    pub(super) damaged: bool,
    /// The stamp that it came with, microseconds since any moment.
    pub(super) stamp_us: Option<i64>,
}

/// The form of a frame.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Form {
    size: String,
    pixels: String,
}

impl fmt::Display for Form {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", self.size.replace('x', " x "), self.pixels)
    }
}

/// A stream goes on in another form.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("from {from} to {to}")]
pub(super) struct FormChange {
    /// The first frame of the other form.
    frame: u64,
    from: Form,
    to: Form,
}

/// What the lines so far say.
#[derive(Debug, Default)]
struct Lines {
    unfinished: Vec<u8>,
    frames: u64,
    first: Option<Form>,
    change: Option<FormChange>,
    /// Damaged frames that nobody has asked for yet.
    damaged: VecDeque<u64>,
    /// Times stamped on frames that nobody has asked for yet.
    stamps: VecDeque<(u64, i64)>,
    complaint: Option<String>,
}

impl DecodeLog {
    /// Begins to listen.
    #[cfg(unix)]
    pub(super) fn listen(stderr: ChildStderr) -> io::Result<Self> {
        use rustix::event::{PollFd, PollFlags, poll};
        use std::os::fd::AsFd;
        rustix::io::ioctl_fionbio(&stderr, true)?;
        let readable = stderr.as_fd().try_clone_to_owned()?;
        let log = Self(Arc::new(Mutex::new(Shared { stderr, ended: false, lines: Lines::default() })));
        let listener = log.clone();
        thread::spawn(move || {
            while !listener.taken_in().ended {
                match poll(&mut [PollFd::new(&readable, PollFlags::IN)], None) {
                    Ok(_) | Err(rustix::io::Errno::INTR) => {}
                    Err(_) => return,
                }
            }
        });
        Ok(log)
    }

    /// Begins to listen. Where nobody can ask whether there is more to read, the last lines may come too late.
    #[cfg(not(unix))]
    pub(super) fn listen(mut stderr: ChildStderr) -> io::Result<Self> {
        let log = Self(Arc::new(Mutex::new(Shared { lines: Lines::default() })));
        let listener = log.clone();
        thread::spawn(move || {
            let mut block = [0; BLOCK_BYTES];
            while let Ok(length @ 1..) = stderr.read(&mut block) {
                listener.taken_in().lines.add(&block[..length]);
            }
        });
        Ok(log)
    }

    /// All that has been said by now.
    fn taken_in(&self) -> MutexGuard<'_, Shared> {
        // A thread that panicked has at worst left a line unfinished.
        #[cfg_attr(not(unix), expect(unused_mut, reason = "the thread takes in all"))]
        let mut shared = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        #[cfg(unix)]
        shared.take_in();
        shared
    }

    /// An error when the frame with that index is said to have another form than those before.
    pub(super) fn check_form(&self, frame: u64) -> Result<(), FormChange> {
        let change = &self.taken_in().lines.change;
        change.as_ref().filter(|change| frame >= change.frame).map_or(Ok(()), |change| Err(change.clone()))
    }

    /// What was said of the frame with that index. To be asked for one frame after the other.
    pub(super) fn take_notes(&self, frame: u64) -> FrameNotes {
        let lines = &mut self.taken_in().lines;
        let mut notes = FrameNotes { frame, damaged: false, stamp_us: None };
        while lines.damaged.front().is_some_and(|damaged| *damaged <= frame) {
            notes.damaged |= lines.damaged.pop_front() == Some(frame);
        }
        while lines.stamps.front().is_some_and(|(stamped, _)| *stamped <= frame) {
            let of_frame = lines.stamps.pop_front().filter(|(stamped, _)| *stamped == frame);
            notes.stamp_us = of_frame.map(|(_, stamp_us)| stamp_us);
        }
        notes
    }

    /// The last complaint, with the input's address as it may be shown.
    pub(super) fn complaint(&self) -> Option<String> {
        self.taken_in().lines.last_complaint().map(|line| without_credentials(&line))
    }
}

#[cfg(unix)]
impl Shared {
    fn take_in(&mut self) {
        let mut block = [0; BLOCK_BYTES];
        while !self.ended {
            match self.stderr.read(&mut block) {
                Ok(length @ 1..) => self.lines.add(&block[..length]),
                Err(cause) if cause.kind() == ErrorKind::WouldBlock => return,
                Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
                Ok(0) | Err(_) => self.ended = true,
            }
        }
    }
}

impl Lines {
    fn add(&mut self, bytes: &[u8]) {
        for piece in bytes.split_inclusive(|byte| *byte == b'\n') {
            let room = KEPT_LINE_BYTES - self.unfinished.len();
            let (text, is_whole) = piece
                .split_last()
                .filter(|(last, _)| **last == b'\n')
                .map_or((piece, false), |(_, text)| (text, true));
            self.unfinished.extend_from_slice(&text[..text.len().min(room)]);
            if is_whole {
                let line = std::mem::take(&mut self.unfinished);
                self.add_line(String::from_utf8_lossy(&line).trim());
            }
        }
    }

    fn add_line(&mut self, line: &str) {
        match Level::of(line) {
            Level::Info if line.contains("showinfo") => self.add_frame(line),
            Level::Info => {}
            // Only of the frame that comes next it is said before that frame's own line.
            Level::Warning if line.contains("corrupt decoded frame") => {
                if self.damaged.back() != Some(&self.frames) {
                    self.damaged.push_back(self.frames);
                }
            }
            Level::Warning => {}
            Level::Error if line.is_empty() => {}
            Level::Error => self.complaint = Some(line.to_owned()),
        }
    }

    fn add_frame(&mut self, line: &str) {
        let value = |name: &str| line.split(name).nth(1)?.split_whitespace().next();
        let (Some(number), Some(pixels), Some(size)) = (value(" n:"), value(" fmt:"), value(" s:")) else {
            return;
        };
        let form = Form { size: size.to_owned(), pixels: pixels.to_owned() };
        // Where the form changes ffmpeg sets its filters up anew, which then count from zero.
        let goes_on = number.parse() == Ok(self.frames);
        let first = self.first.get_or_insert_with(|| form.clone());
        if self.change.is_none() && (!goes_on || *first != form) {
            self.change = Some(FormChange { frame: self.frames, from: first.clone(), to: form });
        }
        // Whole microseconds: what ffmpeg writes as seconds has six digits in all. Frames without a time read NOPTS.
        if let Some(stamp_us) = value(" pts:").and_then(|text| text.parse::<i64>().ok()) {
            self.stamps.push_back((self.frames, stamp_us));
        }
        self.frames += 1;
    }

    fn last_complaint(&self) -> Option<String> {
        let unfinished = String::from_utf8_lossy(&self.unfinished);
        let unfinished = unfinished.trim();
        let last =
            (!unfinished.is_empty() && Level::of(unfinished) == Level::Error).then(|| unfinished.to_owned());
        last.or_else(|| self.complaint.clone())
            .map(|line| line.replacen("[error] ", "", 1).replacen("[fatal] ", "", 1))
    }
}

/// How much a line matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Level {
    Info,
    Warning,
    Error,
}

impl Level {
    /// From `[info] ...` or `[h264 @ 0x5651bc] [error] ...`; what says no level is a complaint.
    fn of(line: &str) -> Self {
        let behind_speaker =
            line.split_once("] ").filter(|(speaker, _)| speaker.contains(" @ ")).map(|(_, rest)| rest);
        let marked = behind_speaker.unwrap_or(line);
        if ["[info]", "[verbose]", "[debug]"].iter().any(|level| marked.starts_with(level)) {
            Self::Info
        } else if marked.starts_with("[warning]") {
            Self::Warning
        } else {
            Self::Error
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u64, pixels: &str, size: &str) -> String {
        format!(
            "[Parsed_showinfo_2 @ 0x56] [info] n:{number:4} pts:  NOPTS pos: 12 fmt:{pixels} sar:1/1 s:{size} i:P iskey:1\n"
        )
    }

    fn lines(text: &str, block: usize) -> Lines {
        let mut lines = Lines::default();
        text.as_bytes().chunks(block).for_each(|bytes| lines.add(bytes));
        lines
    }

    #[test]
    fn another_form_is_found_at_its_frame_however_the_text_is_cut() {
        let same = (0..7).map(|number| frame(number, "yuv420p", "320x240")).collect::<String>();
        for (next, expected) in [
            (frame(7, "yuv420p", "320x240"), None),
            (frame(0, "yuv420p", "160x120"), Some("from 320 x 240 (yuv420p) to 160 x 120 (yuv420p)")),
            (frame(7, "yuv420p", "240x320"), Some("from 320 x 240 (yuv420p) to 240 x 320 (yuv420p)")),
            (frame(0, "yuvj420p", "320x240"), Some("from 320 x 240 (yuv420p) to 320 x 240 (yuvj420p)")),
        ] {
            for block in [1, 7, 100, 4096] {
                let lines = lines(&format!("[info] Input #0: n:  3\n{same}{next}"), block);
                assert_eq!(lines.frames, 8);
                assert_eq!(lines.change.as_ref().map(ToString::to_string).as_deref(), expected);
                assert!(lines.change.is_none_or(|change| change.frame == 7));
            }
        }
    }

    #[test]
    fn times_belong_to_their_frames() {
        let stamped = |number: u64, time: &str| frame(number, "gray", "2x2").replace("NOPTS", time);
        // In seconds ffmpeg writes the third as 20000.
        let text = [
            stamped(0, "3500000"),
            stamped(1, "NOPTS"),
            stamped(2, "20000033333 pts_time:20000"),
            stamped(3, "inf"),
        ];
        let stamps = lines(&text.concat(), 9).stamps;
        assert_eq!(stamps, [(0, 3_500_000), (2, 20_000_033_333)]);
    }

    #[test]
    fn damage_belongs_to_the_frame_behind_it_and_complaints_are_kept() {
        let corrupt = "[warning] a.ts: corrupt decoded frame in stream 0\n";
        let text = [
            &frame(0, "gray", "2x2"),
            corrupt,
            corrupt,
            &frame(1, "gray", "2x2"),
            "[h264 @ 0x5] [error] MB 3\n",
            corrupt,
        ];
        let lines = lines(&text.concat(), 5);
        assert_eq!(lines.damaged, [1, 2]);
        assert_eq!(lines.last_complaint().as_deref(), Some("[h264 @ 0x5] MB 3"));
        assert!(lines.stamps.is_empty());
        let noise = "x".repeat(1_000_000);
        let lines = self::lines(&format!("{noise}\nno level\n"), 999);
        assert_eq!(lines.last_complaint().as_deref(), Some("no level"));
        assert_eq!(self::lines("[warning] a\n[info] b\n\n", 3).last_complaint(), None);
    }
}
