//! The search itself: what it asks for, done or played back.

use anyhow::{Result, bail};
use fingerpost_format::{TuningPurpose, TuningTrial};
use fingerpost_io::TuningFolder;
use fingerpost_search::{Nsga2, SearchOptions};

use super::drives::TuneDrive;
use super::trials::{Bench, WantedTrial};
use super::{TuneArgs, trial};
use crate::output;

/// Does the trials that the search asks for, generation by generation; those that are recorded are played back.
pub(super) fn search(
    args: &TuneArgs,
    bench: &Bench<'_>,
    drives: &[TuneDrive],
    done: &mut Vec<TuningTrial>,
    folder: &mut TuningFolder,
) -> Result<()> {
    let settings = bench.settings;
    let options = SearchOptions { population: args.population as usize, seed: args.seed };
    let mut search = Nsga2::new(settings.variables(), &settings.start(), options)?;
    let objectives = args.objectives();
    let mut begun = 0;
    while begun < args.trials {
        let points = search.ask(&|values| settings.config(&settings.named(values)).is_some());
        if points.is_empty() {
            output::message(&format!("all that these settings allow was tried after {begun} trials"));
            return Ok(());
        }
        let mut generation: Vec<WantedTrial> = (begun..)
            .zip(&points)
            .map(|(trial, values)| WantedTrial { trial, settings: settings.named(values) })
            .collect();
        generation.truncate((args.trials - begun) as usize);
        begun += generation.len() as u64;
        // The settings that the search begins with come first, by themselves: where they fail nothing else is worth its time.
        let (first, others) = generation.split_at(usize::from(generation[0].trial == 0));
        bench.trials(first, TuningPurpose::Search, drives, done, folder)?;
        if let Some(cause) = trial(done, 0, TuningPurpose::Search).and_then(|first| first.error.as_ref()) {
            bail!("the settings that the search begins with fail on a drive: {cause}");
        }
        bench.trials(others, TuningPurpose::Search, drives, done, folder)?;
        let told: Vec<Vec<f64>> = generation
            .iter()
            .filter_map(|wanted| trial(done, wanted.trial, TuningPurpose::Search))
            .map(|trial| trial.objectives(&objectives))
            .collect();
        // Fewer where an end is wanted, or where the last generation is not a whole one.
        if told.len() < points.len() {
            return Ok(());
        }
        search.tell(told)?;
    }
    Ok(())
}
