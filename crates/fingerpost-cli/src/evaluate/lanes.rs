//! `fingerpost evaluate lanes`: lane edges against marked ones.

mod table;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::{ArgGroup, Args, ValueEnum};
use fingerpost_eval::{
    LANE_ROI_ROWS, LANE_THRESHOLDS_PX2, LaneEvaluation, LaneMean, LaneMeasure, LpdDivisor, TuSimpleScores,
    evaluate_lanes, evaluate_tusimple, lane_picture_px, mean_of_lanes,
};
use fingerpost_format::{FromJson, Summary, TuSimpleRecord, from_json_lines};
use fingerpost_map::escaped;
use fingerpost_report::{SurfacePlot, surface_svg};
use serde::Serialize;

use self::table::{clip_table, mean_table, tusimple_line};
use super::records;
use crate::arguments::{PictureSize, number};
use crate::examples::examples;
use crate::output_path::FileKind;
use crate::{inputs, output, output_path};

/// Lane edges: Lane Position Deviation, its root and the accuracy over regions of interest and thresholds, by default those of paper 3 (100,
/// 120, 140 and 150 rows; 10, 15 and 20 squared pixels), and the scores of the TuSimple benchmark.
///
/// An edge is true in a frame when the mean squared distance from its truth, along the region's rows that the truth
/// reaches, is at most the threshold; it is false otherwise, and where the run has no edge in any of those rows, or no
/// such frame. Edges found where the truth has none are counted by themselves, and so are false lanes: frames in which an edge
/// is found although the truth has none on either side. Of a truth without any edge, of an unmarked road, they are all that
/// there is to say.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("reference").required(true)))]
#[command(before_long_help = examples!(
    "evaluate lanes run --truth truth.jsonl --plot accuracy.svg",
    "evaluate lanes run --tusimple labels.json"
))]
pub(crate) struct LanesArgs {
    /// Run folders, as written by `fingerpost run`.
    #[arg(value_name = "RUN", required = true)]
    runs: Vec<PathBuf>,
    /// Truth of the same pictures, truth.jsonl; once for every RUN, in their order.
    #[arg(long, value_name = "FILE", group = "reference")]
    truth: Vec<PathBuf>,
    /// Labels in the form of the TuSimple benchmark, a line for every frame of the one RUN, instead of --truth.
    #[arg(long, value_name = "FILE", group = "reference", conflicts_with = "plot")]
    tusimple: Option<PathBuf>,
    /// Rows of the regions of interest, from the picture's base, 1 to 65535.
    #[arg(long, value_name = "N,...", value_delimiter = ',', conflicts_with = "tusimple", default_values_t = LANE_ROI_ROWS,
          value_parser = clap::value_parser!(u32).range(1..=65_535))]
    roi_rows: Vec<u32>,
    /// Thresholds of the Lane Position Deviation, squared pixels, 0 to 1e9.
    #[arg(long, value_name = "PX2,...", value_delimiter = ',', conflicts_with = "tusimple", default_values_t = LANE_THRESHOLDS_PX2,
          value_parser = number(0.0, 1e9, "threshold", "squared pixels"))]
    thresholds: Vec<f64>,
    /// What the sum of an edge's squared distances is divided by: the rows that the truth reaches, or all rows of the region, as
    /// equation 1 of paper 3 is printed.
    #[arg(long, value_enum, default_value = "evaluated", conflicts_with = "tusimple")]
    lpd_divisor: Divisor,
    /// Size of the pictures, where neither run nor truth says it.
    #[arg(long, value_name = "WIDTHxHEIGHT")]
    picture_size: Option<PictureSize>,
    /// Write the mean accuracies as a surface over regions of interest and thresholds, an SVG picture.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Print the numbers as JSON on standard output, and the table on standard error.
    #[arg(long)]
    json: bool,
}

/// What the sum of an edge's squared distances is divided by.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Divisor {
    /// The rows that the truth reaches.
    Evaluated,
    /// All rows of the region.
    Region,
}

impl LanesArgs {
    fn measure(&self) -> LaneMeasure {
        let mut measure = LaneMeasure {
            roi_rows: self.roi_rows.clone(),
            thresholds_px2: self.thresholds.clone(),
            divisor: match self.lpd_divisor {
                Divisor::Evaluated => LpdDivisor::EvaluatedRows,
                Divisor::Region => LpdDivisor::Region,
            },
        };
        measure.roi_rows.sort_unstable();
        measure.roi_rows.dedup();
        measure.thresholds_px2.sort_by(f64::total_cmp);
        measure.thresholds_px2.dedup();
        measure
    }

    fn picture_px(&self) -> Option<[u32; 2]> {
        self.picture_size.map(|size| [size.width as u32, size.height as u32])
    }
}

/// A run that was compared.
#[derive(Debug, Serialize)]
struct Clip {
    run: PathBuf,
    truth: PathBuf,
    #[serde(flatten)]
    evaluation: LaneEvaluation,
}

/// All numbers.
#[derive(Debug, Serialize)]
struct LaneNumbers {
    clips: Vec<Clip>,
    /// None where no truth has edges.
    mean: Option<LaneMean>,
}

/// The numbers of a run against labels of the benchmark.
#[derive(Debug, Serialize)]
struct TuSimpleNumbers<'a> {
    run: &'a Path,
    tusimple: TuSimpleScores,
}

/// Compares.
pub(super) fn lanes(args: &LanesArgs) -> Result<()> {
    if let Some(labels) = &args.tusimple {
        return tusimple(args, labels);
    }
    if let Some(plot) = &args.plot {
        let LaneMeasure { roi_rows, thresholds_px2, .. } = args.measure();
        if roi_rows.len() < 2 || thresholds_px2.len() < 2 {
            bail!(
                "--plot needs two --roi-rows and two --thresholds at the least, or there is no surface; give more or leave it out"
            );
        }
        let runs: Vec<PathBuf> = args.runs.iter().flat_map(|run| output_path::run_files(run)).collect();
        output_path::check_file(plot, FileKind::Plot, args.truth.iter().chain(&runs).map(PathBuf::as_path))?;
    }
    if args.runs.len() != args.truth.len() {
        bail!(
            "there are {} runs and {} truths; give --truth once for every run, in their order",
            args.runs.len(),
            args.truth.len()
        );
    }
    let (given, measure) = (args.picture_px(), args.measure());
    let clips: Vec<Clip> = args
        .runs
        .iter()
        .zip(&args.truth)
        .map(|(run, truth)| clip(run, truth, given, &measure))
        .collect::<Result<_>>()?;
    let evaluations: Vec<LaneEvaluation> = clips.iter().map(|clip| clip.evaluation.clone()).collect();
    let mean = mean_of_lanes(&evaluations);
    let mut text: String = clips
        .iter()
        .map(|clip| clip_table(&escaped(&clip.run.display().to_string()), &clip.evaluation, &measure))
        .collect::<Vec<_>>()
        .join("\n");
    if let Some(mean) = mean.as_ref().filter(|mean| mean.clips > 1) {
        text.push('\n');
        text.push_str(&mean_table(mean, &measure));
    }
    say(args, text.trim_end())?;
    if let Some(path) = &args.plot {
        let mean = mean.as_ref().context(
            "no truth has lane edges, so that there is no accuracy to plot; leave out --plot or name a marked drive",
        )?;
        fingerpost_io::write_file(path, surface_svg(&surface(mean, &measure)))?;
        output::message(&format!("the surface is {}", path.display()));
    }
    if args.json { output::print_json(&LaneNumbers { clips, mean }) } else { Ok(()) }
}

fn tusimple(args: &LanesArgs, labels: &Path) -> Result<()> {
    let [run] = &args.runs[..] else {
        bail!("labels belong to one run, and {} are given; name one RUN", args.runs.len());
    };
    let text = fingerpost_io::read_text(labels)?;
    let lines: Vec<TuSimpleRecord> = from_json_lines(&text).with_context(|| labels.display().to_string())?;
    let picture_px = picture_px(run)?.or(args.picture_px());
    let tusimple = evaluate_tusimple(&records(run)?, &lines, picture_px)
        .with_context(|| format!("{} against {}", run.display(), labels.display()))?;
    say(args, &tusimple_line(&tusimple))?;
    if args.json { output::print_json(&TuSimpleNumbers { run, tusimple }) } else { Ok(()) }
}

fn clip(run: &Path, truth: &Path, given: Option<[u32; 2]>, measure: &LaneMeasure) -> Result<Clip> {
    let records = records(run)?;
    let marked = inputs::truth(truth)?;
    let evaluation = lane_picture_px(picture_px(run)?, &marked, given)
        .and_then(|picture_px| evaluate_lanes(&records, &marked, picture_px, measure))
        .with_context(|| format!("{} against {}", run.display(), truth.display()))?;
    Ok(Clip { run: run.to_owned(), truth: truth.to_owned(), evaluation })
}

/// The size of a run's pictures; none where it ended before it could say.
fn picture_px(run: &Path) -> Result<Option<[u32; 2]>> {
    let path = run.join("summary.json");
    if !path.exists() {
        return Ok(None);
    }
    let summary = Summary::from_json(&fingerpost_io::read_text(&path)?)
        .with_context(|| format!("{} is no summary of a run; run again", path.display()))?;
    Ok(summary.picture_px)
}

/// The table: on standard output, unless data has that.
fn say(args: &LanesArgs, text: &str) -> Result<()> {
    if args.json {
        text.lines().for_each(output::message);
        Ok(())
    } else {
        output::print_text(text)
    }
}

/// Figure 21 of paper 3.
fn surface(mean: &LaneMean, measure: &LaneMeasure) -> SurfacePlot {
    let accuracies: Vec<f64> = mean.cells.iter().map(|cell| cell.accuracy_pct).collect();
    let of = if mean.clips == 1 { "one clip".to_owned() } else { format!("{} clips", mean.clips) };
    SurfacePlot {
        title: format!("Accuracy of the lane edges, mean of {of}"),
        x_label: "deviation threshold, px²".to_owned(),
        xs: measure.thresholds_px2.clone(),
        y_label: "ROI, rows".to_owned(),
        ys: measure.roi_rows.iter().copied().map(f64::from).collect(),
        z_label: "accuracy, %".to_owned(),
        percent: accuracies.chunks(measure.thresholds_px2.len()).map(<[f64]>::to_vec).collect(),
    }
}
