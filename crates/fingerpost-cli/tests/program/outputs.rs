//! What commands may write: nothing of the user's is replaced, and what is written is whole.

use std::fs;
use std::os::unix::fs::symlink;
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
    let before = "as it was ".repeat(100);
    for path in [&route, &camera, &signals] {
        fs::write(path, &before).unwrap();
    }
    for (line, path) in lines.iter().zip([&route, &camera, &signals]) {
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
