//! How much the program says: `-q`, `-v` and `RUST_LOG`.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{Called, command, frames};

/// A run of four frames with `before` the arguments that all runs have, and `RUST_LOG` where one is given.
fn run(before: &str, rust_log: Option<&str>, out: &Path) -> Called {
    let drive = Drive::get();
    let line = format!(
        "{before} {} --map {} --truth {} --frames 4 --no-recording",
        drive.run_line(&drive.path(), out),
        drive.map().display(),
        drive.truth().display()
    );
    let mut command = command();
    if let Some(filter) = rust_log {
        command.env("RUST_LOG", filter);
    }
    Called::from(command.args(line.split_whitespace()).output().unwrap()).done()
}

/// Lines that are records of the log, and the messages; without the rate, which is the clock's.
fn records_and_messages(called: &Called) -> (Vec<&str>, Vec<&str>) {
    called.stderr.lines().filter(|line| !line.contains(" a second")).partition(|line| line.starts_with('['))
}

#[test]
fn quiet_says_nothing_but_errors_and_does_the_same() {
    let folder = TempDir::new().unwrap();
    let (usual, quiet) = (folder.path().join("usual"), folder.path().join("quiet"));
    assert!(run("", None, &usual).stderr.contains("results in"));
    // Whatever the environment asks for.
    let called = run("-q", Some("trace"), &quiet);
    assert_eq!((called.stdout.as_str(), called.stderr.as_str()), ("", ""));
    let config = |run: &Path| fs::read_to_string(run.join("config.toml")).unwrap();
    assert_eq!(config(&quiet), config(&usual));
    let why = |run: &Path| frames(run).into_iter().map(|frame| frame.why).collect::<Vec<_>>();
    assert_eq!(why(&quiet), why(&usual));

    let failed = Called::from(
        command().args(["route", "--quiet", "--map", "none.osm"]).args(TO_NOWHERE).output().unwrap(),
    );
    failed.refused(1, &["fingerpost: ", "none.osm"]);
}

const TO_NOWHERE: [&str; 6] = ["--from", "47,9.5", "--to", "47.0005,9.5006", "--out", "none.geojson"];

#[test]
fn verbose_says_besides_what_was_read_and_chosen_and_how_long_it_took() {
    let folder = TempDir::new().unwrap();
    let usual = run("", None, folder.path());
    let (none, messages) = records_and_messages(&usual);
    assert!(none.is_empty(), "{none:?}");
    let verbose = run("-v", None, folder.path());
    let (records, same) = records_and_messages(&verbose);
    assert_eq!(same, messages, "the messages stay as they are");
    for fact in [
        "camera.toml: camera of 320 x 240 pixels, focal length 210.0 pixels",
        "planned.geojson: route of ",
        "with 1 feature (junction 1)",
        "map.osm: map with 2 roads, of 3 straight pieces between 4 nodes",
        "truth.jsonl: truth of 80 frames",
        "the drive begins at 5.0 m on the route",
        "pictures are used at 320 x 240 pixels",
        "kernels use ",
        "road: ",
        "summary and report took ",
        "done after ",
    ] {
        assert!(records.iter().any(|record| record.contains(fact)), "{fact:?} is not in {records:#?}");
    }
    assert!(
        verbose.stderr.contains("80 frames, 10.000 a second, decoded picture by picture"),
        "{}",
        verbose.stderr
    );
    assert!(!records.iter().any(|record| record.contains("frame 3: ")), "{records:#?}");

    let every_frame = run("-vv", None, folder.path());
    let (records, same) = records_and_messages(&every_frame);
    assert_eq!(same, messages);
    for frame in 0..4 {
        let said = format!("[DEBUG fingerpost::recorder] frame {frame}: Searching: ");
        assert!(records.iter().any(|record| record.starts_with(&said)), "{said:?} is not in {records:#?}");
    }
}

#[test]
fn settings_that_are_not_the_default_are_named() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let config = folder.path().join("own.toml");
    fs::write(&config, "[track]\ndetect_present = 0.9\n").unwrap();
    let line = drive.run_line(&drive.path(), &folder.path().join("run"));
    let line = format!("{line} --verbose --frames 1 --config {}", config.display());
    let called = Called::from(command().args(line.split_whitespace()).output().unwrap()).done();
    for fact in ["own.toml: settings that are not the default: 1", "track.detect_present = 0.9 (default "] {
        assert!(called.stderr.contains(fact), "{}", called.stderr);
    }
}

#[test]
fn the_environment_chooses_by_module_and_level() {
    let folder = TempDir::new().unwrap();
    let usual = run("", None, folder.path());
    let (_, messages) = records_and_messages(&usual);
    // Times differ, and what they are of does not.
    let said = |called: &Called| -> Vec<String> {
        let of = |record: &&str| {
            !record.contains(" ms ") && !record.contains(" took ") && !record.contains("done after")
        };
        records_and_messages(called).0.into_iter().filter(of).map(str::to_owned).collect()
    };
    let (verbose, by_level) = (run("-v", None, folder.path()), run("", Some("info"), folder.path()));
    assert_eq!(said(&by_level), said(&verbose));
    let inputs = run("", Some("fingerpost::inputs=info"), folder.path());
    let (records, same) = records_and_messages(&inputs);
    assert_eq!(same, messages);
    assert_eq!(records.len(), 4, "camera, route, map and truth: {records:#?}");
    assert!(records.iter().all(|record| record.starts_with("[INFO fingerpost::inputs] ")), "{records:#?}");
    let off = run("", Some("off"), folder.path());
    assert_eq!(records_and_messages(&off), (Vec::new(), messages.clone()));
    let wrong = run("", Some("fingerpost=loud"), folder.path());
    let (_, with_warning) = records_and_messages(&wrong);
    assert!(
        with_warning[0].starts_with("RUST_LOG is not used: ") && with_warning[0].contains("loud"),
        "{with_warning:?}"
    );
    assert_eq!(with_warning[1..], messages[..]);
}

/// What is started in place of ffmpeg is read as ffmpeg is: its own failure is said, and nothing of a filter.
#[cfg(unix)]
#[test]
fn a_filter_that_cannot_be_used_is_no_message_of_what_is_started() {
    let started = |program: &str| {
        let mut command = command();
        command.env("RUST_LOG", "fingerpost=loud").args(["tether", &std::process::id().to_string(), program]);
        Called::from(command.output().unwrap())
    };
    assert_eq!(started("true").done().stderr, "");
    let missing = started("/none/ffmpeg");
    missing.refused(1, &["/none/ffmpeg cannot be run", "check its installation"]);
    assert_eq!(missing.stderr.lines().count(), 1, "{}", missing.stderr);
}
