//! What no other beats: chosen among the trials, put together with the drives held back, and written.

use anyhow::{Context, Result};
use fingerpost_format::{ToJson, TuningFront, TuningPoint, TuningPurpose, TuningTrial};
use fingerpost_io::TuningFolder;
use fingerpost_report::{FrontInput, front_html};
use fingerpost_search::fronts;

use super::keys::SearchedSettings;
use super::trials::WantedTrial;
use super::{TuneArgs, table, trial};
use crate::output;
use crate::version::{VERSION, WRITTEN_BY};

/// The trials that a front is made of.
pub(super) struct Chosen {
    /// The settings that the search began with.
    first: WantedTrial,
    /// Those that no other beats in everything, by their objectives.
    front: Vec<WantedTrial>,
}

impl Chosen {
    /// The front of the trials that are done; none before the first is.
    pub(super) fn of(args: &TuneArgs, done: &[TuningTrial]) -> Option<Self> {
        let objectives = args.objectives();
        let mut tuned = args.searched(done);
        tuned.sort_by_key(|trial| trial.trial);
        let values: Vec<Vec<f64>> = tuned.iter().map(|trial| trial.objectives(&objectives)).collect();
        let mut front = fronts(&values).into_iter().next()?;
        let by_values = |a: &usize, b: &usize| {
            let pairs = values[*a].iter().zip(&values[*b]);
            pairs.map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne()).unwrap_or(a.cmp(b))
        };
        front.sort_by(by_values);
        let wanted =
            |trial: &TuningTrial| WantedTrial { trial: trial.trial, settings: trial.settings.clone() };
        let first = tuned.iter().find(|trial| trial.trial == 0).map(|trial| wanted(trial))?;
        Some(Self { first, front: front.into_iter().map(|index| wanted(tuned[index])).collect() })
    }

    /// All of them, the first once.
    pub(super) fn all(&self) -> Vec<WantedTrial> {
        let others = self.front.iter().filter(|wanted| wanted.trial != self.first.trial);
        [&self.first].into_iter().chain(others).cloned().collect()
    }

    /// The front with what came of it on either part of the drives.
    pub(super) fn front(&self, args: &TuneArgs, done: &[TuningTrial], drives: [usize; 2]) -> TuningFront {
        let point = |wanted: &WantedTrial, config: Option<String>| {
            let scores = |purpose| trial(done, wanted.trial, purpose).and_then(|trial| trial.scores);
            let [tuned, held_back] = [TuningPurpose::Search, TuningPurpose::HeldBack].map(scores);
            TuningPoint { trial: wanted.trial, config, settings: wanted.settings.clone(), tuned, held_back }
        };
        let name = |number: usize| Some(format!("{number:02}.toml"));
        TuningFront {
            objectives: args.objectives(),
            trials: args.searched(done).len() as u64,
            drives: drives.map(|count| count as u64),
            defaults: point(&self.first, None),
            front: (1..).zip(&self.front).map(|(number, wanted)| point(wanted, name(number))).collect(),
        }
    }
}

/// Writes and shows the front.
pub(super) fn write(
    args: &TuneArgs,
    settings: &SearchedSettings,
    front: &TuningFront,
    done: &[TuningTrial],
    folder: TuningFolder,
) -> Result<()> {
    let mut configs = Vec::new();
    for point in &front.front {
        let config =
            settings.config(&point.settings).context("settings of the front contradict each other")?;
        let text = config.to_toml()?;
        configs.extend(point.config.clone().map(|name| (name, format!("{WRITTEN_BY}{text}"))));
    }
    let mut text = front.to_json().context("the front cannot be written as JSON")?;
    text.push('\n');
    let drives = table::counted(front.drives[0]);
    let title = format!("Search of settings: {} trials on {drives}", front.trials);
    let written_by = format!("fingerpost {VERSION}");
    let report = front_html(&FrontInput { title: &title, front, trials: done, written_by: &written_by });
    folder.finish(&text, &report, &configs)?;
    table::print(front, done);
    output::message(&format!(
        "results in {}; look at {}",
        args.out.display(),
        args.out.join("report.html").display()
    ));
    if args.json {
        output::print_json(front)?;
    }
    Ok(())
}
