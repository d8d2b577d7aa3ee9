//! `fingerpost tune`: settings that no others beat in everything, searched for on drives with truth.
//!
//! A trial is the method with some settings on all drives that are searched with; the search (`fingerpost-search`) says which
//! settings are tried next. What it asks for follows from its seed and from the trials before, so that a search that was ended in
//! the middle plays its recorded trials back and goes on as if nothing had happened. Drives that are held back are run with the
//! front alone: what is better on the others and not there fits those drives and nothing else.

mod drives;
mod front;
mod keys;
mod screening;
mod search;
mod setup;
mod table;
mod trials;

use std::collections::BTreeSet;
use std::path::PathBuf;

use anyhow::{Error, Result, bail};
use clap::Args;
use clap::builder::PossibleValuesParser;
use fingerpost::Config;
use fingerpost_format::{TuningObjective, TuningPurpose, TuningTrial};
use fingerpost_io::{FolderKind, TuningFolder};
use fingerpost_sim::Conditions;

use self::drives::TuneDrive;
use self::front::Chosen;
use self::keys::{SearchedSettings, WantedKey};
use self::trials::Bench;
use crate::arguments::{InputLimit, PictureSize, Threads, number};
use crate::campaign::{DEFAULT_CONDITIONS, Drawing, WORLD};
use crate::examples::examples;
use crate::interrupt::Interrupt;
use crate::{inputs, output, output_path};

/// Search settings of the method that no others beat in everything, on drives with truth: features missed, false detections, errors
/// of place, honesty of sigma. Ended in the middle, the same call goes on with it.
#[derive(Debug, Args)]
#[command(before_long_help = examples!(
    "tune --campaign 16 --trials 60 --out tuning",
    "tune --drives drive_a drive_b drive_c --start-m 12 --keys track.detect_present=0.6..0.9 --out tuning"
))]
pub(crate) struct TuneArgs {
    /// Drive folders with truth, as `simulate` writes them. Every one of them has the same --start-m.
    #[arg(long, value_name = "DIR", num_args = 1.., required_unless_present = "campaign")]
    drives: Vec<PathBuf>,
    /// Simulate so many drives, as `campaign` draws them, 1 to 1000; they are kept in the folder.
    #[arg(long, value_name = "N", conflicts_with = "drives", value_parser = clap::value_parser!(u64).range(1..=1000))]
    campaign: Option<u64>,
    /// Seed of the search, and of the first drive of --campaign; the others count up from it.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What the drives of --campaign are like; they take these in turns.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', requires = "campaign",
          default_values_t = DEFAULT_CONDITIONS.map(str::to_owned),
          value_parser = PossibleValuesParser::new([WORLD].iter().chain(Conditions::names())))]
    conditions: Vec<String>,
    /// Size of their pictures, pixels: 480x360 by default, and in `world` as drawn.
    #[arg(long, value_name = "WxH", requires = "campaign")]
    size: Option<PictureSize>,
    /// Their frames a second: 10 by default, and in `world` as drawn; 0.1 to 1000.
    #[arg(long, requires = "campaign", value_parser = crate::arguments::simulated_rate)]
    fps: Option<f64>,
    /// OpenStreetMap data to drive on, in place of the built-in town.
    #[arg(long, value_name = "FILE", requires = "campaign")]
    map: Option<PathBuf>,
    #[command(flatten)]
    limit: InputLimit,
    /// Distance along the route at the first frame of --drives, metres, where it is known; -1e6 to 1e6.
    #[arg(long, value_name = "M", requires = "drives", allow_hyphen_values = true,
          value_parser = number(-1e6, 1e6, "place on a route", "metres"))]
    start_m: Option<f64>,
    /// Settings that the search begins with and changes; every key is optional.
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,
    /// Settings to search, each KEY or KEY=LEAST..MOST: numbers, choices and switches of `fingerpost schema`. Without a range a
    /// number is searched from a third of its value to three times as much, within what is allowed.
    #[arg(long, value_name = "KEY,...", value_delimiter = ',', default_values_t = keys::DEFAULT_KEYS.map(str::to_owned))]
    keys: Vec<String>,
    /// Find the settings to search first: the N of a list whose change by itself makes the most difference. Takes about as long as 36 trials
    /// more; CANDIDATES in the source is the list.
    #[arg(long, value_name = "N", conflicts_with = "keys", value_parser = clap::value_parser!(u64).range(1..=screening::CANDIDATES.len() as u64))]
    screen: Option<u64>,
    /// What is to be small, `missed` among it. `ms` is wall time: with it among them two searches give two fronts.
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_values_t = DEFAULT_OBJECTIVES.map(|o| o.name().to_owned()),
          value_parser = PossibleValuesParser::new(TuningObjective::ALL.map(TuningObjective::name)))]
    objectives: Vec<String>,
    /// Settings to try, the first of them those of today, 1 to 100000.
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = clap::value_parser!(u64).range(1..=100_000))]
    trials: u64,
    /// Trials of a generation, 2 to 1000, at most --trials.
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(2..=1000))]
    population: u64,
    /// Share of the drives, the last of them, that the search never sees, 0 to 0.9: the front is tried on them at the end.
    #[arg(long, value_name = "SHARE", default_value_t = 0.3, value_parser = number(0.0, 0.9, "share of drives", "of them"))]
    held_out: f64,
    /// Drives at the same time; as many as the machine has processor cores by default. Results do not depend on it.
    #[arg(long, value_name = "N")]
    threads: Option<Threads>,
    /// Folder to write: a new or empty one, or one of the same search, which is gone on with, also with more trials.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Print what front.json holds on standard output.
    #[arg(long)]
    json: bool,
}

/// What is to be small where nothing else is said: no more than a few dozen trials can tell apart. The median error goes with
/// the 95th percentile, and time is the machine's.
const DEFAULT_OBJECTIVES: [TuningObjective; 4] =
    [TuningObjective::Missed, TuningObjective::False, TuningObjective::ErrorP95, TuningObjective::Sigma];

impl TuneArgs {
    fn objectives(&self) -> Vec<TuningObjective> {
        TuningObjective::ALL
            .into_iter()
            .filter(|objective| self.objectives.iter().any(|name| name == objective.name()))
            .collect()
    }

    /// Whether these arguments search for anything.
    fn check(&self) -> Result<()> {
        if self.population > self.trials {
            bail!(
                "--population {} is more than --trials {}, so that no generation would follow the first; give more trials or a \
                 smaller population",
                self.population,
                self.trials
            );
        }
        if !self.objectives().contains(&TuningObjective::Missed) {
            bail!("--objectives needs missed: without it settings that find nothing are the best; add it");
        }
        Ok(())
    }

    /// How many of so many drives are held back; one at the least is searched with.
    fn held_back(&self, drives: usize) -> usize {
        ((self.held_out * drives as f64).round() as usize).min(drives.saturating_sub(1))
    }

    /// The trials that the search asked for.
    fn searched<'a>(&self, done: &'a [TuningTrial]) -> Vec<&'a TuningTrial> {
        let of_search = |trial: &&TuningTrial| trial.purpose == TuningPurpose::Search;
        done.iter().filter(of_search).filter(|trial| trial.trial < self.trials).collect()
    }

    /// Seed and conditions of every simulated drive.
    fn campaign_drives(&self) -> Result<Vec<(u64, String)>> {
        let count = self.campaign.unwrap_or(0);
        let Some(end) = self.seed.checked_add(count) else {
            bail!("--seed {} leaves no seeds for {count} drives; give a smaller one", self.seed);
        };
        Ok((self.seed..end).zip(self.conditions.iter().cycle().cloned()).collect())
    }
}

/// Searches.
pub(crate) fn tune(args: &TuneArgs) -> Result<()> {
    args.check()?;
    let base = inputs::config(args.config.as_deref())?;
    let named = match args.screen {
        Some(_) => searched(&screening::CANDIDATES, &base)?,
        None => searched(&args.keys, &base)?,
    };
    let files = [&args.map, &args.config].into_iter().flatten().chain(&args.drives).map(PathBuf::as_path);
    output_path::check_folder(&args.out, FolderKind::Tuning, files)?;
    let given = opened(args, &base)?;
    let drawing = args
        .campaign
        .map(|_| Drawing::new(args.map.as_deref(), args.limit, args.size, args.fps, base.clone()));
    let drawing = drawing.transpose()?;
    let interrupt = Interrupt::listen()?;
    let (mut folder, mut done) = TuningFolder::go_on_with(&args.out, &setup::setup(args, &named)?)?;
    let mut drives = match drawing {
        Some(drawing) => simulated(args, &drawing, &folder, &interrupt)?,
        None => given,
    };
    let held_back = drives.split_off(drives.len() - args.held_back(drives.len()));
    let bar = output::progress(Some(args.trials), "trials");
    let bench = |settings| Bench { settings, threads: args.threads, interrupt: &interrupt, bar: &bar };
    let settings = match args.screen {
        Some(keep) => {
            let (bench, objectives) = (bench(&named), args.objectives());
            let kept =
                screening::screen(&bench, keep as usize, &objectives, &drives, &mut done, &mut folder)?;
            let Some(kept) = kept else { bail!("{}", interrupted(&done)) };
            searched(&kept, &base)?
        }
        None => named.clone(),
    };
    let bench = bench(&settings);
    search::search(args, &bench, &drives, &mut done, &mut folder)?;
    let Some(chosen) = Chosen::of(args, &done) else { bail!("{}", interrupted(&done)) };
    if !held_back.is_empty() {
        let chosen = chosen.all();
        bar.inc_length(chosen.len() as u64);
        bench.trials(&chosen, TuningPurpose::HeldBack, &held_back, &mut done, &mut folder)?;
    }
    bar.finish_and_clear();
    if interrupt.wanted() {
        bail!("{}", interrupted(&done));
    }
    let front = chosen.front(args, &done, [drives.len(), held_back.len()]);
    front::write(args, &settings, &front, &done, folder)
}

/// The drive folders that are given.
fn opened(args: &TuneArgs, base: &Config) -> Result<Vec<TuneDrive>> {
    let mut folders = BTreeSet::new();
    for folder in &args.drives {
        if folder.canonicalize().is_ok_and(|whole| !folders.insert(whole)) {
            bail!(
                "--drives names {} twice, and a drive that is searched with cannot be one that is held back; name each once",
                folder.display()
            );
        }
    }
    let given = args.drives.iter().zip(0..);
    given.map(|(folder, number)| TuneDrive::open(folder, number, args.start_m, &base.vehicle)).collect()
}

/// The drives that are drawn from seeds, each simulated when it is first asked for.
fn simulated(
    args: &TuneArgs,
    drawing: &Drawing,
    folder: &TuningFolder,
    interrupt: &Interrupt,
) -> Result<Vec<TuneDrive>> {
    let drives = args.campaign_drives()?;
    let bar = output::progress(Some(drives.len() as u64), "drives");
    let simulated = drives::simulate_all(drawing, &drives, folder, interrupt, &bar)?;
    bar.finish_and_clear();
    Ok(simulated)
}

/// The settings that are named.
fn searched(keys: &[impl AsRef<str>], base: &Config) -> Result<SearchedSettings> {
    let wanted = keys.iter().map(|key| key.as_ref().parse().map_err(Error::msg));
    Ok(SearchedSettings::new(&wanted.collect::<Result<Vec<WantedKey>>>()?, base)?)
}

fn interrupted(done: &[TuningTrial]) -> String {
    format!("interrupted after {} trials; the same call goes on with them", done.len())
}

/// The trial of a number and purpose, where it is done.
fn trial(done: &[TuningTrial], number: u64, purpose: TuningPurpose) -> Option<&TuningTrial> {
    done.iter().find(|trial| trial.trial == number && trial.purpose == purpose)
}
