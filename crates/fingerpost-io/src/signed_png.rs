//! Pictures that say which program wrote them, so that they are told from a user's.
//!
//! The text is a chunk `tEXt` right behind the header (PNG specification, 11.3.3.2), under the keyword that is registered for it.

use std::path::Path;

use fingerpost_vision::picture::RgbImage;

use crate::{
    picture_file::{PictureFileError, encode_png},
    whole_file::write_private_file,
};

/// Kind of the chunk, keyword, a zero byte and text.
const SIGNED: &[u8] = b"tEXtSoftware\0fingerpost";
/// Bytes of a chunk's length, and of its kind.
const LENGTH_BYTES: usize = 4;
const KIND_BYTES: usize = 4;
/// Bytes of a file's signature and header: 8, and a chunk of 13.
const HEADER_BYTES: usize = 33;

/// Writes a colour picture as PNG that says that this program wrote it.
///
/// # Errors
/// [`PictureFileError`] when the picture has no pixels or the file cannot be written.
pub fn write_signed_png(path: &Path, picture: &RgbImage) -> Result<(), PictureFileError> {
    let (width, height) = picture.size();
    let mut bytes = encode_png(picture).map_err(|error| PictureFileError::Encode {
        path: path.to_owned(),
        width,
        height,
        cause: error.cause,
    })?;
    let length = (SIGNED.len() - KIND_BYTES) as u32;
    let chunk = [&length.to_be_bytes()[..], SIGNED, &crc32fast::hash(SIGNED).to_be_bytes()].concat();
    bytes.splice(HEADER_BYTES..HEADER_BYTES, chunk);
    Ok(write_private_file(path, bytes)?)
}

/// Whether the bytes are those of a picture that [`write_signed_png`] wrote.
pub fn is_signed_png(bytes: &[u8]) -> bool {
    bytes.get(HEADER_BYTES + LENGTH_BYTES..).is_some_and(|rest| rest.starts_with(SIGNED))
}

#[cfg(test)]
mod tests {
    use tempfile::TempDir;

    use super::*;
    use crate::picture_file::read_picture;

    #[test]
    fn a_signed_picture_is_read_like_another_and_known_again() {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("a.png");
        let picture = RgbImage::from_vec(2, 1, vec![1, 2, 3, 4, 5, 6]).unwrap();
        write_signed_png(&path, &picture).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(read_picture(&path).unwrap().as_slice(), picture.as_slice());
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        reader.next_frame(&mut [0; 6]).unwrap();
        let text = &reader.info().uncompressed_latin1_text[0];
        assert_eq!((text.keyword.as_str(), text.text.as_str()), ("Software", "fingerpost"));
        assert!(
            is_signed_png(&bytes) && !is_signed_png(&encode_png(&picture).unwrap()) && !is_signed_png(b"")
        );
    }
}
