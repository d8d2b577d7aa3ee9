//! `fingerpost evaluate`: results against truth.

mod kerbs;
mod lanes;
mod road;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use clap::{Args, Subcommand};
use fingerpost_eval::{evaluate_junctions, evaluate_motion, poses_from_kitti, poses_from_truth};
use fingerpost_format::{ErrorQuantiles, FrameRecord, FromJson, Summary, from_json_lines};

use crate::examples::examples;
use crate::{inputs, output};

/// Compare a finished run, or road surfaces, with truth.
#[derive(Debug, Subcommand)]
#[command(before_long_help = examples!(
    "evaluate junctions run --truth drive/truth.jsonl",
    "evaluate road --images pictures --labels labels --road 1"
))]
pub(crate) enum EvaluateCommand {
    Junctions(JunctionsArgs),
    Motion(MotionArgs),
    Kerbs(kerbs::KerbsArgs),
    Lanes(lanes::LanesArgs),
    Road(road::RoadArgs),
}

/// Features detected, falsely detected and arrived at, and the error of their places.
///
/// A feature counts when the vehicle passes it or comes within 10 m; a detection is false when it lies more than 3 m from
/// the feature's true place, or the feature has been passed or is never come to. Quantiles are nearest-rank.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "evaluate junctions run --truth drive/truth.jsonl",
    "evaluate junctions run --truth drive/truth.jsonl --json"
))]
pub(crate) struct JunctionsArgs {
    /// Run folder, as written by `fingerpost run`.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Truth of the same drive, truth.jsonl.
    #[arg(long, value_name = "FILE")]
    truth: PathBuf,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// Ego-motion: distance, heading at the end, and the error of single steps.
#[derive(Debug, Args)]
#[command(group(clap::ArgGroup::new("reference").required(true)))]
#[command(before_long_help = examples!(
    "evaluate motion run --truth drive/truth.jsonl",
    "evaluate motion run --kitti-poses poses/00.txt"
))]
pub(crate) struct MotionArgs {
    /// Run folder, as written by `fingerpost run`.
    #[arg(value_name = "RUN")]
    run: PathBuf,
    /// Truth of the same drive, truth.jsonl.
    #[arg(long, value_name = "FILE", group = "reference")]
    truth: Option<PathBuf>,
    /// Camera poses of the same drive, a KITTI odometry pose file.
    #[arg(long, value_name = "FILE", group = "reference")]
    kitti_poses: Option<PathBuf>,
    /// Print the numbers as JSON on standard output.
    #[arg(long)]
    json: bool,
}

/// Compares.
pub(crate) fn evaluate(command: &EvaluateCommand) -> Result<()> {
    match command {
        EvaluateCommand::Junctions(args) => junctions(args),
        EvaluateCommand::Motion(args) => motion(args),
        EvaluateCommand::Kerbs(args) => kerbs::kerbs(args),
        EvaluateCommand::Lanes(args) => lanes::lanes(args),
        EvaluateCommand::Road(args) => road::road(args),
    }
}

fn junctions(args: &JunctionsArgs) -> Result<()> {
    let records = records(&args.run)?;
    let summary_path = args.run.join("summary.json");
    let summary = Summary::from_json(&fingerpost_io::read_text(&summary_path)?)
        .with_context(|| format!("{} is no summary of a run; run again", summary_path.display()))?;
    let ids: Vec<i64> = summary.features.iter().map(|feature| feature.id).collect();
    let truth = inputs::truth(&args.truth)?;
    let evaluation = evaluate_junctions(&records, &truth, &ids)?;
    let numbers = &evaluation.summary;
    output::message(&format!(
        "{} of {} features detected, {} falsely, {} arrived at",
        numbers.features_detected, numbers.features_total, numbers.false_detections, numbers.arrivals
    ));
    print_quantiles("position error while tracked", "m", numbers.position_error_m);
    print_quantiles("position error on the way through", "m", evaluation.arrived_position_error_m);
    if args.json { output::print_json(&evaluation) } else { Ok(()) }
}

fn motion(args: &MotionArgs) -> Result<()> {
    let records = records(&args.run)?;
    let poses = match (&args.truth, &args.kitti_poses) {
        (_, Some(path)) => {
            let text = fingerpost_io::read_text(path)?;
            poses_from_kitti(&text).with_context(|| path.display().to_string())?
        }
        (Some(path), None) => poses_from_truth(&inputs::truth(path)?),
        (None, None) => Default::default(),
    };
    let evaluation = evaluate_motion(&records, &poses)?;
    output::message(&format!(
        "{:.1} m driven, {:.1} m estimated over {} steps: {:.2} % off, heading {:.2}° off at the end",
        evaluation.true_distance_m,
        evaluation.distance_m,
        evaluation.steps,
        evaluation.motion_error_pct,
        evaluation.end_heading_error_deg
    ));
    print_quantiles("error of a step forward", "m", evaluation.forward_error_m);
    print_quantiles("error of a step to the left", "m", evaluation.left_error_m);
    print_quantiles("error of a step's turn", "°", evaluation.yaw_error_deg);
    if args.json { output::print_json(&evaluation) } else { Ok(()) }
}

fn records(run: &Path) -> Result<Vec<FrameRecord>> {
    let path = run.join("frames.jsonl");
    let text = fingerpost_io::read_text(&path)?;
    from_json_lines(&text).with_context(|| path.display().to_string())
}

fn print_quantiles(what: &str, unit: &str, quantiles: Option<ErrorQuantiles>) {
    if let Some(ErrorQuantiles { p50, p95, max }) = quantiles {
        output::message(&format!(
            "{what}: median {p50:.3} {unit}, p95 {p95:.3} {unit}, largest {max:.3} {unit}"
        ));
    }
}
