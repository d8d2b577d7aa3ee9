//! Settings tried on drives, side by side, each trial recorded when its last drive is done.

use std::sync::Mutex;

use anyhow::{Error, Result, bail};
use fingerpost::{Config, Sensors};
use fingerpost_eval::CampaignTally;
use fingerpost_format::{FrameRecord, TrackState, TriedSettings, TuningPurpose, TuningTrial};
use fingerpost_io::{FrameSource, SourceOptions, TuningFolder};
use fingerpost_record::{FrameTime, broken_record};
use indicatif::ProgressBar;

use super::drives::TuneDrive;
use super::keys::SearchedSettings;
use crate::arguments::Threads;
use crate::campaign::{Driven, measure};
use crate::driver::{Driver, RunSetting, Sequence};
use crate::inputs;
use crate::interrupt::Interrupt;
use crate::output;
use crate::recorder::Wishes;
use crate::side_by_side;

/// What trials are done with.
pub(super) struct Bench<'a> {
    pub(super) settings: &'a SearchedSettings,
    pub(super) threads: Option<Threads>,
    pub(super) interrupt: &'a Interrupt,
    pub(super) bar: &'a ProgressBar,
}

/// A trial that is to be done.
#[derive(Debug, Clone)]
pub(super) struct WantedTrial {
    pub(super) trial: u64,
    pub(super) settings: TriedSettings,
}

/// A drive in numbers, and the wall time of the method on it, milliseconds a frame.
type TimedDrive = (Driven, f64);

/// A trial on its way: what came of its drives, or why there is nothing.
struct OpenTrial {
    drives: Vec<TimedDrive>,
    done: usize,
    error: Option<String>,
}

impl Bench<'_> {
    /// Does trials on drives, and gives them in their order with those that `done` has already; each is added to the folder when it
    /// is complete. Fewer where an end is wanted.
    pub(super) fn trials(
        &self,
        wanted: &[WantedTrial],
        purpose: TuningPurpose,
        drives: &[TuneDrive],
        done: &mut Vec<TuningTrial>,
        folder: &mut TuningFolder,
    ) -> Result<()> {
        let recorded = |wanted: &WantedTrial| super::trial(done, wanted.trial, purpose);
        if let Some(other) = wanted
            .iter()
            .find(|wanted| recorded(wanted).is_some_and(|trial| trial.settings != wanted.settings))
        {
            bail!(
                "trial {} is recorded with other settings than the search asks for, as those of another machine may be; choose another \
                 folder",
                other.trial
            );
        }
        let left: Vec<&WantedTrial> = wanted.iter().filter(|wanted| recorded(wanted).is_none()).collect();
        self.bar.inc((wanted.len() - left.len()) as u64);
        let open = |_| Mutex::new(OpenTrial { drives: Vec::new(), done: 0, error: None });
        let trials: Vec<Mutex<OpenTrial>> = left.iter().map(open).collect();
        let results = Mutex::new((done, folder));
        let pieces = (left.len() * drives.len()) as u64;
        side_by_side::each(self.threads, pieces, self.interrupt, |number| {
            let (index, drive) = (number as usize / drives.len(), &drives[number as usize % drives.len()]);
            let Some(outcome) = self.on_drive(&left[index].settings, drive)? else { return Ok(()) };
            let mut trial = trials[index].lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            trial.done += 1;
            match outcome {
                Ok(timed) => trial.drives.push(timed),
                Err(error) => trial.error = Some(output::cause_chain(&error)),
            }
            if trial.done < drives.len() {
                return Ok(());
            }
            let record = trial.record(left[index], purpose);
            let mut results = results.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
            results.1.append(&record)?;
            results.0.push(record);
            self.bar.inc(1);
            Ok(())
        })
    }

    /// The method with these settings on a drive, or why it refuses them; none when an end is wanted.
    ///
    /// # Errors
    /// When the drive cannot be read: that says nothing of the settings, and is not recorded as theirs.
    fn on_drive(&self, settings: &TriedSettings, drive: &TuneDrive) -> Result<Option<Result<TimedDrive>>> {
        let Some(config) = self.settings.config(settings) else {
            return Ok(Some(Err(Error::msg("the settings contradict each other"))));
        };
        self.run(&Config { vehicle: drive.vehicle.clone(), ..config }, drive)
    }

    fn run(&self, config: &Config, drive: &TuneDrive) -> Result<Option<Result<TimedDrive>>> {
        let setting = RunSetting {
            config,
            camera: &drive.camera,
            route: Some(&drive.route),
            start_m: drive.start_m,
            sequence: Sequence::Drive,
        };
        // Other threads are busy with other drives.
        let threads = Some(std::num::NonZeroUsize::MIN);
        let options = SourceOptions { threads, programs: inputs::ffmpeg(), ..SourceOptions::default() };
        let source = FrameSource::open(&drive.folder.to_string_lossy(), &options)?;
        let mut driver = match Driver::new(setting, &Wishes::records_alone(), source.length()) {
            Ok(driver) => driver,
            Err(refused) => return Ok(Some(Err(refused))),
        };
        let mut records: Vec<FrameRecord> = Vec::with_capacity(drive.truth.len());
        for frame in source {
            if self.interrupt.wanted() {
                return Ok(None);
            }
            let time = FrameTime { frame: frame.index, t_s: frame.t_s };
            let seen = match &frame.picture {
                Ok(picture) => {
                    driver.step(time, picture, Sensors::default())?.outcome.map(|seen| seen.record)
                }
                Err(cause) => Err(cause.to_string()),
            };
            let broken = |cause| broken_record(time, records.last(), TrackState::Searching, cause);
            let record = seen.unwrap_or_else(broken);
            records.push(record);
        }
        let ms: f64 = records.iter().flat_map(|record| record.stage_ms.values()).sum();
        let driven = measure(&drive.named, &records, &drive.truth, &drive.route, &driver)?;
        Ok(Some(Ok((driven, ms / records.len().max(1) as f64))))
    }
}

impl OpenTrial {
    /// The trial as a record; without scores where it failed on a drive.
    fn record(&mut self, wanted: &WantedTrial, purpose: TuningPurpose) -> TuningTrial {
        let count = self.drives.len();
        let frames: u64 = self.drives.iter().map(|((drive, _), _)| drive.frames).sum();
        let ms: f64 = self.drives.iter().map(|((drive, _), ms)| ms * drive.frames as f64).sum();
        let mut tally = CampaignTally::new(&[], count as u64);
        for ((drive, claims), _) in self.drives.drain(..) {
            tally.add(drive, claims);
        }
        TuningTrial {
            trial: wanted.trial,
            purpose,
            settings: wanted.settings.clone(),
            scores: self.error.is_none().then(|| (&tally.campaign().total).into()),
            // To the microsecond: finer than what repeats.
            ms_per_frame: (1e3 * ms / frames.max(1) as f64).round() / 1e3,
            error: self.error.clone(),
        }
    }
}
