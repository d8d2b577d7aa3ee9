//! Pictures in files: PNG, JPEG and binary portable pixmaps (PPM) in and out.
//!
//! Everything becomes 8-bit red, green and blue: grey is repeated, 16 bits are reduced to their upper 8, palettes are
//! looked up, transparency is left out. A picture whose Exif data say that it lies on its side or its head is turned upright.

mod orientation;
mod pixmap;

use std::{
    io::{BufWriter, Cursor},
    path::{Path, PathBuf},
};

use fingerpost_vision::{
    jpeg::{ChromaSampling, jpeg_file},
    picture::{Plane, RgbImage},
};
use thiserror::Error;
use zune_jpeg::{
    JpegDecoder,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions},
};

use self::orientation::Orientation;
use crate::{
    file::{FileError, read_bytes},
    whole_file::write_private_file,
};

/// Largest side of a picture that is read or written, pixels: no camera's is larger, a broken header's may be.
pub(crate) const MAX_SIDE_PX: usize = 16_384;

/// Most pixels of a picture that is read: a square of half of the largest side, four times a large camera's. Decoding one takes
/// 0.6 GB at the most (a progressive JPEG with all its coefficients).
const MAX_PIXELS: usize = 8192 * 8192;
/// A byte of a JPEG file is no more than so many pixels: every block of 8 x 8 takes a bit of each scan of its first coefficient.
const JPEG_PIXELS_PER_BYTE: usize = 8 * 64;
/// A byte of a PNG file is no more than so many bytes of rows: deflate packs no closer.
const DEFLATE_RATIO: usize = 1032;
/// What a PNG decoder may take beside the rows, bytes: palettes and headers take a few thousand; colour profiles and texts, which
/// can be packed a thousandfold, are passed over.
const PNG_EXTRA_BYTES: usize = 1 << 20;

/// First bytes of every PNG file.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// First bytes of every JPEG file.
const JPEG_SIGNATURE: &[u8] = b"\xff\xd8\xff";

/// A picture file that cannot be read or written.
#[derive(Debug, Error)]
pub enum PictureFileError {
    /// The file itself cannot be read or written.
    #[error(transparent)]
    File(#[from] FileError),
    /// The file holds no picture of a known kind.
    #[error("{} is neither PNG, JPEG nor binary PPM; convert it, or take it out of the folder", .path.display())]
    UnknownKind {
        /// The file.
        path: PathBuf,
    },
    /// The picture is truncated or damaged.
    #[error("the picture {} is damaged ({cause}); copy or record it again", .path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// What the decoder says.
        cause: String,
    },
    /// The picture is larger than any camera's, or cannot be encoded.
    #[error("a picture of {width} x {height} pixels cannot be written to {} ({cause}); check its size", .path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Width, pixels.
        width: usize,
        /// Height, pixels.
        height: usize,
        /// What the encoder says.
        cause: String,
    },
}

/// Reads a PNG, JPEG or binary PPM file, upright; its first bytes, not its name, decide which it is.
///
/// # Errors
/// [`PictureFileError`] when the file cannot be read, is of another kind, truncated or damaged.
pub fn read_picture(path: &Path) -> Result<RgbImage, PictureFileError> {
    read_picture_into(path, Vec::new())
}

/// [`read_picture`] into the memory of `buffer`, where the decoder allows it.
pub(crate) fn read_picture_into(path: &Path, buffer: Vec<u8>) -> Result<RgbImage, PictureFileError> {
    decode_into(&read_bytes(path)?, path, buffer)
}

/// The picture that bytes of a PNG or JPEG file hold; `path` says in messages where they come from.
///
/// # Errors
/// [`PictureFileError`] when they are of another kind, truncated or damaged.
pub fn decode_picture(bytes: &[u8], path: &Path) -> Result<RgbImage, PictureFileError> {
    decode_into(bytes, path, Vec::new())
}

fn decode_into(bytes: &[u8], path: &Path, buffer: Vec<u8>) -> Result<RgbImage, PictureFileError> {
    let decoded = if bytes.starts_with(PNG_SIGNATURE) {
        decode_png(bytes, buffer)
    } else if bytes.starts_with(JPEG_SIGNATURE) {
        decode_jpeg(bytes, buffer)
    } else if bytes.starts_with(pixmap::SIGNATURE) {
        pixmap::decode(bytes, buffer)
    } else if bytes.is_empty() {
        Err("the file is empty".to_owned())
    } else {
        return Err(PictureFileError::UnknownKind { path: path.to_owned() });
    };
    decoded.map_err(|cause| PictureFileError::Damaged { path: path.to_owned(), cause })
}

/// Writes a colour picture as PNG.
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_png(path: &Path, picture: &RgbImage) -> Result<(), PictureFileError> {
    let encoded = png_bytes(picture.size(), RGB, picture.as_slice());
    write_encoded(path, picture.size(), encoded)
}

/// Writes a colour picture as binary portable pixmap.
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_ppm(path: &Path, picture: &RgbImage) -> Result<(), PictureFileError> {
    write_encoded(path, picture.size(), pixmap::encode(picture))
}

/// Writes a grey picture as PNG.
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_grey_png(path: &Path, picture: &Plane<u8>) -> Result<(), PictureFileError> {
    let encoded = png_bytes(picture.size(), GREY, picture.as_slice());
    write_encoded(path, picture.size(), encoded)
}

/// Writes a grey picture of 16 bits a pixel as PNG.
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_deep_png(path: &Path, picture: &Plane<u16>) -> Result<(), PictureFileError> {
    // PNG has the high byte first.
    let bytes: Vec<u8> = picture.as_slice().iter().flat_map(|value| value.to_be_bytes()).collect();
    write_encoded(path, picture.size(), png_bytes(picture.size(), DEEP_GREY, &bytes))
}

/// Writes a colour picture as JPEG of `quality` 1 to [`JpegEncoder::MOST_QUALITY`](fingerpost_vision::jpeg::JpegEncoder::MOST_QUALITY).
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_jpeg(
    path: &Path,
    picture: &RgbImage,
    quality: u8,
    sampling: ChromaSampling,
) -> Result<(), PictureFileError> {
    let (width, height) = picture.size();
    let encoded = encodable(width, height)
        .and_then(|_| jpeg_file(picture, quality, sampling).map_err(|cause| cause.to_string()));
    write_encoded(path, (width, height), encoded)
}

/// A colour picture as the bytes of a PNG file, as a report holds it.
///
/// # Errors
/// [`EncodeError`] when the picture has no pixels or is too large.
pub fn encode_png(picture: &RgbImage) -> Result<Vec<u8>, EncodeError> {
    let (width, height) = picture.size();
    png_bytes((width, height), RGB, picture.as_slice()).map_err(|cause| EncodeError { width, height, cause })
}

/// A picture that cannot be encoded.
#[derive(Debug, Error)]
#[error("a picture of {width} x {height} pixels cannot be encoded ({cause}); check its size")]
pub struct EncodeError {
    /// Width, pixels.
    pub width: usize,
    /// Height, pixels.
    pub height: usize,
    /// What the encoder says.
    pub cause: String,
}

fn write_encoded(
    path: &Path,
    (width, height): (usize, usize),
    encoded: Result<Vec<u8>, String>,
) -> Result<(), PictureFileError> {
    let bytes =
        encoded.map_err(|cause| PictureFileError::Encode { path: path.to_owned(), width, height, cause })?;
    Ok(write_private_file(path, bytes)?)
}

/// What a pixel of a PNG file holds.
const RGB: (png::ColorType, png::BitDepth) = (png::ColorType::Rgb, png::BitDepth::Eight);
const GREY: (png::ColorType, png::BitDepth) = (png::ColorType::Grayscale, png::BitDepth::Eight);
const DEEP_GREY: (png::ColorType, png::BitDepth) = (png::ColorType::Grayscale, png::BitDepth::Sixteen);

fn png_bytes(
    (width, height): (usize, usize),
    (colour, depth): (png::ColorType, png::BitDepth),
    data: &[u8],
) -> Result<Vec<u8>, String> {
    encodable(width, height)?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(BufWriter::new(&mut bytes), width as u32, height as u32);
    encoder.set_color(colour);
    encoder.set_depth(depth);
    // Report and debug pictures are many and looked at once; the small gain of slower settings is not worth the wait.
    encoder.set_compression(png::Compression::Fast);
    let mut writer = encoder.write_header().map_err(|cause| cause.to_string())?;
    writer.write_image_data(data).map_err(|cause| cause.to_string())?;
    writer.finish().map_err(|cause| cause.to_string())?;
    Ok(bytes)
}

/// Whether the encoders take a picture of this size.
fn encodable(width: usize, height: usize) -> Result<(), String> {
    let sides = 1..=MAX_SIDE_PX;
    if sides.contains(&width) && sides.contains(&height) {
        Ok(())
    } else {
        Err(format!("each side must have 1 to {MAX_SIDE_PX} pixels"))
    }
}

/// Looks at a header before any memory of its size is taken; `most_pixels` is what the file's length can hold.
fn check_size(width: usize, height: usize, most_pixels: usize) -> Result<(), String> {
    let sides = 1..=MAX_SIDE_PX;
    let says = format!("its header says {width} x {height} pixels");
    match width.checked_mul(height) {
        Some(pixels) if sides.contains(&width) && sides.contains(&height) && pixels <= MAX_PIXELS => {
            if pixels <= most_pixels { Ok(()) } else { Err(format!("{says}, more than its bytes can hold")) }
        }
        _ => Err(format!(
            "{says}; each side may have {MAX_SIDE_PX}, and the picture {} million",
            MAX_PIXELS / 1_000_000
        )),
    }
}

fn decode_png(bytes: &[u8], mut buffer: Vec<u8>) -> Result<RgbImage, String> {
    let mut decoder = png::Decoder::new(Cursor::new(bytes));
    decoder.set_limits(png::Limits { bytes: PNG_EXTRA_BYTES });
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let header = decoder.read_header_info().map_err(|cause| cause.to_string())?;
    let most_pixels = bytes.len().saturating_mul(DEFLATE_RATIO * 8) / header.bits_per_pixel().max(1);
    check_size(header.width as usize, header.height as usize, most_pixels)?;
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().map_err(|cause| cause.to_string())?;
    let (width, height) = (reader.info().width as usize, reader.info().height as usize);
    // The decoder takes it for granted.
    if reader.info().palette.as_ref().is_some_and(|palette| palette.is_empty() || palette.len() % 3 != 0) {
        return Err("its palette is not made of whole colours".to_owned());
    }
    let (colour, _) = reader.output_color_type();
    buffer.clear();
    buffer.resize(width * height * colour.samples(), 0);
    reader.next_frame(&mut buffer).map_err(|cause| cause.to_string())?;
    // Exif data may stand behind the pixels, where faults cost none of them.
    let _ = reader.finish();
    let orientation =
        reader.info().exif_metadata.as_deref().map_or(Orientation::TopLeft, Orientation::of_exif);
    let rgb = match colour {
        png::ColorType::Rgb => buffer,
        png::ColorType::Rgba => drop_last_channel(&buffer),
        png::ColorType::Grayscale => buffer.iter().flat_map(|grey| [*grey; 3]).collect(),
        png::ColorType::GrayscaleAlpha => {
            buffer.as_chunks::<2>().0.iter().flat_map(|[grey, _]| [*grey; 3]).collect()
        }
        png::ColorType::Indexed => return Err("its palette cannot be looked up".to_owned()),
    };
    let stored = RgbImage::from_vec(width, height, rgb).map_err(|cause| cause.to_string())?;
    Ok(orientation.upright(stored))
}

fn drop_last_channel(rgba: &[u8]) -> Vec<u8> {
    rgba.as_chunks::<4>().0.iter().flat_map(|[red, green, blue, _]| [*red, *green, *blue]).collect()
}

fn decode_jpeg(bytes: &[u8], mut buffer: Vec<u8>) -> Result<RgbImage, String> {
    let options = DecoderOptions::default()
        .jpeg_set_out_colorspace(ColorSpace::RGB)
        .set_max_width(MAX_SIDE_PX)
        .set_max_height(MAX_SIDE_PX)
        // Without it a truncated picture is filled with grey and passes for a whole one.
        .set_strict_mode(true);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|cause| cause.to_string())?;
    let info = decoder.info().ok_or("it has no header")?;
    let (width, height) = (usize::from(info.width), usize::from(info.height));
    check_size(width, height, bytes.len().saturating_mul(JPEG_PIXELS_PER_BYTE))?;
    buffer.clear();
    buffer.resize(width * height * RgbImage::CHANNELS, 0);
    decoder.decode_into(&mut buffer).map_err(|cause| cause.to_string())?;
    let orientation = decoder.exif().map_or(Orientation::TopLeft, |exif| Orientation::of_exif(exif));
    let stored = RgbImage::from_vec(width, height, buffer).map_err(|cause| cause.to_string())?;
    Ok(orientation.upright(stored))
}
