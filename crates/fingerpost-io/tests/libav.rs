//! Videos read by FFmpeg's libraries, frame by frame beside what the program ffmpeg gives of them.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::{
    fs,
    num::NonZeroUsize,
    path::{Path, PathBuf},
    process::Command,
};

use fingerpost_io::{FfmpegPrograms, FrameSource, SourceError, SourceOptions, VideoDecoder, VideoError};

/// Frames of the test pattern.
const FRAMES: usize = 31;

/// Writes a moving test pattern.
fn pattern(to: &Path, size: &str, arguments: &[&str]) {
    let source = format!("testsrc2=size={size}:rate=30000/1001");
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y", "-f", "lavfi", "-i", &source]).args(arguments);
    command.args(["-frames:v", &FRAMES.to_string()]).arg(to);
    assert!(command.status().unwrap().success(), "{arguments:?}");
}

/// Where there are no programs to fall back on.
fn no_programs() -> FfmpegPrograms {
    let nowhere = PathBuf::from("/nowhere/ffmpeg");
    FfmpegPrograms { ffmpeg: nowhere.clone(), ffprobe: nowhere, ..FfmpegPrograms::default() }
}

fn open(path: &Path, options: &SourceOptions) -> FrameSource {
    FrameSource::open(path.to_str().unwrap(), options).unwrap()
}

/// All that a source says of its frames: time, damage, and pixels or what is wrong.
type Reading = Vec<(u64, f64, bool, Result<((usize, usize), Vec<u8>), String>)>;

fn reading(source: &mut FrameSource) -> Reading {
    let mut frames = Vec::new();
    while let Some(frame) = source.next() {
        let picture = match frame.picture {
            Ok(picture) => {
                let pixels = (picture.size(), picture.as_slice().to_vec());
                source.recycle(picture);
                Ok(pixels)
            }
            // An address in memory is another in every run.
            Err(error) => Err(error.to_string().split(" 0x").next().unwrap_or_default().to_owned()),
        };
        frames.push((frame.index, frame.t_s, frame.damaged, picture));
    }
    frames
}

/// Numbers of threads; as many as the machine runs where there is none.
const THREADS: [Option<NonZeroUsize>; 3] = [NonZeroUsize::new(1), NonZeroUsize::new(3), None];

/// The libraries' reading, which is to be the program's.
fn assert_same(path: &Path, threads: Option<NonZeroUsize>, programs: &FfmpegPrograms) -> Reading {
    let name = format!("{}, {threads:?}", path.display());
    let options = SourceOptions { threads, programs: programs.clone(), ..SourceOptions::default() };
    let mut by_libraries = open(path, &options);
    let (decoder, programs) = (VideoDecoder::Program, FfmpegPrograms::default());
    let mut by_program = open(path, &SourceOptions { decoder, programs, ..options });
    let stated = |source: &FrameSource| (source.length(), source.expected_length(), source.fps());
    assert_eq!(stated(&by_libraries), stated(&by_program), "{name}");
    let (found, expected) = (reading(&mut by_libraries), reading(&mut by_program));
    assert_eq!(found.len(), expected.len(), "{name}");
    for (found, expected) in found.iter().zip(&expected) {
        let but_pixels = |(index, t_s, damaged, picture): &(u64, f64, bool, Result<_, String>)| {
            (*index, *t_s, *damaged, picture.as_ref().map(|_| ()).map_err(String::clone))
        };
        assert_eq!(but_pixels(found), but_pixels(expected), "{name}");
        assert!(found.3 == expected.3, "{name}: the pixels of frame {} differ", found.0);
    }
    found
}

/// How to code frames whose times are far from even.
fn uneven(more: &[&'static str]) -> Vec<&'static str> {
    let times = "settb=1/1000,setpts='if(lt(N,9),N*0.02,1+N*0.3)/TB'";
    let coding = ["-vsync", "0", "-enc_time_base", "1/1000", "-c:v", "libx264", "-pix_fmt", "yuv420p"];
    [&["-vf", times], &coding[..], more].concat()
}

#[test]
fn frames_and_times_are_those_of_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let b_frames = ["-c:v", "libx264", "-bf", "3", "-g", "12", "-pix_fmt", "yuv420p"];
    let colours = |matrix: &'static str, range: &'static str| {
        let plain = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-qp", "0"];
        [&plain[..], &["-colorspace", matrix, "-color_range", range]].concat()
    };
    let cases: Vec<(&str, &str, Vec<&str>)> = vec![
        ("b_frames.mp4", "320x180", b_frames.to_vec()),
        ("b_frames.mkv", "320x180", b_frames.to_vec()),
        ("with_sound.mkv", "320x180", {
            let sound = ["-f", "lavfi", "-t", "3", "-i", "sine", "-map", "0:v", "-map", "1:a"];
            [&sound[..], &b_frames[..], &["-c:a", "aac"]].concat()
        }),
        ("uneven.mp4", "160x96", uneven(&["-video_track_timescale", "1000"])),
        ("odd.mkv", "163x97", vec!["-c:v", "ffv1", "-pix_fmt", "yuv420p"]),
        ("jpeg.avi", "163x97", vec!["-c:v", "mjpeg", "-pix_fmt", "yuvj420p"]),
        ("mpeg4.mp4", "176x144", vec!["-c:v", "mpeg4", "-bf", "2"]),
        ("vp9.webm", "176x144", vec!["-c:v", "libvpx-vp9", "-pix_fmt", "yuv420p", "-deadline", "realtime"]),
        (
            "hevc.mp4",
            "176x144",
            vec!["-c:v", "libx265", "-pix_fmt", "yuv420p", "-x265-params", "log-level=0"],
        ),
        ("limited_601.mp4", "162x98", colours("smpte170m", "tv")),
        ("full_601.mp4", "162x98", colours("bt470bg", "pc")),
        ("limited_709.mp4", "162x98", colours("bt709", "tv")),
        ("full_709.mp4", "162x98", colours("bt709", "pc")),
    ];
    for (name, size, arguments) in cases {
        let path = folder.path().join(name);
        pattern(&path, size, &arguments);
        for threads in THREADS {
            // Without programs, so that nothing else can have read it.
            let found = assert_same(&path, threads, &no_programs());
            assert_eq!(found.len(), FRAMES, "{name}");
            assert!(found.iter().all(|(.., picture)| picture.is_ok()), "{name}");
        }
    }
}

#[test]
fn what_the_libraries_leave_to_the_program_is_read_all_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let plain = folder.path().join("plain.mp4");
    pattern(&plain, "160x96", &["-c:v", "libx264", "-pix_fmt", "yuv420p"]);
    let [rotated, ten_bits, raw] =
        ["rotated.mp4", "ten_bits.mkv", "raw.h264"].map(|name| folder.path().join(name));
    let copied = |arguments: &[&str], to: &Path| {
        let mut command = Command::new("ffmpeg");
        command.args(["-v", "error", "-y", "-i"]).arg(&plain).args(arguments).arg(to);
        assert!(command.status().unwrap().success());
    };
    copied(&["-c", "copy", "-metadata:s:v:0", "rotate=90"], &rotated);
    copied(&["-c:v", "ffv1", "-pix_fmt", "yuv420p10le"], &ten_bits);
    copied(&["-c", "copy"], &raw);
    // Its duration makes it seem short.
    let few = folder.path().join("uneven.mkv");
    pattern(&few, "160x96", &uneven(&[]));
    // Its stamps may begin anew.
    let stream = folder.path().join("mpeg2.ts");
    pattern(&stream, "176x144", &["-c:v", "mpeg2video", "-bf", "2"]);
    for (path, threads) in [rotated, ten_bits, raw, few, stream].iter().zip(THREADS.iter().cycle()) {
        let found = assert_same(path, *threads, &FfmpegPrograms::default());
        let good = found.iter().filter(|(.., picture)| picture.is_ok()).count();
        assert_eq!(good, FRAMES, "{}", path.display());
    }
}

#[test]
fn where_a_video_goes_wrong_the_program_goes_on_behind_the_last_good_frame() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.mp4");
    let coding = ["-c:v", "libx264", "-pix_fmt", "yuv420p", "-g", "6", "-movflags", "+faststart"];
    pattern(&whole, "320x180", &coding);
    let bytes = fs::read(&whole).unwrap();
    let cut = folder.path().join("cut.mp4");
    fs::write(&cut, &bytes[..bytes.len() / 2]).unwrap();
    let found = assert_same(&cut, NonZeroUsize::new(1), &FfmpegPrograms::default());
    let good = found.iter().filter(|(.., picture)| picture.is_ok()).count();
    assert!((5..FRAMES).contains(&good), "{good} good frames");
    assert!(found.last().unwrap().3.is_err());
    // Where there is no program either, what has been read stays, and an error says why there is no more.
    let options = SourceOptions { programs: no_programs(), ..SourceOptions::default() };
    let found = reading(&mut open(&cut, &options));
    assert_eq!(found.iter().filter(|(.., picture)| picture.is_err()).count(), 1);
    assert!(found.last().unwrap().3.as_ref().is_err_and(|error| error.contains("install ffmpeg")));

    let path = folder.path().join("damaged.mp4");
    let mut damaged = 0;
    for share in 2..6 {
        let mut bytes = bytes.clone();
        let place = bytes.len() * share / 7;
        bytes[place..place + 400].fill(0x5a);
        fs::write(&path, &bytes).unwrap();
        // With several threads the program itself makes up other parts from run to run.
        let found = assert_same(&path, NonZeroUsize::new(1), &FfmpegPrograms::default());
        damaged += found.iter().filter(|(_, _, damaged, _)| *damaged).count();
    }
    assert!(damaged > 0, "the bytes must do damage");
}

#[test]
fn what_holds_no_moving_pictures_is_an_error_with_its_cause() {
    let folder = tempfile::tempdir().unwrap();
    let sound = folder.path().join("sound.wav");
    let mut command = Command::new("ffmpeg");
    command.args(["-v", "error", "-y", "-f", "lavfi", "-t", "1", "-i", "sine"]).arg(&sound);
    assert!(command.status().unwrap().success());
    let text = folder.path().join("text.mp4");
    fs::write(&text, "no video").unwrap();
    for path in [sound, text] {
        let refused = FrameSource::open(path.to_str().unwrap(), &SourceOptions::default());
        let Err(SourceError::Video(VideoError::Unreadable { input, cause })) = refused else {
            panic!("{refused:?}")
        };
        assert_eq!(input, path.to_str().unwrap());
        assert!(!cause.is_empty());
    }
}
