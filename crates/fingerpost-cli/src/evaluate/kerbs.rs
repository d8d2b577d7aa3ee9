//! `fingerpost evaluate kerbs`: the road surface against the kerbs of simulated drives.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::Args;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_eval::{KerbEvaluation, KerbScores};
use fingerpost_format::TruthRecord;
use fingerpost_io::{picture_paths, read_picture};
use rayon::prelude::*;
use serde::Serialize;

use super::print_quantiles;
use crate::examples::examples;
use crate::parts::parts;
use crate::surface_place::probability_at;
use crate::{inputs, output};

/// Kerbs: where the road surface ends against where the kerb is, pavement that is called road, and road that is not.
///
/// Runs the method on drive folders of `simulate` (conditions with kerbs: street, street_shade), whose truth has the kerbs that are
/// seen. Those at least 8 cm high count, 5 to 12 m ahead; 1.5 m behind one is pavement, all between it and the vehicle's axis
/// road. Where the surface goes on beyond the kerb to the end of what is seen, it is missed, and its error is as large as that.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "evaluate kerbs drive",
    "evaluate kerbs drive_a drive_b --config fingerpost.toml --json"
))]
pub(crate) struct KerbsArgs {
    /// Drive folders, as written by `fingerpost simulate`.
    #[arg(value_name = "DRIVE", required = true)]
    drives: Vec<PathBuf>,
    /// Settings of the method; every key is optional.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// All numbers.
#[derive(Debug, Serialize)]
struct KerbNumbers {
    drives: Vec<DriveNumbers>,
    all: KerbEvaluation,
}

/// Those of a drive.
#[derive(Debug, Serialize)]
struct DriveNumbers {
    drive: PathBuf,
    #[serde(flatten)]
    evaluation: KerbEvaluation,
}

/// Compares.
pub(super) fn kerbs(args: &KerbsArgs) -> Result<()> {
    let config = inputs::config(args.config.as_deref())?;
    let scores: Vec<KerbScores> =
        args.drives.par_iter().map(|drive| scores(drive, &config)).collect::<Result<_>>()?;
    let mut all = KerbScores::default();
    scores.iter().for_each(|scores| all.extend(scores));
    let drives = args.drives.iter().zip(&scores);
    let drives: Vec<DriveNumbers> = drives
        .map(|(drive, scores)| DriveNumbers { drive: drive.clone(), evaluation: scores.evaluation() })
        .collect();
    drives.iter().for_each(|of| print(&of.drive.display().to_string(), &of.evaluation));
    let all = all.evaluation();
    if drives.len() > 1 {
        print("all drives", &all);
    }
    if args.json { output::print_json(&KerbNumbers { drives, all }) } else { Ok(()) }
}

fn print(name: &str, numbers: &KerbEvaluation) {
    output::message(&format!(
        "{name}: {} places of kerbs, {:.1} % missed; {:.1} % of the pavement called road, {:.1} % of the road not",
        numbers.kerbs, numbers.missed_pct, numbers.pavement_called_road_pct, numbers.road_not_called_road_pct
    ));
    print_quantiles("error of the kerb's line", "m", numbers.error_m);
}

fn scores(drive: &Path, config: &Config) -> Result<KerbScores> {
    let camera = inputs::camera(&drive.join("camera.toml"))?;
    let truth = inputs::truth(&drive.join("truth.jsonl"))?;
    let paths = picture_paths(drive)?;
    if paths.len() != truth.len() {
        bail!(
            "{} has {} pictures and {} frames of truth; give a drive as `simulate` writes it",
            drive.display(),
            paths.len(),
            truth.len()
        );
    }
    if truth.iter().all(|frame| frame.kerb_left_m.is_empty() && frame.kerb_right_m.is_empty()) {
        bail!("{} has no kerbs; simulate with the conditions street or street_shade", drive.display());
    }
    let mut pipeline = Pipeline::with_parts(config, &camera, None, None, parts(config)?)?;
    let grid = *pipeline.view().grid();
    let mut scores = KerbScores::default();
    let mut before: Option<&TruthRecord> = None;
    for (path, truth) in paths.iter().zip(&truth) {
        let frame = read_picture(path)?;
        let sensors = Sensors { dt_s: before.map(|before| truth.t_s - before.t_s), ..Sensors::default() };
        let (_, evidence) =
            pipeline.step(&frame, sensors, &mut |_| ()).with_context(|| path.display().to_string())?;
        let (probability, validity) = (&evidence.surface.probability, evidence.validity);
        scores.add(truth, |place| probability_at(&grid, probability, validity, place));
        before = Some(truth);
    }
    Ok(scores)
}
