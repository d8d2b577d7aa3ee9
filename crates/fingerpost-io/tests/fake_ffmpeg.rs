//! Video without ffmpeg: shell scripts that speak its protocol, and its absence.
#![cfg(unix)]
// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::{
    fs,
    num::NonZeroUsize,
    path::{Path, PathBuf},
    process::Command,
    time::{Duration, Instant},
};

use fingerpost_io::{
    FfmpegPrograms, FrameError, FrameSource, SourceError, SourceOptions, VideoError, VideoWriter,
};
use fingerpost_vision::picture::RgbImage;
use tempfile::TempDir;

const PROBE: &str = r#"echo '{"streams": [{"avg_frame_rate": "30000/1001", "nb_frames": "3"}]}'"#;

/// Two programs with the given bodies, and a file that passes for a video.
struct Machine {
    folder: TempDir,
    programs: FfmpegPrograms,
}

impl Machine {
    fn new(ffprobe: &str, ffmpeg: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let script = |name: &str, body: &str| -> PathBuf {
            let path = folder.path().join(name);
            let text = folder.path().join("text");
            fs::write(&text, format!("#!/bin/sh\n{body}\n")).unwrap();
            // A file that this process has open for writing while another test forks cannot be run until that child has begun
            // its own program ("text file busy"); what another process writes is closed when that ends.
            let copied = Command::new("install").args(["-m", "755"]).args([&text, &path]).status().unwrap();
            assert!(copied.success(), "{copied}");
            path
        };
        let (ffmpeg, ffprobe) = (script("ffmpeg", ffmpeg), script("ffprobe", ffprobe));
        let programs = FfmpegPrograms { ffmpeg, ffprobe, ..FfmpegPrograms::default() };
        fs::write(folder.path().join("drive.mp4"), "not looked into").unwrap();
        Self { folder, programs }
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn open(&self) -> Result<FrameSource, SourceError> {
        let options = SourceOptions { programs: self.programs.clone(), ..SourceOptions::default() };
        FrameSource::open(self.path("drive.mp4").to_str().unwrap(), &options)
    }
}

/// What prints `count` pictures of 2 x 1 pixels.
fn pictures(count: usize) -> String {
    r"printf 'P6\n2 1\n255\nabcdef'; ".repeat(count)
}

fn video_error(error: FrameError) -> VideoError {
    match error {
        FrameError::Video(error) => error,
        FrameError::Picture(error) => unreachable!("a video has no picture files: {error}"),
    }
}

#[test]
fn frames_come_with_the_rate_and_length_that_ffprobe_says() {
    let machine = Machine::new(PROBE, &pictures(3));
    let mut source = machine.open().unwrap();
    assert_eq!(source.length(), Some(3));
    for index in 0..3 {
        let frame = source.next().unwrap();
        assert_eq!(frame.index, index);
        assert!((frame.t_s - index as f64 * 1001.0 / 30_000.0).abs() < 1e-12);
        let picture = frame.picture.unwrap();
        assert_eq!((picture.size(), picture.as_slice()), ((2, 1), &b"abcdef"[..]));
        source.recycle(picture);
    }
    assert!(source.next().is_none());
    assert!(source.next().is_none());
}

#[test]
fn pixels_of_the_commonest_kind_are_taken_as_they_are() {
    let probe =
        r#"echo '{"streams": [{"avg_frame_rate": "10/1", "pix_fmt": "yuv420p", "color_range": "pc"}]}'"#;
    let frame = r"printf 'FRAME\n\012\024\200\200'; ";
    let play = format!(
        "echo \"$@\" > \"$(dirname \"$0\")/arguments\"; printf 'YUV4MPEG2 W2 H1 C420mpeg2\\n'; {frame}{frame}"
    );
    let machine = Machine::new(probe, &play);
    for threads in [1, 3] {
        let threads = NonZeroUsize::new(threads);
        let options =
            SourceOptions { threads, programs: machine.programs.clone(), ..SourceOptions::default() };
        let source = FrameSource::open(machine.path("drive.mp4").to_str().unwrap(), &options).unwrap();
        let pictures: Vec<Vec<u8>> = source.map(|frame| frame.picture.unwrap().into_vec()).collect();
        assert_eq!(pictures, [[10, 10, 10, 20, 20, 20]; 2]);
        let arguments = fs::read_to_string(machine.path("arguments")).unwrap();
        assert!(arguments.contains("-pix_fmt yuv420p -f yuv4mpegpipe"), "{arguments}");
        assert!(arguments.contains(&format!("-threads {}", threads.unwrap())), "{arguments}");
    }
}

#[test]
fn without_the_program_it_says_what_to_install() {
    let machine = Machine::new(PROBE, "");
    fs::remove_file(machine.path("ffmpeg")).unwrap();
    let without_ffmpeg = machine.open().unwrap_err();
    fs::remove_file(machine.path("ffprobe")).unwrap();
    let without_both = machine.open().unwrap_err();
    for error in [without_ffmpeg, without_both] {
        assert!(matches!(error, SourceError::Video(VideoError::NotInstalled { .. })), "{error}");
        assert!(error.to_string().contains("apt install ffmpeg"), "{error}");
    }
    let error = VideoWriter::create(&machine.path("out.mp4"), (2, 2), 10.0, &machine.programs).unwrap_err();
    assert!(error.to_string().contains("apt install ffmpeg"), "{error}");
}

#[test]
fn what_ffprobe_cannot_read_is_an_error_with_its_words() {
    let machine = Machine::new("echo first >&2; echo 'moov atom not found' >&2; exit 1", "");
    let message = machine.open().unwrap_err().to_string();
    assert!(message.contains("drive.mp4") && message.contains("moov atom not found"), "{message}");
    let machine = Machine::new(r#"echo '{"streams": []}'"#, "");
    let message = machine.open().unwrap_err().to_string();
    assert!(message.contains("no moving pictures"), "{message}");
    let machine = Machine::new("echo nonsense", "");
    assert!(machine.open().unwrap_err().to_string().contains("not understood"));
}

#[test]
fn a_video_that_breaks_off_yields_its_frames_and_then_says_so() {
    let endings = [
        ("echo 'partial file' >&2; exit 1", "partial file"),
        ("echo 'partial file' >&2; exit 0", "partial file"),
        (r"printf 'P6\n2 1\n255\nabc'; exit 0", "failed to fill whole buffer"),
        ("exit 7", "without a message"),
        ("printf 'what is this?'; exec sleep 60", "header"),
    ];
    for (ending, expected) in endings {
        let machine = Machine::new(PROBE, &format!("{}{ending}", pictures(2)));
        let mut source = machine.open().unwrap();
        assert!(source.next().unwrap().picture.is_ok());
        assert!(source.next().unwrap().picture.is_ok());
        let last = source.next().unwrap();
        assert_eq!(last.index, 2);
        let error = video_error(last.picture.unwrap_err());
        assert!(matches!(error, VideoError::BrokenOff { frames: 2, .. }), "{ending}: {error}");
        assert!(error.to_string().contains(expected), "{ending}: {error}");
        assert!(source.next().is_none(), "{ending}");
    }
}

#[test]
fn complaints_about_a_whole_video_are_no_error() {
    let machine = Machine::new(PROBE, &format!("echo 'concealing errors' >&2; {}", pictures(3)));
    assert_eq!(machine.open().unwrap().filter(|frame| frame.picture.is_ok()).count(), 3);
    // With more messages than a pipe holds the program must not wait for a reader.
    let chatter = "i=0; while [ $i -lt 3000 ]; do echo 'a message of some forty bytes for everyone' >&2; i=$((i+1)); done";
    let machine = Machine::new(PROBE, &format!("{chatter}; {}", pictures(3)));
    assert_eq!(machine.open().unwrap().count(), 3);
}

#[test]
fn nothing_decoded_is_an_unreadable_video() {
    let machine = Machine::new(PROBE, "echo 'Decoder not found' >&2; exit 1");
    let error = video_error(machine.open().unwrap().next().unwrap().picture.unwrap_err());
    assert!(matches!(error, VideoError::Unreadable { .. }), "{error}");
    assert!(error.to_string().contains("Decoder not found"));
}

#[test]
fn a_source_that_is_dropped_ends_its_program() {
    let machine =
        Machine::new(PROBE, &format!("echo $$ > \"$(dirname \"$0\")/pid\"; {}exec sleep 60", pictures(1)));
    let began = Instant::now();
    let mut source = machine.open().unwrap();
    assert!(source.next().unwrap().picture.is_ok());
    drop(source);
    assert!(began.elapsed() < Duration::from_secs(30));
    let pid = fs::read_to_string(machine.path("pid")).unwrap();
    assert!(!Path::new("/proc").join(pid.trim()).exists(), "process {pid} is still there");
}

#[test]
fn pictures_are_written_to_the_program_in_order() {
    let machine =
        Machine::new("", "echo \"$@\" > \"$(dirname \"$0\")/arguments\"; cat > \"$(dirname \"$0\")/bytes\"");
    let mut video = VideoWriter::create(&machine.path("out.mp4"), (2, 1), 12.5, &machine.programs).unwrap();
    video.write(&RgbImage::from_vec(2, 1, b"abcdef".to_vec()).unwrap()).unwrap();
    video.write(&RgbImage::from_vec(2, 1, b"ghijkl".to_vec()).unwrap()).unwrap();
    let error = video.write(&RgbImage::new(1, 2)).unwrap_err();
    assert!(error.to_string().contains("1 x 2 pixels does not fit a video of 2 x 1"), "{error}");
    assert!(!machine.path("out.mp4").exists(), "a video that is not whole has no name");
    video.finish().unwrap();
    assert!(machine.path("out.mp4").exists());
    assert_eq!(fs::read(machine.path("bytes")).unwrap(), b"abcdefghijkl");
    let arguments = fs::read_to_string(machine.path("arguments")).unwrap();
    assert!(arguments.contains("-s 2x1 -r 12.5") && arguments.contains("libx264"), "{arguments}");
}

#[test]
fn a_video_that_cannot_be_written_says_why() {
    let machine = Machine::new("", "echo 'No space left on device' >&2; exit 1");
    let path = machine.path("out.mp4");
    let mut video = VideoWriter::create(&path, (64, 64), 10.0, &machine.programs).unwrap();
    let picture = RgbImage::new(64, 64);
    // The pipe takes some pictures before it notices that nobody reads them.
    let error = (0..1000).find_map(|_| video.write(&picture).err()).unwrap();
    assert!(error.to_string().contains("out.mp4") && error.to_string().contains("No space left"), "{error}");
    assert!(video.write(&picture).is_err());
    let machine = Machine::new("", "cat > /dev/null; echo 'Could not write trailer' >&2; exit 1");
    let video = VideoWriter::create(&path, (64, 64), 10.0, &machine.programs).unwrap();
    assert!(video.finish().unwrap_err().to_string().contains("Could not write trailer"));
}
