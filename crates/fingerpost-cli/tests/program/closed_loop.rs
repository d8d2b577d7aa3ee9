//! Drives in which the advice moves the vehicle.

use std::fs;
use std::path::Path;

use fingerpost_format::{LoopDrive, LoopEnd, from_json_lines};
use tempfile::TempDir;

use crate::program::call_line;

/// Small pictures, few of them, a short route: what is tried is the loop, not how well it drives.
fn small(out: &Path, more: &str) -> String {
    let out = out.display();
    format!(
        "campaign --closed-loop --features 1 --conditions ideal --size 96x72 --fps 4 --seed 5 --out {out} {more}"
    )
}

fn drives(out: &Path) -> Vec<LoopDrive> {
    from_json_lines(&fs::read_to_string(out.join("closed_loop.jsonl")).unwrap()).unwrap()
}

#[test]
fn a_campaign_that_was_ended_goes_on_where_it_was() {
    let out = TempDir::new().unwrap();
    call_line(&small(out.path(), "--drives 1 --controllers stanley")).done();
    let first = drives(out.path());
    assert_eq!(first.len(), 1);
    assert!(first[0].frames > 10 && first[0].error.is_none(), "{first:?}");
    // A line that a killed program left without its end is no drive.
    let path = out.path().join("closed_loop.jsonl");
    let torn = format!("{}{{\"seed\": 6, \"cond", fs::read_to_string(&path).unwrap());
    fs::write(&path, torn).unwrap();
    let called = call_line(&small(out.path(), "--drives 2 --controllers stanley")).done();
    assert!(called.stderr.contains("1 of 2 drives are done already"), "{}", called.stderr);
    let both = drives(out.path());
    assert_eq!((both.len(), &both[0]), (2, &first[0]));
    assert!(out.path().join("closed_loop.json").exists() && out.path().join("report.html").exists());
    // Drives of other settings are not mixed with these.
    call_line(&small(out.path(), "--drives 2 --controllers stanley --fault late"))
        .refused(1, &["another campaign", "fault"]);
}

#[test]
fn a_drive_follows_from_its_seed_and_a_report_does_not_change_it() {
    let (plain, reported) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    call_line(&small(plain.path(), "--drives 1 --controllers fuzzy --threads 1")).done();
    call_line(&small(reported.path(), "--drives 1 --controllers fuzzy --threads 2 --reports")).done();
    assert_eq!(drives(plain.path()), drives(reported.path()));
    let run = reported.path().join("ideal_5_fuzzy");
    assert!(fs::read_to_string(run.join("plan.svg")).unwrap().starts_with("<svg"));
    let frames = fs::read_to_string(run.join("loop.jsonl")).unwrap().lines().count() as u64;
    assert_eq!(frames, drives(plain.path())[0].frames);
}

/// Whatever is wrong with pictures, GPS or map, a drive comes to an end of its own: it arrives, or it stops, or it is found
/// beside the road or the route; it gives no error, and it is not driven on for ever.
#[test]
fn a_drive_with_a_fault_comes_to_an_end() {
    // One of each kind: of a camera's line, of GPS, of the map.
    let faults = ["reordered", "gps_jumps", "node_moved"];
    for fault in faults {
        let out = TempDir::new().unwrap();
        let more = format!("--drives 1 --controllers pure_pursuit --fault {fault}");
        call_line(&small(out.path(), &more)).done();
        let drive = drives(out.path()).remove(0);
        assert!(drive.error.is_none() && drive.end != LoopEnd::Failed, "{fault}: {drive:?}");
        assert_ne!(drive.end, LoopEnd::TimedOut, "{fault}: {drive:?}");
    }
}

/// A camera that goes blind for good: the vehicle does not arrive, it stops and says that it is lost.
#[test]
fn a_vehicle_whose_camera_goes_blind_stops_and_says_that_it_is_lost() {
    let out = TempDir::new().unwrap();
    let line = format!(
        "campaign --closed-loop --features 1 --conditions clear --size 160x120 --seed 9820 --drives 1 \
         --controllers pure_pursuit --fault blind --out {}",
        out.path().display()
    );
    call_line(&line).done();
    let drive = drives(out.path()).remove(0);
    assert_eq!(drive.end, LoopEnd::StoppedLost, "{drive:?}");
    assert!(drive.because.contains("lost"), "{}", drive.because);
}

/// A clear drive of 260 m with three turns, on which the vehicle arrives without a fault.
const WITH_TURNS: u32 = 9823;

/// The clear drive of a seed with this fault.
fn drive_with(seed: u32, fault: &str) -> LoopDrive {
    let out = TempDir::new().unwrap();
    let line = format!(
        "campaign --closed-loop --features 1 --conditions clear --size 160x120 --seed {seed} --drives 1 --controllers fuzzy \
         --fault {fault} --out {}",
        out.path().display()
    );
    call_line(&line).done();
    drives(out.path()).remove(0)
}

fn arrives_on_the_road(seed: u32, fault: &str) {
    let drive = drive_with(seed, fault);
    assert_eq!(drive.end, LoopEnd::Arrived, "{drive:?}");
    assert_eq!(drive.claimed_off_frames, 0, "{drive:?}");
}

fn gets_to_the_end(fault: &str) {
    let drive = drive_with(WITH_TURNS, fault);
    assert!(matches!(drive.end, LoopEnd::Arrived | LoopEnd::ArrivedOffRoad), "{drive:?}");
    assert!(drive.claimed_off_frames < 20, "{drive:?}");
}

/// One picture in five does not arrive: the motion between those that do is twice as long, and the line that was seen is kept. Of four
/// drives two arrive, this one and that of 9824.
#[test]
fn a_vehicle_that_misses_pictures_arrives() {
    arrives_on_the_road(9825, "dropped");
}

/// The same picture for a second, every eight seconds: it shows no motion, which the vehicle's speed gives the lie; the line that
/// was seen is driven along, slower.
#[test]
fn a_vehicle_whose_picture_freezes_for_a_second_arrives() {
    arrives_on_the_road(WITH_TURNS, "frozen");
}

/// Black pictures for a second, every eight seconds: likewise.
#[test]
fn a_vehicle_whose_camera_is_black_for_a_second_arrives() {
    arrives_on_the_road(WITH_TURNS, "black");
}

/// Every picture two frames late: the vehicle is 1 to 2 m farther than it sees, and steers later by as much. It gets to the end of the
/// route, and may cut a corner by half of its width.
#[test]
fn a_vehicle_whose_pictures_are_late_gets_to_the_end() {
    gets_to_the_end("late");
}

/// GPS that is 60 m off for three seconds, every ten: what is found without it is found with it.
#[test]
fn a_vehicle_whose_gps_jumps_arrives() {
    arrives_on_the_road(WITH_TURNS, "gps_jumps");
}

/// One road in four is not on the map, and the route goes round by the others: a junction with an arm more than the map has is found
/// by the arms that it has.
#[test]
fn a_vehicle_whose_map_lacks_roads_arrives() {
    arrives_on_the_road(WITH_TURNS, "road_missing");
}

/// One junction in three is 5 m off on the map: it is found where it is seen.
#[test]
fn a_vehicle_whose_map_has_junctions_elsewhere_arrives() {
    arrives_on_the_road(WITH_TURNS, "node_moved");
}

/// Widths a third off on the map: the vehicle gets to the end of the route. It may come off a road's edge by a wheel's width where a
/// driving line follows the map's width round a corner.
#[test]
fn a_vehicle_whose_map_has_wrong_widths_gets_to_the_end() {
    gets_to_the_end("wrong_width");
}
