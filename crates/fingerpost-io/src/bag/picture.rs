//! Pictures as messages hold them: packed as JPEG or PNG, which stay as they are, or as bare pixels.

use fingerpost_vision::picture::RgbImage;
use thiserror::Error;

/// A picture of a message.
#[derive(Debug, Clone, PartialEq)]
pub enum Picture {
    /// A JPEG file.
    Jpeg(Vec<u8>),
    /// A PNG file.
    Png(Vec<u8>),
    /// Pixels.
    Raw(RgbImage),
}

/// A picture that is not read.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PictureError {
    /// It is packed in another manner.
    #[error(
        "pictures of format {format:?} are neither JPEG nor PNG; record the camera as one of these, or as bare pixels"
    )]
    Format {
        /// What the message calls it.
        format: String,
    },
    /// Its pixels mean something else.
    #[error(
        "pictures of encoding {encoding:?} are not read, only {known}; convert them with image_proc or cv_bridge, or record the \
         camera's JPEG pictures"
    )]
    Encoding {
        /// What the message calls it.
        encoding: String,
        /// Those that are read.
        known: String,
    },
    /// There are fewer bytes than pixels, or none.
    #[error(
        "a picture of {width} x {height} pixels in rows of {step} bytes has {bytes} bytes; its sender is at fault"
    )]
    Size {
        /// Width, pixels.
        width: usize,
        /// Height, pixels.
        height: usize,
        /// Bytes of a row.
        step: usize,
        /// Bytes that there are.
        bytes: usize,
    },
}

/// How pixels lie in bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PixelLayout<'a> {
    pub(crate) width: usize,
    pub(crate) height: usize,
    /// Bytes of a row.
    pub(crate) step: usize,
    pub(crate) encoding: &'a str,
}

/// Encodings that are read (ROS `sensor_msgs/image_encodings.hpp`; OpenCV's types hold blue first): bytes of a pixel and
/// which of them are red, green and blue.
const ENCODINGS: [(&str, usize, [usize; 3]); 8] = [
    ("rgb8", 3, [0, 1, 2]),
    ("bgr8", 3, [2, 1, 0]),
    ("rgba8", 4, [0, 1, 2]),
    ("bgra8", 4, [2, 1, 0]),
    ("mono8", 1, [0, 0, 0]),
    ("8UC1", 1, [0, 0, 0]),
    ("8UC3", 3, [2, 1, 0]),
    ("8UC4", 4, [2, 1, 0]),
];

impl Picture {
    /// A packed picture, told by its first bytes; formats are named in many ways.
    pub(crate) fn packed(format: &str, bytes: &[u8]) -> Result<Self, PictureError> {
        match bytes {
            [0xFF, 0xD8, ..] => Ok(Self::Jpeg(bytes.to_vec())),
            [0x89, b'P', b'N', b'G', ..] => Ok(Self::Png(bytes.to_vec())),
            _ => Err(PictureError::Format { format: format.to_owned() }),
        }
    }

    /// A picture of bare pixels.
    pub(crate) fn raw(layout: &PixelLayout<'_>, data: &[u8]) -> Result<Self, PictureError> {
        let PixelLayout { width, height, step, encoding } = *layout;
        let Some((_, pixel_bytes, order)) = ENCODINGS.iter().find(|(name, ..)| *name == encoding) else {
            let known = ENCODINGS.map(|(name, ..)| name).join(", ");
            return Err(PictureError::Encoding { encoding: encoding.to_owned(), known });
        };
        let wrong = PictureError::Size { width, height, step, bytes: data.len() };
        let row_bytes = width.saturating_mul(*pixel_bytes);
        if row_bytes == 0 || step < row_bytes || step.saturating_mul(height) > data.len() || height == 0 {
            return Err(wrong);
        }
        let rows = data.chunks_exact(step).take(height).filter_map(|row| row.get(..row_bytes));
        let mut pixels = Vec::with_capacity(3 * width * height);
        for pixel in rows.flat_map(|row| row.chunks_exact(*pixel_bytes)) {
            pixels.extend(order.map(|channel| pixel.get(channel).copied().unwrap_or_default()));
        }
        RgbImage::from_vec(width, height, pixels).map(Self::Raw).map_err(|_| wrong)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pixels above each other, the rows padded by a byte.
    fn read(encoding: &str, step: usize, data: &[u8]) -> Result<Vec<u8>, PictureError> {
        let picture = Picture::raw(&PixelLayout { width: 1, height: 2, step, encoding }, data)?;
        match picture {
            Picture::Raw(picture) => Ok(picture.as_slice().to_vec()),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn channels_and_padding_are_known() {
        assert_eq!(read("rgb8", 4, &[1, 2, 3, 0, 4, 5, 6, 0]), Ok(vec![1, 2, 3, 4, 5, 6]));
        assert_eq!(read("bgr8", 4, &[1, 2, 3, 0, 4, 5, 6, 0]), Ok(vec![3, 2, 1, 6, 5, 4]));
        assert_eq!(read("bgra8", 4, &[1, 2, 3, 9, 4, 5, 6, 9]), Ok(vec![3, 2, 1, 6, 5, 4]));
        assert_eq!(read("mono8", 2, &[7, 0, 8, 0]), Ok(vec![7, 7, 7, 8, 8, 8]));
    }

    #[test]
    fn what_is_not_read_is_named() {
        let error = read("bayer_rggb8", 1, &[0, 0]).unwrap_err().to_string();
        assert!(error.contains("bayer_rggb8") && error.contains("rgb8, bgr8"), "{error}");
        for (step, bytes) in [(2, 6), (3, 5), (0, 0), (usize::MAX, 6)] {
            assert!(matches!(read("rgb8", step, &vec![0; bytes]), Err(PictureError::Size { .. })), "{step}");
        }
        let error = Picture::packed("jpeg", b"RIFF").unwrap_err().to_string();
        assert!(error.contains("\"jpeg\""), "{error}");
    }
}
