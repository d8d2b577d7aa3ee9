//! Frames from folders of pictures, whole and broken.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::{
    fs,
    num::{NonZeroU64, NonZeroUsize},
    path::Path,
};

use fingerpost_io::{
    DEFAULT_PICTURE_FPS, FrameClock, FrameError, FrameSource, PictureFolderError, Sampling, SourceError,
    SourceOptions, write_jpeg, write_png,
};
use fingerpost_vision::{jpeg::ChromaSampling, picture::RgbImage};

fn picture(value: u8) -> RgbImage {
    RgbImage::from_vec(16, 16, vec![value; 16 * 16 * 3]).unwrap()
}

fn open(path: &Path) -> Result<FrameSource, SourceError> {
    FrameSource::open(path.to_str().unwrap(), &SourceOptions::default())
}

/// Index, time and first byte of every frame; no byte where the frame is broken.
fn frames(source: FrameSource) -> Vec<(u64, f64, Option<u8>)> {
    source
        .map(|frame| (frame.index, frame.t_s, frame.picture.ok().map(|picture| picture.as_slice()[0])))
        .collect()
}

#[test]
fn pictures_come_in_natural_order_at_the_default_rate() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("f10.png", 30), ("f9.PNG", 20), ("f1.png", 10)] {
        write_png(&folder.path().join(name), &picture(value)).unwrap();
    }
    write_jpeg(&folder.path().join("f11.JPEG"), &picture(40), 95, ChromaSampling::Full).unwrap();
    fs::write(folder.path().join("notes.txt"), "not a picture").unwrap();
    fs::write(folder.path().join("._f1.png"), "left behind by a file manager").unwrap();
    let source = open(folder.path()).unwrap();
    assert_eq!((source.length(), source.fps()), (Some(4), DEFAULT_PICTURE_FPS));
    let expected = [(0, 0.0, Some(10)), (1, 0.1, Some(20)), (2, 0.2, Some(30)), (3, 0.3, Some(40))];
    for (found, expected) in frames(source).into_iter().zip(expected) {
        assert_eq!((found.0, found.2), (expected.0, expected.2));
        assert!((found.1 - expected.1).abs() < 1e-12);
    }
}

#[test]
fn a_broken_picture_is_reported_and_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    for (name, value) in [("1.png", 1), ("2.png", 2), ("3.png", 3)] {
        write_png(&folder.path().join(name), &picture(value)).unwrap();
    }
    let second = folder.path().join("2.png");
    let bytes = fs::read(&second).unwrap();
    fs::write(&second, &bytes[..bytes.len() / 2]).unwrap();
    let mut source = open(folder.path()).unwrap();
    let first = source.next().unwrap().picture.unwrap();
    source.recycle(first);
    let broken = source.next().unwrap();
    match broken.picture {
        Err(FrameError::Picture(error)) => assert!(error.to_string().contains("2.png"), "{error}"),
        other => panic!("the second picture is broken: {other:?}"),
    }
    let third = source.next().unwrap();
    assert_eq!((third.index, third.picture.unwrap().as_slice()[0]), (2, 3));
    assert!(source.next().is_none());
}

#[test]
fn times_are_read_beside_the_pictures_and_above_a_frames_folder() {
    let drive = tempfile::tempdir().unwrap();
    let inner = drive.path().join("frames");
    fs::create_dir(&inner).unwrap();
    write_png(&inner.join("000000.png"), &picture(1)).unwrap();
    write_png(&inner.join("000001.png"), &picture(2)).unwrap();
    fs::write(drive.path().join("times.txt"), "7.0\n7.25\n").unwrap();
    for path in [drive.path(), &inner] {
        let source = open(path).unwrap();
        assert!((source.fps() - 4.0).abs() < 1e-12);
        assert_eq!(frames(source), [(0, 0.0, Some(1)), (1, 0.25, Some(2))]);
    }
    fs::write(inner.join("times.txt"), "0.0\n0.5\n").unwrap();
    for path in [drive.path(), &inner] {
        assert_eq!(frames(open(path).unwrap()), [(0, 0.0, Some(1)), (1, 0.5, Some(2))]);
    }
}

#[test]
fn a_given_rate_replaces_the_default_and_must_be_possible() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("1.png"), &picture(1)).unwrap();
    write_png(&folder.path().join("2.png"), &picture(2)).unwrap();
    let input = folder.path().to_str().unwrap();
    let at = |fps| FrameSource::open(input, &SourceOptions { fps: Some(fps), ..SourceOptions::default() });
    assert!((frames(at(4.0).unwrap())[1].1 - 0.25).abs() < 1e-12);
    for fps in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(at(fps), Err(SourceError::FrameRate { .. })), "{fps}");
    }
}

#[test]
fn a_rate_of_pictures_with_a_file_of_times_is_refused_with_both() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("1.png"), &picture(1)).unwrap();
    fs::write(folder.path().join("times.txt"), "0\n").unwrap();
    let options = SourceOptions { fps: Some(4.0), ..SourceOptions::default() };
    let refused = FrameSource::open(folder.path().to_str().unwrap(), &options).unwrap_err();
    assert!(matches!(refused, SourceError::RateOfTimed { .. }), "{refused}");
    let said = refused.to_string();
    assert!(said.contains("times.txt") && said.contains("--fps"), "{said}");
}

#[test]
fn frames_that_are_used_keep_their_numbers_and_times() {
    let folder = tempfile::tempdir().unwrap();
    for number in 0..9 {
        write_png(&folder.path().join(format!("{number}.png")), &picture(number)).unwrap();
    }
    fs::write(folder.path().join("times.txt"), "0\n0.1\n0.2\n0.3\n0.4\n2\n2.1\n2.2\n2.3\n").unwrap();
    // What is not used is not even opened.
    fs::write(folder.path().join("1.png"), "no picture").unwrap();
    let input = folder.path().to_str().unwrap();
    let used = |sampling, threads| {
        let threads = NonZeroUsize::new(threads);
        let source =
            FrameSource::open(input, &SourceOptions { sampling, threads, ..SourceOptions::default() });
        let source = source.unwrap();
        (source.length(), frames(source))
    };
    let every = Sampling::Every(NonZeroU64::new(3).unwrap());
    for threads in [1, 2, 5] {
        let expected = vec![(0, 0.0, Some(0)), (3, 0.3, Some(3)), (6, 2.1, Some(6))];
        assert_eq!(used(every, threads), (Some(3), expected));
        let expected = [(0, 0.0, Some(0)), (2, 0.2, Some(2)), (4, 0.4, Some(4)), (5, 2.0, Some(5))];
        let expected = expected.into_iter().chain([(7, 2.2, Some(7))]).collect();
        assert_eq!(used(Sampling::Rate { hz: 5.0 }, threads), (Some(5), expected));
    }
    for hz in [0.0, f64::NAN, 1e9] {
        let sampling = Sampling::Rate { hz };
        let refused = FrameSource::open(input, &SourceOptions { sampling, ..SourceOptions::default() });
        assert!(matches!(refused, Err(SourceError::FrameRate { .. })), "{hz}");
    }
}

#[test]
fn times_that_do_not_fit_say_both_numbers() {
    let folder = tempfile::tempdir().unwrap();
    write_png(&folder.path().join("1.png"), &picture(1)).unwrap();
    fs::write(folder.path().join("times.txt"), "0\n0.1\n0.2\n").unwrap();
    let error = open(folder.path()).unwrap_err();
    assert!(matches!(
        error,
        SourceError::Folder(PictureFolderError::TimesCount { times: 3, pictures: 1, .. })
    ));
    assert!(error.to_string().contains("3 times for 1 pictures"), "{error}");
    fs::write(folder.path().join("times.txt"), "now\n").unwrap();
    let message = open(folder.path()).unwrap_err().to_string();
    assert!(message.contains("times.txt") && message.contains("\"now\""), "{message}");
}

#[test]
fn an_input_that_is_not_there_or_empty_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let message = open(folder.path()).unwrap_err().to_string();
    assert!(message.contains("holds no picture") && message.contains("check the path"), "{message}");
    let message = open(&folder.path().join("gone")).unwrap_err().to_string();
    assert!(message.contains("gone") && message.contains("give a folder"), "{message}");
}

#[test]
fn pictures_named_by_times_have_their_order_and_times() {
    let folder = tempfile::tempdir().unwrap();
    for (index, name) in (0..).zip(["102.05", "102.1", "102.15", "103", "103.5"]) {
        write_png(&folder.path().join(format!("{name}.png")), &picture(index)).unwrap();
    }
    let input = folder.path().to_str().unwrap();
    let source = |fps| FrameSource::open(input, &SourceOptions { fps, ..SourceOptions::default() }).unwrap();
    let read =
        |fps| source(fps).map(|frame| (frame.t_s, frame.picture.unwrap().as_slice()[0])).collect::<Vec<_>>();
    assert_eq!(source(None).clock(), FrameClock::Names);
    assert_eq!(read(None), [(0.0, 0), (0.05, 1), (0.1, 2), (0.95, 3), (1.45, 4)]);
    assert_eq!(source(Some(2.0)).clock(), FrameClock::Given);
    assert_eq!(read(Some(2.0)), [(0.0, 0), (0.5, 1), (1.0, 2), (1.5, 3), (2.0, 4)]);
    fs::write(folder.path().join("times.txt"), "0\n1\n2\n3\n4\n").unwrap();
    assert_eq!(source(None).clock(), FrameClock::Own);
    assert_eq!(read(None).last(), Some(&(4.0, 4)));
}

#[test]
fn a_picture_that_keeps_the_others_names_from_being_times_is_named() {
    for (more, said) in [
        ("cover", "1 of the 4 pictures, cover first, are not named by a time"),
        ("102.10", "102.10 first, are not named by a time"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        for name in ["102.05", "102.1", "102.15", more] {
            write_png(&folder.path().join(format!("{name}.png")), &picture(0)).unwrap();
        }
        let source = FrameSource::open(folder.path().to_str().unwrap(), &SourceOptions::default()).unwrap();
        assert_eq!(source.clock(), FrameClock::Guessed);
        let doubt = source.times_doubt().unwrap().to_string();
        assert!(doubt.contains(said), "{doubt}");
    }
}

#[test]
fn an_input_that_is_not_there_says_what_may_be_meant() {
    for (input, said) in [
        ("0", "/dev/video0"),
        ("12", "/dev/video12"),
        ("/dev/video77", "ls /dev/video*"),
        ("pictures/*.png", "patterns"),
        ("frame_%06d.png", "patterns"),
        ("gone.mp4", "a video file"),
    ] {
        let refused = FrameSource::open(input, &SourceOptions::default()).unwrap_err().to_string();
        assert!(refused.contains(&format!("no {input}")) && refused.contains(said), "{refused}");
    }
}
