//! Inputs and programs that give nothing any more: they are given up, one Ctrl-C is enough, and nothing is left running.

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

/// What a camera's description looks like.
const DESCRIBE: &str = r#"echo '{"streams":[{"avg_frame_rate":"10/1","r_frame_rate":"10/1"}]}'"#;
/// Hangs, deaf to every signal that can be ignored.
const HANG: &str = "trap '' TERM INT HUP PIPE; exec sleep 1000";
/// Long enough for everything on a machine that is busy with other tests, and far shorter than what hangs.
const PATIENCE: Duration = Duration::from_secs(60);
/// "Within a second", and what a busy machine adds.
const AT_ONCE: Duration = Duration::from_secs(4);

/// Where something hangs.
struct Hang {
    name: &'static str,
    describe: String,
    play: String,
    arguments: &'static [&'static str],
    /// Frames that come before.
    frames: usize,
}

fn hangs() -> Vec<Hang> {
    let three = "cat $PICTURE $PICTURE $PICTURE";
    let encoder = |instead: &str| format!("case \"$*\" in *libx264*) {instead};; esac\n{three}");
    let hang = |name, play: String, arguments, frames| Hang {
        name,
        describe: DESCRIBE.to_owned(),
        play,
        arguments,
        frames,
    };
    vec![
        Hang { describe: HANG.to_owned(), ..hang("ffprobe", String::new(), &[], 0) },
        hang("the first frame", HANG.to_owned(), &[], 0),
        hang("the fourth frame", format!("{three}; {HANG}"), &[], 3),
        hang("the fourth frame, in one thread", format!("{three}; {HANG}"), &["--threads", "1"], 3),
        hang("half a frame", format!("{three}; head -c 1000 $PICTURE; {HANG}"), &[], 3),
        hang("after the end", format!("{three}; exec >&-; {HANG}"), &[], 3),
        hang("an encoder that takes nothing", encoder(HANG), &["--video"], 0),
        hang("an encoder that does not end", encoder(&format!("cat > /dev/null; {HANG}")), &["--video"], 3),
    ]
}

impl Hang {
    fn stub(&self) -> VideoStub {
        VideoStub::described(&self.describe, &self.play)
    }

    fn start(&self, stub: &VideoStub, out: &TempDir, timeout_s: &str) -> Child {
        let mut command = stub.run(&out.path().join("run"));
        command.args(self.arguments).args(["--timeout-s", timeout_s]);
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// Waits until it hangs: all frames that can be are written, and the program rests.
    fn wait_for_it(&self, stub: &VideoStub, out: &TempDir) {
        let path = out.path().join("run/frames.jsonl");
        let lines = || fs::read_to_string(&path).unwrap_or_default().lines().count();
        let began = Instant::now();
        while lines() < self.frames || stub.running().is_empty() {
            assert!(began.elapsed() < PATIENCE, "{}: the run does not get going", self.name);
            sleep(Duration::from_millis(20));
        }
        sleep(Duration::from_millis(300));
    }
}

fn nothing_is_left(stub: &VideoStub, name: &str) {
    let began = Instant::now();
    while !stub.running().is_empty() {
        assert!(began.elapsed() < AT_ONCE, "{name}: {:?} still run", stub.running());
        sleep(Duration::from_millis(20));
    }
}

fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}

#[test]
fn what_stalls_is_given_up_in_time() {
    for hang in hangs() {
        let (stub, out) = (hang.stub(), TempDir::new().unwrap());
        let began = Instant::now();
        let called = Called::from(hang.start(&stub, &out, "0.6").wait_with_output().unwrap());
        assert!(began.elapsed() < PATIENCE, "{}", hang.name);
        assert!(!called.stderr.contains("panicked"), "{}: {}", hang.name, called.stderr);
        nothing_is_left(&stub, hang.name);
        let run = out.path().join("run");
        if hang.name == "after the end" {
            // All frames came; how ffmpeg ends is then of no interest but that it is no good end.
            assert_eq!(summary(&run).frames, 3, "{}", called.stderr);
            continue;
        }
        assert_eq!(called.code, Some(1), "{}: {}", hang.name, called.stderr);
        assert!(called.stderr.contains("nothing came for 0.6 s"), "{}: {}", hang.name, called.stderr);
        if hang.frames > 0 {
            assert_eq!(frames(&run).len(), hang.frames, "{}", hang.name);
            assert_eq!(summary(&run).frames, hang.frames as u64, "{}", hang.name);
        }
    }
}

#[test]
fn one_interrupt_ends_whatever_is_waited_for() {
    // SIGHUP is ignored where the tests run under nohup, and with it by the program.
    for (hang, name) in hangs().iter().zip(["-INT", "-TERM"].into_iter().cycle()) {
        let (stub, out) = (hang.stub(), TempDir::new().unwrap());
        let child = hang.start(&stub, &out, "500");
        hang.wait_for_it(&stub, &out);
        signal(&child, name);
        let began = Instant::now();
        let called = Called::from(child.wait_with_output().unwrap());
        assert!(began.elapsed() < AT_ONCE, "{} {name}: {:?}", hang.name, began.elapsed());
        assert_eq!(called.code, Some(1), "{}: {}", hang.name, called.stderr);
        nothing_is_left(&stub, hang.name);
        if hang.frames > 0 {
            assert_eq!(summary(&out.path().join("run")).frames, hang.frames as u64, "{}", hang.name);
        }
    }
}

#[test]
fn nothing_outlives_a_killed_run() {
    for hang in hangs() {
        let (stub, out) = (hang.stub(), TempDir::new().unwrap());
        let mut child = hang.start(&stub, &out, "500");
        hang.wait_for_it(&stub, &out);
        signal(&child, "-KILL");
        child.wait().unwrap();
        nothing_is_left(&stub, hang.name);
    }
}

/// Every file that `run` and `route` read, as a pipe that nobody writes.
#[test]
fn pipes_that_nobody_writes_are_given_up() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    // A calibration is told by its name.
    let named = folder.path().join("pipe.toml");
    symlink(&pipe, &named).unwrap();
    let (pipe, named, out) = (pipe.display(), named.display(), folder.path().join("run"));
    let run = drive.run_line(&drive.path(), &out);
    let route = format!("route --from 47,9.5 --to 47.0005,9.5006 --out {} --map {pipe}", out.display());
    let (input, camera) = (drive.path(), drive.path().join("camera.toml"));
    let without_camera = format!("run {} --out {} --camera {named}", input.display(), out.display());
    let bus = ["can.toml", "car.dbc", "can.log"].map(|name| drive.path().join(name).display().to_string());
    let [config, dbc, log] = &bus;
    let lines = [
        route,
        without_camera,
        format!(
            "run {} --out {} --camera {} --route {pipe}",
            input.display(),
            out.display(),
            camera.display()
        ),
        format!("{run} --config {pipe}"),
        format!("{run} --gps {pipe}"),
        format!("{run} --truth {pipe}"),
        format!("{run} --bank {pipe}"),
        format!("{run} --config {config} --can {log} --dbc {pipe}"),
        format!("{run} --config {config} --dbc {dbc} --can {pipe}"),
    ];
    for line in lines {
        let began = Instant::now();
        let called = call_line(&format!("{line} --timeout-s 0.3"));
        assert!(began.elapsed() < PATIENCE, "{line}");
        if line.contains("--bank") {
            // It is refused before it is read.
            called.refused(1, &["pipe"]);
        } else {
            called.refused(1, &["nothing came for 0.3 s", "--timeout-s"]);
        }
    }
}

/// A bus under way, written into a pipe without an end.
#[test]
fn a_log_that_does_not_end_is_given_up() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let pipe = folder.path().join("pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let write = format!("exec > '{}'; while echo '(1.0) can0 123#00'; do sleep 0.05; done", pipe.display());
    let mut writer = Command::new("sh").args(["-c", &write]).spawn().unwrap();
    let [config, dbc] = ["can.toml", "car.dbc"].map(|name| drive.path().join(name).display().to_string());
    let line = format!("can {} --config {config} --dbc {dbc} --timeout-s 0.5", pipe.display());
    let began = Instant::now();
    call_line(&line).refused(1, &["has not ended after 0.5 s", "socketcan:can0", "--timeout-s"]);
    assert!(began.elapsed() < PATIENCE);
    writer.kill().unwrap();
    writer.wait().unwrap();
}

/// Writes a line into a pipe twenty times a second, for long; `line` may count on with `$i`.
fn drip(pipe: &Path, line: &str) -> Child {
    let write = format!(
        "exec > '{}'; i=0; while [ $i -lt 600 ] && echo \"{line}\"; do i=$((i + 1)); sleep 0.05; done",
        pipe.display()
    );
    Command::new("sh").args(["-c", &write]).spawn().unwrap()
}

/// Whatever drips is no file that ends, however its clock goes on: on a bus that was under way before it is read, the time of what is
/// queued comes at once.
#[test]
fn what_drips_through_a_pipe_is_given_up() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let [config, dbc] = ["can.toml", "car.dbc"].map(|name| drive.path().join(name).display().to_string());
    let (map, out) = (drive.map(), folder.path().join("out"));
    let run = drive.run_line(&drive.path(), &out);
    let no_end = "has not ended after 0.5 s";
    for (line, dripped, said) in [
        (format!("can PIPE --config {config} --dbc {dbc}"), "($i.0) can0 123#00", [no_end, "socketcan:can0"]),
        (
            format!("locate --map {} --motion PIPE --out {}", map.display(), out.display()),
            "$i,10.0,0.0",
            [no_end, "--timeout-s"],
        ),
        (format!("{run} --gps PIPE"), "no sentence $i", [no_end, "--timeout-s"]),
    ] {
        // A pipe of its own: what a killed shell still waits for holds the other's end open, and lets go of it when it likes.
        let own = TempDir::new().unwrap();
        let pipe = own.path().join("pipe");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let mut writer = drip(&pipe, dripped);
        let line = line.replace("PIPE", &pipe.display().to_string());
        call_line(&format!("{line} --timeout-s 0.5")).refused(1, &said);
        writer.kill().unwrap();
        writer.wait().unwrap();
    }
}

/// A pipe that is written slowly is read like a file.
#[test]
fn a_slow_writer_is_waited_for() {
    let (drive, folder) = (Drive::get(), TempDir::new().unwrap());
    let pipe = folder.path().join("route pipe");
    assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    let text = drive.route();
    let write = format!(
        "exec > '{}'; for part in 1 2 3; do sleep 0.2; done; cat '{}'",
        pipe.display(),
        text.display()
    );
    let mut writer = Command::new("sh").args(["-c", &write]).spawn().unwrap();
    let out = folder.path().join("run");
    let (input, camera) = (drive.path(), drive.path().join("camera.toml"));
    let mut run = command();
    run.arg("run").arg(input).arg("--camera").arg(camera).arg("--route").arg(&pipe);
    let called = run.args(["--frames", "2", "--timeout-s", "50"]).arg("--out").arg(&out).output().unwrap();
    Called::from(called).done();
    assert!(writer.wait().unwrap().success());
    assert_eq!(frames(&out).len(), 2);
}
