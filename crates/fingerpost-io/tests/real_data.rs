//! Recorded drives in the folder named by FINGERPOST_DATA; missing data is a failure.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::{env, fs, path::PathBuf};

use fingerpost_io::{FrameSource, SourceOptions, read_picture};

fn data(name: &str) -> PathBuf {
    PathBuf::from(env::var("FINGERPOST_DATA").unwrap()).join(name)
}

/// Number of frames, the rate, and their size, which must be the same for all.
fn frames_of(name: &str) -> (usize, f64, (usize, usize)) {
    let mut source = FrameSource::open(data(name).to_str().unwrap(), &SourceOptions::default()).unwrap();
    let fps = source.fps();
    let mut sizes = Vec::new();
    while let Some(frame) = source.next() {
        let picture = frame.picture.unwrap();
        sizes.push(picture.size());
        source.recycle(picture);
    }
    assert!(sizes.windows(2).all(|pair| pair[0] == pair[1]));
    (sizes.len(), fps, sizes[0])
}

#[test]
fn every_picture_of_the_recorded_drives_is_read() {
    assert_eq!(frames_of("kitti/frames00"), (130, 10.0, (1241, 376)));
    assert_eq!(frames_of("kitti/frames06"), (51, 10.0, (1226, 370)));
    assert_eq!(frames_of("camvid/val"), (101, 10.0, (480, 360)));
}

#[test]
fn stills_of_many_cameras_and_programs_are_read() {
    for folder in ["udacity/camera_cal", "udacity/test_images", "unpaved", "bdd", "camvid/valannot"] {
        let entries = fs::read_dir(data(folder)).unwrap();
        let paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
        let is_picture = |path: &&PathBuf| path.extension().is_some_and(|end| end == "jpg" || end == "png");
        let sizes: Vec<(usize, usize)> =
            paths.iter().filter(is_picture).map(|path| read_picture(path).unwrap().size()).collect();
        assert!(sizes.len() >= 4 && sizes.iter().all(|(width, _)| *width >= 300), "{folder}: {sizes:?}");
    }
}

#[test]
fn recorded_videos_have_all_their_frames() {
    assert_eq!(frames_of("udacity/p1_solidWhiteRight.mp4"), (221, 25.0, (960, 540)));
    assert_eq!(frames_of("udacity/p5h_project_video_cut.mp4"), (76, 25.0, (1280, 720)));
    assert_eq!(frames_of("udacity/p5h_test_small1.mp4"), (88, 25.0, (1280, 720)));
}
