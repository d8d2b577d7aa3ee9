//! CAN logs and DBC files through the public face.

// A helper that fails has failed the test that calls it.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use fingerpost_io::{
    CanDatabase, CanDatabaseError, CanId, CanLogError, SignalLayout, SignalLog, SignalReading, UnknownSignal,
    parse_candump_line,
};
use flate2::Compression;
use flate2::write::GzEncoder;
use tempfile::TempDir;

fn shipped(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/can").join(name)
}

fn database() -> CanDatabase {
    CanDatabase::read(&shipped("signals.dbc")).unwrap()
}

fn signals(names: &[&str]) -> Vec<SignalLayout> {
    names.iter().map(|name| database().signal(name).unwrap()).collect()
}

#[test]
fn every_value_is_that_of_cantools() {
    let golden = fs::read_to_string(shipped("cantools.csv")).unwrap();
    let all: BTreeMap<&str, SignalLayout> = golden
        .lines()
        .skip(1)
        .map(|line| line.split(',').nth(1).unwrap())
        .map(|name| (name, database().signal(name).unwrap()))
        .collect();
    assert_eq!(all.len(), 15, "every signal of the file has been decoded at least once");
    let mut frames: BTreeMap<&str, BTreeMap<&str, f64>> = BTreeMap::new();
    for line in golden.lines().skip(1) {
        let [frame, signal, value] = line.split(',').collect::<Vec<_>>().try_into().unwrap();
        frames.entry(frame).or_default().insert(signal, value.parse().unwrap());
    }
    for (text, expected) in frames {
        let line = format!("(0.0) can0 {text}");
        let frame = parse_candump_line(&line).unwrap().unwrap().frame;
        for (name, layout) in &all {
            // A signal that cantools does not find in the frame, being multiplexed out, is not found here either.
            match (layout.decode(&frame).and_then(SignalReading::value), expected.get(name)) {
                (None, None) => {}
                (Some(found), Some(value)) => {
                    assert!((found - value).abs() <= 1e-12 * value.abs(), "{name} in {text}: {found}");
                }
                other => panic!("{name} in {text}: {other:?}"),
            }
        }
    }
}

#[test]
fn lines_of_candump() {
    let frame =
        |line| parse_candump_line(line).map(|frame| frame.map(|f| (f.frame.id, f.frame.data().to_vec())));
    let standard = Some(Some((CanId::Standard(0x123), vec![0x11, 0xaf])));
    assert_eq!(frame("(1436509052.249713) vcan0 123#11AF"), standard);
    assert_eq!(frame("(1.5) can0 123#11af R\r\n"), standard, "a direction may follow");
    assert_eq!(frame("(1.5) can0 123##111AF T\n"), standard, "CAN FD with its flags");
    assert_eq!(frame("(1.5) can0 1F334455#"), Some(Some((CanId::Extended(0x1f33_4455), Vec::new()))));
    assert_eq!(frame("(1.5) can0 123#R4"), Some(None), "a request has no data");
    assert_eq!(frame("(1.5) can0 20000088#0000000000000000"), Some(None), "nor has an error");
    for torn in [
        "",
        "(1.5)",
        "(1.5) can0",
        "(1.5) can0 123",
        "(1.5) can0 123#1",
        "(1.5) can0 123#1G",
        "(1.5) can0 1234#11",
        "(1.5) can0 7FF#+1",
        "(1.5) can0 +12#11",
        "(1.5) can0 -12#11",
        "(1.5) can0 800#11",
        "(1.5) can0 80000123#11",
        "(nan) can0 123#11",
        "1.5 can0 123#11",
        "(1.5) can0 123#11 R more",
        "(1.5) can0 123#11 X",
        "(1.5) can0 123##",
        "(1.5) can0 123##é1",
    ] {
        assert_eq!(frame(torn), None, "{torn}");
    }
    let long = "00".repeat(65);
    assert_eq!(frame(&format!("(1.5) can0 123##0{long}")), None, "longer than any frame");
}

/// Yaw rates of -125 and 0.588 deg/s, and a turn to the left, on two interfaces; a line is torn.
const LOG: &str = "(100.000000) can0 024#0000000000000000\n(100.010000) can1 024#0203000000000000\n\
    (100.5) can0 614#0000001000000000 R\nhalf a li\n(101.0) can0 024#00\n";

#[test]
fn samples_of_a_plain_and_a_compressed_log() {
    let folder = TempDir::new().unwrap();
    let (plain, packed) = (folder.path().join("log"), folder.path().join("log.gz"));
    fs::write(&plain, LOG).unwrap();
    let mut encoder = GzEncoder::new(fs::File::create(&packed).unwrap(), Compression::fast());
    encoder.write_all(LOG.as_bytes()).unwrap();
    encoder.finish().unwrap();
    let wanted = signals(&["KINEMATICS.YAW_RATE", "BLINKERS_STATE.TURN_SIGNALS"]);
    let log = SignalLog::read(&plain, None, &wanted).unwrap();
    assert_eq!(log, SignalLog::read(&packed, None, &wanted).unwrap());
    assert_eq!((log.frames, log.unreadable_lines), (4, 1));
    assert!((log.first_s, log.last_s) == (100.0, 101.0));
    let yaw: Vec<(f64, f64)> = log.samples[0].iter().map(|sample| (sample.t_s, sample.value)).collect();
    assert_eq!(yaw.len(), 2, "the frame that is too short has no yaw rate");
    assert!((yaw[0].1 + 125.0).abs() < 1e-9 && (yaw[1].1 - (515.0 * 0.244 - 125.0)).abs() < 1e-9);
    assert_eq!(wanted[1].value_named("left"), Some(log.samples[1][0].value));
    assert_eq!(wanted[1].value_named("up"), None);
    let of_one = SignalLog::read(&plain, Some("can1"), &wanted).unwrap();
    assert_eq!((of_one.samples[0].len(), of_one.samples[1].len()), (1, 0));

    let torn = folder.path().join("torn.gz");
    let bytes = fs::read(&packed).unwrap();
    fs::write(&torn, &bytes[..bytes.len() - 12]).unwrap();
    let message = SignalLog::read(&torn, None, &wanted).unwrap_err().to_string();
    assert!(message.contains("torn.gz"), "{message}");
}

#[test]
fn a_line_without_end_takes_no_memory_and_no_frame_with_it() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("log");
    let endless = "(1.0) can0 024#".repeat(100_000);
    fs::write(&path, format!("{endless}\n(100.5) can0 024#0203000000000000\n{endless}")).unwrap();
    let log = SignalLog::read(&path, None, &signals(&["KINEMATICS.YAW_RATE"])).unwrap();
    assert_eq!((log.frames, log.unreadable_lines, log.samples[0].len()), (1, 2, 1));
}

#[test]
fn a_log_that_steps_back_in_time_is_refused_with_the_line() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("drive.log");
    let refused_lines = |times_s: &[f64]| {
        let lines: Vec<String> =
            times_s.iter().map(|t_s| format!("({t_s:.3}) can0 123#1122334455667788\n")).collect();
        fs::write(&path, lines.concat()).unwrap();
        match SignalLog::read(&path, None, &signals(&["KINEMATICS.YAW_RATE"])) {
            Ok(log) => {
                assert_eq!(log.frames, times_s.len() as u64);
                None
            }
            Err(CanLogError::Backwards { line, .. }) => Some(line),
            Err(other) => panic!("{other}"),
        }
    };
    let forward: Vec<f64> = (0..200).map(|i| 1e9 + 0.02 * f64::from(i)).collect();
    assert_eq!(refused_lines(&forward), None);
    let backward: Vec<f64> = forward.iter().rev().copied().collect();
    assert_eq!(refused_lines(&backward), Some(52), "a second is allowed");
    for (place, step_s) in [(1, 2.0), (120, 1.5), (199, 1e6), (60, 0.9), (150, 0.0)] {
        let mut times_s = forward.clone();
        times_s[place] -= step_s;
        let is_refused = step_s > 1.0 + 0.02;
        assert_eq!(refused_lines(&times_s), is_refused.then_some(place as u64 + 1), "{place}, {step_s} s");
    }
}

#[test]
fn times_of_no_clock_are_no_lines_of_a_log() {
    for time in ["1e17", "1e300", "-1.7e308", "1.7e308", "inf", "NaN", "10000000001"] {
        assert!(parse_candump_line(&format!("({time}) can0 123#00")).is_none(), "{time}");
    }
    for time in ["0", "-5.5", "1700000000.25", "10000000000"] {
        assert!(parse_candump_line(&format!("({time}) can0 123#00")).is_some(), "{time}");
    }
}

#[test]
fn what_is_no_log_and_no_database_is_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("notes.txt");
    fs::write(&path, "a shopping list\n").unwrap();
    let refused = SignalLog::read(&path, None, &[]).unwrap_err();
    assert!(matches!(refused, CanLogError::NoFrames { lines: 1, .. }), "{refused}");
    fs::write(&path, "").unwrap();
    assert!(matches!(SignalLog::read(&path, None, &[]), Err(CanLogError::NoFrames { lines: 0, .. })));
    assert!(matches!(CanDatabase::read(&path), Err(CanDatabaseError::Contents { .. })), "an empty file");
    fs::write(&path, "BO_ nonsense").unwrap();
    let message = CanDatabase::read(&path).unwrap_err().to_string();
    assert!(message.contains("notes.txt is no DBC file") && !message.contains('\n'), "{message}");
    assert!(matches!(CanDatabase::read(&folder.path().join("none.dbc")), Err(CanDatabaseError::File(_))));
}

#[test]
fn unknown_names_are_answered_with_near_ones() {
    for name in ["KINEMATICS.YAWRATE", "yaw_rate", "KINEMATIC.YAW_RATE"] {
        match database().signal(name).unwrap_err() {
            UnknownSignal::Name { near, .. } => assert_eq!(near[0], "KINEMATICS.YAW_RATE", "{name}"),
            other => panic!("{other}"),
        }
    }
    let message = database().signal("").unwrap_err().to_string();
    assert!(message.contains("names are MESSAGE.SIGNAL"), "{message}");
}

#[test]
fn a_database_that_contradicts_itself_gives_no_signal() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("broken.dbc");
    fs::write(
        &path,
        "VERSION \"Z\u{fc}rich\"\nBO_ 1 A: 8 X\n SG_ WIDE : 0|65@1+ (1,0) [0|0] \"\" X\n SG_ ALONE m1 : 0|8@1+ (1,0) [0|0] \"\" X\n \
         SG_ FAR : 18446744073709551615|8@1+ (1,0) [0|0] \"\" X\n SG_ EMPTY : 0|0@1+ (1,0) [0|0] \"\" X\n \
         SG_ HALF : 0|16@1- (1,0) [0|0] \"\" X\n\
         BO_ 2 B: 8 X\n SG_ P m1M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ Q m1M : 8|8@1+ (1,0) [0|0] \"\" X\n\
         BO_ 65536291 WIDE_ID: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n\
         BO_ 4095 TWELVE_BITS: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n\
         BO_ 2147483939 EXTENDED: 8 X\n SG_ S : 0|8@1+ (1,0) [0|0] \"\" X\n\
         SIG_VALTYPE_ 1 HALF : 1;\nSG_MUL_VAL_ 2 P Q 1-1;\nSG_MUL_VAL_ 2 Q P 1-1;\n",
    )
    .unwrap();
    let broken = CanDatabase::read(&path).unwrap();
    for name in ["A.WIDE", "A.FAR", "A.EMPTY"] {
        assert!(matches!(broken.signal(name), Err(UnknownSignal::Size { .. })), "{name}");
    }
    for (name, identifier) in [("WIDE_ID.S", 65_536_291), ("TWELVE_BITS.S", 4095)] {
        let expected = UnknownSignal::Identifier { name: name.to_owned(), identifier };
        assert_eq!(broken.signal(name).unwrap_err(), expected);
    }
    assert_eq!(broken.signal("EXTENDED.S").unwrap().message, CanId::Extended(291));
    assert!(matches!(broken.signal("A.HALF"), Err(UnknownSignal::Float { size: 16, .. })));
    for name in ["A.ALONE", "B.P"] {
        assert!(matches!(broken.signal(name), Err(UnknownSignal::Multiplexer { .. })), "{name}");
    }
}
