//! Signals of the vehicle's bus: the look-up, and a run that uses them.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames};

const DBC: &str = "VERSION \"\"\n\nBU_: CAR\n\nBO_ 180 SPEEDS: 4 CAR\n SG_ SPEED : 7|16@0+ (0.01,0) [0|0] \"km/h\" CAR\n \
    SG_ YAW_RATE : 16|16@1- (0.01,0) [0|0] \"deg/s\" CAR\n\nBO_ 1556 LEVERS: 1 CAR\n SG_ TURN : 0|2@1+ (1,0) [0|3] \"\" CAR\n\n\
    VAL_ 1556 TURN 0 \"none\" 1 \"left\" 2 \"right\" ;\n";
const CONFIG: &str = "[can]\nspeed = \"SPEEDS.SPEED\"\nyaw_rate = \"SPEEDS.YAW_RATE\"\nyaw_rate_positive = \"right\"\n\
    turn_signal = \"LEVERS.TURN\"\n";

/// A log of four seconds at 28 km/h and a degree a second to the right, that signals left from the second second on and falls
/// silent after the third; and its DBC file and configuration.
fn write_log(folder: &Path) {
    let mut log = String::new();
    for tenth in 0..40 {
        let t_s = 1000.0 + 0.1 * f64::from(tenth);
        if tenth < 30 {
            log.push_str(&format!("({t_s:.6}) can0 0B4#0AF06400\n"));
        }
        log.push_str(&format!("({t_s:.6}) can0 614#0{}\n", if tenth < 10 { 0 } else { 1 }));
    }
    fs::write(folder.join("drive.log"), log).unwrap();
    fs::write(folder.join("car.dbc"), DBC).unwrap();
    fs::write(folder.join("fingerpost.toml"), CONFIG).unwrap();
}

#[test]
fn a_log_is_decoded() {
    let folder = TempDir::new().unwrap();
    write_log(folder.path());
    let at = folder.path().display();
    let called = call_line(&format!(
        "can {at}/drive.log --dbc {at}/car.dbc --config {at}/fingerpost.toml --out {at}/signals.csv --json"
    ))
    .done();
    assert!(called.stderr.contains("speed_mps (SPEEDS.SPEED): 30 samples"), "{}", called.stderr);
    let facts: serde_json::Value = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(
        (facts[0]["quantity"].as_str(), facts[0]["samples"].as_u64()),
        (Some("yaw_rate_rps"), Some(30))
    );
    let csv = fs::read_to_string(folder.path().join("signals.csv")).unwrap();
    let lines: Vec<&str> = csv.lines().collect();
    assert_eq!(lines[0], "log_s,t_s,yaw_rate_rps,speed_mps,turn_signal");
    assert_eq!(lines[1], "1000.000000,0.000000,-0.017453,,");
    assert_eq!(lines[2], "1000.000000,0.000000,,7.777778,");
    assert_eq!(*lines.last().unwrap(), "1003.900000,3.900000,,,1.000000");
    assert_eq!(lines.len(), 1 + 30 + 30 + 40);
}

#[test]
fn a_run_takes_signals_while_they_come_and_says_when_they_do_not() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    write_log(folder.path());
    let (at, out) = (folder.path().display(), folder.path().join("run"));
    let line = drive.run_line(&drive.path(), &out);
    call_line(&format!(
        "{line} --frames 40 --can {at}/drive.log --dbc {at}/car.dbc --config {at}/fingerpost.toml"
    ))
    .done();
    let signals: Vec<_> = frames(&out).into_iter().map(|record| record.signals.unwrap()).collect();
    assert_eq!((signals[5].speed_mps, signals[5].turn_signal.as_str()), (Some(7.7778), "off"));
    assert!((signals[5].yaw_rate_rps.unwrap() + 0.017453).abs() < 1e-6);
    assert_eq!(signals[15].turn_signal, "left");
    assert!(signals[20].not_used.is_empty() && signals[20].source["speed"] == "can");
    let silent = &signals[37];
    assert_eq!((silent.not_used["speed"].as_str(), silent.source["speed"].as_str()), ("late", "camera"));
    assert!(silent.speed_mps.is_some() && silent.source["turn_signal"] == "can");
}

#[test]
fn wrong_names_are_answered_with_what_to_do() {
    let folder = TempDir::new().unwrap();
    write_log(folder.path());
    let at = folder.path().display();
    let call = |config: &str| {
        fs::write(folder.path().join("fingerpost.toml"), config).unwrap();
        call_line(&format!("can {at}/drive.log --dbc {at}/car.dbc --config {at}/fingerpost.toml"))
    };
    call("[can]\nspeed = \"SPEEDS.SPED\"\n").refused(1, &["can.speed", "no signal", "SPEEDS.SPEED"]);
    call("").refused(1, &["names no signal", "can.yaw_rate"]);
    call("[can]\nturn_signal = \"LEVERS.TURN\"\nturn_signal_left = \"up\"\n")
        .refused(1, &["can.turn_signal_left", "none, left, right"]);
    call("[can]\nturn_signal = \"LEVERS.TURN\"\nturn_signal_left = 7\n").done();
    call("[can]\nmax_age_s = -1\n").refused(1, &["can.max_age_s"]);
    let (drive, out) = (Drive::get(), folder.path().join("run"));
    let line = drive.run_line(&drive.path(), &out);
    fs::write(folder.path().join("fingerpost.toml"), CONFIG.replace("can]", "can]\ninterface = \"can7\""))
        .unwrap();
    let run = |can: &str| {
        call_line(&format!("{line} --can {can} --dbc {at}/car.dbc --config {at}/fingerpost.toml"))
    };
    run(&format!("{at}/drive.log")).refused(1, &["no frame with", "can.interface", "never came", "can0"]);
    run(&format!("{at}/car.dbc")).refused(1, &["no CAN log"]);
    run("socketcan:nosuchbus0")
        .refused(1, &["SocketCAN"].map(|word| if cfg!(feature = "socketcan") { "nosuchbus0" } else { word }));
    call_line(&format!("{line} --can x")).refused(2, &["--dbc"]);
}

#[test]
fn what_has_no_value_in_j1939_is_counted_said_and_not_used() {
    let folder = TempDir::new().unwrap();
    let at = folder.path().display();
    // Wheel-based vehicle speed of CCVS1 (65265), from anyone.
    let dbc = "VERSION \"\"\n\nBU_: E\n\nBO_ 2566844926 CCVS1: 8 E\n SG_ SPEED : 8|16@1+ (0.00390625,0) [0|250] \"km/h\" E\n";
    fs::write(folder.path().join("truck.dbc"), dbc).unwrap();
    fs::write(folder.path().join("can.toml"), "[can]\nspeed = \"CCVS1.SPEED\"\n").unwrap();
    let log = |messages: &[&str]| {
        let lines = messages.iter().enumerate();
        let lines = lines.map(|(i, id)| format!("({}.0) can0 {id}\n", 100 + i));
        fs::write(folder.path().join("truck.log"), lines.collect::<String>()).unwrap();
    };
    let line = format!("{at}/truck.log --dbc {at}/truck.dbc --config {at}/can.toml");
    // 64 km/h, by the engine at two priorities; not available and in error from another address.
    log(&["18FEF100#000040FFFFFFFFFF", "0CFEF100#000040", "18FEF10B#00FFFF", "18FEF10B#0012FE"]);
    let called = call_line(&format!("can {line} --out {at}/signals.csv --json")).done();
    let facts: serde_json::Value = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!((facts[0]["samples"].as_u64(), facts[0]["without_value"].as_u64()), (Some(2), Some(2)));
    assert!(facts[0]["max"].as_f64().is_some_and(|mps| (mps - 64.0 / 3.6).abs() < 1e-9), "{facts}");
    let said = &called.stderr;
    assert!(said.contains("no value in 2 of 4 messages: 1 say that it is not available and 1"), "{said}");
    assert!(said.contains("2.0 s after") && said.contains("several senders, 18FEF100, 18FEF10B,"), "{said}");
    assert_eq!(fs::read_to_string(folder.path().join("signals.csv")).unwrap().lines().count(), 3);

    log(&["18FEF100#00FFFF", "18FEF100#00FFFF"]);
    let (drive, out) = (Drive::get(), folder.path().join("run"));
    call_line(&format!("{} --can {line}", drive.run_line(&drive.path(), &out)))
        .refused(1, &["says no value of any signal", "2 of 2 messages"]);
}
