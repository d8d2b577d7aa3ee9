//! What commands may write: nothing of the user's is replaced, and what is written is whole.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::drive::Drive;
use crate::program::{Called, call_line, command, frames, summary};
use crate::video_stub::VideoStub;

/// Longest time that anything here may take, generously.
const PATIENCE: Duration = Duration::from_secs(120);

fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let patience = Instant::now();
    while !is_so() {
        assert!(patience.elapsed() < PATIENCE, "{what}");
        sleep(Duration::from_millis(10));
    }
}

fn signal(name: &str, child: &Child) {
    let sent = Command::new("kill").args([name, &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
}

/// A run without end, once it has some frames, started by `through`, which gets its command line as arguments.
fn endless_run(stub: &VideoStub, out: &Path, through: &[&str]) -> Child {
    let run = stub.run(out);
    let mut command = Command::new(through[0]);
    command.args(&through[1..]).arg(run.get_program()).args(run.get_args());
    command.envs(run.get_envs().filter_map(|(name, value)| Some((name, value?))));
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until("the run does not get going", || lines(out) >= 3);
    child
}

fn lines(out: &Path) -> usize {
    fs::read_to_string(out.join("frames.jsonl")).unwrap_or_default().lines().count()
}

#[test]
fn a_folder_of_the_users_is_no_folder_for_results() {
    let drive = Drive::get();
    let pictures = drive.pictures(3);
    let own = pictures.path();
    fs::write(own.join("config.toml"), "# mine\n").unwrap();
    let run = |out: &str| {
        let line = drive.run_line(Path::new("."), Path::new(out));
        let called = command().current_dir(own).args(line.split_whitespace()).output().unwrap();
        Called::from(called)
    };
    run(".").refused(1, &["would be replaced", "choose another place", "--out"]);
    let (map, route) = (drive.map(), drive.route());
    let simulate = format!("simulate --map {} --route {} --frames 1", map.display(), route.display());
    let campaign = "campaign --drives 1".to_owned();
    for line in [simulate, campaign, "demo".to_owned()] {
        let called = call_line(&format!("{line} --out {}", own.display()));
        called.refused(1, &["holds 000000.jpg and no .fingerpost.json", "choose another folder"]);
    }
    assert_eq!(fs::read_dir(own).unwrap().count(), 4);
    assert_eq!(fs::read_to_string(own.join("config.toml")).unwrap(), "# mine\n");

    // A new folder beside the pictures is nobody's, and is written again.
    for _ in 0..2 {
        run("results").done();
        assert_eq!(frames(&own.join("results")).len(), 3);
    }
    let again = drive.run_line(own, &own.join("results"));
    let config = own.join("results/config.toml");
    call_line(&format!("{again} --config {}", config.display()))
        .refused(1, &["config.toml would be replaced"]);
    assert!(config.exists());
    // A drive is no run.
    call_line(&drive.run_line(own, &drive.path())).refused(1, &["holds a simulated drive"]);
}

#[test]
fn a_file_that_is_read_is_not_written() {
    let drive = Drive::get();
    let folder = TempDir::new().unwrap();
    let [map, link, hard, camera] =
        ["map.osm", "link.osm", "hard.osm", "camera.toml"].map(|name| folder.path().join(name));
    fs::copy(drive.map(), &map).unwrap();
    fs::copy(drive.camera(), &camera).unwrap();
    symlink(&map, &link).unwrap();
    fs::hard_link(&map, &hard).unwrap();
    for out in [&map, &link, &hard] {
        let line = format!(
            "route --map {} --from 47,9.5 --to 47.0005,9.5006 --out {}",
            map.display(),
            out.display()
        );
        call_line(&line).refused(1, &["map.osm would be replaced", "--out"]);
    }
    assert_eq!(fs::read(&map).unwrap(), fs::read(drive.map()).unwrap());
    let (input, own) = (drive.path(), camera.display());
    let mount = format!("calibrate mount {} --camera {own} --speed-mps 8 --out {own}", input.display());
    call_line(&mount).refused(1, &["camera.toml would be replaced"]);
    let run = drive.run_line(&input, &folder.path().join("run"));
    for over in [drive.camera(), drive.route(), input.join("times.txt"), input.join("frames/000003.jpg")] {
        let before = fs::read(&over).unwrap();
        call_line(&format!("{run} --bank {}", over.display())).refused(1, &["would be replaced"]);
        assert_eq!(fs::read(&over).unwrap(), before);
    }
}

/// Commands that write a single file, each up to the option that names it.
fn commands_of_single_files(folder: &Path) -> Vec<(String, &'static str)> {
    let drive = Drive::get();
    let (path, camera) = (drive.path(), drive.camera());
    let points = folder.join("points.txt");
    fs::write(&points, "80,180,6,1.5\n240,180,6,-1.5\n110,150,12,1.5\n210,150,12,-1.5\n").unwrap();
    let (input, camera, map) = (path.display(), camera.display(), drive.map());
    vec![
        (format!("route --map {} --from 47,9.5 --to 47.0005,9.5006 --out", map.display()), "route"),
        (format!("calibrate mount {input} --camera {camera} --speed-mps 8 --out"), "camera"),
        (format!("calibrate points --image-size 320x240 --points {} --out", points.display()), "camera"),
        (format!("calibrate chessboard {input}/frames --corners 5x4 --height-m 1.4 --out"), "camera"),
        (
            format!("can {input}/can.log --dbc {input}/car.dbc --config {input}/can.toml --out"),
            "table of signals",
        ),
        (
            format!("evaluate road --images {input}/frames --labels {input}/road_masks --road 1 --sheet"),
            "sheet",
        ),
        (
            format!(
                "evaluate lanes {input} --truth {input}/truth.jsonl --roi-rows 100,120 --thresholds 10,20 --plot"
            ),
            "plot",
        ),
    ]
}

#[test]
fn a_single_file_that_may_be_the_users_is_not_replaced() {
    let folder = TempDir::new().unwrap();
    let own = folder.path().join("own");
    // A text, a picture of another program, and what other commands write.
    let foreign: [&[u8]; 4] = [
        b"my notes",
        b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR of another program, and more of it than a header",
        b"<svg xmlns=\"http://www.w3.org/2000/svg\"><text>mine</text></svg>",
        b"{\"type\": \"FeatureCollection\", \"features\": []}",
    ];
    for (line, kind) in commands_of_single_files(folder.path()) {
        for contents in foreign {
            fs::write(&own, contents).unwrap();
            let said =
                format!("own is no {kind} that this program wrote, so it may be yours; choose another file");
            call_line(&format!("{line} {}", own.display())).refused(1, &[&said]);
            assert_eq!(fs::read(&own).unwrap(), contents, "{line}");
        }
    }
}

#[test]
fn a_camera_that_was_written_by_hand_is_not_replaced() {
    let folder = TempDir::new().unwrap();
    let own = folder.path().join("own.toml");
    let written = fs::read_to_string(Drive::get().camera()).unwrap();
    let commented = format!("# measured with a tape on 3 May\n{written}");
    let without_spaces = written.replace(" = ", "=");
    for (line, _) in commands_of_single_files(folder.path()).iter().filter(|(_, kind)| *kind == "camera") {
        for contents in [&commented, &without_spaces] {
            fs::write(&own, contents).unwrap();
            call_line(&format!("{line} {}", own.display()))
                .refused(1, &["own.toml is no camera that this program wrote"]);
            assert_eq!(fs::read_to_string(&own).unwrap(), *contents, "{line}");
        }
    }
}

#[test]
fn a_single_file_of_the_programs_is_replaced_and_so_is_an_empty_one() {
    let folder = TempDir::new().unwrap();
    let out = folder.path().join("out");
    for (line, kind) in commands_of_single_files(folder.path()) {
        // These need pictures of chessboards, labels and marked lanes; what they write is tried where they are tested.
        if matches!(kind, "sheet" | "plot") || line.contains("chessboard") || line.contains("calibrate mount")
        {
            continue;
        }
        fs::write(&out, "").unwrap();
        for _ in 0..2 {
            call_line(&format!("{line} {}", out.display())).done();
            assert!(fs::metadata(&out).unwrap().len() > 0);
        }
    }
}

/// Mode of a file or folder.
fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().permissions().mode() & 0o777
}

/// Everything in a folder and below it.
fn everything_in(folder: &Path) -> Vec<std::path::PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| if path.is_dir() { [everything_in(&path), vec![path]].concat() } else { vec![path] })
        .collect()
}

#[test]
fn what_a_camera_saw_is_its_owners_alone() {
    let (folder, drive) = (TempDir::new().unwrap(), Drive::get());
    let [simulated, run, converted] = ["drive", "run", "converted"].map(|name| folder.path().join(name));
    let shared = folder.path().join("shared");
    let [map, route] = [drive.map(), drive.route()];
    // The loosest umask that there is.
    let script = |line: &str| {
        let script = format!("umask 0; exec {} {line}", env!("CARGO_BIN_EXE_fingerpost"));
        Called::from(Command::new("sh").args(["-c", &script]).output().unwrap()).done()
    };
    script(&format!(
        "simulate --map {} --route {} --frames 3 --size 320x240 --out {}",
        map.display(),
        route.display(),
        simulated.display()
    ));
    let input = drive.pictures(6);
    script(&format!("{} --pictures 0-1", drive.run_line(input.path(), &run)));
    let recording = run.join("run.mcap");
    script(&format!(
        "convert mcap {} --image-topic /camera/image --height-m 1.4 --out {}",
        recording.display(),
        converted.display()
    ));
    for out in [&simulated, &run, &converted] {
        assert_eq!(mode(out), 0o700, "{}", out.display());
        let all = everything_in(out);
        assert!(all.len() > 4, "{all:?}");
        for path in all {
            assert_eq!(mode(&path), if path.is_dir() { 0o700 } else { 0o600 }, "{}", path.display());
        }
    }
    // A folder that its owner shares stays shared, and so does a file that was there; what is new in it is the owner's.
    fs::create_dir(&shared).unwrap();
    fs::set_permissions(&shared, fs::Permissions::from_mode(0o755)).unwrap();
    script(&drive.run_line(input.path(), &shared));
    assert_eq!((mode(&shared), mode(&shared.join("run.mcap"))), (0o755, 0o600));
    // What tells of no camera's pictures is as the user's other files.
    let planned = folder.path().join("planned.geojson");
    script(&format!(
        "route --map {} --from 47,9.5 --to 47.0005,9.5006 --out {}",
        map.display(),
        planned.display()
    ));
    assert_eq!(mode(&planned), 0o666);
}

#[test]
fn a_folder_in_use_is_refused_and_a_killed_holder_holds_nothing() {
    let stub = VideoStub::new("while cat $PICTURE; do :; done");
    let out = TempDir::new().unwrap();
    let mut child = endless_run(&stub, out.path(), &["env"]);
    let second = Drive::get().run_line(&Drive::get().path(), out.path());
    call_line(&second).refused(1, &["is in use by process", &child.id().to_string(), " run ", "since 20"]);
    signal("-KILL", &child);
    child.wait().unwrap();
    call_line(&format!("{second} --frames 4")).done();
    assert_eq!(frames(out.path()).len(), 4);
    assert!(!out.path().join(".fingerpost.lock").exists());
}

#[test]
fn two_people_do_not_mark_in_one_folder() {
    let pictures = Drive::get().pictures(2);
    let out = TempDir::new().unwrap();
    let line = format!("mark {} --port 0 --out {}", pictures.path().display(), out.path().display());
    let mut first = command().args(line.split_whitespace()).stderr(Stdio::piped()).spawn().unwrap();
    wait_until("the page is not served", || out.path().join(".fingerpost.json").exists());
    // A second page that is served ends with an exit code of its own.
    let mut second = Command::new("timeout");
    second.args(["60", env!("CARGO_BIN_EXE_fingerpost")]).args(line.split_whitespace());
    let called = Called::from(second.output().unwrap());
    called.refused(1, &["is in use by process", &first.id().to_string(), " mark "]);
    signal("-KILL", &first);
    first.wait().unwrap();
}

#[test]
fn every_signal_that_ends_programs_leaves_a_finished_run_folder() {
    let stub = VideoStub::new("while cat $PICTURE; do :; done");
    for name in ["-INT", "-TERM", "-HUP"] {
        let out = TempDir::new().unwrap();
        // The tests themselves may run under nohup.
        let child = endless_run(&stub, out.path(), &["env", "--default-signal=HUP"]);
        signal(name, &child);
        let called = Called::from(child.wait_with_output().unwrap());
        called.refused(1, &["interrupted after", "results so far are in"]);
        let summary = summary(out.path());
        assert!(summary.interrupted && out.path().join("report.html").exists(), "{name}");
        assert_eq!(summary.frames, frames(out.path()).len() as u64, "{name}");
    }
}

#[test]
fn a_program_that_outlives_its_terminal_goes_on() {
    let stub = VideoStub::new("while cat $PICTURE; do :; done");
    let out = TempDir::new().unwrap();
    let child = endless_run(&stub, out.path(), &["nohup"]);
    signal("-HUP", &child);
    let before = lines(out.path());
    wait_until("the run ended with its terminal", || lines(out.path()) >= before + 5);
    signal("-TERM", &child);
    Called::from(child.wait_with_output().unwrap()).refused(1, &["interrupted after"]);
}

#[test]
fn a_full_disk_keeps_the_files_that_were_there() {
    let drive = Drive::get();
    let folder = TempDir::new().unwrap();
    let [route, camera, signals] =
        ["route.geojson", "camera.toml", "can.csv"].map(|name| folder.path().join(name));
    const POINTS: &str = "80,180,6,1.5;240,180,6,-1.5;110,150,12,1.5;210,150,12,-1.5";
    let input = drive.path();
    let bus = ["can.log", "car.dbc", "can.toml"].map(|name| input.join(name).display().to_string());
    let lines = [
        format!(
            "route --map {} --from 47,9.5 --to 47,9.5014 --out {}",
            drive.map().display(),
            route.display()
        ),
        format!("calibrate points --image-size 320x240 --points {POINTS} --out {}", camera.display()),
        format!("can {} --dbc {} --config {} --out {}", bus[0], bus[1], bus[2], signals.display()),
    ];
    for line in &lines {
        call_line(line).done();
    }
    for (line, path) in lines.iter().zip([&route, &camera, &signals]) {
        // One line more than the program writes.
        let before = fs::read_to_string(path).unwrap() + "\n";
        fs::write(path, &before).unwrap();
        let program = env!("CARGO_BIN_EXE_fingerpost");
        let script = format!("ulimit -f 0; exec {program} {}", line.replace(';', "\\;"));
        let called = Called::from(Command::new("sh").args(["-c", &script]).output().unwrap());
        called.refused(1, &["cannot be written", "ulimit -f"]);
        assert!(!called.stderr.contains("fingerpost-tmp"), "{}", called.stderr);
        assert_eq!(fs::read_to_string(path).unwrap(), before);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3, "a temporary file is left");
        call_line(line).done();
        assert_ne!(fs::read_to_string(path).unwrap(), before);
    }
}
