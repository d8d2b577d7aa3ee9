//! The road's middle by its surface, on a simulated drive.

use fingerpost_format::{TruthRecord, from_json_lines};
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames};

/// Metres of the way to the junction, at 46 m, on which the window shows nothing but the street.
const STREET_M: f64 = 28.0;

#[test]
fn the_streets_middle_is_found_and_steered_beside() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    call_line(&drive.run_line(&drive.path(), out.path())).done();
    let truth: Vec<TruthRecord> = from_json_lines(&std::fs::read_to_string(drive.truth()).unwrap()).unwrap();
    // The route's first street leads east along the map's x axis, which is its middle.
    let on_street = frames(out.path()).into_iter().zip(truth).filter(|(_, truth)| truth.x_m < STREET_M);
    let (mut errors_m, mut missing) = (Vec::new(), 0);
    for (record, truth) in on_street {
        let Some(centreline) = record.centreline else {
            missing += 1;
            continue;
        };
        errors_m.push((centreline.offset_m + truth.y_m / libm::cos(truth.heading_rad)).abs());
        assert!((centreline.heading_rad + truth.heading_rad).abs() < 0.1, "frame {}", record.frame);
        // The vehicle keeps to the right, where it is: there is little to steer.
        assert!(
            centreline.offset_m > 0.5 && centreline.steer_rad.is_some_and(|rad| rad.abs() < 0.15),
            "{centreline:?}"
        );
    }
    errors_m.sort_by(f64::total_cmp);
    assert!(errors_m.len() > 20 && missing <= 2, "{} frames, {missing} without", errors_m.len());
    let p95_m = errors_m[errors_m.len() * 95 / 100];
    assert!(p95_m < 0.25, "{p95_m}");
}

#[test]
fn it_can_be_switched_off() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (config, out) = (folder.path().join("fingerpost.toml"), folder.path().join("run"));
    std::fs::write(&config, "[centreline]\nenabled = false\n").unwrap();
    let line = drive.run_line(&drive.path(), &out);
    call_line(&format!("{line} --frames 3 --config {}", config.display())).done();
    assert!(frames(&out).iter().all(|record| record.centreline.is_none()));
}
