//! `fingerpost campaign`: many simulated drives, each from a seed, and the method on them.
//!
//! A drive follows from its seed and its conditions alone: route, speed, sun, scenery, noise, and of a `world` all the rest. Drives run side by side, one
//! a thread; what is written does not depend on their number. After every drive `campaign.json` is replaced by one that
//! holds it, so that whatever ends the campaign, finished drives stay.

mod closed_loop;
mod drive;
mod plan;
mod road_edges;

use std::path::PathBuf;
use std::sync::Mutex;

use anyhow::{Context, Result, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use fingerpost_control::ControllerName;
use fingerpost_eval::CampaignTally;
use fingerpost_format::{Campaign, CampaignDrive, CampaignGroup, ErrorQuantiles, ToJson};
use fingerpost_io::{FolderKind, OutputFolder, write_private_file};
use fingerpost_sim::Conditions;
use indicatif::ProgressBar;

use self::closed_loop::Fault;
pub(crate) use self::drive::{Driven, measure};
pub(crate) use self::plan::{DEFAULT_CONDITIONS, Drawing, Plan, WORLD};
use crate::arguments::{InputLimit, PictureSize, Threads};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::{inputs, output, output_path, side_by_side};

/// Simulate many short drives, run the method on each and count: features found, falsely found and arrived at, errors of
/// place and of motion, edges of the road in their places, by conditions. The truth is only used to measure the results. With --closed-loop the advice drives the
/// vehicle.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "campaign --drives 8 --conditions clear,shadows --out campaign",
    "campaign --drives 12 --closed-loop --controllers fuzzy --reports --out closed_loop"
))]
pub(crate) struct CampaignArgs {
    /// How many drives, 1 to 1000000.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    drives: u64,
    /// Seed of the first drive; the others count up from it. A drive follows from its seed and its conditions.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What the drives are like; they take these in turns. In all but `world` the days differ, and camera, corners, paint and map
    /// are those of one world; in `world` every drive has its own. By default world, shadows, wet, mixed, dusk, dust, street and
    /// street_shade; with --closed-loop clear, unmarked, shadows, rough, wet, mixed, dusk, dust, hills, knocked, dirty_lens and world.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',',
          value_parser = PossibleValuesParser::new([WORLD].iter().chain(Conditions::names())))]
    conditions: Vec<String>,
    /// Let a simulated vehicle be driven by the advice and nothing else, with camera, map and route: no GPS, no truth. Counts the
    /// drives that arrive, how far from its lane's middle the vehicle is, and failures by kind, for each controller. Ended in the
    /// middle, the same call goes on with it; results are closed_loop.jsonl, closed_loop.json and report.html.
    #[arg(long)]
    closed_loop: bool,
    /// Who steers; every one drives all drives.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "closed_loop",
          default_value = "pure_pursuit,stanley,fuzzy", value_parser = controller)]
    controllers: Vec<ControllerName>,
    /// Something that goes wrong besides, in every drive.
    #[arg(long, value_enum, value_name = "NAME", requires = "closed_loop")]
    fault: Option<Fault>,
    /// Least number of features of a route; routes have up to three more.
    #[arg(long, value_name = "N", requires = "closed_loop", default_value_t = closed_loop::FEATURES,
          value_parser = least_features)]
    features: usize,
    /// OpenStreetMap data to drive on, in place of the built-in town.
    #[arg(long, value_name = "FILE")]
    map: Option<PathBuf>,
    #[command(flatten)]
    limit: InputLimit,
    /// Settings of the method; every key is optional.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Size of the pictures, pixels: 480x360 by default, and in `world` as drawn.
    #[arg(long, value_name = "WxH")]
    size: Option<PictureSize>,
    /// Frames a second: 10 by default, and in `world` as drawn; 0.1 to 1000.
    #[arg(long, value_parser = crate::arguments::simulated_rate)]
    fps: Option<f64>,
    /// Drives at the same time; as many as the machine has processor cores by default. Results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<Threads>,
    /// Write a run folder with report, pictures, route and truth for every drive.
    #[arg(long)]
    reports: bool,
    /// A video of every drive with a report, annotated.mp4; needs ffmpeg.
    #[arg(long, requires_all = ["closed_loop", "reports"])]
    video: bool,
    /// Folder to write campaign.json and the run folders into: a new or empty one, or one of an earlier campaign, which is
    /// replaced.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what campaign.json holds on standard output.
    #[arg(long)]
    json: bool,
}

impl CampaignArgs {
    /// What the drives are like, in turns.
    fn conditions(&self) -> Vec<String> {
        let usual: &[&str] = if self.closed_loop { &closed_loop::CONDITIONS } else { &DEFAULT_CONDITIONS };
        if self.conditions.is_empty() {
            usual.iter().map(|&name| name.to_owned()).collect()
        } else {
            self.conditions.clone()
        }
    }
}

/// A controller by its name.
fn controller(name: &str) -> Result<ControllerName, String> {
    let known = ControllerName::ALL.map(ControllerName::name);
    let found = ControllerName::ALL.into_iter().find(|controller| controller.name() == name);
    found.ok_or_else(|| format!("no controller of that name; choose one of {}", known.join(", ")))
}

/// A number of features that routes may be asked to have at least.
fn least_features(text: &str) -> Result<usize, String> {
    let number = text.parse().ok().filter(|number| (1..=20).contains(number));
    number.ok_or_else(|| format!("{text:?} is no number of features; give 1 to 20"))
}

/// What all drives share.
struct Setting<'a> {
    args: &'a CampaignArgs,
    conditions: Vec<String>,
    drawing: Drawing,
    interrupt: Interrupt,
}

/// Drives, evaluates and counts.
pub(crate) fn campaign(args: &CampaignArgs) -> Result<()> {
    if args.seed.checked_add(args.drives).is_none() {
        bail!("--seed {} leaves no seeds for {} drives; give a smaller one", args.seed, args.drives);
    }
    if args.closed_loop {
        return closed_loop::closed_loop(args);
    }
    let setting = Setting {
        args,
        conditions: args.conditions(),
        drawing: Drawing::new(
            args.map.as_deref(),
            args.limit,
            args.size,
            args.fps,
            inputs::config(args.config.as_deref())?,
        )?,
        interrupt: Interrupt::listen()?,
    };
    let inputs = [&args.map, &args.config].into_iter().flatten().map(PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::Campaign, inputs)?;
    let _folder = OutputFolder::take(&args.out, FolderKind::Campaign)?;
    log::info!(
        "{} drives from seed {}, conditions {}",
        args.drives,
        args.seed,
        setting.conditions.join(", ")
    );
    let bar = output::progress(Some(args.drives), "drives");
    let campaign = drive_all(&setting, &bar)?;
    bar.finish_and_clear();
    if setting.interrupt.wanted() {
        let done = campaign.total.drives;
        bail!(
            "interrupted after {done} of {} drives; results so far are in {}",
            args.drives,
            args.out.display()
        );
    }
    print_table(&campaign);
    output::message(&format!("results in {}", args.out.join(RESULT_FILE).display()));
    if args.json {
        output::print_json(&campaign)?;
    }
    match campaign.drives.iter().find_map(|drive| Some((drive.seed, drive.error.as_ref()?))) {
        Some((seed, error)) => {
            bail!(
                "{} drives failed, the first of them with seed {seed}: {error}",
                campaign.total.drives_failed
            )
        }
        None => Ok(()),
    }
}

/// File of the results.
const RESULT_FILE: &str = "campaign.json";

/// Runs all drives side by side.
fn drive_all(setting: &Setting<'_>, bar: &ProgressBar) -> Result<Campaign> {
    let args = setting.args;
    let tally = Mutex::new(CampaignTally::new(&setting.conditions, args.drives));
    side_by_side::each(args.threads, args.drives, &setting.interrupt, |number| {
        let conditions = &setting.conditions[(number % setting.conditions.len() as u64) as usize];
        let Some((drive, claims)) = drive::drive(setting, args.seed + number, conditions) else {
            return Ok(());
        };
        let CampaignDrive { truth, frames, error, .. } = &drive;
        let error = error.as_deref().unwrap_or("no error");
        log::debug!(
            "drive of seed {} ({conditions}): {frames} frames, {} of {} features found, {} falsely, {error}",
            drive.seed,
            truth.features_detected,
            truth.features_total,
            truth.false_detections
        );
        let mut tally = tally.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        tally.add(drive, claims);
        write(args, &tally.campaign())?;
        bar.set_position(tally.done());
        Ok(())
    })?;
    let tally = tally.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    Ok(tally.campaign())
}

fn write(args: &CampaignArgs, campaign: &Campaign) -> Result<()> {
    let mut text = campaign.to_json().context("the campaign cannot be written as JSON")?;
    text.push('\n');
    Ok(write_private_file(&args.out.join(RESULT_FILE), text)?)
}

fn print_table(campaign: &Campaign) {
    TABLE_HEAD.lines().for_each(output::message);
    for group in campaign.conditions.iter().chain([&campaign.total]) {
        output::message(&line(group));
    }
    for worst in &campaign.worst {
        let p95 = worst.position_error_p95_m.map_or("-".to_owned(), |m| format!("{m:.2} m"));
        output::message(&format!(
            "worst: {} missed, {} false, p95 {p95}: --drives 1 --seed {} --conditions {} --reports shows it",
            worst.missed, worst.false_detections, worst.seed, worst.conditions
        ));
    }
}

/// Columns of the table. Errors are those of a feature's place: over frames, over features, and over frames by the reported
/// standard deviation. The last ones are the shares of confident frames that are off, and of features that were better
/// known before their detection. `edges` is the share of the road's edges that the road surface has within 0.3 m.
const TABLE_HEAD: &str = "\
conditions  drives  features  found  false  arrived  lost     error, m      of features, m    by sigma        sure,    made   distance  edges in
                                                             p50    p95      p50    p95    p68  p95  p99  % off  worse, %  p50, % off  0.3 m, %";

fn line(group: &CampaignGroup) -> String {
    let name = group.conditions.as_deref().unwrap_or("all");
    let CampaignGroup { drives, features_total, false_detections, arrivals, losses, .. } = group;
    let number =
        |value: Option<f64>, digits: usize| value.map_or("-".to_owned(), |value| format!("{value:.digits$}"));
    let errors = |errors: Option<ErrorQuantiles>| {
        [errors.map(|errors| errors.p50), errors.map(|errors| errors.p95)].map(|value| number(value, 2))
    };
    let [p50, p95] = errors(group.position_error_m);
    let [feature_p50, feature_p95] = errors(group.feature_error_m);
    let sigma = group.error_per_sigma;
    let [s68, s95, s99] =
        [sigma.map(|by| by.p68), sigma.map(|by| by.p95), sigma.map(|by| by.p99)].map(|by| number(by, 1));
    let percent = |part: u64, whole: u64| number((whole > 0).then(|| 100.0 * part as f64 / whole as f64), 0);
    let found = percent(group.features_detected, *features_total);
    let off = percent(group.confident_frames_off, group.confident_frames);
    let worse = percent(group.features_made_worse, group.features_expected);
    let distance = number(group.motion_error_pct.map(|error_pct| error_pct.p50), 2);
    let edges = number(group.road_edges.map(|edges| 100.0 * edges.within_share), 1);
    format!(
        "{name:<10}  {drives:>6}  {features_total:>8}  {found:>3} %  {false_detections:>5}  {arrivals:>7}  {losses:>4}  \
         {p50:>6} {p95:>6}   {feature_p50:>6} {feature_p95:>6}  {s68:>5}{s95:>5}{s99:>5}  {off:>5}  {worse:>8}  {distance:>10}  {edges:>8}"
    )
}
