//! Inputs that cannot be used: each a message with cause and next action, and an exit code.

use std::fs;
use std::path::PathBuf;

use tempfile::TempDir;

use crate::drive::{Drive, MAP};
use crate::program::{Called, call_line, command};

/// A folder with one file in it.
fn file(name: &str, contents: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join(name);
    fs::write(&path, contents).unwrap();
    (folder, path)
}

/// Calls `run` on the drive with one argument exchanged or added.
fn run_with(change: impl FnOnce(String) -> String) -> Called {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    call_line(&change(drive.run_line(&drive.path(), &out.path().join("run"))))
}

#[test]
fn wrong_arguments_are_told_from_failed_runs() {
    call_line("run").refused(2, &["--camera"]);
    call_line("fly").refused(2, &["fly"]);
    call_line("route --map a --out b").refused(2, &["--from"]);
    call_line("route --map a --from 48.9 --to 1,2 --out b").refused(2, &["LAT,LON"]);
    call_line("run in --camera c --start-m 3 --out o").refused(2, &["--route"]);
    call_line("run in --camera c --frames 0 --out o").refused(2, &["--frames"]);
    call_line("simulate --map m --route r --size 640 --out o").refused(2, &["WIDTHxHEIGHT"]);
    call_line("run in --camera c --pictures 9-8 --out o").refused(2, &["FROM-TO"]);
    call_line("evaluate motion run").refused(2, &["--truth"]);
}

/// What is called for an argument that is a number, and the argument.
const NUMBERS: [(&str, &str); 20] = [
    ("run in --camera c --out o", "--fps"),
    ("run in --camera c --out o", "--frames"),
    ("run in --camera c --out o", "--threads"),
    ("run in --camera c --out o", "--max-input-mib"),
    ("run in --camera c --route r --out o", "--start-m"),
    ("route --map m --from 1,2 --to 1,2 --out o", "--max-input-mib"),
    ("simulate --map m --route r --out o", "--fps"),
    ("simulate --map m --route r --out o", "--frames"),
    ("simulate --map m --route r --out o", "--seed"),
    ("simulate --map m --route r --out o", "--max-input-mib"),
    ("simulate --course country --out o", "--length-m"),
    ("campaign --drives 1 --out o", "--fps"),
    ("campaign --out o", "--drives"),
    ("campaign --drives 1 --out o", "--threads"),
    ("campaign --drives 1 --out o", "--max-input-mib"),
    ("calibrate mount in --camera c --out o", "--speed-mps"),
    ("calibrate mount in --camera c --out o", "--distance-m"),
    ("calibrate mount in --camera c --out o", "--lane-width-m"),
    ("calibrate mount in --camera c --out o", "--fps"),
    ("mark in", "--port"),
];

#[test]
fn no_argument_takes_a_number_that_is_none() {
    for (line, argument) in NUMBERS {
        for value in [
            "-1e300",
            "1e300",
            "NaN",
            "inf",
            "-inf",
            "18446744073709551616",
            "-9223372036854775809",
            "ten",
            "0x7",
        ] {
            let called = call_line(&format!("{line} {argument}={value}"));
            called.refused(2, &[argument, value]);
            assert!(called.stderr.len() < 400, "{line} {argument}={value}: {}", called.stderr);
        }
    }
}

#[test]
fn inputs_that_are_not_there() {
    run_with(|line| line.replace("/drive ", "/nothing ")).refused(1, &["there is no", "give a folder"]);
    run_with(|line| line.replace("camera.toml", "kamera.toml"))
        .refused(1, &["kamera.toml", "cannot be read"]);
    let empty = TempDir::new().unwrap();
    let drive = Drive::get();
    call_line(&drive.run_line(empty.path(), &empty.path().join("run"))).refused(1, &["holds no picture"]);
}

#[test]
fn calibrations_that_cannot_be_right() {
    let text = fs::read_to_string(Drive::get().camera()).unwrap();
    let with = |key: &str, value: &str| -> String {
        text.lines()
            .map(
                |line| if line.starts_with(key) { format!("{key} = {value}\n") } else { format!("{line}\n") },
            )
            .collect()
    };
    for (contents, words) in [
        (with("fx", "nan"), ["fx", "focal length"]),
        (with("fx", "1.0"), ["fx", "focal length"]),
        (with("fy", "2000.0"), ["fy", "square"]),
        (with("cx", "900.0"), ["cx", "inside the picture"]),
        (with("cy", "-3.0"), ["cy", "inside the picture"]),
        (with("cx", "nan"), ["cx", "inside the picture"]),
        (with("height_m", "0.0"), ["height_m", "above the road"]),
        (with("height_m", "nan"), ["height_m", "NaN"]),
        (with("height_m", "-1.5"), ["height_m", "-1.5"]),
        (with("height_m", "150.0"), ["height_m", "150"]),
        (with("pitch_deg", "inf"), ["pitch", "inf"]),
        (with("fy", "\"wide\""), ["fy", "wide"]),
        (text.replace("[mount]", "[mounting]"), ["mounting", "camera.toml"]),
    ] {
        let (_folder, camera) = file("bad.toml", &contents);
        let called = run_with(|line| {
            line.replace(&Drive::get().camera().display().to_string(), &camera.display().to_string())
        });
        called.refused(1, &words);
        called.refused(1, &["bad.toml"]);
    }
}

/// A run with the drive's calibration changed: the table in place of the lines that begin with one of its keys.
fn run_with_camera(changes: &[(&str, &str)]) -> Called {
    let text = fs::read_to_string(Drive::get().camera()).unwrap();
    let change = |line: &str| {
        let changed = changes.iter().find(|(key, _)| line.split(' ').next() == Some(key));
        changed.map_or(format!("{line}\n"), |(key, value)| format!("{key} = {value}\n"))
    };
    let contents: String = text.lines().map(change).collect();
    let (_folder, camera) = file("changed.toml", &contents);
    run_with(|line| line.replace(&Drive::get().camera().display().to_string(), &camera.display().to_string()))
}

#[test]
fn calibrations_that_do_not_fit_the_road_or_the_pictures() {
    run_with_camera(&[("width", "240"), ("height", "320"), ("cx", "119.5"), ("cy", "159.5")])
        .refused(1, &["320 x 240", "240 x 320", "exchanged"]);
    run_with_camera(&[("height_m", "0.06")]).refused(1, &["far edge", "mount.height_m"]);
    run_with_camera(&[("pitch_deg", "-60.0")]).refused(1, &["sees", "pitch"]);
    run_with_camera(&[("yaw_deg", "79.0")]).refused(1, &["sees", "of the ground view"]);
    let lens = "\"brown-conrady\"";
    run_with_camera(&[("model", lens), ("coefficients", "[-1.5, 0.0, 0.0, 0.0]")])
        .refused(1, &["folds back", "calibrate again"]);
    run_with_camera(&[("model", lens), ("coefficients", "[-0.25, 0.07]")])
        .refused(1, &["coefficients", "4, 5 or 8"]);
}

#[test]
fn four_points_whose_horizon_is_in_the_ground_view() {
    let text = "[image]\nwidth = 320\nheight = 240\n[points]\n\
                image_px = [[60.0, 200.0], [260.0, 200.0], [150.0, 180.0], [170.0, 180.0]]\n\
                road_m = [[5.0, 2.0], [5.0, -2.0], [9.0, 2.0], [9.0, -2.0]]\n";
    let (_folder, camera) = file("points.toml", text);
    run_with(|line| {
        line.replace(&Drive::get().camera().display().to_string(), &camera.display().to_string())
    })
    .refused(1, &["horizon"]);
}

#[test]
fn configurations_that_cannot_be_used() {
    for (contents, words) in [
        ("[track]\ndetect_presnt = 0.8\n", ["detect_presnt", "fingerpost schema"]),
        ("[tracking]\n", ["tracking", "fingerpost schema"]),
        ("[track]\ndetect_present = 1.5\n", ["track.detect_present", "1.5"]),
        ("[ground_view]\nnear_m = nan\n", ["near_m", "NaN"]),
        ("[track\n", ["line 1", "fingerpost schema"]),
    ] {
        let (_folder, config) = file("mine.toml", contents);
        run_with(|line| format!("{line} --config {}", config.display())).refused(1, &words);
    }
}

#[test]
fn maps_without_use() {
    for (contents, words) in [
        ("", ["empty", "download it again"]),
        ("P6 not a map", ["neither OSM XML", "give a .osm"]),
        (r#"<osm version="0.6"><node id="1" lat="47" lon="9"/></osm>"#, ["no roads", "map.osm"]),
        (&MAP[..MAP.len() / 2], ["broken", "again"]),
    ] {
        let (folder, map) = file("map.osm", contents);
        let out = folder.path().join("route.geojson");
        let line =
            format!("route --map {} --from 47,9.5 --to 47,9.501 --out {}", map.display(), out.display());
        call_line(&line).refused(1, &words);
        assert!(!out.exists(), "nothing is left behind that looks like a route");
    }
}

#[test]
fn routes_that_leave_the_map() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let map = drive.map();
    let (map, out) = (map.display(), folder.path().join("out"));
    let to = out.display();
    call_line(&format!("route --map {map} --from 47,9.5 --to 47.3,9.5 --out {to}"))
        .refused(1, &["stop 2", "from the nearest road", "check the place"]);

    let far = "<gpx version=\"1.1\"><trk><trkseg><trkpt lat=\"47.0\" lon=\"9.5\"/><trkpt lat=\"47.0\" lon=\"9.5005\"/>\
               <trkpt lat=\"47.01\" lon=\"9.51\"/><trkpt lat=\"47.02\" lon=\"9.52\"/></trkseg></trk></gpx>";
    let (_folder, track) = file("far.gpx", far);
    call_line(&format!("route --map {map} --gpx {} --out {to}", track.display()))
        .refused(1, &["far.gpx", "leaves the map", "cut the track"]);

    let (_folder, elsewhere) = file("elsewhere.osm", &MAP.replace("lat=\"47", "lat=\"46"));
    let route = drive.route();
    call_line(&format!("simulate --map {} --route {} --out {to}", elsewhere.display(), route.display()))
        .refused(1, &["away from every road", "give the map"]);
}

#[test]
fn route_files_that_are_none() {
    for (contents, words) in [("{", "route.geojson"), ("{\"type\":\"Feature\"}", "FeatureCollection")] {
        let (_folder, route) = file("route.geojson", contents);
        let planned = Drive::get().route().display().to_string();
        run_with(|line| line.replace(&planned, &route.display().to_string())).refused(1, &[words]);
    }
}

#[test]
fn a_start_that_is_not_on_the_route() {
    run_with(|line| line.replace("--start-m 5", "--start-m 5000")).refused(1, &["5000", "give 0 to"]);
    run_with(|line| line.replace("--start-m 5", "--start-m -1")).refused(1, &["-1", "give 0 to"]);
    run_with(|line| line.replace("--start-m 5", "--start-m nan")).refused(2, &["nan", "--start-m"]);
}

#[test]
fn a_gps_track_of_another_place_is_refused() {
    for (lat, lon) in [(47.02, 9.5), (48.0, 9.5), (-33.0, 151.0)] {
        let (_folder, track) = file(
            "track.gpx",
            &format!(
                "<gpx version=\"1.1\"><trk><trkseg><trkpt lat=\"{lat}\" lon=\"{lon}\"><time>2020-01-01T10:00:00Z</time></trkpt>\
                 </trkseg></trk></gpx>"
            ),
        );
        run_with(|line| format!("{line} --gps {}", track.display()))
            .refused(1, &["never comes nearer", "leave --gps out"]);
    }
}

#[test]
fn a_gps_track_of_another_place_is_refused_without_a_route_too() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let route = format!(" --route {} --start-m 5", drive.route().display());
    let run = drive.run_line(&drive.path(), &folder.path().join("out")).replace(&route, "");
    for (lat, lon, cause) in [(48.0, 9.5, "111 km from the nearest road"), (9.5003, 47.0002, "exchanged?")] {
        let point = format!("<trkpt lat=\"{lat}\" lon=\"{lon}\"><time>2020-01-01T10:00:00Z</time></trkpt>");
        let (_folder, track) = file("track.gpx", &format!("<gpx version=\"1.1\">{point}</gpx>"));
        call_line(&format!("{run} --map {} --gps {}", drive.map().display(), track.display()))
            .refused(1, &["never comes to a road of the map", cause, "leave --gps out"]);
        assert!(!folder.path().join("out").exists());
        // With a route the same is asked of the same track.
        let with_route = format!("{run}{route} --gps {}", track.display());
        let refused = call_line(&with_route);
        refused.refused(1, &["never comes nearer to the route", "leave --gps out"]);
        assert_eq!(refused.stderr.contains("exchanged?"), cause == "exchanged?", "{}", refused.stderr);
    }
}

#[test]
fn a_gps_track_without_times() {
    let (_folder, track) = file("t.gpx", r#"<gpx version="1.1"><wpt lat="47" lon="9.5"/></gpx>"#);
    run_with(|line| format!("{line} --gps {}", track.display()))
        .refused(1, &["t.gpx", "no times", "export it"]);
}

#[test]
fn times_that_do_not_fit_the_pictures() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let pictures = drive.pictures(3);
    fs::write(pictures.path().join("times.txt"), "0.0\n0.1\n").unwrap();
    call_line(&drive.run_line(pictures.path(), out.path())).refused(1, &["2 times for 3 pictures", "remove"]);
    fs::write(pictures.path().join("times.txt"), "0.0\n0.2\n0.1\n").unwrap();
    call_line(&drive.run_line(pictures.path(), out.path())).refused(1, &["backwards at line 3"]);
}

#[test]
fn unknown_conditions_and_absurd_rates() {
    let drive = Drive::get();
    let out = TempDir::new().unwrap();
    let (map, route) = (drive.map(), drive.route());
    let line = format!(
        "simulate --map {} --route {} --out {}",
        map.display(),
        route.display(),
        out.path().display()
    );
    call_line(&format!("{line} --conditions fog")).refused(2, &["fog", "shadows"]);
    call_line(&format!("{line} --fps 0")).refused(2, &["fps", "0.1 to 1000"]);
    run_with(|line| format!("{line} --fps 0")).refused(2, &["is no frame rate", "give 0.01"]);
}

#[test]
fn video_without_ffmpeg() {
    let (folder, video) = file("drive.mp4", "no video");
    let (drive, out) = (Drive::get(), folder.path().join("run"));
    let reading = drive.run_line(&video, &out);
    let writing = format!("{} --video", drive.run_line(&drive.path(), &out));
    for line in [reading, writing] {
        let output = command().args(line.split_whitespace()).env("PATH", folder.path()).output().unwrap();
        Called::from(output).refused(1, &["was not found", "install ffmpeg"]);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    let map = Drive::get().map();
    call_line(&format!("route --map {} --from 47,9.5 --to 47.0005,9.5006 --out /dev/full", map.display()))
        .refused(1, &["/dev/full", "space"]);
}

#[test]
fn an_output_folder_that_is_a_file() {
    let (_folder, path) = file("taken", "");
    let drive = Drive::get();
    call_line(&drive.run_line(&drive.path(), &path)).refused(1, &["taken"]);
}

#[test]
fn an_input_that_the_results_would_replace() {
    let out = TempDir::new().unwrap();
    let pictures = out.path().join("pictures");
    fs::create_dir(&pictures).unwrap();
    fs::write(pictures.join("1.png"), "recorded").unwrap();
    let drive = Drive::get();
    call_line(&drive.run_line(&pictures, out.path())).refused(1, &["replaced", "--out"]);
    assert_eq!(fs::read(pictures.join("1.png")).unwrap(), b"recorded");
}

#[cfg(not(feature = "onnx"))]
#[test]
fn networks_need_a_program_built_for_them() {
    for settings in ["detector = \"onnx\"", "detector = \"memory\"\nmemory.of = \"onnx\""] {
        let (_folder, config) = file("network.toml", &format!("[road_surface]\n{settings}\n"));
        run_with(|line| format!("{line} --config {}", config.display())).refused(1, &["--features onnx"]);
    }
}

#[cfg(unix)]
#[test]
fn a_device_without_an_end_is_no_input() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), &out.path().join("run"));
    let config = out.path().join("settings.toml");
    fs::write(&config, "").unwrap();
    let zero = "holds more than the 1 MB that are read of a device";
    for option in ["--config", "--gps", "--truth", "--bank"] {
        call_line(&format!("{line} {option} /dev/zero")).refused(1, &["/dev/zero", zero]);
    }
    let route = drive.route().display().to_string();
    call_line(&line.replace(&route, "/dev/zero")).refused(1, &["/dev/zero", zero]);
    let can = format!("{line} --config {} --can", config.display());
    call_line(&format!("{can} /dev/null --dbc /dev/zero")).refused(1, &["/dev/zero", zero]);
    let dbc = out.path().join("car.dbc");
    fs::write(&dbc, fingerpost_sim::BUS_DATABASE).unwrap();
    fs::write(&config, fingerpost_sim::BUS_SETTINGS).unwrap();
    call_line(&format!("{can} /dev/zero --dbc {}", dbc.display()))
        .refused(1, &["/dev/zero", "a line of it has no end"]);
    let planned = "--from 47.2,9.5 --to 47.3,9.5 --out";
    let route = out.path().join("route.geojson");
    call_line(&format!("route --map /dev/zero {planned} {}", route.display()))
        .refused(1, &["/dev/zero", zero]);
}

#[cfg(unix)]
#[test]
fn settings_may_come_through_a_pipe() {
    let (drive, out) = (Drive::get(), TempDir::new().unwrap());
    let line = drive.run_line(&drive.path(), &out.path().join("run"));
    let script = format!(
        "echo '[track]' | {} {line} --frames 2 --config /dev/stdin",
        env!("CARGO_BIN_EXE_fingerpost")
    );
    let called = Called::from(std::process::Command::new("sh").args(["-c", &script]).output().unwrap());
    assert_eq!(called.code, Some(0), "{}", called.stderr);
}

#[test]
fn arguments_that_are_refused_say_what_may_be_meant() {
    call_line("run --input 0 --camera camera.toml --out run").refused(2, &["fingerpost run /dev/video0"]);
    call_line("run drive.mp4 --start-m 5 --camera camera.toml --out run")
        .refused(2, &["--route", "fingerpost route", "--near"]);
}

/// A GPX track whose positions have one time says nothing of when; one bad time costs its own position.
#[test]
fn times_of_a_gps_track_that_say_nothing_are_not_believed() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (track, out) = (folder.path().join("track.gpx"), folder.path().join("run"));
    let point = |east: u32, time: &str| {
        format!("<trkpt lat=\"47.0\" lon=\"9.5000{east}\"><time>{time}</time></trkpt>\n")
    };
    let run = |points: &str| {
        fs::write(&track, format!("<gpx>{points}</gpx>")).unwrap();
        let line = drive.run_line(&drive.path(), &out);
        call_line(&format!("{line} --frames 2 --gps {}", track.display()))
    };
    let at = |second: u32| format!("2026-01-01T08:00:0{second}Z");
    run(&(0..5).map(|east| point(east, &at(0))).collect::<String>())
        .refused(1, &["no times that tell its positions apart", "all 5"]);
    let called = run(&(point(0, "") + &point(1, &at(1)) + &point(2, &at(2)))).done();
    assert!(called.stderr.contains("line 1: time \"\" is not ISO 8601"), "{}", called.stderr);
    assert!(called.stderr.contains("position 2 is taken to belong to the first frame"), "{}", called.stderr);
    let called = run(&point(0, "1970-01-01T02:00:00Z")).done();
    assert!(called.stderr.contains("none of the 1 GPS positions was used"), "{}", called.stderr);
}

/// Whatever a file is called, what is said of it is on its own lines.
#[test]
#[cfg(unix)]
fn a_line_break_in_a_files_name_forges_no_line() {
    let folder = TempDir::new().unwrap();
    let forged = "fingerpost: results in elsewhere";
    for line_break in ["\n", "\r\n", "\u{2028}", "\u{85}", "\u{b}"] {
        let name = folder.path().join(format!("drive{line_break}{forged}"));
        // A map that is empty, one that is none, and a configuration that is no TOML.
        for (text, arguments) in [
            (
                "<osm><remark>cut</remark></osm>",
                vec!["route", "--out", "r.geojson", "--from", "47,9", "--to", "47,9.1", "--map"],
            ),
            ("no map", vec!["route", "--out", "r.geojson", "--from", "47,9", "--to", "47,9.1", "--map"]),
            ("a = [", vec!["can", "x.log", "--dbc", "x.dbc", "--config"]),
        ] {
            fs::write(&name, text).unwrap();
            let called: Called = command().args(&arguments).arg(&name).output().unwrap().into();
            called.refused(1, &["elsewhere"]);
            assert!(called.stderr.lines().all(|line| !line.starts_with(forged)), "{}", called.stderr);
            assert!(!called.stderr.contains(['\r', '\u{2028}', '\u{85}', '\u{b}']), "{}", called.stderr);
        }
        fs::remove_file(&name).unwrap();
    }
}
