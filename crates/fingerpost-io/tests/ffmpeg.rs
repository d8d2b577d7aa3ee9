//! Video with the real ffmpeg; its absence is a failure.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{
    fs,
    num::NonZeroUsize,
    path::{Path, PathBuf},
    process::Command,
};

use fingerpost_io::{
    FfmpegPrograms, FrameClock, FrameError, FrameSource, Sampling, SourceOptions, StampFaults, VideoError,
    VideoWriter,
};
use fingerpost_vision::picture::RgbImage;

/// A picture whose left half is red and whose brightness tells the frame.
fn picture(width: usize, height: usize, index: usize) -> RgbImage {
    let level = 40 + 8 * (index % 12) as u8;
    let row =
        (0..width).flat_map(|x| if x < width / 2 { [level + 80, level / 2, level / 2] } else { [level; 3] });
    RgbImage::from_vec(width, height, row.collect::<Vec<u8>>().repeat(height)).unwrap()
}

fn write(path: &Path, (width, height): (usize, usize), fps: f64, frames: usize) {
    let mut video = VideoWriter::create(path, (width, height), fps, &FfmpegPrograms::default()).unwrap();
    for index in 0..frames {
        video.write(&picture(width, height, index)).unwrap();
    }
    video.finish().unwrap();
}

fn open(path: &Path) -> FrameSource {
    FrameSource::open(path.to_str().unwrap(), &SourceOptions::default()).unwrap()
}

fn ffmpeg(arguments: &[&str], from: &Path, to: &Path) {
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y", "-i"]).arg(from).args(arguments).arg(to);
    assert!(command.status().unwrap().success());
}

fn assert_close(found: [u8; 3], expected: [u8; 3]) {
    let close = found.iter().zip(expected).all(|(found, expected)| found.abs_diff(expected) <= 8);
    assert!(close, "{found:?} is not {expected:?}");
}

#[test]
fn what_is_written_reads_back_in_order_with_odd_sides_padded() {
    let folder = tempfile::tempdir().unwrap();
    // A colon must not be taken for a protocol, nor a percent sign for a pattern.
    let path = folder.path().join("a: 100%d drive.mp4");
    write(&path, (161, 121), 12.5, 10);
    let mut source = open(&path);
    assert_eq!(source.length(), Some(10));
    assert!((source.fps() - 12.5).abs() < 1e-9);
    for index in 0..10_usize {
        let frame = source.next().unwrap();
        assert!((frame.t_s - index as f64 * 0.08).abs() < 1e-9);
        let found = frame.picture.unwrap();
        assert_eq!(found.size(), (162, 122));
        let expected = picture(161, 121, index);
        for (x, y) in [(20, 20), (140, 100)] {
            assert_close(found.get(x, y).unwrap(), expected.get(x, y).unwrap());
        }
        source.recycle(found);
    }
    assert!(source.next().is_none());
}

#[test]
fn colours_are_those_that_ffmpeg_finds_however_they_are_coded() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("source.mkv");
    let pattern = ["-f", "lavfi", "-i", "testsrc2=size=164x98:rate=10:duration=0.3"];
    let coding = ["-c:v", "ffv1", "-pix_fmt", "gbrp"];
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y"]).args(pattern).args(coding).arg(&source);
    assert!(command.status().unwrap().success());
    for (name, pixels, space, range) in [
        ("limited 601", "yuv420p", "smpte170m", "tv"),
        ("limited 709", "yuv420p", "bt709", "tv"),
        ("full 601", "yuvj420p", "bt470bg", "pc"),
        ("ten bits", "yuv420p10le", "smpte170m", "tv"),
        ("colour in every row", "yuv422p", "smpte170m", "tv"),
    ] {
        let coded = folder.path().join(format!("{name}.mkv"));
        let scale = format!("scale=out_color_matrix={space}:out_range={range},format={pixels}");
        let arguments = ["-vf", scale.as_str(), "-colorspace", space, "-color_range", range, "-c:v", "ffv1"];
        ffmpeg(&arguments, &source, &coded);
        let raw = folder.path().join("expected.rgb");
        ffmpeg(&["-f", "rawvideo", "-pix_fmt", "rgb24"], &coded, &raw);
        let expected = fs::read(&raw).unwrap();
        let found: Vec<u8> = open(&coded).flat_map(|frame| frame.picture.unwrap().into_vec()).collect();
        assert_eq!(found.len(), expected.len(), "{name}");
        let difference = found.iter().zip(&expected).map(|(a, b)| u64::from(a.abs_diff(*b)));
        let (sum, most) = difference.fold((0, 0), |(sum, most), d| (sum + d, most.max(d)));
        let mean = sum as f64 / found.len() as f64;
        assert!(mean < 1.0 && most <= 6, "{name}: {mean:.3} on average, {most} at most");
    }
}

#[test]
fn a_rotated_video_stands_upright() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, rotated) = (folder.path().join("plain.mp4"), folder.path().join("rotated.mp4"));
    write(&plain, (160, 96), 10.0, 3);
    ffmpeg(&["-c", "copy", "-metadata:s:v:0", "rotate=90"], &plain, &rotated);
    let sizes: Vec<(usize, usize)> = open(&rotated).map(|frame| frame.picture.unwrap().size()).collect();
    assert_eq!(sizes, [(96, 160); 3]);
}

#[test]
fn a_varying_rate_neither_drops_nor_doubles_frames() {
    let folder = tempfile::tempdir().unwrap();
    let (plain, uneven) = (folder.path().join("plain.mp4"), folder.path().join("uneven.mkv"));
    write(&plain, (160, 96), 10.0, 12);
    let filter = ["-vf", "settb=1/1000,setpts='if(lt(N,6),N*0.02,1+N*0.3)/TB'"];
    let uneven_arguments =
        [&filter[..], &["-vsync", "0", "-enc_time_base", "1/1000", "-c:v", "libx264"]].concat();
    ffmpeg(&uneven_arguments, &plain, &uneven);
    let expected = (0..12).map(|index| picture(160, 96, index).get(140, 50).unwrap()[0]);
    let times: Vec<f64> = open(&uneven).map(|frame| frame.t_s).collect();
    for (index, t_s) in (0_u8..).zip(&times) {
        let expected_s =
            f64::from(index) * if index < 6 { 0.02 } else { 0.3 } + if index < 6 { 0.0 } else { 1.0 };
        // Matroska counts milliseconds, and ffmpeg cuts to them.
        assert!((t_s - expected_s).abs() < 1.1e-3, "{index}: {t_s}");
    }
    let options = SourceOptions { fps: Some(4.0), ..SourceOptions::default() };
    let source = FrameSource::open(uneven.to_str().unwrap(), &options).unwrap();
    assert_eq!(source.clock(), FrameClock::Given);
    assert!(source.map(|frame| frame.t_s).eq((0_u8..12).map(|index| f64::from(index) / 4.0)));
    let options = SourceOptions { sampling: Sampling::Rate { hz: 1.0 }, ..SourceOptions::default() };
    let sampled = FrameSource::open(uneven.to_str().unwrap(), &options).unwrap().map(|frame| frame.index);
    assert_eq!(sampled.collect::<Vec<_>>(), [0, 6, 7, 10], "at 0, 2.8, 3.1 and 4 s");
    let found = open(&uneven).map(|frame| frame.picture.unwrap().get(140, 50).unwrap()[0]);
    let (found, expected): (Vec<u8>, Vec<u8>) = (found.collect(), expected.collect());
    assert_eq!(found.len(), 12, "{found:?}");
    assert!(found.iter().zip(&expected).all(|(a, b)| a.abs_diff(*b) <= 6), "{found:?} {expected:?}");
}

#[test]
fn times_are_counted_from_the_first_frame_wherever_stamps_begin() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.mp4");
    write(&plain, (160, 96), 10.0, 12);
    for (name, arguments) in
        [("later.mkv", &["-c", "copy", "-output_ts_offset", "7"][..]), ("stream.ts", &["-c", "copy"])]
    {
        let path = folder.path().join(name);
        ffmpeg(arguments, &plain, &path);
        let mut source = open(&path);
        let times: Vec<f64> = source.by_ref().map(|frame| frame.t_s).collect();
        assert!(times.len() >= 8, "{name}: {times:?}");
        for (index, t_s) in (0_u8..).zip(&times) {
            assert!((t_s - f64::from(index) / 10.0).abs() < 1e-9, "{name}: {times:?}");
        }
        assert_eq!(
            (source.clock(), source.stamp_faults()),
            (FrameClock::Own, StampFaults::default()),
            "{name}"
        );
    }
}

#[test]
fn a_bare_stream_without_a_rate_has_a_guess_and_one_with_a_rate_has_that() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.mp4");
    write(&plain, (160, 96), 20.0, 12);
    for (name, arguments, clock, fps) in [
        ("a.mjpeg", &["-c:v", "mjpeg", "-pix_fmt", "yuvj420p"][..], FrameClock::Guessed, 25.0),
        ("a.hevc", &["-c:v", "libx265", "-x265-params", "log-level=0"], FrameClock::Stated, 20.0),
        ("a.h264", &["-c:v", "libx264"], FrameClock::Stated, 20.0),
        ("a.m2v", &["-c:v", "mpeg2video", "-r", "25"], FrameClock::Stated, 25.0),
        ("a.y4m", &[], FrameClock::Own, 20.0),
    ] {
        let path = folder.path().join(name);
        ffmpeg(arguments, &plain, &path);
        let source = open(&path);
        assert_eq!((source.clock(), source.unsampled_fps()), (clock, fps), "{name}");
        let times: Vec<f64> = source.map(|frame| frame.t_s).collect();
        let (index, last_s) = (times.len() - 1, *times.last().unwrap());
        assert!((last_s - index as f64 / fps).abs() < 1e-9, "{name}: {times:?}");
        let options = SourceOptions { fps: Some(20.0), ..SourceOptions::default() };
        let source = FrameSource::open(path.to_str().unwrap(), &options).unwrap();
        assert_eq!(source.clock(), FrameClock::Given, "{name}");
        assert!(source.map(|frame| frame.t_s).nth(11).is_some_and(|t_s| (t_s - 0.55).abs() < 1e-9), "{name}");
    }
}

#[test]
fn a_truncated_video_yields_its_frames_and_then_says_so() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["cut.mp4", "cut.mkv"] {
        let (whole, cut) = (folder.path().join("whole.mp4"), folder.path().join(name));
        write(&whole, (320, 240), 10.0, 20);
        ffmpeg(&["-vf", "noise=alls=40:allf=t", "-movflags", "+faststart", "-g", "1"], &whole, &cut);
        let bytes = fs::read(&cut).unwrap();
        fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
        let results: Vec<Result<RgbImage, FrameError>> = open(&cut).map(|frame| frame.picture).collect();
        let good = results.iter().filter(|result| result.is_ok()).count();
        assert!((5..20).contains(&good), "{name}: {good} good frames");
        let last = results.last().unwrap().as_ref().unwrap_err();
        assert!(
            matches!(last, FrameError::Video(VideoError::BrokenOff { frames, .. }) if *frames == good as u64),
            "{name}: {last}"
        );
    }
}

#[test]
fn what_is_no_video_is_an_error_that_names_it() {
    let folder = tempfile::tempdir().unwrap();
    let path: PathBuf = folder.path().join("note.mp4");
    fs::write(&path, "this is a note, not a video, however long it may get").unwrap();
    let error = FrameSource::open(path.to_str().unwrap(), &SourceOptions::default()).unwrap_err();
    assert!(error.to_string().contains("note.mp4") && error.to_string().contains("Invalid data"), "{error}");
    let whole = folder.path().join("whole.mp4");
    write(&whole, (160, 96), 10.0, 5);
    let bytes = fs::read(&whole).unwrap();
    fs::write(&path, &bytes[..600]).unwrap();
    let opened = FrameSource::open(path.to_str().unwrap(), &SourceOptions::default());
    let broken = opened.map(|mut source| source.all(|frame| frame.picture.is_ok()));
    assert!(!matches!(broken, Ok(true)), "a cut header must not pass");
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("gone/out.mp4");
    let error = VideoWriter::create(&path, (160, 96), 10.0, &FfmpegPrograms::default()).unwrap_err();
    let message = error.to_string();
    assert!(message.contains("gone/out.mp4 cannot be written (No such file"), "{message}");
    assert!(!message.contains("fingerpost-tmp"), "{message}");
}

/// Numbers below `limit` that look drawn by lot and are the same in every run (SplitMix64).
fn lots(seed: u64) -> impl FnMut(u64) -> u64 {
    let mut state = seed;
    move |limit| {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (state ^ (state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (mixed ^ (mixed >> 31)) % limit
    }
}

/// A test pattern of ten frames a second.
fn pattern(to: &Path, (width, height): (u64, u64), frames: u64, arguments: &[&str]) {
    let source = format!("testsrc2=size={width}x{height}:rate=10");
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y", "-f", "lavfi", "-i", &source, "-frames:v", &frames.to_string()]);
    assert!(command.args(arguments).arg(to).status().unwrap().success(), "{arguments:?}");
}

#[test]
fn a_stream_that_changes_half_way_ends_there_and_names_both_forms() {
    let folder = tempfile::tempdir().unwrap();
    let [first, second, both] = ["first.ts", "second.ts", "both.ts"].map(|name| folder.path().join(name));
    let mut draw = lots(1);
    for codec in ["libx264", "mpeg2video", "mpeg4"] {
        for kind in 0..4 {
            let size = (160 + 16 * draw(6), 96 + 16 * draw(4));
            let (other, pixels) = match kind {
                0 => ((size.0 * 2, size.1 * 2), "yuv420p"),
                1 => ((size.0 - 32, size.1 - 16), "yuv420p"),
                2 => ((size.1, size.0), "yuv420p"),
                // Other decoders of ffmpeg do not tell, or cannot.
                _ if codec != "libx264" => continue,
                _ => (size, "yuv422p"),
            };
            let (before, behind) = (3 + draw(12), 3 + draw(30));
            let coding = |pixels| ["-c:v", codec, "-pix_fmt", pixels, "-bf", "0"];
            pattern(&first, size, before, &coding("yuv420p"));
            pattern(&second, other, behind, &coding(pixels));
            fs::write(&both, [fs::read(&first).unwrap(), fs::read(&second).unwrap()].concat()).unwrap();
            for threads in [NonZeroUsize::new(1), None] {
                let options = SourceOptions { threads, ..SourceOptions::default() };
                let source = FrameSource::open(both.to_str().unwrap(), &options).unwrap();
                let mut pictures: Vec<_> = source.map(|frame| frame.picture).collect();
                let name = format!("{codec} {size:?} to {other:?} {pixels} at {before}");
                let last = pictures.pop().unwrap().map(|picture| picture.size()).unwrap_err();
                let FrameError::Video(VideoError::Changed { frames, change, .. }) = last else {
                    panic!("{name}: {last}")
                };
                let forms =
                    format!("from {} x {} (yuv420p) to {} x {} ({pixels})", size.0, size.1, other.0, other.1);
                assert_eq!(change, forms, "{name}");
                // A decoder that has a frame in hand may lose it there.
                let in_hand = u64::from(codec != "libx264");
                assert!((before - in_hand..=before).contains(&frames), "{name}: {frames}");
                let sizes: Vec<_> = pictures.into_iter().map(|picture| picture.unwrap().size()).collect();
                assert_eq!(sizes, vec![(size.0 as usize, size.1 as usize); frames as usize], "{name}");
            }
        }
    }
}

/// What was read of a video.
#[derive(Debug, PartialEq)]
struct Reading {
    good: u64,
    damaged: u64,
    error: Option<String>,
    complaint: Option<String>,
    expected: Option<u64>,
}

/// Reads a video in one thread; none where it cannot be opened.
fn read(path: &Path) -> Option<Reading> {
    let options = SourceOptions { threads: NonZeroUsize::new(1), ..SourceOptions::default() };
    let mut source = FrameSource::open(path.to_str().unwrap(), &options).ok()?;
    let (mut good, mut damaged, mut error) = (0, 0, None);
    for frame in source.by_ref() {
        assert!(error.is_none(), "something comes behind {error:?}");
        damaged += u64::from(frame.damaged);
        match frame.picture {
            Ok(_) => good += 1,
            Err(cause) => error = Some(cause.to_string()),
        }
    }
    let expected = source.expected_length();
    // An address in memory is another in every run.
    let words = |text: String| {
        text.split_whitespace().filter(|word| !word.starts_with("0x")).collect::<Vec<_>>().join(" ")
    };
    Some(Reading {
        good,
        damaged,
        error: error.map(words),
        complaint: source.complaint().map(words),
        expected,
    })
}

const FRAMES: u64 = 30;
const VIDEOS: [(&str, &str); 8] = [
    ("mp4", "libx264"),
    ("mkv", "libx264"),
    ("ts", "libx264"),
    ("mp4", "mpeg4"),
    ("mkv", "mpeg4"),
    ("ts", "mpeg2video"),
    ("avi", "mpeg4"),
    ("avi", "mjpeg"),
];

fn video(folder: &Path, container: &str, codec: &str) -> PathBuf {
    let path = folder.join(format!("whole.{container}"));
    let mut arguments = vec!["-c:v", codec, "-g", "6", "-bf", "0"];
    if container == "mp4" {
        arguments.extend(["-movflags", "+faststart"]);
    }
    pattern(&path, (160, 96), FRAMES, &arguments);
    let whole = read(&path).unwrap();
    assert_eq!((whole.good, whole.damaged, &whole.error, &whole.complaint), (FRAMES, 0, &None, &None));
    assert!(whole.expected.is_some_and(|expected| expected.abs_diff(FRAMES) <= 1), "{container}: {whole:?}");
    path
}

#[test]
fn damaged_bytes_never_cost_frames_in_silence() {
    let folder = tempfile::tempdir().unwrap();
    let (mut said, mut damaged) = (0, 0);
    for (container, codec) in VIDEOS {
        let path = video(folder.path(), container, codec);
        let bytes = fs::read(&path).unwrap();
        for seed in 0..6 {
            let (mut draw, mut bytes) = (lots(seed), bytes.clone());
            for _ in 0..1 << draw(6) {
                let place = bytes.len() as u64 / 6 + draw(bytes.len() as u64 * 4 / 6);
                bytes[place as usize] ^= 1 + draw(255) as u8;
            }
            let path = folder.path().join(format!("damaged.{container}"));
            fs::write(&path, &bytes).unwrap();
            let name = format!("{codec} in {container}, {seed}");
            let Some(found) = read(&path) else { continue };
            assert_eq!(read(&path).as_ref(), Some(&found), "{name}: not twice the same");
            let anything = found.error.is_some() || found.complaint.is_some() || found.damaged > 0;
            assert!(found.good == FRAMES || anything, "{name}: {found:?}");
            assert!(found.damaged <= found.good, "{name}: {found:?}");
            let counted = matches!(container, "mp4" | "avi");
            assert!(!counted || found.good >= FRAMES || found.error.is_some(), "{name}: {found:?}");
            said += u64::from(anything);
            damaged += found.damaged;
        }
    }
    assert!(said > 20 && damaged > 20, "the lots must do damage: {said} {damaged}");
}

#[test]
fn a_video_cut_anywhere_says_how_many_frames_are_missing() {
    let folder = tempfile::tempdir().unwrap();
    for (container, codec) in VIDEOS {
        let path = video(folder.path(), container, codec);
        let bytes = fs::read(&path).unwrap();
        for seed in 0..4 {
            let mut draw = lots(seed);
            let length = bytes.len() as u64 / 3 + draw(bytes.len() as u64 / 3);
            let path = folder.path().join(format!("cut.{container}"));
            fs::write(&path, &bytes[..length as usize]).unwrap();
            let name = format!("{codec} in {container}, {length} bytes of {}", bytes.len());
            let found = read(&path).unwrap();
            assert!((1..FRAMES).contains(&found.good), "{name}: {found:?}");
            if container == "ts" {
                // It states no length: what is there is all that anybody knows of.
                assert!(found.expected.is_none_or(|expected| expected <= FRAMES), "{name}: {found:?}");
            } else {
                assert!(found.error.is_some(), "{name}: {found:?}");
                assert!(
                    found.expected.is_some_and(|expected| expected.abs_diff(FRAMES) <= 1),
                    "{name}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn a_cut_that_hides_frames_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, cut] = ["whole.mp4", "cut.mp4"].map(|name| folder.path().join(name));
    pattern(&whole, (160, 96), 40, &["-c:v", "libx264", "-g", "12", "-bf", "0"]);
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y", "-ss", "1.7", "-i"]).arg(&whole).args(["-c", "copy"]).arg(&cut);
    assert!(command.status().unwrap().success());
    let found = read(&cut).unwrap();
    assert_eq!((found.good, found.error, found.expected), (23, None, Some(23)));
}
