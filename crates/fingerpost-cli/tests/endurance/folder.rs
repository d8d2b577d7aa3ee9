//! What a run has left, read as its users read it.

use std::fs;
use std::path::Path;

use fingerpost::road_surface::SurfaceFile;
use fingerpost_format::{FrameRecord, Summary, from_json_lines};
use fingerpost_io::read_picture;

use crate::faults::{Fault, Seen, Subject};

/// Checks everything that is there, and gives the number of frames.
pub(crate) fn check(subject: &Subject, fault: Fault, seen: &Seen) -> usize {
    let Seen { stderr, code, .. } = seen;
    assert!(!stderr.contains("panicked"), "{stderr}");
    match fault {
        // Both may come when the run has ended already, and the second before it listens.
        Fault::Kill => assert!(matches!(code, None | Some(0)), "{code:?} {stderr}"),
        Fault::Terminate => {
            assert!(*code != Some(1) || stderr.contains("interrupted after"), "{code:?} {stderr}");
        }
        Fault::FullDisk => {
            assert!(*code == Some(1) && stderr.contains("cannot be written"), "{code:?} {stderr}")
        }
    }
    let out = subject.out();
    let frames = frames(&out.join("frames.jsonl"));
    let pictures = pictures(&out.join("pictures"));
    // A picture follows its frame's line.
    assert!(
        pictures <= frames && frames <= pictures + 1,
        "{pictures} pictures of {frames} frames, {fault:?}"
    );
    let summary = summary(&out.join("summary.json"));
    if fault == Fault::Terminate && code.is_some() {
        let summary = summary.unwrap();
        assert_eq!((summary.interrupted, summary.frames), (*code == Some(1), frames as u64));
    }
    for name in names(&out) {
        let known = [
            ".fingerpost.json",
            ".fingerpost.lock",
            "config.toml",
            "frames.jsonl",
            "pictures",
            "report.html",
            "run.mcap",
            "summary.json",
        ];
        assert!(known.contains(&name.as_str()) || name.ends_with(".fingerpost-tmp"), "{name}");
    }
    if let Ok(config) = fs::read_to_string(out.join("config.toml")) {
        fingerpost::Config::from_toml(&config).unwrap();
    }
    if let Ok(report) = fs::read_to_string(out.join("report.html")) {
        assert!(report.trim_end().ends_with("</html>"));
    }
    // The file of an earlier run is whole whatever happened to this one.
    let bank = fs::read_to_string(subject.bank()).unwrap();
    serde_json::from_str::<SurfaceFile>(&bank).unwrap();
    frames
}

/// The number of frames, each of which is there and follows the one before. A run that ended at once has no file.
fn frames(path: &Path) -> usize {
    let text = fs::read_to_string(path).unwrap_or_default();
    let records: Vec<FrameRecord> = from_json_lines(&text).unwrap();
    assert!(text.is_empty() || text.ends_with('\n'), "the last line is torn");
    assert!(records.iter().map(|record| record.frame).eq(0..records.len() as u64), "a frame is missing");
    records.len()
}

/// The number of pictures, each of which decodes.
fn pictures(folder: &Path) -> usize {
    if !folder.exists() {
        return 0;
    }
    let pictures: Vec<String> = names(folder).into_iter().filter(|name| name.ends_with(".png")).collect();
    for name in &pictures {
        read_picture(&folder.join(name)).unwrap();
    }
    pictures.len()
}

fn summary(path: &Path) -> Option<Summary> {
    Some(serde_json::from_str(&fs::read_to_string(path).ok()?).unwrap())
}

/// The names in a folder.
pub(crate) fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}
