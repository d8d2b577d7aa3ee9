//! Recorded drives in the folder named by FINGERPOST_DATA; missing data is a failure.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used)]

use std::{env, fs, path::PathBuf};

use fingerpost_io::{CanDatabase, FrameSource, SignalLog, SourceOptions, read_picture};

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

/// Mean of the values within half a window of a time.
fn mean_about(series: &[(f64, f64)], t_s: f64, window_s: f64) -> f64 {
    let from = series.partition_point(|(time_s, _)| *time_s < t_s - window_s / 2.0);
    let to = series.partition_point(|(time_s, _)| *time_s <= t_s + window_s / 2.0);
    series[from..to].iter().map(|(_, value)| value).sum::<f64>() / (to - from) as f64
}

fn correlation(pairs: &[(f64, f64)]) -> f64 {
    let count = pairs.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| pairs.iter().map(of).sum::<f64>() / count;
    let (mean_a, mean_b) = (mean(|pair| pair.0), mean(|pair| pair.1));
    let sum =
        |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|(a, b)| of(a - mean_a, b - mean_b)).sum::<f64>();
    sum(&|a, b| a * b) / (sum(&|a, _| a * a) * sum(&|_, b| b * b)).sqrt()
}

#[test]
fn signals_of_a_recorded_bus_agree_with_other_instruments() {
    let database = CanDatabase::read(&data("can/toyota_2017_ref_pt.dbc")).unwrap();
    let wanted = ["YGS1S03.YR", "VSC1S03.SP1"].map(|name| database.signal(name).unwrap());
    let log = SignalLog::read(&data("can/segment.candump.log.gz"), Some("can0"), &wanted).unwrap();
    let series = |signal: usize| -> Vec<(f64, f64)> {
        log.samples[signal].iter().map(|sample| (sample.t_s, sample.value)).collect()
    };
    let column = |file: &str, column: usize| -> Vec<(f64, f64)> {
        let text = fs::read_to_string(data(file)).unwrap();
        let numbers =
            |line: &str| line.split(',').map(|number| number.parse().unwrap()).collect::<Vec<f64>>();
        text.lines().skip(1).map(|line| (numbers(line)[0], numbers(line)[column])).collect()
    };
    // The gyroscope's z axis points down. A bit of the yaw rate is 0.24 degrees a second, a fifth of all that it does
    // here, and the gyroscope feels the engine: both are averaged over half a second.
    let (yaw, gyro) = (series(0), column("can/gyro.csv", 3));
    let window_s = 0.5;
    let times_s: Vec<f64> = (5..550).map(|tenth| log.first_s + 0.1 * f64::from(tenth)).collect();
    let best = (-20..=20)
        .map(|step| {
            let later_s = 0.01 * f64::from(step);
            let pair =
                |&t_s: &f64| (mean_about(&yaw, t_s + later_s, window_s), -mean_about(&gyro, t_s, window_s));
            correlation(&times_s.iter().map(pair).collect::<Vec<_>>())
        })
        .fold(f64::NEG_INFINITY, f64::max);
    assert!(best > 0.95, "yaw rate and gyroscope agree: r = {best}");

    let (speed, wheels) = (series(1), column("can/speed.csv", 1));
    for t_s in times_s {
        let (of_bus, of_file) = (mean_about(&speed, t_s, window_s) / 3.6, mean_about(&wheels, t_s, window_s));
        assert!((of_bus - of_file).abs() < 0.6, "{t_s}: {of_bus} and {of_file} m/s");
    }
}
