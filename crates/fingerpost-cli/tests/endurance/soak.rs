//! A long run: its memory, its open files and its report do not grow with it.
//!
//! `FINGERPOST_SOAK_FRAMES` is the number of frames, 1500 without it; 100,000 take about ten minutes.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::Duration;

use fingerpost_format::FrameRecord;
use tempfile::TempDir;

use crate::faults::program;

/// Frames of the drive that is repeated.
const DRIVE_FRAMES: usize = 100;
/// Share of the run after which nothing may grow any more.
const WARM_UP_SHARE: f64 = 0.4;
/// Frames after which nothing may grow in a run that is longer.
const MOST_WARM_UP_FRAMES: usize = 5_000;
/// What an allocator may still gather without anything growing, kilobytes. A record kept for every frame, 1 kB or more,
/// would take as much in ten thousand frames.
const MOST_GROWTH_KB: u64 = 8_192;
/// What results take that wait to be written while a key frame is compressed, kilobytes: at most ten, of 0.7 MB each at this
/// picture size, more where the allocator finds no gap for them.
const MOST_WAITING_KB: u64 = 10_240;
/// Memory of this size, bytes, is given back to the system as soon as it is freed, so that what is resident is what is held.
const GIVEN_BACK_BYTES: &str = "131072";
/// Files that are open for a moment while the results at the end are written.
const MOST_MORE_FILES: usize = 4;
/// Largest report.
const MOST_REPORT_BYTES: u64 = 20_000_000;

/// What a process takes at a frame.
#[derive(Debug, Clone, Copy)]
struct Sample {
    frame: usize,
    resident_kb: u64,
    open_files: usize,
}

#[test]
fn nothing_grows_with_the_length_of_a_run() {
    let frames = std::env::var("FINGERPOST_SOAK_FRAMES").map_or(1_500, |text| text.parse().unwrap());
    let folder = TempDir::new().unwrap();
    let drive = folder.path().join("drive");
    simulate(&drive);
    let long = folder.path().join("long");
    repeat(&drive.join("frames"), &long, frames);
    let out = folder.path().join("run");
    let samples = run(&long, &drive, &out);
    let warm = MOST_WARM_UP_FRAMES.min((WARM_UP_SHARE * frames as f64) as usize);
    let later: Vec<Sample> = samples.into_iter().filter(|sample| sample.frame >= warm).collect();
    let (first, last) = (later[0], later[later.len() - 1]);
    let report_bytes = fs::metadata(out.join("report.html")).unwrap().len();
    writeln!(io::stderr(), "{first:?} to {last:?}; report {report_bytes} bytes").unwrap();
    assert!(last.frame > first.frame && later.len() >= 6, "the run was too short to be watched: {later:?}");
    // Results wait now and then, so that single samples differ; what grows is there when none wait, too.
    let (before_kb, after_kb) =
        (least_kb(&later[..later.len() / 3]), least_kb(&later[later.len() * 2 / 3..]));
    assert!(after_kb <= before_kb + MOST_GROWTH_KB, "{before_kb} kB to {after_kb} kB: {later:?}");
    let most_kb = later.iter().map(|sample| sample.resident_kb).max().unwrap();
    assert!(
        most_kb <= before_kb + MOST_GROWTH_KB + MOST_WAITING_KB,
        "{before_kb} kB to {most_kb} kB: {later:?}"
    );
    assert!(later.iter().all(|sample| sample.open_files <= first.open_files + MOST_MORE_FILES), "{later:?}");
    assert!(report_bytes < MOST_REPORT_BYTES, "{report_bytes}");
}

/// The least that was taken at any of `samples`, kilobytes.
fn least_kb(samples: &[Sample]) -> u64 {
    samples.iter().map(|sample| sample.resident_kb).min().unwrap()
}

fn simulate(drive: &Path) {
    let options = format!(
        "simulate --course country --length-m 300 --frames {DRIVE_FRAMES} --size 160x120 --conditions ideal --out {}",
        drive.display()
    );
    let done = Command::new(program()).args(options.split_whitespace()).output().unwrap();
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
}

/// A folder of so many pictures: those of another, again and again.
fn repeat(pictures: &Path, into: &Path, frames: usize) {
    let mut names: Vec<_> = fs::read_dir(pictures).unwrap().map(|entry| entry.unwrap().path()).collect();
    names.sort();
    fs::create_dir(into).unwrap();
    for frame in 0..frames {
        let picture = &names[frame % names.len()];
        let name = format!("{frame:06}.{}", picture.extension().unwrap().to_str().unwrap());
        symlink(picture, into.join(name)).unwrap();
    }
}

/// Runs the method, watching the process.
fn run(pictures: &Path, drive: &Path, out: &Path) -> Vec<Sample> {
    let mut child = Command::new(program())
        .arg("run")
        .arg(pictures)
        .arg("--camera")
        .arg(drive.join("camera.toml"))
        .arg("--out")
        .arg(out)
        // Else glibc learns from the first large buffer that is freed to keep such ones, and what once waited counts for ever.
        .env("MALLOC_MMAP_THRESHOLD_", GIVEN_BACK_BYTES)
        .env("MALLOC_TRIM_THRESHOLD_", GIVEN_BACK_BYTES)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let process = Path::new("/proc").join(child.id().to_string());
    let mut samples = Vec::new();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{status}");
            return samples;
        }
        // With the summary the run is at its end, and the report is made, whose size has a bound of its own.
        if !out.join("summary.json").exists() {
            samples.extend(sample(&process, &out.join("frames.jsonl")));
        }
        sleep(Duration::from_millis(200));
    }
}

/// What the process takes now; none before it writes and when it has ended.
fn sample(process: &Path, records: &Path) -> Option<Sample> {
    let frame = last_frame(records)?;
    let status = fs::read_to_string(process.join("status")).ok()?;
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(Sample {
        frame,
        resident_kb: resident.trim().strip_suffix(" kB")?.trim().parse().ok()?,
        open_files: fs::read_dir(process.join("fd")).ok()?.count(),
    })
}

/// The frame of the last whole line.
fn last_frame(records: &Path) -> Option<usize> {
    const TAIL_BYTES: u64 = 1 << 16;
    let mut file = File::open(records).ok()?;
    let start = file.metadata().ok()?.len().saturating_sub(TAIL_BYTES);
    file.seek(SeekFrom::Start(start)).ok()?;
    let mut tail = Vec::new();
    file.read_to_end(&mut tail).ok()?;
    let lines = String::from_utf8_lossy(&tail);
    let (whole, _) = lines.rsplit_once('\n')?;
    let record: FrameRecord = serde_json::from_str(whole.lines().last()?).ok()?;
    usize::try_from(record.frame).ok()
}
