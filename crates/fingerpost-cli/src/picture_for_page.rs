//! A picture file as browsers show it.

use std::path::Path;

use fingerpost_io::{encode_png, read_bytes, read_picture};
use fingerpost_server::{Cause, Picture};

/// The picture of a file: as it is where browsers know its kind, else as PNG.
pub(crate) fn of_file(path: &Path) -> Result<Picture, Cause> {
    let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
    let (content_type, bytes) = match ending.to_str() {
        Some("png") => ("image/png", read_bytes(path)?),
        Some("jpg" | "jpeg") => ("image/jpeg", read_bytes(path)?),
        _ => ("image/png", encode_png(&read_picture(path)?)?),
    };
    Ok(Picture { content_type, bytes })
}
