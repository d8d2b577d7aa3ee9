//! The program with its page, and a small drive to be marked.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};

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

/// `fingerpost mark`, killed with the value.
pub(crate) struct Marking {
    program: Child,
    pub(crate) address: String,
}

impl Marking {
    /// Starts it on a free port.
    pub(crate) fn start(input: &Path, out: &Path) -> Self {
        let mut program = Command::new(env!("CARGO_BIN_EXE_fingerpost"))
            .arg("mark")
            .args([input, Path::new("--out"), out])
            .args(["--port", "0"])
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let said = BufReader::new(program.stderr.take().unwrap()).lines().map(Result::unwrap);
        let address = said
            .filter_map(|line| Some(line.strip_prefix("open ")?.split(' ').next()?.to_owned()))
            .next()
            .unwrap();
        Self { program, address }
    }
}

impl Drop for Marking {
    fn drop(&mut self) {
        let _ = self.program.kill();
        let _ = self.program.wait();
    }
}
