//! Run folders, drive folders, calibrations and texts on disk.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{
    cell::RefCell,
    fs::{self, File, OpenOptions},
    io::{self, Write},
    path::Path,
    rc::Rc,
};

use fingerpost_format::{FrameRecord, Summary, TruthRecord, from_json_lines};
use fingerpost_geometry::{Mount, View};
use fingerpost_io::{
    AppendError, CROSSINGS_FILE, CameraReadError, DriveFolder, FileError, FrameFormat, FrameSource,
    JsonLinesFile, LineSink, RunFolder, SourceOptions, read_camera, read_picture, read_text, read_truth,
};
use fingerpost_vision::picture::{Plane, RgbImage};

fn frame(index: u64) -> FrameRecord {
    let text = format!(
        r#"{{"frame":{index},"t_s":0.5,"state":"searching","feature":null,"motion":null,"driving_line_m":[],
        "centreline":null,"lanes":null,"fix":null,"stage_ms":{{}},"why":"nothing yet"}}"#
    );
    serde_json::from_str(&text).unwrap()
}

fn names(folder: &Path) -> Vec<String> {
    let entries = fs::read_dir(folder).unwrap();
    let mut names: Vec<String> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_run_folder_holds_what_the_contract_says() {
    let parent = tempfile::tempdir().unwrap();
    let path = parent.path().join("deep/run");
    let mut run = RunFolder::create(&path).unwrap();
    run.write_config("[match]\n").unwrap();
    run.append(&frame(0)).unwrap();
    // Lines are there at once, not when the folder is closed.
    let text = read_text(&path.join("frames.jsonl")).unwrap();
    assert_eq!(from_json_lines::<FrameRecord>(&text).unwrap(), [frame(0)]);
    run.append(&frame(1)).unwrap();
    run.write_summary(&Summary { frames: 2, ..Summary::default() }).unwrap();
    assert_eq!(run.write_report("<html>").unwrap(), path.join("report.html"));
    let picture = RgbImage::new(4, 3);
    let picture_path = run.write_picture(1, &picture).unwrap();
    assert_eq!(picture_path, path.join("pictures/frame_000001.png"));
    assert_eq!(read_picture(&picture_path).unwrap(), picture);
    assert_eq!(run.video_path(), path.join("annotated.mp4"));
    run.finish().unwrap();
    assert_eq!(
        names(&path),
        [".fingerpost.json", "config.toml", "frames.jsonl", "pictures", "report.html", "summary.json"]
    );
    let summary: Summary = serde_json::from_str(&read_text(&path.join("summary.json")).unwrap()).unwrap();
    assert_eq!(summary.frames, 2);
}

#[test]
fn an_earlier_run_is_replaced_and_other_files_stay() {
    let parent = tempfile::tempdir().unwrap();
    let path = parent.path();
    let mut earlier = RunFolder::create(path).unwrap();
    earlier.append(&frame(0)).unwrap();
    earlier.write_picture(7, &RgbImage::new(2, 2)).unwrap();
    drop(earlier);
    for name in ["config.toml", "summary.json", "report.html", "annotated.mp4", "run.mcap", "notes.txt"] {
        fs::write(path.join(name), "old").unwrap();
    }
    fs::write(path.join("pictures/mine.txt"), "kept").unwrap();
    fs::write(path.join("pictures/mine.png"), "kept").unwrap();
    drop(RunFolder::create(path).unwrap());
    assert_eq!(names(path), [".fingerpost.json", "frames.jsonl", "notes.txt", "pictures"]);
    assert_eq!(names(&path.join("pictures")), ["mine.png", "mine.txt"]);
    assert_eq!(read_text(&path.join("frames.jsonl")).unwrap(), "");
}

#[test]
fn a_folder_that_cannot_be_made_is_named() {
    let parent = tempfile::tempdir().unwrap();
    let path = parent.path().join("file");
    fs::write(&path, "").unwrap();
    let message = RunFolder::create(&path.join("run")).unwrap_err().to_string();
    assert!(message.contains("file") && message.contains("choose another place"), "{message}");
}

/// A disk of so many bytes that takes what still fits and then is full.
#[derive(Default)]
struct SmallDisk {
    bytes: Vec<u8>,
    capacity: usize,
    can_cut: bool,
}

/// The same disk for the writer and for the test.
#[derive(Clone, Default)]
struct SharedDisk(Rc<RefCell<SmallDisk>>);

impl Write for SharedDisk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut disk = self.0.borrow_mut();
        let taken = bytes.len().min(disk.capacity - disk.bytes.len());
        if taken == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        disk.bytes.extend_from_slice(&bytes[..taken]);
        Ok(taken)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl LineSink for SharedDisk {
    fn cut_back(&mut self, length: u64) -> io::Result<()> {
        let mut disk = self.0.borrow_mut();
        if !disk.can_cut {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        disk.bytes.truncate(length as usize);
        Ok(())
    }
}

#[test]
fn a_full_disk_leaves_whole_lines_and_lets_the_run_go_on_when_there_is_space() {
    for can_cut in [true, false] {
        let disk = SharedDisk::default();
        *disk.0.borrow_mut() = SmallDisk { bytes: Vec::new(), capacity: 700, can_cut };
        let mut lines = JsonLinesFile::over(Path::new("run/frames.jsonl"), disk.clone());
        let mut written = 0;
        let message = loop {
            match lines.append(&frame(written)) {
                Ok(()) => written += 1,
                Err(error @ AppendError::File(FileError::Write { .. })) => break error.to_string(),
                Err(other) => panic!("{other}"),
            }
        };
        assert!(written >= 2, "{written} lines fit");
        assert!(message.contains("run/frames.jsonl") && message.contains("free some space"), "{message}");
        // Without the cut a part of a line stays at the end until it can be cut off.
        assert_eq!(disk.0.borrow().bytes.ends_with(b"\n"), can_cut);
        assert!(lines.append(&frame(written)).is_err());
        (disk.0.borrow_mut().capacity, disk.0.borrow_mut().can_cut) = (100_000, true);
        lines.append(&frame(written)).unwrap();
        let text = String::from_utf8(disk.0.borrow().bytes.clone()).unwrap();
        let expected: Vec<FrameRecord> = (0..=written).map(frame).collect();
        assert_eq!(from_json_lines::<FrameRecord>(&text).unwrap(), expected);
    }
}

#[test]
fn a_line_that_fits_goes_on_after_one_that_did_not() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("frames.jsonl");
    let mut lines = JsonLinesFile::create(&path).unwrap();
    lines.append(&frame(0)).unwrap();
    let mut file = lines.into_inner();
    let whole = file.metadata().unwrap().len();
    file.write_all(b"{\"frame\": 1, \"t_").unwrap();
    file.cut_back(whole).unwrap();
    let mut rest = JsonLinesFile::over(&path, file);
    rest.append(&frame(1)).unwrap();
    let text = read_text(&path).unwrap();
    assert_eq!(from_json_lines::<FrameRecord>(&text).unwrap(), [frame(0), frame(1)]);
}

#[test]
fn a_file_of_lines_is_gone_on_with_behind_its_last_whole_one() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("trials.jsonl");
    let (mut lines, before) = JsonLinesFile::go_on_with(&path).unwrap();
    assert_eq!(before, "");
    lines.append(&frame(0)).unwrap();
    lines.into_inner().write_all(b"{\"frame\": 1, \"t_").unwrap();
    let (mut lines, before) = JsonLinesFile::go_on_with(&path).unwrap();
    assert_eq!(from_json_lines::<FrameRecord>(&before).unwrap(), [frame(0)]);
    lines.append(&frame(1)).unwrap();
    lines.finish().unwrap();
    let text = read_text(&path).unwrap();
    assert_eq!(from_json_lines::<FrameRecord>(&text).unwrap(), [frame(0), frame(1)]);
}

#[cfg(target_os = "linux")]
#[test]
fn the_systems_full_device_is_a_full_disk() {
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut lines: JsonLinesFile<File> = JsonLinesFile::over(Path::new("/dev/full"), full);
    let message = lines.append(&frame(0)).unwrap_err().to_string();
    assert!(message.contains("/dev/full") && message.contains("the disk is full"), "{message}");
}

#[test]
fn a_drive_can_be_read_as_an_input_and_as_truth() {
    let parent = tempfile::tempdir().unwrap();
    let truth = |index: u64| TruthRecord { frame: index, t_s: index as f64 * 0.05, ..TruthRecord::default() };
    for (format, count) in [(FrameFormat::Jpeg, 3), (FrameFormat::Ppm, 4), (FrameFormat::Png, 2)] {
        let mut drive = DriveFolder::create(parent.path(), format).unwrap();
        // Only some drives have such a file; that of the drive before is none of this one's.
        assert!(!parent.path().join(CROSSINGS_FILE).exists());
        let camera_path = drive.write_camera("[image]\n").unwrap();
        assert_eq!(read_text(&camera_path).unwrap(), "[image]\n");
        drive.write_route("{}").unwrap();
        for index in 0..count {
            drive.write_frame(index, &RgbImage::new(16, 16)).unwrap();
            drive.write_road_mask(index, &Plane::new(16, 16, 255_u8)).unwrap();
            drive.append(&truth(index)).unwrap();
        }
        let truth_path = drive.truth_path();
        drive.finish().unwrap();
        let expected: Vec<TruthRecord> = (0..count).map(truth).collect();
        assert_eq!(read_truth(&truth_path).unwrap(), expected);
        let source = FrameSource::open(parent.path().to_str().unwrap(), &SourceOptions::default()).unwrap();
        let times: Vec<f64> = source.map(|frame| frame.t_s).collect();
        assert_eq!(times.len() as u64, count);
        assert!((times[1] - 0.05).abs() < 1e-9);
        assert_eq!(
            names(parent.path()),
            [
                ".fingerpost.json",
                "camera.toml",
                "frames",
                "road_masks",
                "route.geojson",
                "times.txt",
                "truth.jsonl"
            ]
        );
        assert_eq!(names(&parent.path().join("road_masks")).len() as u64, count);
        fs::write(parent.path().join(CROSSINGS_FILE), "of this drive").unwrap();
    }
}

#[test]
fn a_broken_truth_file_names_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("truth.jsonl");
    fs::write(&path, "{\"frame\": 0}\n").unwrap();
    let message = read_truth(&path).unwrap_err().to_string();
    assert!(message.contains("truth.jsonl") && message.contains("line 1"), "{message}");
}

const YAML: &str = "image_width: 640\nimage_height: 480\nK: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n";

fn mount_of(path: &Path) -> Mount {
    match read_camera(path).unwrap().camera.view() {
        View::Calibrated { mount, .. } => *mount,
        View::RoadPlane(_) => panic!("a calibrated camera was expected"),
    }
}

#[test]
fn a_yaml_calibration_finds_its_mount() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("front.yaml");
    fs::write(&path, YAML).unwrap();
    let message = read_camera(&path).unwrap_err().to_string();
    for expected in ["front.yaml", "front.mount.toml", "[mount]", "height_m"] {
        assert!(message.contains(expected), "{message}");
    }
    fs::write(&path, format!("{YAML}mount: {{height_m: 1.1}}\n")).unwrap();
    assert_eq!(mount_of(&path), Mount::level(1.1));
    fs::write(folder.path().join("mount.toml"), "[mount]\nheight_m = 1.2\n").unwrap();
    assert_eq!(mount_of(&path), Mount::level(1.2));
    fs::write(folder.path().join("front.mount.toml"), "[mount]\nheight_m = 1.3\n").unwrap();
    assert_eq!(mount_of(&path), Mount::level(1.3));
    fs::write(folder.path().join("front.mount.toml"), "[mount]\nheight = 1.3\n").unwrap();
    let message = read_camera(&path).unwrap_err().to_string();
    assert!(message.contains("front.mount.toml") && message.contains("`height`"), "{message}");
}

#[test]
fn a_calibration_is_told_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("camera.toml");
    let text = "[image]\nwidth = 640\nheight = 480\n[intrinsics]\nfx = 500\nfy = 500\ncx = 320\ncy = 240\n\
                [mount]\nheight_m = 1.5\n";
    fs::write(&path, text).unwrap();
    assert_eq!(mount_of(&path), Mount::level(1.5));
    fs::write(&path, text.replace("fx = 500", "fx = nan")).unwrap();
    let message = read_camera(&path).unwrap_err().to_string();
    assert!(message.contains("camera.toml") && message.contains("intrinsics.fx"), "{message}");
    let other = folder.path().join("camera.json");
    assert!(matches!(read_camera(&other), Err(CameraReadError::UnknownKind { .. })));
    assert!(matches!(
        read_camera(&folder.path().join("gone.toml")),
        Err(CameraReadError::File(FileError::Read { .. }))
    ));
}

#[test]
fn texts_lose_their_byte_order_mark_and_must_be_utf8() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("text");
    fs::write(&path, b"\xef\xbb\xbfhello").unwrap();
    assert_eq!(read_text(&path).unwrap(), "hello");
    fs::write(&path, b"\xff\xfe").unwrap();
    assert!(matches!(read_text(&path), Err(FileError::NotText { .. })));
    let message = read_text(folder.path()).unwrap_err().to_string();
    assert!(message.contains("name a file in it"), "{message}");
}
