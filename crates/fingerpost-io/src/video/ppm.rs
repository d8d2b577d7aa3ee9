//! Pictures in a pipe as binary PPM: each states its own size.

use std::io::{self, BufRead, ErrorKind};

use fingerpost_vision::picture::RgbImage;

use crate::picture_file::MAX_SIDE_PX;

/// Reads one binary PPM picture of 8 bits; none at the end of the stream.
pub(super) fn read_ppm(from: &mut impl BufRead, mut buffer: Vec<u8>) -> io::Result<Option<RgbImage>> {
    if from.fill_buf()?.is_empty() {
        return Ok(None);
    }
    let mut magic = [0; 2];
    from.read_exact(&mut magic)?;
    let [width, height, largest] = [header_number(from)?, header_number(from)?, header_number(from)?];
    let sides = 1..=MAX_SIDE_PX;
    if &magic != b"P6" || largest != 255 || !sides.contains(&width) || !sides.contains(&height) {
        let cause = format!("ffmpeg's picture has an unexpected header: {width} x {height}, {largest}");
        return Err(io::Error::new(ErrorKind::InvalidData, cause));
    }
    buffer.resize(width * height * RgbImage::CHANNELS, 0);
    from.read_exact(&mut buffer)?;
    RgbImage::from_vec(width, height, buffer)
        .map(Some)
        .map_err(|cause| io::Error::new(ErrorKind::InvalidData, cause.to_string()))
}

/// A decimal number of a PPM header with the one white space behind it, leading white space left out.
fn header_number(from: &mut impl BufRead) -> io::Result<usize> {
    let mut number = 0_usize;
    let mut digits = 0;
    loop {
        let mut byte = [0];
        from.read_exact(&mut byte)?;
        match byte[0] {
            digit @ b'0'..=b'9' if digits < 6 => {
                number = number * 10 + usize::from(digit - b'0');
                digits += 1;
            }
            space if space.is_ascii_whitespace() && digits == 0 => {}
            space if space.is_ascii_whitespace() => return Ok(number),
            _ => return Err(io::Error::new(ErrorKind::InvalidData, "ffmpeg's picture has no header")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_pictures_of_different_sizes_follow_each_other() {
        let mut stream = &b"P6\n1 2\n255\nabcdefP6\n1 1\n255\nxyz"[..];
        let first = read_ppm(&mut stream, Vec::new()).unwrap().unwrap();
        assert_eq!((first.size(), first.as_slice()), ((1, 2), &b"abcdef"[..]));
        let second = read_ppm(&mut stream, first.into_vec()).unwrap().unwrap();
        assert_eq!((second.size(), second.as_slice()), ((1, 1), &b"xyz"[..]));
        assert!(read_ppm(&mut stream, Vec::new()).unwrap().is_none());
    }

    #[test]
    fn a_picture_that_ends_early_or_is_none_is_an_error() {
        for stream in
            [&b"P6\n1 2\n255\nabc"[..], b"P6\n1", b"P5\n1 1\n255\nx", b"P6\n0 1\n255\n", b"P6\n99999999 1\n"]
        {
            assert!(read_ppm(&mut &*stream, Vec::new()).is_err(), "{stream:?}");
        }
    }
}
