//! `fingerpost run` on a whole recording, against the rate at which ffmpeg decodes it and does nothing else.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use fingerpost_format::camera_to_toml;
use fingerpost_io::{FrameSource, SourceOptions};
use fingerpost_vision::simd::InstructionSet;

use crate::footage::{Footage, dashcam};
use crate::measure::{Contestant, Effort, median, side_by_side};
use crate::results::{Figure, Row, Section, set_name};

/// Share of ffmpeg's rate that a run is promised to keep.
const PROMISED_SHARE: f64 = 0.8;
/// Longest that the first result of a large video is promised to take, seconds; and the size of that video, pixels.
const PROMISED_FIRST_S: f64 = 0.3;
const LARGE_PX: (usize, usize) = (1280, 720);
/// Frames that the recording is made to have, by repetition: enough that starting programs does not count.
const FRAMES: u64 = 2000;

/// Runs the program and ffmpeg in turns.
pub fn recording(effort: Effort, footage: &Footage, program: &Path, set: InstructionSet) -> Result<Section> {
    let folder = tempfile::tempdir()?;
    let (video, frames) = long_video(footage, folder.path())?;
    let camera = folder.path().join("camera.toml");
    std::fs::write(&camera, camera_to_toml(&footage.camera)?)?;
    let (width, height) = footage.size();
    let size = format!("{width} x {height}");
    let mut section = Section::new(
        "Recording",
        &format!(
            "milliseconds a frame of whole commands on {frames} frames; ffmpeg decodes and throws the pictures away; the \
             ratio is the share of its rate that `fingerpost run` keeps"
        ),
    );
    let out = folder.path().join("run");
    for (threads, decoder, promised, what) in [
        (None, "libraries", Some(PROMISED_SHARE), "run without --video, both on all cores"),
        (Some("1"), "libraries", Some(PROMISED_SHARE), "run without --video, both with one thread"),
        (None, "ffmpeg", None, "decoded by the program ffmpeg, both on all cores"),
        (Some("1"), "ffmpeg", None, "decoded by the program ffmpeg, both with one thread"),
    ] {
        let ours = whole_command("fingerpost run", frames as f64, || {
            let mut command = Command::new(program);
            command.arg("run").arg(&video).arg("--camera").arg(&camera).arg("--out").arg(&out);
            command.args(["--decoder", decoder, "--instruction-set", &set_name(set)]);
            command.args(threads.iter().flat_map(|threads| ["--threads", threads]));
            command
        });
        let theirs = whole_command("ffmpeg", frames as f64, || {
            let mut command = Command::new("ffmpeg");
            command.args(["-v", "error", "-nostdin"]);
            command.args(threads.iter().flat_map(|threads| ["-threads", threads]));
            command.arg("-i").arg(&video).args(["-map", "0:v:0", "-f", "null", "-"]);
            command
        });
        // A turn is one command.
        let once = Effort { rounds: effort.rounds.min(5), turn_ms: 0.0 };
        let measured = side_by_side(once, &mut [ours, theirs])?;
        section.rows.push(Row::new(what, &size, measured, promised));
    }
    section.figures.push(first_result(effort, footage, program, set)?);
    Ok(section)
}

/// From the start of `fingerpost run` to the end of a run of one frame of a large video, with all that it writes.
fn first_result(effort: Effort, footage: &Footage, program: &Path, set: InstructionSet) -> Result<Figure> {
    let folder = tempfile::tempdir()?;
    let video = folder.path().join("large.mp4");
    let (width, height) = LARGE_PX;
    let status = Command::new("ffmpeg")
        .args(["-v", "error", "-nostdin", "-i"])
        .arg(&footage.video)
        .args(["-map", "0:v:0", "-vf", &format!("scale={width}:{height}"), "-frames:v", "100"])
        .arg(&video)
        .status()
        .context("ffmpeg cannot be started")?;
    ensure!(status.success(), "ffmpeg cannot resize {}", footage.video.display());
    let camera = folder.path().join("camera.toml");
    std::fs::write(&camera, camera_to_toml(&dashcam(width, height)?)?)?;
    let out = folder.path().join("run");
    let mut run = whole_command("fingerpost run", 1.0, || {
        let mut command = Command::new(program);
        command.arg("run").arg(&video).arg("--camera").arg(&camera).arg("--out").arg(&out);
        command.args(["--frames", "1", "--instruction-set", &set_name(set)]);
        command
    });
    let mut times_ms = Vec::new();
    for _ in 0..effort.rounds {
        times_ms.extend((run.time)(1)?);
    }
    Ok(Figure {
        what: format!("start to the end of a run of one frame, {width} x {height}"),
        value: median(&mut times_ms) / 1e3,
        unit: "s",
        promised_most: Some(PROMISED_FIRST_S),
    })
}

/// A command as a contestant; its time is given as one of so many parts.
fn whole_command<'a>(name: &str, parts: f64, command: impl Fn() -> Command + 'a) -> Contestant<'a> {
    let program = name.to_owned();
    let time = move |_| {
        let start = Instant::now();
        let status = command()
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
            .with_context(|| format!("{program} cannot be started"))?;
        ensure!(status.success(), "{program} failed: {status}");
        Ok(vec![start.elapsed().as_secs_f64() * 1e3 / parts])
    };
    Contestant { name: name.to_owned(), time: Box::new(time) }
}

/// The footage's video repeated, without coding it again, and its number of frames.
fn long_video(footage: &Footage, folder: &Path) -> Result<(PathBuf, u64)> {
    let video = folder.join("long.mp4");
    let once = frames_of(&footage.video)?;
    let more = FRAMES.div_ceil(once).saturating_sub(1);
    let status = Command::new("ffmpeg")
        .args(["-v", "error", "-nostdin", "-stream_loop", &format!("{more}"), "-i"])
        .arg(&footage.video)
        .args(["-map", "0:v:0", "-c", "copy"])
        .arg(&video)
        .status()
        .context("ffmpeg cannot be started")?;
    ensure!(status.success(), "ffmpeg cannot repeat {}", footage.video.display());
    let frames = frames_of(&video)?;
    Ok((video, frames))
}

fn frames_of(video: &Path) -> Result<u64> {
    let input = video.to_str().context("the video's path is not UTF-8")?;
    let source = FrameSource::open(input, &SourceOptions::default())?;
    source.length().with_context(|| format!("{input} does not say how many frames it holds"))
}
