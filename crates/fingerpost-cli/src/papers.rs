//! `fingerpost papers`: what the papers claim, measured again on simulated drives.
//!
//! Drives are rendered once, frame by frame, and every setting that is compared sees the same frame, so that comparisons are made
//! drive by drive and no picture is stored. Each finished drive is a line of `measured.jsonl`; the same call goes on behind them.
//! The page is made of those lines alone.

mod lane_clips;
mod runs;

use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost::Config;
use fingerpost_format::from_json_lines;
use fingerpost_io::{FolderKind, JsonLinesFile, OutputFolder, create_private_folder, write_private_file};
use fingerpost_papers::claims::{
    Asked, Measured, Measurement, Measurements, PLOTS_FOLDER, Page, RENDERED_FPS, ROADS, RoadKind, SAMPLES,
    SIZE_PX, variants,
};

use self::runs::Run;
use crate::arguments::{PictureSize, Threads, number};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::simulate::{Lens, default_camera};
use crate::version::VERSION;
use crate::{output, output_path, side_by_side};

/// Measure the papers' claims again: simulate drives, run the method on them with one setting changed at a time, and write papers.md
/// with plots and a verdict for each claim. Ended in the middle, the same call goes on with it.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "papers --out papers",
    "papers --drives 2 --seconds 8 --out papers"
))]
pub(crate) struct PapersArgs {
    /// Drives of each kind of roads and clips of each sample, 1 to 1000; with one nothing can be decided.
    #[arg(long, value_name = "N", default_value_t = DRIVES, value_parser = clap::value_parser!(u64).range(1..=1000))]
    drives: u64,
    /// Seed of the first drive of each kind; the others count up from it.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(0..=1_000_000_000))]
    seed: u64,
    /// Most seconds of each drive, 0.5 to 1000; by default two features are passed on most of them.
    #[arg(long, value_name = "S", default_value_t = SECONDS, value_parser = number(0.5, 1000.0, "length of a drive", "seconds"))]
    seconds: f64,
    /// Drives at the same time; as many as the machine has processor cores by default. Only times of frames depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<Threads>,
    /// Folder to write: a new or empty one, or one of the same measurements, which are gone on with.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// Drives of each kind where nothing else is said: the fewest with which a loss of some points stands out of the scatter.
const DRIVES: u64 = 6;
/// Seconds of each drive where nothing else is said: a first feature lies 35 to 80 m on, and drives go at 6 to 10 m/s.
const SECONDS: f64 = 14.0;
/// File of what was measured.
const MEASURED_FILE: &str = "measured.jsonl";
/// File of the page.
const PAGE_FILE: &str = "papers.md";

/// The papers' own settings.
const PAPERS_TOML: &str = include_str!("../papers.toml");

/// A drive or clip to be measured.
#[derive(Debug, Clone, Copy)]
enum Piece {
    Drive(RoadKind, u64),
    Clip(&'static str, u64),
}

impl Piece {
    /// Kind and seed, as the file of measurements has them.
    const fn name(&self) -> (&'static str, u64) {
        match self {
            Self::Drive(road, seed) => (road.name, *seed),
            Self::Clip(sample, seed) => (sample, *seed),
        }
    }

    fn measure(&self, frames: usize, interrupt: &Interrupt) -> Result<Option<Measured>> {
        match self {
            Self::Drive(road, seed) => drive(road, *seed, frames, interrupt),
            Self::Clip(sample, seed) => lane_clips::measure(sample, *seed, frames, interrupt),
        }
    }
}

/// Measures all settings on one drive; none when it was interrupted.
fn drive(road: &RoadKind, seed: u64, frames: usize, interrupt: &Interrupt) -> Result<Option<Measured>> {
    let [width, height] = SIZE_PX;
    let camera = default_camera(PictureSize { width, height }, Lens::None)?;
    let settings = Config::from_toml(PAPERS_TOML).context("papers.toml")?;
    let planned = road.plan((&settings, &camera), seed, frames)?;
    let variants = variants(&planned.config);
    let mut runs =
        variants.into_iter().map(|variant| Run::new(variant, &planned)).collect::<Result<Vec<_>>>()?;
    let mut truth = Vec::new();
    for index in 0..planned.simulator.frames() {
        if interrupt.wanted() {
            return Ok(None);
        }
        let frame = planned.simulator.frame(index);
        runs.iter_mut().try_for_each(|run| run.take(index, &frame, &planned.simulator))?;
        truth.push(frame.truth);
    }
    let mut measured = Measured::new();
    runs.into_iter().try_for_each(|run| run.finish(&truth, &mut measured))?;
    Ok(Some(measured))
}

/// Measures what is not measured yet, and writes the page.
pub(crate) fn papers(args: &PapersArgs) -> Result<()> {
    output_path::check_folder(&args.out, FolderKind::Papers, [])?;
    let _folder = OutputFolder::go_on_with(&args.out, FolderKind::Papers)?;
    let path = args.out.join(MEASURED_FILE);
    let (file, lines) = JsonLinesFile::go_on_with(&path)?;
    let before: Vec<Measurement> = from_json_lines(&lines).with_context(|| path.display().to_string())?;
    let frames = (args.seconds * RENDERED_FPS).ceil() as usize;
    let is_of_this = |m: &Measurement| m.written_by == VERSION && m.frames == frames as u64;
    if before.iter().any(|measurement| !is_of_this(measurement)) {
        bail!(
            "{} was measured by another version of the program or with other --seconds; choose another folder, or remove the file",
            path.display()
        );
    }
    let pieces = pieces(args);
    let is_known = |piece: &Piece, known: &[Measurement]| {
        known.iter().any(|known| (known.kind.as_str(), known.seed) == piece.name())
    };
    let left: Vec<Piece> = pieces.iter().copied().filter(|piece| !is_known(piece, &before)).collect();
    let interrupt = Interrupt::listen()?;
    let bar = output::progress(Some(pieces.len() as u64), "drives");
    bar.set_position((pieces.len() - left.len()) as u64);
    let results = Mutex::new((file, before));
    side_by_side::each(args.threads, left.len() as u64, &interrupt, |number| {
        let piece = &left[number as usize];
        let (kind, seed) = piece.name();
        let context = || format!("the drive of seed {seed} ({kind})");
        let Some(values) = piece.measure(frames, &interrupt).with_context(context)? else { return Ok(()) };
        let kind = kind.to_owned();
        let measurement =
            Measurement { kind, seed, frames: frames as u64, written_by: VERSION.to_owned(), values };
        let mut results = results.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        results.0.append(&measurement)?;
        results.1.push(measurement);
        bar.inc(1);
        Ok(())
    })?;
    bar.finish_and_clear();
    let (file, all) = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    file.finish()?;
    if interrupt.wanted() {
        bail!("interrupted; the same call goes on with what is in {}", args.out.display());
    }
    let asked =
        all.into_iter().filter(|m| pieces.iter().any(|piece| piece.name() == (m.kind.as_str(), m.seed)));
    write(args, &Measurements::new(asked.collect()))
}

/// All drives and clips that are asked for, seed by seed, so that what is finished when a call is ended makes a page with fewer drives.
fn pieces(args: &PapersArgs) -> Vec<Piece> {
    let of_seed = |seed: u64| {
        let drives = ROADS.map(|road| Piece::Drive(road, seed)).into_iter();
        drives.chain(SAMPLES.map(|(sample, _)| Piece::Clip(sample, seed)))
    };
    (args.seed..args.seed + args.drives).flat_map(of_seed).collect()
}

fn write(args: &PapersArgs, measurements: &Measurements) -> Result<()> {
    let mut command = "fingerpost papers --out DIR".to_owned();
    if args.drives != DRIVES {
        command.push_str(&format!(" --drives {}", args.drives));
    }
    if args.seed != 1 {
        command.push_str(&format!(" --seed {}", args.seed));
    }
    if (args.seconds - SECONDS).abs() > f64::EPSILON {
        command.push_str(&format!(" --seconds {}", args.seconds));
    }
    let page =
        Page::of(measurements, &Asked { command: &command, drives: args.drives, seconds: args.seconds });
    let plots = args.out.join(PLOTS_FOLDER);
    create_private_folder(&plots)?;
    for (name, svg) in &page.plots {
        write_private_file(&plots.join(name), svg)?;
    }
    let path = args.out.join(PAGE_FILE);
    write_private_file(&path, &page.text)?;
    output::message(&format!("the page is {}", path.display()));
    Ok(())
}
