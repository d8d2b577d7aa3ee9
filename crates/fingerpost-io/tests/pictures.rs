//! Pictures in files: every kind that is read, and what is refused.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{fs, io::Write, path::Path};

use fingerpost_io::{
    FileError, PictureFileError, decode_picture, encode_png, read_picture, write_grey_png, write_jpeg,
    write_png,
};
use fingerpost_vision::{
    jpeg::{ChromaSampling, jpeg_file},
    picture::{Plane, RgbImage},
};

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
    write_jpeg(&path, &picture, 95, ChromaSampling::Full).unwrap();
    assert_eq!(fs::read(&path).unwrap(), jpeg_file(&picture, 95, ChromaSampling::Full).unwrap());
    let again = read_picture(&path).unwrap();
    assert_eq!(again.size(), (61, 33));
    let errors = again.as_slice().iter().zip(picture.as_slice()).map(|(a, b)| a.abs_diff(*b));
    let worst = errors.max().unwrap();
    assert!(worst <= 16, "worst error {worst}");
}

#[test]
fn grey_jpeg_becomes_rgb() {
    // 16 x 16 pixels of grey 120, written once by the crate jpeg-encoder at quality 95.
    let picture = read_picture(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/grey.jpg")).unwrap();
    assert_eq!(picture.size(), (16, 16));
    assert!(picture.as_slice().iter().all(|value| value.abs_diff(120) <= 1));
}

#[test]
fn a_truncated_picture_is_damaged_wherever_it_ends() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut");
    let picture = sample(64, 48);
    for bytes in [encode_png(&picture).unwrap(), jpeg_file(&picture, 90, ChromaSampling::Full).unwrap()] {
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

/// What may be allocated for a picture that is refused by its header, bytes: the file and the decoder's own tables.
const REFUSED_BYTES: u64 = 2 << 20;

/// The most memory that reading took at once, bytes, and what came of it.
fn measured(path: &Path, bytes: &[u8]) -> (u64, Result<RgbImage, PictureFileError>) {
    fs::write(path, bytes).unwrap();
    let mut read = None;
    let taken = allocation_counter::measure(|| read = Some(read_picture(path)));
    (taken.bytes_max, read.unwrap())
}

#[test]
fn headers_ask_for_no_memory_that_their_files_cannot_fill() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture");
    let png = encode_png(&sample(64, 48)).unwrap();
    let jpeg = jpeg_file(&sample(64, 48), 90, ChromaSampling::Full).unwrap();
    // The frame header of a baseline JPEG: marker, length, precision, then height and width.
    let frame = jpeg.windows(2).position(|bytes| bytes == [0xff, 0xc0]).unwrap();
    for sides in
        [[16_384, 16_384], [16_384, 4096], [8192, 8192], [5000, 3000], [16_384, 1000], [65_535, 65_535]]
    {
        let [width, height] = sides.map(|side: u32| side.to_be_bytes());
        let mut bytes = png.clone();
        bytes[16..24].copy_from_slice(&[width, height].concat());
        let check_sum = crc32(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&check_sum.to_be_bytes());
        let (taken, read) = measured(&path, &bytes);
        assert!(read.is_err() && taken < REFUSED_BYTES, "PNG {sides:?}: {taken} bytes, {read:?}");
        let mut bytes = jpeg.clone();
        bytes[frame + 5..frame + 9].copy_from_slice(&[&height[2..], &width[2..]].concat());
        let (taken, read) = measured(&path, &bytes);
        assert!(read.is_err() && taken < REFUSED_BYTES, "JPEG {sides:?}: {taken} bytes, {read:?}");
    }
}

#[test]
fn colour_profiles_and_texts_take_no_memory() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.png");
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(&vec![0; 100 << 20]).unwrap();
    let packed = packed.finish().unwrap();
    let png = encode_png(&sample(64, 48)).unwrap();
    for (kind, head) in [(b"iCCP", "x\0\0"), (b"zTXt", "x\0\0"), (b"iTXt", "x\0\u{1}\0\0\0")] {
        let body = [kind.as_slice(), head.as_bytes(), &packed].concat();
        let length = (body.len() - 4) as u32;
        let chunk = [&length.to_be_bytes(), body.as_slice(), &crc32(&body).to_be_bytes()].concat();
        // Behind the first chunk, which ends with its check sum.
        let bytes = [&png[..33], &chunk, &png[33..]].concat();
        let (taken, read) = measured(&path, &bytes);
        assert_eq!(read.unwrap(), sample(64, 48));
        assert!(taken < REFUSED_BYTES, "{}: {taken} bytes", String::from_utf8_lossy(kind));
    }
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
    let none = RgbImage::default();
    for result in [write_png(&path, &none), write_jpeg(&path, &none, 90, ChromaSampling::Full)] {
        assert!(result.unwrap_err().to_string().contains("0 x 0"));
    }
    assert!(encode_png(&RgbImage::default()).is_err());
    assert!(!path.exists());
}

/// A chunk of a PNG file.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let body = [kind, data].concat();
    [&(data.len() as u32).to_be_bytes(), body.as_slice(), &crc32(&body).to_be_bytes()].concat()
}

#[test]
fn palettes_of_every_length_are_looked_up_or_refused() {
    let mut packed = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::fast());
    packed.write_all(&[0, 0b0001_1011]).unwrap();
    let packed = packed.finish().unwrap();
    for depth in [1, 2, 4, 8] {
        for (colours, alphas) in (0..14).flat_map(|colours| (0..6).map(move |alphas| (colours, alphas))) {
            let header = [0, 0, 0, 1, 0, 0, 0, 1, depth, 3, 0, 0, 0];
            let chunks = [
                chunk(b"IHDR", &header),
                chunk(b"PLTE", &vec![7; colours]),
                chunk(b"tRNS", &vec![9; alphas]),
                chunk(b"IDAT", &packed),
                chunk(b"IEND", &[]),
            ];
            let bytes = [b"\x89PNG\r\n\x1a\n".as_slice(), &chunks.concat()].concat();
            let read = decode_picture(&bytes, Path::new("palette.png"));
            let is_whole = colours > 0 && colours % 3 == 0;
            assert!(is_whole || read.is_err(), "{colours} bytes of colours, {alphas} of alphas: {read:?}");
            assert!(!is_whole || alphas > colours / 3 || read.is_ok(), "{colours}, {alphas}: {read:?}");
        }
    }
}

/// Exif data with the tag Orientation alone.
fn exif(number: u8) -> Vec<u8> {
    [&b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0"[..], &[number, 0, 0, 0, 0, 0, 0, 0]].concat()
}

/// The corners of a picture of four fields, from the top left clockwise: which of red, green, blue and white each is.
fn corners(picture: &RgbImage) -> String {
    let (right, bottom) = (picture.width() - 3, picture.height() - 3);
    let places = [(2, 2), (right, 2), (right, bottom), (2, bottom)];
    let name = |(x, y)| match picture.get(x, y).unwrap().map(|value| value > 127) {
        [true, false, false] => 'r',
        [false, true, false] => 'g',
        [false, false, true] => 'b',
        _ => 'w',
    };
    places.map(name).into_iter().collect()
}

#[test]
fn pictures_stand_upright_as_their_exif_data_say() {
    let folder = tempfile::tempdir().unwrap();
    let (width, height) = (48, 32);
    let mut picture = RgbImage::new(width, height);
    for (index, pixel) in picture.as_mut_slice().chunks_exact_mut(3).enumerate() {
        let (is_right, is_low) = (index % width >= width / 2, index / width >= height / 2);
        pixel.copy_from_slice(match (is_right, is_low) {
            (false, false) => &[255, 0, 0],
            (true, false) => &[0, 255, 0],
            (true, true) => &[0, 0, 255],
            (false, true) => &[255, 255, 255],
        });
    }
    let path = folder.path().join("picture.jpg");
    write_jpeg(&path, &picture, 95, ChromaSampling::Full).unwrap();
    let jpeg = fs::read(&path).unwrap();
    let png = encode_png(&picture).unwrap();
    // How each stored corner comes to stand, from the figure of the standard.
    let upright = ["rgbw", "grwb", "bwrg", "wbgr", "rwbg", "wrgb", "bgrw", "gbwr"];
    for (number, expected) in (1..).zip(upright) {
        let segment = [b"Exif\0\0", exif(number).as_slice()].concat();
        let length = (segment.len() as u16 + 2).to_be_bytes();
        let tagged = [&jpeg[..2], b"\xff\xe1", &length, &segment, &jpeg[2..]].concat();
        let mut chunk = b"eXIf".to_vec();
        chunk.extend(exif(number));
        let (length, sum) =
            ((exif(number).len() as u32).to_be_bytes(), crc32fast::hash(&chunk).to_be_bytes());
        // Behind the header, and before the end.
        for at in [33, png.len() - 12] {
            let tagged = [&png[..at], &length, &chunk, &sum, &png[at..]].concat();
            let read = decode_picture(&tagged, Path::new("picture.png")).unwrap();
            assert_eq!(corners(&read), expected, "PNG {number} at {at}");
        }
        let read = decode_picture(&tagged, Path::new("picture.jpg")).unwrap();
        assert_eq!(corners(&read), expected, "JPEG {number}");
        let size = if number > 4 { (height, width) } else { (width, height) };
        assert_eq!(read.size(), size, "{number}");
        // Broken off inside the Exif data, which then say nothing.
        let short = [b"Exif\0\0", &exif(number)[..12]].concat();
        let length = (short.len() as u16 + 2).to_be_bytes();
        let tagged = [&jpeg[..2], b"\xff\xe1", &length, &short, &jpeg[2..]].concat();
        assert_eq!(decode_picture(&tagged, Path::new("picture.jpg")).unwrap().size(), (width, height));
    }
}
