//! Searches of settings.

use std::fs;
use std::path::Path;
use std::process::Stdio;
use std::thread;
use std::time::{Duration, Instant};

use fingerpost_format::{TuningFront, TuningTrial, from_json_lines};
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, command};

/// Three trials on the small drive and on its first half, which is held back.
fn line(half: &Path, out: &Path) -> String {
    format!(
        "tune --drives {} {} --start-m 5 --held-out 0.5 --keys road_surface.bank.frames,track.detect_present=0.6..0.9 --trials 3 \
         --population 2 --threads 1 --out {}",
        Drive::get().path().display(),
        half.display(),
        out.display()
    )
}

/// The first half of the small drive as a drive folder of its own.
fn half() -> TempDir {
    let (drive, half) = (Drive::get(), TempDir::new().unwrap());
    fs::rename(drive.pictures(40).keep(), half.path().join("frames")).unwrap();
    for path in [drive.camera(), drive.path().join("route.geojson"), drive.truth()] {
        fs::copy(&path, half.path().join(path.file_name().unwrap())).unwrap();
    }
    half
}

fn trials(out: &Path) -> Vec<TuningTrial> {
    from_json_lines(&fs::read_to_string(out.join("trials.jsonl")).unwrap_or_default()).unwrap_or_default()
}

#[test]
fn a_search_that_was_killed_ends_with_the_same_front() {
    let (half, whole, killed) = (half(), TempDir::new().unwrap(), TempDir::new().unwrap());
    let called = call_line(&format!("{} --json", line(half.path(), whole.path()))).done();
    assert!(called.stderr.contains("defaults") && called.stderr.contains("held back"), "{}", called.stderr);
    let read = |out: &Path| fs::read_to_string(out.join("front.json")).unwrap();
    let front: TuningFront = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(front, serde_json::from_str(&read(whole.path())).unwrap());
    assert_eq!((front.trials, front.drives, front.defaults.trial), (3, [1, 1], 0));
    assert!(front.front.iter().all(|point| point.tuned.is_some() && point.held_back.is_some()));
    assert_eq!(front.defaults.settings["road_surface.bank.frames"], 5);
    assert!(fs::read_to_string(whole.path().join("report.html")).unwrap().contains("<svg"));

    let mut child = command()
        .args(line(half.path(), killed.path()).split_whitespace())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let begun = Instant::now();
    while trials(killed.path()).is_empty() && begun.elapsed() < Duration::from_secs(300) {
        thread::sleep(Duration::from_millis(10));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let before = trials(killed.path()).len();
    assert!((1..5).contains(&before) && !killed.path().join("front.json").exists(), "{before} trials");
    // As if the program had been killed in the middle of a line.
    let path = killed.path().join("trials.jsonl");
    let recorded = fs::read_to_string(&path).unwrap();
    fs::write(&path, format!("{recorded}{{\"trial\":")).unwrap();
    call_line(&line(half.path(), killed.path()).replace("--threads 1", "--threads 2")).done();
    assert!(fs::read_to_string(&path).unwrap().starts_with(&recorded), "what was recorded is not done again");
    assert_eq!(read(whole.path()), read(killed.path()));

    let config = whole.path().join(front.front[0].config.as_ref().unwrap());
    let run = TempDir::new().unwrap();
    let run_line = Drive::get().run_line(&Drive::get().path(), run.path());
    call_line(&format!("{run_line} --frames 2 --config {}", config.display())).done();
    call_line(&line(half.path(), whole.path()).replace("--population 2", "--population 3"))
        .refused(1, &["another search", "population", "another folder"]);
    let truth = half.path().join("truth.jsonl");
    fs::write(&truth, format!("{}\n", fs::read_to_string(&truth).unwrap())).unwrap();
    call_line(&line(half.path(), whole.path())).refused(1, &["another search", "drives", "another folder"]);
}

#[test]
fn what_cannot_be_searched_is_refused_before_any_work() {
    let (half, folder) = (half(), TempDir::new().unwrap());
    let out = folder.path().join("out");
    let with = |keys: &str| line(half.path(), &out).replace("road_surface.bank.frames", keys);
    call_line(&with("track.detect_presen"))
        .refused(1, &["track.detect_presen;", "track.detect_present", "schema"]);
    call_line(&with("road_surface.bank.frames=0..5"))
        .refused(1, &["road_surface.bank.frames", "0..5", "1 to 1000"]);
    call_line(&with("vehicle.width_m")).refused(1, &["vehicle.width_m", "each drive"]);
    call_line(&with("road_surface.bank.frames").replace("--population 2", "--population 4"))
        .refused(1, &["--population 4", "--trials 3"]);
    call_line(&format!("{} --objectives false", with("road_surface.bank.frames"))).refused(1, &["missed"]);
    call_line(&line(&Drive::get().path(), &out)).refused(1, &["twice", "held back"]);
    fs::remove_file(half.path().join("truth.jsonl")).unwrap();
    call_line(&line(half.path(), &out)).refused(1, &["truth.jsonl", "simulate"]);
    assert!(!out.exists());
}
