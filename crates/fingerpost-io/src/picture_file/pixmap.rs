//! Binary portable pixmaps (PPM, P6): a line of words, and the pixels' bytes.

use fingerpost_vision::picture::RgbImage;

use super::check_size;

/// First bytes of every such file.
pub(super) const SIGNATURE: &[u8] = b"P6";

/// The bytes of a picture's file.
pub(super) fn encode(picture: &RgbImage) -> Result<Vec<u8>, String> {
    let (width, height) = picture.size();
    if width == 0 || height == 0 {
        return Err("it has no pixels".to_owned());
    }
    let mut bytes = format!("P6\n{width} {height}\n255\n").into_bytes();
    bytes.extend_from_slice(picture.as_slice());
    Ok(bytes)
}

/// The picture that a file's bytes hold, in the memory of `buffer`.
pub(super) fn decode(bytes: &[u8], mut buffer: Vec<u8>) -> Result<RgbImage, String> {
    let mut rest = &bytes[SIGNATURE.len()..];
    let mut number = || {
        let (number, after) = next_number(rest)?;
        rest = after;
        Ok::<usize, String>(number)
    };
    let (width, height, most) = (number()?, number()?, number()?);
    if most != 255 {
        return Err(format!("its largest value is {most}, and only 255 is read"));
    }
    check_size(width, height, rest.len() / RgbImage::CHANNELS)?;
    let pixels = rest.get(..width * height * RgbImage::CHANNELS).ok_or("it is cut off")?;
    buffer.clear();
    buffer.extend_from_slice(pixels);
    RgbImage::from_vec(width, height, buffer).map_err(|cause| cause.to_string())
}

/// The next number, and what is behind the one space that ends it.
fn next_number(mut bytes: &[u8]) -> Result<(usize, &[u8]), String> {
    loop {
        match bytes.first() {
            Some(b'#') => {
                bytes = &bytes[bytes.iter().position(|byte| *byte == b'\n').unwrap_or(bytes.len())..]
            }
            Some(byte) if byte.is_ascii_whitespace() => bytes = &bytes[1..],
            _ => break,
        }
    }
    let digits = bytes.iter().take_while(|byte| byte.is_ascii_digit()).count();
    let number = std::str::from_utf8(&bytes[..digits]).ok().and_then(|digits| digits.parse().ok());
    let number = number.ok_or("its header does not say its size")?;
    match bytes[digits..].split_first() {
        Some((space, behind)) if space.is_ascii_whitespace() => Ok((number, behind)),
        _ => Err("its header has no end".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let picture = RgbImage::from_vec(3, 2, (0..18).collect()).unwrap();
        let bytes = encode(&picture).unwrap();
        assert_eq!(decode(&bytes, Vec::new()), Ok(picture.clone()));
        // As netpbm's own programs write it, with a comment.
        let commented = [&b"P6 # by hand\n3\t2\n# 8 bits\n255\n"[..], picture.as_slice()].concat();
        assert_eq!(decode(&commented, vec![7; 100]), Ok(picture));
    }

    #[test]
    fn what_is_damaged_is_refused() {
        let good = encode(&RgbImage::new(3, 2)).unwrap();
        for cut in 2..good.len() {
            assert!(decode(&good[..cut], Vec::new()).is_err(), "{cut}");
        }
        for bytes in [
            &b"P6\n0 2\n255\n"[..],
            b"P6\n99999 99999\n255\n",
            b"P6\n1 1\n65535\n123456",
            b"P6\n-1 1\n255\nabc",
            // A comment without an end, whose last byte begins one.
            b"P6\n#",
            b"P6 # by hand #",
        ] {
            assert!(decode(bytes, Vec::new()).is_err());
        }
        assert!(encode(&RgbImage::new(0, 2)).is_err());
    }
}
