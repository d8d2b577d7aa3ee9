//! A lens of which a part is covered.

use std::fs;
use std::path::Path;

use fingerpost_format::TrackState;
use fingerpost_io::{read_picture, read_truth, write_png};
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{call_line, frames, summary};

/// Frames after which a cover is named: as many looks as it takes to be certain of day, and of a block that black is a cover.
const NAMED_WITHIN: u64 = 15;
/// The junction is arrived at where the vehicle's front is at its mouth: its node is that near then, metres.
const AT_THE_JUNCTION_M: f64 = 15.0;

/// The drive's pictures with the lower third black.
fn black_below(drive: &Drive, folder: &Path) {
    for index in 0..FRAMES {
        let name = format!("{index:06}");
        let mut picture = read_picture(&drive.path().join("frames").join(format!("{name}.jpg"))).unwrap();
        for row in 2 * picture.height() / 3..picture.height() {
            picture.row_mut(row).fill(0);
        }
        write_png(&folder.join(format!("{name}.png")), &picture).unwrap();
    }
}

#[test]
fn a_black_lower_third_is_named_with_its_share_and_nothing_is_read_out_of_it() {
    let (drive, pictures, out) = (Drive::get(), TempDir::new().unwrap(), TempDir::new().unwrap());
    black_below(drive, pictures.path());
    let line = drive.run_line(pictures.path(), out.path());
    let called = call_line(&format!("{line} --fps 10 --truth {}", drive.truth().display())).done();
    assert!(
        called.stderr.contains("of the camera's picture did not move with the rest"),
        "{}",
        called.stderr
    );

    let (records, truth) = (frames(out.path()), read_truth(&drive.truth()).unwrap());
    let share = |index: usize| records[index].camera.and_then(|camera| camera.covered_share);
    let first = (0..FRAMES).find(|&index| share(index).is_some()).unwrap();
    let covered = summary(out.path()).covered.unwrap();
    assert!(covered.first_frame == first as u64 && covered.first_frame <= NAMED_WITHIN, "{covered:?}");
    assert_eq!(covered.frames, (FRAMES - first) as u64, "it stays covered");
    let most = (first..FRAMES).map(|index| share(index).unwrap()).fold(0.0, f64::max);
    assert!((covered.most_share - most).abs() < 1e-9 && (0.3..0.4).contains(&most), "{covered:?}");

    for (record, truth) in records.iter().zip(&truth) {
        let ahead_m = truth.feature_forward_m.unwrap_or(0.0);
        let has_arrived = record.state == TrackState::Arrived;
        assert!(!has_arrived || ahead_m < AT_THE_JUNCTION_M, "{}: {ahead_m} m", record.frame);
    }
    let (seen_m, true_m) = (first + 5..FRAMES)
        .map(|index| {
            (records[index].motion.map_or(0.0, |motion| motion.forward_m), 0.1 * truth[index].speed_mps)
        })
        .fold((0.0, 0.0), |(seen_m, true_m), (of_seen_m, of_true_m)| {
            (seen_m + of_seen_m, true_m + of_true_m)
        });
    assert!((seen_m / true_m - 1.0).abs() < 0.05, "{seen_m} m of {true_m} m");
    let wide = records[first..]
        .iter()
        .filter_map(|record| record.lanes.as_ref()?.width_m)
        .find(|&width_m| width_m > 3.5);
    assert_eq!(wide, None, "edges of the cover in place of the lane's");
}

#[test]
fn a_drive_through_a_clear_lens_says_nothing_of_a_cover() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    call_line(&drive.run_line(&drive.path(), out.path())).done();
    for file in ["frames.jsonl", "summary.json"] {
        assert!(!fs::read_to_string(out.path().join(file)).unwrap().contains("covered"), "{file}");
    }
}
