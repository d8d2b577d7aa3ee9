//! `fingerpost run` on a whole recording, against the rate at which ffmpeg decodes it and does nothing else.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use fingerpost_format::camera_to_toml;
use fingerpost_io::{FrameSource, SourceOptions};
use fingerpost_vision::simd::InstructionSet;

use crate::footage::Footage;
use crate::measure::{Contestant, Effort, side_by_side};
use crate::results::{Row, Section, set_name};

/// Share of ffmpeg's rate that a run is promised to keep.
const PROMISED_SHARE: f64 = 0.8;
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
        let ours = whole_command("fingerpost run", frames, || {
            let mut command = Command::new(program);
            command.arg("run").arg(&video).arg("--camera").arg(&camera).arg("--out").arg(&out);
            command.args(["--decoder", decoder, "--instruction-set", &set_name(set)]);
            command.args(threads.iter().flat_map(|threads| ["--threads", threads]));
            command
        });
        let theirs = whole_command("ffmpeg", frames, || {
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
    Ok(section)
}

fn whole_command<'a>(name: &str, frames: u64, command: impl Fn() -> Command + 'a) -> Contestant<'a> {
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
        Ok(vec![start.elapsed().as_secs_f64() * 1e3 / frames as f64])
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
