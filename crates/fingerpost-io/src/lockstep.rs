//! Frames that a vehicle or simulator gives one by one: a line that describes the frame, then its bytes.
//!
//! What is wrong costs one frame. Where the line says how large the frame is, its bytes are passed over; where it does not, or
//! bytes are missing, everything is passed over up to the next line that is a description, also one that stands behind bytes of
//! a picture. Whoever gives nothing in the middle of a frame is not waited for without end.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};

use fingerpost_format::{FrameHeader, FrameHeaderError};
use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

use crate::picture_file::MAX_SIDE_PX;

/// Longest line, bytes: a hundred times what is said of a frame.
const LONGEST_LINE: u64 = 1 << 16;
/// How much of a line without end is kept, bytes.
const LONGEST_DESCRIPTION: usize = 1 << 12;

/// A frame that came.
#[derive(Debug)]
pub enum FedFrame<'a> {
    /// One that can be used.
    Good(FrameHeader, &'a RgbImage),
    /// One that cannot.
    Bad(FeedError),
    /// There are no more.
    End,
}

/// A frame that cannot be used.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum FeedError {
    /// Its description is wrong.
    #[error(transparent)]
    Header(#[from] FrameHeaderError),
    /// It has another size than the calibration's.
    #[error(
        "the frame has {} x {} pixels and the calibration is for {} x {}; give frames of that size, or their own calibration",
        .found_px[0], .found_px[1], .expected_px[0], .expected_px[1]
    )]
    Size {
        /// Width and height that its description says, pixels.
        found_px: [usize; 2],
        /// Those of the calibration.
        expected_px: [usize; 2],
    },
    /// Bytes are missing.
    #[error(
        "{came} of the frame's {needed} bytes came; give width x height x 3 bytes behind each description"
    )]
    TooFew {
        /// Bytes that came.
        came: usize,
        /// Bytes that were described.
        needed: usize,
    },
}

/// Reads frame after frame.
#[derive(Debug)]
pub struct FrameFeed<R> {
    from: BufReader<R>,
    line: Vec<u8>,
    picture: RgbImage,
    /// Whether what comes next may be in the middle of a frame.
    astray: bool,
}

/// The frames on standard input, of this width and height, pixels. While one is waited for, also in its middle, `meanwhile` is called
/// some twenty times a second; an error that it gives ends the waiting and is [`FrameFeed::next_frame`]'s.
///
/// # Errors
/// Those of the system where there is no standard input.
#[cfg(unix)]
pub fn standard_feed(
    size_px: [usize; 2],
    meanwhile: impl FnMut() -> io::Result<()>,
) -> io::Result<FrameFeed<impl Read>> {
    let input = crate::file::InputFile::standard_input()?;
    Ok(FrameFeed::new(Attended { input, meanwhile }, size_px))
}

/// An input during whose waits something else is done.
#[cfg(unix)]
struct Attended<M> {
    input: crate::file::InputFile,
    meanwhile: M,
}

#[cfg(unix)]
impl<M: FnMut() -> io::Result<()>> Read for Attended<M> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.input.read_while(buffer, &mut self.meanwhile)
    }
}

impl<R: Read> FrameFeed<R> {
    /// Frames of this width and height, pixels.
    pub fn new(from: R, [width, height]: [usize; 2]) -> Self {
        let (from, picture) = (BufReader::new(from), RgbImage::new(width, height));
        Self { from, line: Vec::new(), picture, astray: false }
    }

    /// The next frame.
    ///
    /// # Errors
    /// Those of reading; [`ErrorKind::TimedOut`] when no description comes.
    pub fn next_frame(&mut self) -> io::Result<FedFrame<'_>> {
        self.line.clear();
        let header = loop {
            if self.from.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut self.line)? == 0 {
                return Ok(FedFrame::End);
            }
            if self.astray && !self.line.ends_with(b"\n") {
                // A description may begin in what has come so far.
                self.line.drain(..self.line.len().saturating_sub(LONGEST_DESCRIPTION));
                continue;
            }
            if let Some(found) = described(&self.line, self.astray) {
                break found;
            }
            self.line.clear();
        };
        self.astray = false;
        let expected_px = <[usize; 2]>::from(self.picture.size());
        match header {
            Ok(header) if header.size_px == expected_px => {
                let needed = self.picture.as_slice().len();
                let came = fill(&mut self.from, self.picture.as_mut_slice())?;
                self.astray = came < needed;
                Ok(if self.astray {
                    FedFrame::Bad(FeedError::TooFew { came, needed })
                } else {
                    FedFrame::Good(header, &self.picture)
                })
            }
            Ok(FrameHeader { size_px, .. }) => {
                self.pass_over(size_px)?;
                Ok(FedFrame::Bad(FeedError::Size { found_px: size_px, expected_px }))
            }
            Err(error) => {
                match error {
                    FrameHeaderError::Number { size_px, .. } => self.pass_over(size_px)?,
                    FrameHeaderError::Syntax { .. } | FrameHeaderError::NoSize => self.astray = true,
                }
                Ok(FedFrame::Bad(error.into()))
            }
        }
    }

    /// Passes over the bytes of a frame; of one that is larger than any camera's it is not waited for them.
    fn pass_over(&mut self, size_px: [usize; 2]) -> io::Result<()> {
        if size_px.iter().any(|side| *side > MAX_SIDE_PX) {
            self.astray = true;
            return Ok(());
        }
        let mut left = size_px[0] * size_px[1] * RgbImage::CHANNELS;
        let mut some = [0; 4096];
        while left > 0 && !self.astray {
            let piece = left.min(some.len());
            let came = fill(&mut self.from, &mut some[..piece])?;
            self.astray = came < piece;
            left -= came;
        }
        Ok(())
    }
}

/// The description of a frame in a line, if it is meant to be one.
fn described(line: &[u8], astray: bool) -> Option<Result<FrameHeader, FrameHeaderError>> {
    // A description is a flat object: behind bytes of a picture it begins with the last brace.
    let begins = if astray { line.iter().rposition(|byte| *byte == b'{')? } else { 0 };
    let text = String::from_utf8_lossy(&line[begins..]);
    let text = text.trim();
    let is_meant = if astray { text.ends_with('}') && text.contains('"') } else { !text.is_empty() };
    is_meant.then(|| FrameHeader::parse(text))
}

/// Fills a buffer as far as bytes come, and says how many did.
fn fill(from: &mut impl Read, buffer: &mut [u8]) -> io::Result<usize> {
    let mut came = 0;
    while came < buffer.len() {
        match from.read(&mut buffer[came..]) {
            Ok(0) => break,
            Ok(more) => came += more,
            Err(cause) if cause.kind() == ErrorKind::Interrupted => {}
            Err(cause) if cause.kind() == ErrorKind::TimedOut => break,
            Err(cause) => return Err(cause),
        }
    }
    Ok(came)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADER: &str = "{\"t_s\": 0.5, \"width\": 2, \"height\": 1}\n";
    const PIXELS: &[u8] = b"abcdef";

    /// What comes of some bytes: G for a good frame, g for one of other pixels, and a letter for each kind of bad one.
    fn fed(pieces: &[&[u8]]) -> String {
        let bytes = pieces.concat();
        let mut feed = FrameFeed::new(bytes.as_slice(), [2, 1]);
        let mut found = String::new();
        loop {
            found.push(match feed.next_frame().unwrap() {
                FedFrame::Good(header, picture) => {
                    assert!((header.t_s - 0.5).abs() < 1e-12);
                    if picture.as_slice() == PIXELS { 'G' } else { 'g' }
                }
                FedFrame::Bad(FeedError::Header(FrameHeaderError::Number { .. })) => 'N',
                FedFrame::Bad(FeedError::Header(_)) => 'H',
                FedFrame::Bad(FeedError::Size { .. }) => 'S',
                FedFrame::Bad(FeedError::TooFew { .. }) => 'F',
                FedFrame::End => return found,
            });
        }
    }

    #[test]
    fn what_is_wrong_costs_one_frame() {
        let header = HEADER.as_bytes();
        let good: &[&[u8]] = &[header, PIXELS];
        let then_good = |bad: &[&[u8]]| fed(&[good, bad, good, good].concat());
        assert_eq!(fed(&[]), "");
        assert_eq!(fed(&[good, good].concat()), "GG");
        assert_eq!(then_good(&[b"\n"]), "GGG");
        assert_eq!(then_good(&[b"no frame\n"]), "GHGG");
        // Its bytes come all the same, and the next description stands behind them.
        assert_eq!(then_good(&[b"{\"t_s\": 0.5, \"width\": 2\n", PIXELS]), "GHGG");
        assert_eq!(then_good(&[b"{\"t_s\": 0.5}\n", b"a\n{\x80\nc"]), "GHGG");
        assert_eq!(then_good(&[b"{\"t_s\": NaN, \"width\": 2, \"height\": 1}\n", PIXELS]), "GNGG");
        assert_eq!(then_good(&[b"{\"t_s\": 0.5, \"width\": 1, \"height\": 1}\n", b"abc"]), "GSGG");
        assert_eq!(then_good(&[b"{\"t_s\": 0.5, \"width\": 99999999, \"height\": 1}\n"]), "GSGG");
        // Far behind, across what is read at once.
        assert_eq!(then_good(&[b"no frame\n", &vec![b'x'; (1 << 16) - 10]]), "GHGG");
        // Wrong twice.
        assert_eq!(then_good(&[b"no frame\n", b"{\"t_s\": 0.5}\n"]), "GHHGG");
    }

    #[test]
    fn a_frame_that_is_cut_off_is_said_and_ends_the_feed() {
        assert_eq!(fed(&[HEADER.as_bytes(), b"abc"]), "F");
        assert_eq!(fed(&[HEADER.as_bytes(), PIXELS, HEADER.as_bytes()]), "GF");
        assert_eq!(fed(&[b"{\"t_s\": 0.5, \"width\": 5, \"height\": 1}\n", b"abc"]), "S");
    }

    #[test]
    fn bytes_that_are_missing_cost_the_frame_that_they_are_taken_from_too() {
        // The first frame takes bytes of the second, whose description is then none; the third is found again.
        let header = HEADER.as_bytes();
        assert_eq!(fed(&[header, b"abc", header, PIXELS, header, PIXELS]), "gHG");
    }
}
