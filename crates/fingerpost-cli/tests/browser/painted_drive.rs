//! A small drive to be marked.

use std::fs;
use std::path::Path;

use fingerpost_io::write_png;
use fingerpost_vision::picture::RgbImage;

/// Frames of the drive.
pub(crate) const FRAMES: u64 = 11;
/// Width and height of its pictures.
const PICTURE_PX: (usize, usize) = (320, 240);

/// Pictures of a grey road with a white line on the left that moves two pixels a frame.
pub(crate) fn paint_drive(folder: &Path) {
    fs::create_dir(folder).unwrap();
    let (width, height) = PICTURE_PX;
    for frame in 0..FRAMES {
        let mut picture = RgbImage::new(width, height);
        for (index, pixel) in picture.as_mut_slice().chunks_exact_mut(3).enumerate() {
            let (u, v) = ((index % width) as f64, (index / width) as f64);
            let edge = 40.0 + 2.0 * frame as f64 + 0.75 * (230.0 - v);
            let paint = v > 120.0 && (edge - 8.0..edge).contains(&u);
            pixel.fill(if paint {
                230
            } else if v > 110.0 {
                90
            } else {
                170
            });
        }
        write_png(&folder.join(format!("{frame:06}.png")), &picture).unwrap();
    }
}
