//! `run --map`: where the vehicle is on the map.

use std::fs;

use fingerpost_format::FixStatus;
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames};

#[test]
fn a_map_gives_every_frame_a_fix_with_a_route_and_without() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let line = |out: &str| drive.run_line(&drive.path(), &folder.path().join(out));
    let map = drive.map().display().to_string();
    call_line(&format!("{} --frames 20", line("without"))).done();
    assert!(frames(&folder.path().join("without")).iter().all(|record| record.fix.is_none()));

    // Where the drive starts, 5 m along its route.
    let located = format!("--frames 20 --map {map} --near 47.0,9.500066");
    call_line(&format!("{} {located}", line("routed"))).done();
    let route = format!(" --route {} --start-m 5", drive.route().display());
    let roaming = line("roaming");
    assert!(roaming.contains(&route), "{roaming}");
    call_line(&format!("{} {located}", roaming.replace(&route, ""))).done();
    for run in ["routed", "roaming"] {
        let fixes: Vec<_> =
            frames(&folder.path().join(run)).into_iter().filter_map(|record| record.fix).collect();
        assert_eq!(fixes.len(), 20, "{run}");
        for fix in &fixes {
            let off_m = libm::hypot(fix.lat - 47.0, (fix.lon - 9.500_1) * 0.68) * 111_000.0;
            assert!(off_m < 60.0 && fix.sigma_m < 25.0, "{run}: {fix:?}");
            assert!(fix.status.is_some_and(|status| status != FixStatus::Lost), "{run}: {fix:?}");
        }
        assert!(fixes[19].sigma_m > 0.0 && (fixes[19].lon - fixes[0].lon).abs() > 2e-5, "{run}: it moves");
    }
}

#[test]
fn a_place_or_gps_needs_roads_and_stills_are_nowhere() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), &folder.path().join("out"));
    let route = format!(" --route {} --start-m 5", drive.route().display());
    let roaming = line.replace(&route, "");
    call_line(&format!("{roaming} --near 47.0,9.5")).refused(2, &["--map"]);
    let track = folder.path().join("track.gpx");
    fs::write(&track, "<gpx/>").unwrap();
    call_line(&format!("{roaming} --gps {}", track.display())).refused(2, &["--route", "--map"]);
    call_line(&format!("{roaming} --stills --map {}", drive.map().display())).refused(2, &["--stills"]);
}
