//! Pictures in files: every kind that is read, and what is refused.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{fs, path::Path};

use fingerpost_io::{
    FileError, PictureFileError, encode_jpeg, encode_png, read_picture, write_grey_png, write_jpeg, write_png,
};
use fingerpost_vision::picture::{Plane, RgbImage};

/// A smooth picture whose three channels differ, so that exchanged channels or sides show.
fn sample(width: usize, height: usize) -> RgbImage {
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
    let data = pixels.flat_map(|(x, y)| [(3 * x) as u8, (5 * y) as u8, (200 - x - y) as u8]).collect();
    RgbImage::from_vec(width, height, data).unwrap()
}

fn write_raw_png(
    path: &Path,
    colour: png::ColorType,
    depth: png::BitDepth,
    palette: Option<&[u8]>,
    data: &[u8],
) {
    let mut encoder = png::Encoder::new(fs::File::create(path).unwrap(), 2, 1);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    if let Some(palette) = palette {
        encoder.set_palette(palette.to_vec());
    }
    encoder.write_header().unwrap().write_image_data(data).unwrap();
}

#[test]
fn png_gives_back_every_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let picture = sample(37, 21);
    write_png(&path, &picture).unwrap();
    assert_eq!(read_picture(&path).unwrap(), picture);
    fs::write(&path, encode_png(&picture).unwrap()).unwrap();
    assert_eq!(read_picture(&path).unwrap(), picture);
}

#[test]
fn grey_is_repeated_in_all_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mask.png");
    write_grey_png(&path, &Plane::from_vec(3, 1, vec![0, 7, 255]).unwrap()).unwrap();
    assert_eq!(read_picture(&path).unwrap().as_slice(), &[0, 0, 0, 7, 7, 7, 255, 255, 255]);
}

#[test]
fn every_kind_of_png_becomes_rgb() {
    use png::{BitDepth, ColorType};
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.png");
    let expected = RgbImage::from_vec(2, 1, vec![10, 20, 30, 40, 50, 60]).unwrap();
    write_raw_png(&path, ColorType::Rgba, BitDepth::Eight, None, &[10, 20, 30, 0, 40, 50, 60, 255]);
    assert_eq!(read_picture(&path).unwrap(), expected);
    write_raw_png(
        &path,
        ColorType::Rgb,
        BitDepth::Sixteen,
        None,
        &[10, 1, 20, 2, 30, 3, 40, 4, 50, 5, 60, 6],
    );
    assert_eq!(read_picture(&path).unwrap(), expected);
    let palette = [40, 50, 60, 10, 20, 30];
    write_raw_png(&path, ColorType::Indexed, BitDepth::One, Some(&palette), &[0b1000_0000]);
    assert_eq!(read_picture(&path).unwrap(), expected);
    write_raw_png(&path, ColorType::GrayscaleAlpha, BitDepth::Eight, None, &[9, 128, 8, 255]);
    assert_eq!(read_picture(&path).unwrap().as_slice(), &[9, 9, 9, 8, 8, 8]);
    write_raw_png(&path, ColorType::Grayscale, BitDepth::Four, None, &[0x0f]);
    assert_eq!(read_picture(&path).unwrap().as_slice(), &[0, 0, 0, 255, 255, 255]);
}

#[test]
fn jpeg_keeps_colours_and_sides() {
    let folder = tempfile::tempdir().unwrap();
    // The kind is in the bytes, not in the name.
    let path = folder.path().join("picture.png");
    let picture = sample(61, 33);
    write_jpeg(&path, &picture, 95).unwrap();
    assert_eq!(fs::read(&path).unwrap(), encode_jpeg(&picture, 95).unwrap());
    let again = read_picture(&path).unwrap();
    assert_eq!(again.size(), (61, 33));
    let errors = again.as_slice().iter().zip(picture.as_slice()).map(|(a, b)| a.abs_diff(*b));
    let worst = errors.max().unwrap();
    assert!(worst <= 16, "worst error {worst}");
}

#[test]
fn grey_jpeg_becomes_rgb() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grey.jpg");
    let encoder = jpeg_encoder::Encoder::new_file(&path, 95).unwrap();
    encoder.encode(&[120; 16 * 16], 16, 16, jpeg_encoder::ColorType::Luma).unwrap();
    let picture = read_picture(&path).unwrap();
    assert_eq!(picture.size(), (16, 16));
    assert!(picture.as_slice().iter().all(|value| value.abs_diff(120) <= 1));
}

#[test]
fn a_truncated_picture_is_damaged_wherever_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut");
    let picture = sample(64, 48);
    for bytes in [encode_png(&picture).unwrap(), encode_jpeg(&picture, 90).unwrap()] {
        for kept in [0, 12, 40, bytes.len() / 2, bytes.len() * 9 / 10, bytes.len() - 16] {
            fs::write(&path, &bytes[..kept]).unwrap();
            let message = match read_picture(&path) {
                Err(error @ PictureFileError::Damaged { .. }) => error.to_string(),
                other => panic!("{kept} of {} bytes: {other:?}", bytes.len()),
            };
            assert!(message.contains("cut") && message.contains("copy or record it again"), "{message}");
        }
    }
}

#[test]
fn what_is_no_picture_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("note.png");
    fs::write(&path, "this is a note").unwrap();
    let error = read_picture(&path).unwrap_err();
    assert!(matches!(error, PictureFileError::UnknownKind { .. }), "{error}");
    assert!(error.to_string().contains("note.png"));
    let error = read_picture(&folder.path().join("gone.png")).unwrap_err();
    assert!(matches!(error, PictureFileError::File(FileError::Read { .. })), "{error}");
    assert!(
        error.to_string().contains("gone.png") && error.to_string().contains("check the path"),
        "{error}"
    );
}

#[test]
fn absurd_sides_are_refused_before_any_memory_is_taken() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("huge.png");
    let mut bytes = encode_png(&sample(4, 4)).unwrap();
    // Width and height of the first chunk, with its check sum.
    bytes[16..24].copy_from_slice(&[0, 0, 0x4e, 0x20, 0, 0, 0, 10]);
    let check_sum = crc32(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&check_sum.to_be_bytes());
    fs::write(&path, &bytes).unwrap();
    let error = read_picture(&path).unwrap_err();
    assert!(error.to_string().contains("20000 x 10"), "{error}");
}

/// The check sum of PNG chunks (ISO 3309), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(!0_u32, |sum, byte| {
        (0..8).fold(sum ^ u32::from(*byte), |sum, _| (sum >> 1) ^ (0xedb8_8320 & (sum & 1).wrapping_neg()))
    })
}

#[test]
fn a_picture_without_pixels_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none.png");
    for result in [write_png(&path, &RgbImage::default()), write_jpeg(&path, &RgbImage::default(), 90)] {
        assert!(result.unwrap_err().to_string().contains("0 x 0"));
    }
    assert!(encode_png(&RgbImage::default()).is_err());
    assert!(!path.exists());
}
