//! `calibrate` from outside: mounts from drives and from points.

use std::fs;
use std::path::Path;

use fingerpost_format::camera_from_toml;
use fingerpost_geometry::{Mount, View};
use fingerpost_io::read_truth;
use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{call_line, frames};

/// Mount of the drives, degrees.
const PITCH_DEG: f64 = 6.5;
const YAW_DEG: f64 = -2.0;
const HEIGHT_M: f64 = 1.4;

fn camera_text(pitch_deg: f64, yaw_deg: f64, height_m: f64) -> String {
    format!(
        "[image]\nwidth = 480\nheight = 360\n[intrinsics]\nfx = 315.0\nfy = 315.0\ncx = 239.5\ncy = 179.5\n\
         [mount]\nheight_m = {height_m}\npitch_deg = {pitch_deg}\nyaw_deg = {yaw_deg}\nx_m = 1.5\n"
    )
}

fn mount_of(path: &Path) -> Mount {
    let camera = camera_from_toml(&fs::read_to_string(path).unwrap()).unwrap();
    match camera.view() {
        View::Calibrated { mount, .. } => Some(*mount),
        View::RoadPlane(_) => None,
    }
    .unwrap()
}

#[test]
fn a_mount_is_found_from_a_drive_and_a_known_speed_gives_its_height() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let path = |name: &str| folder.path().join(name).display().to_string();
    fs::write(path("true.toml"), camera_text(PITCH_DEG, YAW_DEG, HEIGHT_M)).unwrap();
    fs::write(path("guess.toml"), camera_text(8.0, 0.0, 1.6)).unwrap();
    fs::write(path("far_off.toml"), camera_text(8.0, 35.0, 1.6)).unwrap();
    let (map, route) = (drive.map(), drive.route());
    call_line(&format!(
        "simulate --map {} --route {} --conditions clear --frames 45 --camera {} --out {}",
        map.display(),
        route.display(),
        path("true.toml"),
        path("drive")
    ))
    .done();
    let line = format!(
        "calibrate mount {} --camera {} --out {} --json",
        path("drive"),
        path("guess.toml"),
        path("out.toml")
    );

    let kept = call_line(&line).done();
    assert!(kept.stderr.contains("height kept at 1.600 m"), "{}", kept.stderr);
    let report: serde_json::Value = serde_json::from_str(&kept.stdout).unwrap();
    assert!(report["height_m"].is_null() && report["pitch_deg"]["sigma"].as_f64().unwrap() > 0.0, "{report}");
    let mount = mount_of(&folder.path().join("out.toml"));
    assert!((mount.pitch_rad.to_degrees() - PITCH_DEG).abs() < 0.2, "{mount:?}");
    assert!((mount.yaw_rad.to_degrees() - YAW_DEG).abs() < 0.2, "{mount:?}");

    let truth = read_truth(&folder.path().join("drive/truth.jsonl")).unwrap();
    let steps =
        truth.windows(2).map(|pair| libm::hypot(pair[1].x_m - pair[0].x_m, pair[1].y_m - pair[0].y_m));
    let distance_m: f64 = steps.sum();
    let speed_mps = distance_m / (truth.last().unwrap().t_s - truth[0].t_s);
    call_line(&format!("{line} --speed-mps {speed_mps}")).done();
    let mount = mount_of(&folder.path().join("out.toml"));
    assert!((mount.height_m / HEIGHT_M - 1.0).abs() < 0.03, "{mount:?}");

    // A start that is far off is as good.
    call_line(&format!("{} --speed-mps {speed_mps}", line.replace("guess.toml", "far_off.toml"))).done();
    let mount = mount_of(&folder.path().join("out.toml"));
    assert!((mount.height_m / HEIGHT_M - 1.0).abs() < 0.03, "{mount:?}");
    assert!((mount.yaw_rad.to_degrees() - YAW_DEG).abs() < 0.2, "{mount:?}");

    // Every third frame twice: nobody knows whether time passes meanwhile, but the way is known.
    let frames = folder.path().join("drive/frames");
    let mut names: Vec<_> = fs::read_dir(&frames).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    fs::create_dir(path("filled")).unwrap();
    let filled = names.iter().enumerate().flat_map(|(i, name)| vec![name; if i % 3 == 0 { 2 } else { 1 }]);
    for (i, name) in filled.enumerate() {
        fs::copy(name, folder.path().join(format!("filled/{i:06}.jpg"))).unwrap();
    }
    let filled = line.replace(&path("drive"), &path("filled"));
    let uneven = call_line(&format!("{filled} --fps 10 --speed-mps {speed_mps}"));
    uneven.refused(1, &["15 of 60 frames repeat the one before", "distance", "nothing was written"]);
    let by_distance = call_line(&format!("{filled} --distance-m {distance_m}")).done();
    assert!(by_distance.stderr.contains("15 of 60 frames repeat"), "{}", by_distance.stderr);
    let mount = mount_of(&folder.path().join("out.toml"));
    assert!((mount.height_m / HEIGHT_M - 1.0).abs() < 0.03, "{mount:?}");

    // Frames in a row that repeat the one before hide how far the vehicle came: it cannot have stood.
    let frozen = |run: std::ops::Range<usize>| {
        let name = format!("frozen{}", run.len());
        fs::create_dir(path(&name)).unwrap();
        for (i, picture) in names.iter().enumerate() {
            let shown = if run.contains(&i) { &names[run.start - 1] } else { picture };
            fs::copy(shown, folder.path().join(format!("{name}/{i:06}.jpg"))).unwrap();
        }
        let line = line.replace(&path("drive"), &path(&name));
        call_line(&format!("{line} --fps 10 --speed-mps {speed_mps}"))
    };
    frozen(20..25).refused(1, &["5 of 45 frames repeat the one before", "nothing was written"]);
    let short = frozen(20..22).done();
    assert!(short.stderr.contains("2 of 45 frames repeat"), "{}", short.stderr);
    let mount = mount_of(&folder.path().join("out.toml"));
    assert!((mount.height_m / HEIGHT_M - 1.0).abs() < 0.03, "{mount:?}");

    // What is out of range is the estimate's, and the file is not blamed for it.
    let far_off = call_line(&format!("{line} --distance-m 100000"));
    far_off.refused(
        1,
        &[
            "the drive gives a camera",
            "metres above the road",
            "smooth asphalt",
            "check the speed or distance",
        ],
    );
    assert!(!far_off.stderr.contains("correct it in the calibration"), "{}", far_off.stderr);

    fs::remove_file(path("out.toml")).unwrap();
    call_line(&format!("{line} --frames 12"))
        .refused(1, &["nothing was written", "straight", "give a longer drive"]);
    call_line(&format!("{line} --speed-mps 8 --distance-m 40")).refused(2, &["--distance-m"]);
    let help =
        call_line("calibrate mount --help").done().stdout.split_whitespace().collect::<Vec<_>>().join(" ");
    for (key, least, range, beyond) in [
        ("--speed-mps", "0.5", "0.5 to 100", ["0.49", "101"]),
        ("--distance-m", "5", "5 to 1e6", ["4.9", "1000001"]),
        ("--lane-width-m", "1.5", "1.5 to 8", ["1.4", "8.1"]),
    ] {
        assert!(help.contains(&format!("; {range}")), "{range}: {help}");
        for value in beyond {
            call_line(&format!("{line} {key} {value}")).refused(2, &[key, &format!("give {least} to")]);
        }
    }
    assert!(!folder.path().join("out.toml").exists());
}

/// A fast road moves too far near the vehicle to be followed there, and corners are found again where they had been.
#[test]
fn a_mount_from_a_motorway_s_speed_shows_that_speed() {
    let clips = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/clips");
    let folder = TempDir::new().unwrap();
    let (camera, out) = (clips.join("camera.toml"), folder.path().join("out.toml"));
    let line = |clip: &str| {
        let clip = clips.join(clip);
        format!("calibrate mount {} --camera {} --out {}", clip.display(), camera.display(), out.display())
    };
    for (scale, speed_mps) in
        [("--speed-mps 29", 29.0), ("--distance-m 69.6", 29.0), ("--speed-mps 24", 24.0)]
    {
        call_line(&format!("{} {scale}", line("bridge.mp4"))).done();
        // The lane's width gives 1.165 m for 29 m/s.
        let height_m = mount_of(&out).height_m * 29.0 / speed_mps;
        assert!((1.12..1.24).contains(&height_m), "{scale}: {height_m}");
    }
    fs::remove_file(&out).unwrap();
    call_line(&format!("{} --speed-mps 29", line("motorway.mp4")))
        .refused(1, &["misread", "nothing was written"]);
    assert!(!out.exists());
}

/// A calibration for pictures of twice the size is scaled, one for pictures of another shape refused, by every command that looks
/// through it, and nothing is written then.
#[test]
fn a_calibration_of_another_size_is_scaled_where_the_shape_is_the_same() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let (text, drive_path) = (fs::read_to_string(drive.camera()).unwrap(), drive.path());
    let camera = camera_from_toml(&text).unwrap();
    let doubled = camera.scaled_to(2 * camera.width(), 2 * camera.height()).unwrap();
    let path = |name: &str| folder.path().join(name);
    fs::write(path("doubled.toml"), fingerpost_format::camera_to_toml(&doubled).unwrap()).unwrap();
    fs::write(path("flat.toml"), text.replace("height = 240", "height = 180")).unwrap();
    let run = |camera: &Path, out: &str| {
        call_line(&format!(
            "run {} --camera {} --frames 5 --no-recording --out {}",
            drive_path.display(),
            camera.display(),
            path(out).display()
        ))
    };
    run(&drive.camera(), "as_is").done();
    let scaled = run(&path("doubled.toml"), "scaled").done();
    assert!(scaled.stderr.contains("the pictures have 320 x 240; it is scaled"), "{}", scaled.stderr);
    let motion = |out: &str| -> Vec<f64> {
        frames(&path(out)).iter().filter_map(|frame| Some(frame.motion.as_ref()?.forward_m)).collect()
    };
    let (as_is, scaled) = (motion("as_is"), motion("scaled"));
    assert!(as_is.len() == 4 && scaled.len() == 4, "{as_is:?} {scaled:?}");
    assert!(as_is.iter().zip(&scaled).all(|(a, b)| (a - b).abs() < 1e-6), "{as_is:?} {scaled:?}");
    run(&path("flat.toml"), "flat").refused(1, &["320 x 180", "320 x 240", "give the calibration"]);
    assert!(!path("flat").exists());
    let mount = format!(
        "calibrate mount {} --camera {} --out {}",
        drive_path.display(),
        path("flat.toml").display(),
        path("out.toml").display()
    );
    call_line(&mount).refused(1, &["320 x 180", "320 x 240"]);
    assert!(!path("out.toml").exists());
}

/// Pictures of a vehicle that stands.
#[test]
fn a_drive_without_motion_is_refused() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let first = drive.path().join("frames/000000.jpg");
    for index in 0..30 {
        fs::copy(&first, folder.path().join(format!("{index:06}.jpg"))).unwrap();
    }
    let out = folder.path().join("out.toml");
    call_line(&format!(
        "calibrate mount {} --camera {} --out {}",
        folder.path().display(),
        drive.camera().display(),
        out.display()
    ))
    .refused(1, &["nothing was written", "0 of 30 frames"]);
    assert!(!out.exists());
}

#[test]
fn four_points_make_a_camera_and_with_a_lens_a_mount() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let camera = camera_from_toml(&fs::read_to_string(drive.camera()).unwrap()).unwrap();
    let places = [[6.0, 1.5], [6.0, -1.5], [12.0, 1.5], [12.0, -1.5]];
    let points: Vec<String> = places
        .iter()
        .map(|&[x, y]| {
            let pixel = camera.pixel_of_ground([x, y].into()).unwrap();
            format!("{},{},{x},{y}", pixel.u, pixel.v)
        })
        .collect();
    let out = folder.path().join("out.toml");
    let inline = points.join(";");
    call_line(&format!("calibrate points --image-size 320x240 --points {inline} --out {}", out.display()))
        .done();
    let by_points = camera_from_toml(&fs::read_to_string(&out).unwrap()).unwrap();
    let ground = by_points.ground_of_pixel(camera.pixel_of_ground([9.0, 0.5].into()).unwrap()).unwrap();
    assert!((ground.x - 9.0).abs() < 0.01 && (ground.y - 0.5).abs() < 0.01, "{ground}");
    let run = folder.path().join("run");
    let line = drive.run_line(&drive.path(), &run);
    call_line(&line.replace(&drive.camera().display().to_string(), &out.display().to_string())).done();

    let file = folder.path().join("points.txt");
    fs::write(&file, format!("# u,v,forward,left\n{}\n", points.join("\n"))).unwrap();
    let line = |points: &str| {
        let camera = drive.camera();
        format!("calibrate points --camera {} --points {points} --out {}", camera.display(), out.display())
    };
    call_line(&line(&file.display().to_string())).done();
    let (found, true_mount) = (mount_of(&out), mount_of(&drive.camera()));
    assert!((found.height_m - true_mount.height_m).abs() < 0.01, "{found:?}");
    assert!((found.pitch_rad - true_mount.pitch_rad).abs() < 0.002, "{found:?}");

    fs::remove_file(&out).unwrap();
    for (points, words) in [
        ("1,2,3,4", ["1 points", "FORWARD,LEFT"]),
        ("100,200,6,1;200,200,6,-1;150,200,9,0;120,150,9,1", ["one line", "measure them again"]),
        ("200,200,6,1;100,200,6,-1;180,150,9,1;120,150,9,-1", ["mirrors the road", "same order"]),
        ("100,200,6,1;200,200,6,-1;120,150,9,1;900,150,9,-1", ["outside the picture", "900"]),
        ("100,200,6,1;200,200,6,-1;120,150,9,1;a,150,9,-1", ["no point", "metres"]),
    ] {
        call_line(&format!(
            "calibrate points --image-size 320x240 --points {points} --out {}",
            out.display()
        ))
        .refused(1, &words);
    }
    call_line(&line("60,200,6,1;260,210,6,-1;140,120,9,1;150,160,9,-1")).refused(1, &["nothing was written"]);
    assert!(!out.exists());
}

#[test]
fn a_calibration_tells_how_far_it_sees() {
    let camera = Drive::get().camera();
    let line = format!("calibrate reach --camera {}", camera.display());
    let told = call_line(&format!("{line} --json")).done();
    let told: serde_json::Value = serde_json::from_str(&told.stdout).unwrap();
    let ranges: Vec<f64> =
        told["rows"].as_array().unwrap().iter().map(|row| row["range_m"].as_f64().unwrap()).collect();
    assert!(ranges.len() > 5 && ranges.windows(2).all(|pair| pair[0] < pair[1]), "{ranges:?}");
    assert_eq!(told["reactions"].as_array().unwrap().len(), 5);
    let table = call_line(&line).done().stdout;
    assert!(table.contains("120 km/h") && table.contains("hands-free telephone"), "{table}");
    call_line("calibrate reach --camera none.toml").refused(1, &["none.toml", "check the path"]);
}
