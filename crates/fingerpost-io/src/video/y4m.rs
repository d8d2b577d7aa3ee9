//! Pictures in a pipe as YUV4MPEG2, the format of the mjpegtools: a header states the size of all, and each frame is
//! announced by a line. Half the bytes of red, green and blue, and no work for ffmpeg, whose decoders think in it.

use std::io::{self, BufRead, ErrorKind, Read};

use fingerpost_vision::{
    colour::{Yuv420, YuvCoding, rgb_from_yuv420},
    error::PictureError,
    picture::{PlaneView, RgbImage},
};

use crate::picture_file::MAX_SIDE_PX;

/// First word of a stream.
const STREAM_WORD: &[u8] = b"YUV4MPEG2";
/// First word of a frame.
const FRAME_WORD: &[u8] = b"FRAME";
/// Bytes that a line may have: ffmpeg's have less than a hundred.
const MAX_LINE_BYTES: u64 = 1024;

/// Takes pictures of 8 bits with colour at half their size (4:2:0) from a stream.
#[derive(Debug)]
pub(super) struct Y4mReader {
    coding: YuvCoding,
    size: Option<(usize, usize)>,
    planes: Vec<u8>,
}

impl Y4mReader {
    /// For a stream whose colours are coded in this way.
    pub(super) const fn new(coding: YuvCoding) -> Self {
        Self { coding, size: None, planes: Vec::new() }
    }

    /// Reads one picture into the memory of `rgb`; none at the end of the stream.
    pub(super) fn read(&mut self, from: &mut impl BufRead, mut rgb: Vec<u8>) -> io::Result<Option<RgbImage>> {
        if from.fill_buf()?.is_empty() {
            return Ok(None);
        }
        let (width, height) = match self.size {
            Some(size) => size,
            None => stream_size(&line(from)?)?,
        };
        self.size = Some((width, height));
        if from.fill_buf()?.is_empty() {
            return Ok(None);
        }
        if !line(from)?.starts_with(FRAME_WORD) {
            return Err(invalid("ffmpeg's frame is not announced"));
        }
        let (luma, difference) = (width * height, width.div_ceil(2) * height.div_ceil(2));
        self.planes.resize(luma + 2 * difference, 0);
        from.read_exact(&mut self.planes)?;
        rgb.resize(luma * RgbImage::CHANNELS, 0);
        let (y, differences) = self.planes.split_at(luma);
        let (u, v) = differences.split_at(difference);
        let no_picture = |cause: PictureError| invalid(&cause.to_string());
        let mut picture = RgbImage::from_vec(width, height, rgb).map_err(no_picture)?;
        let y = PlaneView::new(y, width, height, width).map_err(no_picture)?;
        let half = |plane| {
            let (width, height) = (width.div_ceil(2), height.div_ceil(2));
            PlaneView::new(plane, width, height, width).map_err(no_picture)
        };
        let planes = Yuv420 { y, u: half(u)?, v: half(v)? };
        rgb_from_yuv420(planes, self.coding, &mut picture).map_err(no_picture)?;
        Ok(Some(picture))
    }
}

/// A line without its end.
fn line(from: &mut impl BufRead) -> io::Result<Vec<u8>> {
    let mut line = Vec::new();
    from.take(MAX_LINE_BYTES).read_until(b'\n', &mut line)?;
    if line.pop() == Some(b'\n') { Ok(line) } else { Err(invalid("ffmpeg's line has no end")) }
}

/// The size that a stream's header states, if its pictures have 8 bits and colour at half their size.
fn stream_size(header: &[u8]) -> io::Result<(usize, usize)> {
    let mut words = header.split(|byte| *byte == b' ').map(String::from_utf8_lossy);
    let is_stream = words.next().is_some_and(|word| word.as_bytes() == STREAM_WORD);
    let (mut width, mut height, mut known_colour) = (None, None, true);
    for word in words {
        let side = || word[1..].parse().ok().filter(|side| (1..=MAX_SIDE_PX).contains(side));
        match word.as_bytes().first() {
            Some(b'W') => width = side(),
            Some(b'H') => height = side(),
            // "420jpeg" and the like tell where the colour was sampled; "420p10" has more bits.
            Some(b'C') => known_colour = word.starts_with("C420") && !word.starts_with("C420p1"),
            _ => {}
        }
    }
    width.zip(height).filter(|_| is_stream && known_colour).ok_or_else(|| {
        invalid(&format!("ffmpeg's video has an unexpected header: {}", String::from_utf8_lossy(header)))
    })
}

fn invalid(cause: &str) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, cause)
}

#[cfg(test)]
mod tests {
    use fingerpost_vision::colour::{YuvMatrix, YuvRange};

    use super::*;

    const CODING: YuvCoding = YuvCoding { matrix: YuvMatrix::Bt601, range: YuvRange::Full };

    #[test]
    fn pictures_of_odd_sides_follow_each_other() {
        let mut stream = Vec::from(*b"YUV4MPEG2 W3 H1 F25:1 Ip A1:1 C420jpeg XYSCSS=420JPEG\n");
        stream.extend_from_slice(b"FRAME\n\x01\x02\x03\x80\x80\x80\x80");
        stream.extend_from_slice(b"FRAME Ixyz\n\x04\x05\x06\x80\x80\x80\x80");
        let mut from = stream.as_slice();
        let mut reader = Y4mReader::new(CODING);
        let first = reader.read(&mut from, vec![7; 100]).unwrap().unwrap();
        assert_eq!((first.size(), first.as_slice()), ((3, 1), &[1, 1, 1, 2, 2, 2, 3, 3, 3][..]));
        let second = reader.read(&mut from, first.into_vec()).unwrap().unwrap();
        assert_eq!(second.as_slice(), &[4, 4, 4, 5, 5, 5, 6, 6, 6]);
        assert!(reader.read(&mut from, Vec::new()).unwrap().is_none());
    }

    #[test]
    fn a_stream_without_frames_has_none() {
        for stream in [&b""[..], b"YUV4MPEG2 W2 H2 C420mpeg2\n"] {
            assert!(Y4mReader::new(CODING).read(&mut &*stream, Vec::new()).unwrap().is_none());
        }
    }

    #[test]
    fn what_is_cut_or_of_another_kind_is_an_error() {
        for stream in [
            &b"YUV4MPEG2 W2 H1 C420jpeg\nFRAME\n\x01\x02\x80"[..],
            b"YUV4MPEG2 W2 H1 C420jpeg\nFRAM",
            b"YUV4MPEG2 W2 H1 C420jpeg\n\x01\x02\x80\x80\n",
            b"YUV4MPEG2 W2 H1 C444\nFRAME\n\x01\x02\x80\x80",
            b"YUV4MPEG2 W2 H1 C420p10 XYSCSS=420P10\nFRAME\n\x01\x02\x80\x80",
            b"YUV4MPEG2 W0 H1\n",
            b"YUV4MPEG2 H1\n",
            b"YUV4MPEG2 W2 H99999999999999999999\n",
            b"P6\n1 1\n255\nabc",
            b"YUV4MPEG2 W2 H1",
        ] {
            let text = String::from_utf8_lossy(stream);
            assert!(Y4mReader::new(CODING).read(&mut &*stream, Vec::new()).is_err(), "{text}");
        }
    }
}
