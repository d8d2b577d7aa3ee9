//! A run on a simulated drive.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use fingerpost_format::{FrameRecord, TrackState};
use fingerpost_vision::simd::CodePath;
use tempfile::TempDir;

use crate::drive::{Drive, FRAMES};
use crate::program::{call_line, frames, summary};

/// Frames without what the clock says.
fn timeless(run: &Path) -> Vec<FrameRecord> {
    frames(run).into_iter().map(|frame| FrameRecord { stage_ms: BTreeMap::new(), ..frame }).collect()
}

#[test]
fn a_junction_is_found_followed_and_arrived_at() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), out.path());
    let called = call_line(&format!("{line} --truth {} --json", drive.truth().display())).done();

    let records = frames(out.path());
    assert_eq!(records.len(), FRAMES);
    assert!(records.iter().enumerate().all(|(i, record)| record.frame == i as u64));
    assert!((records[20].t_s - 2.0).abs() < 1e-6, "times.txt says ten frames a second");
    assert!(records.iter().any(|record| record.state == TrackState::Tracking));
    let followed = records.iter().find_map(|record| record.feature.as_ref()).unwrap();
    assert_eq!((followed.id, followed.kind.as_str()), (2, "junction"));
    assert!(followed.sub.contains_key("approach") && followed.sub.contains_key("driving_line"));
    for stage in ["ground_view", "road", "motion", "match", "driving_line"] {
        assert!(records[5].stage_ms.contains_key(stage), "{stage}");
    }

    let turning: Vec<&FrameRecord> =
        records.iter().filter(|record| record.why.contains("turns through the junction")).collect();
    assert!(turning.len() > 3 && turning.iter().all(|record| record.lanes.is_none()), "{}", turning.len());

    let summary = summary(out.path());
    let feature = &summary.features[0];
    assert_eq!((summary.features.len(), feature.id), (1, 2));
    assert!(feature.detected_forward_m.unwrap() > 8.0);
    assert!(feature.arrived_frame.unwrap() > feature.detected_frame.unwrap());
    let truth = summary.truth.as_ref().unwrap();
    assert_eq!((truth.features_total, truth.features_detected, truth.false_detections), (1, 1, 0));
    // How precise the method is, its own tests say; here only that it found the junction where it is.
    assert!(truth.position_error_m.unwrap().p50 < 1.0);
    assert!(truth.motion_error_pct.unwrap() < 5.0);

    let printed: fingerpost_format::Summary = serde_json::from_str(&called.stdout).unwrap();
    assert_eq!(printed, summary, "--json prints what summary.json holds");
    assert!(called.stderr.contains("results in"));
}

/// All results that do not come from the clock: records, configuration, pictures, and the report's pictures in their order.
fn results(run: &Path) -> (Vec<FrameRecord>, String, Vec<Vec<u8>>, Vec<String>) {
    let text = |name: &str| fs::read_to_string(run.join(name)).unwrap();
    let pictures =
        [60, 61].map(|frame| fs::read(run.join(format!("pictures/frame_{frame:06}.png"))).unwrap());
    let report = text("report.html");
    let shown = report.split("data:image/jpeg;base64,").skip(1);
    let shown: Vec<String> = shown.filter_map(|rest| Some(rest.split_once('"')?.0.to_owned())).collect();
    assert!(shown.len() >= 6, "{} pictures in the report", shown.len());
    (timeless(run), text("config.toml"), pictures.into(), shown)
}

#[test]
fn the_same_input_gives_the_same_bytes_on_any_number_of_threads_and_instruction_set() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let sets = CodePath::available().map(|path| format!("{:?}", path.instruction_set()).to_lowercase());
    let threads = [1, 2, 8].map(|threads| format!("--threads {threads}"));
    let ways = threads.into_iter().chain(sets.map(|set| format!("--instruction-set {set}")));
    let mut expected = None;
    for (index, way) in ways.enumerate() {
        let out = folder.path().join(index.to_string());
        let line = drive.run_line(&drive.path(), &out);
        call_line(&format!("{line} --pictures 60-61 {way}")).done();
        let found = results(&out);
        assert!(found == *expected.get_or_insert_with(|| results(&out)), "{way}");
    }
}

#[test]
fn an_instruction_set_must_be_known_and_threads_must_be_some() {
    let line = "run in --camera c --out o";
    call_line(&format!("{line} --instruction-set mmx")).refused(2, &["mmx", "avx2"]);
    call_line(&format!("{line} --threads 0")).refused(2, &["--threads"]);
}

#[test]
fn without_a_route_there_is_motion_and_nothing_to_follow() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let (input, camera) = (drive.path(), drive.camera());
    let (input, camera, to) = (input.display(), camera.display(), out.path().display());
    let called = call_line(&format!("run {input} --camera {camera} --frames 10 --out {to}")).done();
    assert!(called.stdout.is_empty(), "data on standard output only when asked");
    let records = frames(out.path());
    assert_eq!(records.len(), 10);
    assert!(records.iter().all(|record| record.state == TrackState::NoRoute && record.feature.is_none()));
    assert!(records[9].motion.unwrap().forward_m > 0.3);
}

#[test]
fn the_effective_configuration_is_saved_and_can_be_used_again() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let config = folder.path().join("mine.toml");
    fs::write(&config, "[track]\ndetect_present = 0.9\n").unwrap();
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    let line = drive.run_line(&drive.path(), &first);
    call_line(&format!("{line} --frames 3 --config {}", config.display())).done();
    let saved = first.join("config.toml");
    let text = fs::read_to_string(&saved).unwrap();
    assert!(text.contains("detect_present = 0.9") && text.contains("[ground_view]"), "{text}");
    let line = drive.run_line(&drive.path(), &second);
    call_line(&format!("{line} --frames 3 --config {}", saved.display())).done();
    assert_eq!(fs::read_to_string(second.join("config.toml")).unwrap(), text);
}

#[test]
fn results_of_an_earlier_run_are_replaced() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), out.path());
    call_line(&format!("{line} --frames 8")).done();
    call_line(&format!("{line} --frames 3")).done();
    assert_eq!(frames(out.path()).len(), 3);
    assert_eq!(summary(out.path()).frames, 3);
}

#[test]
fn the_schema_describes_every_table_and_number() {
    let called = call_line("schema").done();
    let schema: serde_json::Value = serde_json::from_str(&called.stdout).unwrap();
    for table in ["vehicle", "ground_view", "road_surface", "motion", "match", "track"] {
        assert!(schema["properties"][table].is_object(), "{table}");
    }
    let width = &schema["properties"]["vehicle"]["properties"]["width_m"];
    assert_eq!((&width["minimum"], &width["maximum"]), (&0.3.into(), &6.0.into()));
    assert_eq!((&width["default"], &width["x-unit"]), (&1.8.into(), &"metres".into()));
    assert_eq!(width["description"], "Width of the body, metres.");
}

#[test]
fn gps_times_choose_the_frames() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let track = folder.path().join("track.gpx");
    // Where the drive starts, and a second later 8 m on.
    fs::write(
        &track,
        r#"<gpx version="1.1"><trk><trkseg>
        <trkpt lat="47.0" lon="9.500066"><time>2020-01-01T10:00:00Z</time></trkpt>
        <trkpt lat="47.0" lon="9.500170"><time>2020-01-01T10:00:01Z</time></trkpt>
        </trkseg></trk></gpx>"#,
    )
    .unwrap();
    let line = drive.run_line(&drive.path(), folder.path()).replace(" --start-m 5", "");
    let without = call_line(&format!("{line}/without --frames 15")).done();
    let with = call_line(&format!("{line}/with --frames 15 --gps {}", track.display())).done();
    assert!(without.code == with.code);
    let route_m = |run: &str| frames(&folder.path().join(run))[14].route_m;
    let believed_m = route_m("with").unwrap();
    assert!((believed_m - 16.0).abs() < 5.0, "{believed_m}");
    assert_ne!(route_m("without"), Some(believed_m));
    // The same by a receiver's own sentences, 47 degrees north, 9 degrees and 30.00396 and 30.0102 minutes east; the last is damaged.
    let log = folder.path().join("receiver.nmea");
    let sentences = [
        "$GPRMC,100000.00,A,4700.00000,N,00930.00396,E,15.5,90.0,010120,,,A*50",
        "$GPRMC,100001.00,A,4700.00000,N,00930.01020,E,15.5,90.0,010120,,,A*5E",
        "$GPRMC,100002.00,A,4800.00000,N,00930.01020,E,15.5,90.0,010120,,,A*00",
    ];
    fs::write(&log, sentences.join("\r\n")).unwrap();
    let by_log = call_line(&format!("{line}/log --frames 15 --gps {}", log.display())).done();
    assert!(
        by_log.stderr.contains("1 of its reports of position or time cannot be read"),
        "{}",
        by_log.stderr
    );
    assert_eq!(route_m("log"), Some(believed_m));
    // And by sentences without a date, at the same hour.
    let undated = folder.path().join("undated.nmea");
    let sentences = [("100000.00", "00930.00396"), ("100001.00", "00930.01020")]
        .map(|(clock, east)| format!("$GPGGA,{clock},4700.00000,N,{east},E,1,8,1.0,400.0,M,48.0,M,,"));
    fs::write(&undated, sentences.join("\r\n")).unwrap();
    let by_clock = call_line(&format!("{line}/undated --frames 15 --gps {}", undated.display())).done();
    assert!(by_clock.stderr.contains("give the time of day and no date"), "{}", by_clock.stderr);
    assert_eq!(route_m("undated"), Some(believed_m));
    // A start that the track contradicts is said; which of the two is right is not.
    let line = format!("{line}/apart --frames 2 --gps {}", track.display());
    let apart = call_line(&format!("{line} --start-m 100")).done();
    assert_eq!(apart.stderr.matches("one of them is wrong").count(), 1, "{}", apart.stderr);
    assert!(summary(&folder.path().join("apart")).drive.unwrap().remarks[0].contains("one of them is wrong"));
}

#[test]
fn surfaces_learned_on_a_drive_are_kept_for_the_next() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let [bank, config, run] = ["bank.json", "bank.toml", "run"].map(|name| out.path().join(name));
    fs::write(&config, "[road_surface]\ndetector = \"combined\"\n").unwrap();
    let line = drive.run_line(&drive.path(), &run);
    let line = format!("{line} --frames 12 --config {} --bank {}", config.display(), bank.display());
    call_line(&line).done();
    let learned =
        || -> serde_json::Value { serde_json::from_str(&fs::read_to_string(&bank).unwrap()).unwrap() };
    let first = learned();
    assert_eq!((first["version"].as_u64(), first["surfaces"].as_array().unwrap().len()), (Some(1), 1));
    let surface = frames(&run).pop().unwrap().surface.unwrap();
    assert_eq!(
        (surface.detector.as_str(), surface.name.as_deref()),
        ("combined", first["surfaces"][0]["name"].as_str())
    );
    assert!(surface.likeness.unwrap() > 0.6 && surface.remembered_share.unwrap() > 0.0, "{surface:?}");

    call_line(&line).done();
    let total = |bank: &serde_json::Value| bank["surfaces"][0]["frames"].as_u64().unwrap();
    assert_eq!(total(&learned()), 2 * total(&first), "the second run learned on");

    fs::write(&bank, "{").unwrap();
    call_line(&line).refused(1, &["bank.json is no file of known surfaces"]);
    fs::write(&config, "[road_surface]\ndetector = \"backprojection\"\n").unwrap();
    call_line(&line).refused(1, &["knows no surfaces", "combined"]);
}
