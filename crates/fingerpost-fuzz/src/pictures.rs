//! Pictures: PNG, JPEG and PPM.

use std::path::Path;

use fingerpost_io::{decode_picture, encode_png};
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use fingerpost_vision::picture::RgbImage;

use crate::must;

/// A picture that is read has the pixels of its size.
pub(crate) fn picture(bytes: &[u8]) -> bool {
    let Ok(picture) = decode_picture(bytes, Path::new("mutated")) else { return false };
    let (width, height) = picture.size();
    assert!(width > 0 && height > 0, "{width} x {height} pixels");
    assert_eq!(picture.as_slice().len(), width * height * RgbImage::CHANNELS);
    true
}

pub(crate) fn seeds() -> Vec<Vec<u8>> {
    let mut picture = RgbImage::new(40, 24);
    for row in 0..24 {
        for (column, byte) in picture.row_mut(row).iter_mut().enumerate() {
            *byte = ((row * 7 + column * 3) % 251) as u8;
        }
    }
    let pixmap = [b"P6\n# by hand\n40 24\n255\n", picture.as_slice()].concat();
    let jpeg = |sampling| must(jpeg_file(&picture, 80, sampling), "a seed");
    vec![
        must(encode_png(&picture), "a seed"),
        jpeg(ChromaSampling::Halved),
        jpeg(ChromaSampling::Full),
        pixmap,
    ]
}
