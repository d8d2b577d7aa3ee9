//! `fingerpost mark`: lane edges marked by hand on a local web page, and truth from marks.

mod folder;
mod footage;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost_format::marks_from_json;
use fingerpost_io::{FolderKind, OutputFolder, without_credentials};
use fingerpost_mark::{Desk, LaneMarks};
use fingerpost_server::{Limits, LocalServer};

use self::folder::{MarksFolder, TruthTexts};
use self::footage::Footage;
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::output;

/// Mark the edges of the vehicle's lane frame by frame, on a web page that is served to this machine alone.
///
/// Mark an edge in key frames; between them it is interpolated. The inner edge of a marking counts, the one nearer to the
/// vehicle. Every edit is saved in marks.json; "Export" on the page writes truth.jsonl, as `evaluate lanes` reads it, and
/// tusimple.json. With --marks and --export marks become truth without a page.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "mark drive.mp4",
    "mark drive.mp4 --marks drive-marks/marks.json --export truth"
))]
pub(crate) struct MarkArgs {
    /// A folder of pictures, a drive folder of `simulate`, or a video file (needs ffmpeg).
    #[arg(value_name = "INPUT")]
    input: String,
    /// Folder for marks.json and what is exported; marks that it holds are gone on with. By default INPUT's name with
    /// "-marks", in the current folder. Pictures of a video are kept there too.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["marks", "export"])]
    out: Option<PathBuf>,
    /// Port of the page on 127.0.0.1; 0 for any that is free.
    #[arg(long, value_name = "N", default_value_t = 8420, conflicts_with_all = ["marks", "export"])]
    port: u16,
    /// Frames a second, 0.01 to 1000: of pictures without times.txt (else the times in their names, or 10 as a guess), and of a video in
    /// place of its own times. Bare streams (.h264, .hevc, .mjpeg) have none and need it. Where a times.txt, a camera or a
    /// stream times the frames, it is refused.
    #[arg(long, value_name = "N", value_parser = crate::arguments::frame_rate)]
    fps: Option<f64>,
    /// Marks to make truth of, marks.json.
    #[arg(long, value_name = "FILE", requires = "export")]
    marks: Option<PathBuf>,
    /// Folder for truth.jsonl and tusimple.json made of --marks.
    #[arg(long, value_name = "DIR", requires = "marks")]
    export: Option<PathBuf>,
}

/// Marks, or makes truth of marks.
pub(crate) fn mark(args: &MarkArgs) -> Result<()> {
    match (&args.marks, &args.export) {
        (Some(marks), Some(folder)) => export(args, marks, folder),
        _ => serve(args),
    }
}

fn export(args: &MarkArgs, path: &Path, folder: &Path) -> Result<()> {
    let footage = Footage::look_through(&args.input, args.fps)?;
    let marks = read_marks(path, &footage)?;
    if folder.join("road_masks").is_dir() {
        bail!(
            "{} is a simulated drive, whose truth would be replaced; choose another folder",
            folder.display()
        );
    }
    let texts = TruthTexts::of_marks(&marks, &footage)?;
    let folder = OutputFolder::go_on_with(folder, FolderKind::Marks)?;
    for file in texts.write(&folder)? {
        output::message(&format!("written: {file}"));
    }
    Ok(())
}

fn serve(args: &MarkArgs) -> Result<()> {
    let out = args.out.clone().unwrap_or_else(|| default_folder(&args.input));
    let server = LocalServer::open(args.port, Limits::default())?;
    let folder = OutputFolder::go_on_with(&out, FolderKind::Marks)?;
    let footage = Footage::open(&args.input, args.fps, &out)?;
    let folder = MarksFolder::new(folder, footage.clone());
    let marks = if folder.marks_path().exists() {
        read_marks(&folder.marks_path(), &footage)?
    } else {
        LaneMarks::new(footage.name(), footage.picture_px(), footage.frames())
    };
    output::message(&format!("marks are saved in {}", folder.marks_path().display()));
    output::message(&format!("open {} in a browser; Ctrl-C ends the program", server.address()));
    let desk = Arc::new(Desk::new(marks, Box::new(footage), Box::new(folder)));
    let interrupt = Interrupt::listen()?;
    Ok(server.serve(&desk, interrupt.flag())?)
}

/// Marks of this footage.
fn read_marks(path: &Path, footage: &Footage) -> Result<LaneMarks> {
    let text = fingerpost_io::read_text(path)?;
    let file = marks_from_json(&text).with_context(|| path.display().to_string())?;
    let ([width, height], [marked_width, marked_height]) = (footage.picture_px(), file.picture_px);
    if (file.picture_px, file.frames) != (footage.picture_px(), footage.frames()) {
        bail!(
            "{} marks {} frames of {marked_width} x {marked_height} pixels and {} has {} of {width} x {height}; give the \
             input that was marked",
            path.display(),
            file.frames,
            footage.name(),
            footage.frames()
        );
    }
    Ok(LaneMarks::from_file(&file))
}

/// The input's name with a word behind it, in the folder at hand. A folder such as `.` has its name from where it is.
fn default_folder(input: &str) -> PathBuf {
    let shown = without_credentials(input);
    let given = Path::new(&shown);
    let place = match given.file_name() {
        Some(_) => given.to_owned(),
        None => given.canonicalize().unwrap_or_default(),
    };
    // What ends in a folder's name is no file's ending.
    let name = if place.is_dir() { place.file_name() } else { place.file_stem() };
    let name = name.map(|name| name.to_string_lossy()).unwrap_or_default();
    PathBuf::from(if name.is_empty() { "marks".to_owned() } else { format!("{name}-marks") })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_kept_beside_the_name_of_what_is_marked() {
        let folder = tempfile::TempDir::new().unwrap();
        let inner = folder.path().join("drive.v2");
        std::fs::create_dir_all(inner.join("frames")).unwrap();
        let of = |path: PathBuf| default_folder(&path.display().to_string());
        assert_eq!(of(inner.clone()), Path::new("drive.v2-marks"));
        assert_eq!(of(inner.join("")), Path::new("drive.v2-marks"));
        assert_eq!(of(inner.join("frames/..")), Path::new("drive.v2-marks"));
        assert_eq!(default_folder("clips/p1.solid.mp4"), Path::new("p1.solid-marks"));
        let here = std::env::current_dir().unwrap();
        let named = |name: &std::ffi::OsStr| PathBuf::from(format!("{}-marks", name.to_string_lossy()));
        for at_hand in [".", "./", "./."] {
            assert_eq!(default_folder(at_hand), named(here.file_name().unwrap()));
        }
        assert_eq!(default_folder(".."), named(here.parent().unwrap().file_name().unwrap()));
        assert_eq!(default_folder("/"), Path::new("marks"));
    }
}
