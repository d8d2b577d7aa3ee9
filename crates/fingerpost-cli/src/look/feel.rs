//! Settings felt on a run: its last seconds up to a frame are run again.

mod ahead;
mod front;
mod open;
mod save;
mod stretch;

use std::sync::{Mutex, PoisonError};
use std::thread::{self, ScopedJoinHandle};
use std::time::{Duration, Instant};

use anyhow::{Context, Error, Result, bail};
use fingerpost::{Config, ConfigError, PipelineError, Sensors};
use fingerpost_format::{FrameRecord, TriedSettings};
use fingerpost_geometry::Camera;
use fingerpost_look::{Beginning, Refusal, Reruns, SavedSettings, StageView, Stretch};
use fingerpost_map::Route;
use fingerpost_record::FrameTime;
use fingerpost_report::{Scene, StagePicture, StagePictures};
use fingerpost_server::Picture;
use fingerpost_vision::jpeg::{ChromaSampling, jpeg_file};
use rayon::prelude::*;
use serde_json::Value;

use super::run_files::RecordFile;
use crate::changed_settings::with_changes;
use crate::driver::{Driver, RunSetting, Sequence};
use crate::recorder::Wishes;

use self::ahead::{AheadTask, FoundAhead};
pub(super) use self::open::open;
use self::save::SettingsFile;
use self::stretch::{Deadline, Frames, StretchFrame, StretchPictures};

/// JPEG quality of the stages' pictures.
const STAGE_QUALITY: u8 = 85;
/// Settings that name files, and those of what a stretch is run without: a page changes none of them.
const NOT_FELT: [&str; 2] = ["road_surface.onnx", "can"];

/// A run whose stretches are run again.
struct RunAgain {
    config: Config,
    /// The camera of the pictures as the method gets them.
    camera: Camera,
    /// None of a run that followed none.
    route: Option<Route>,
    frames: Frames,
    records: RecordFile,
    /// One stretch at a time: each takes two cores for itself, and decoding all of them.
    kept: Mutex<Kept>,
    file: SettingsFile,
}

/// What is the same in every stretch up to the same frame.
struct Kept {
    pictures: StretchPictures,
    /// What is found ahead in it by the run's settings, by the index of the last frame.
    ahead: Option<(usize, FoundAhead)>,
}

impl RunAgain {
    /// The run's settings with these in place of its own.
    fn changed(&self, changed: &TriedSettings) -> Result<Config, Refusal> {
        let config = with_changes(&self.config.to_json(), changed)
            .map_err(|error| Refusal { key: error.key().map(str::to_owned), cause: error.into() })?;
        // Whatever the keys are: a table may be given as a whole.
        if (&config.road_surface.onnx, &config.can) != (&self.config.road_surface.onnx, &self.config.can) {
            let key = changed.keys().find(|key| NOT_FELT.iter().any(|table| key.starts_with(table))).cloned();
            let cause = "this names a file, or is of the vehicle's bus; set it in the file of --config";
            return Err(Refusal { key, cause: cause.into() });
        }
        Ok(config)
    }

    /// Where the vehicle was on the route by the record of a frame, with its standard deviation, metres.
    fn route_m(&self, index: usize) -> Result<Option<[f64; 2]>> {
        let record: FrameRecord = serde_json::from_slice(&self.records.bytes(index)?)?;
        let sigma_m = record.feature.as_ref().map(|feature| {
            let [ahead_m, across_m] = feature.sigma_m;
            libm::hypot(ahead_m, across_m)
        });
        let start_sigma_m = self.config.route_progress.start_sigma_m;
        Ok(record.route_m.map(|route_m| [route_m, sigma_m.unwrap_or(start_sigma_m)]))
    }

    fn stretch(
        &self,
        index: usize,
        mut config: Config,
        changed: &TriedSettings,
        deadline: Deadline,
    ) -> Result<Stretch> {
        let mut kept = self.kept.lock().unwrap_or_else(PoisonError::into_inner);
        let first = kept.pictures.load_up_to(index, &self.frames, deadline)?;
        let route_m = self.route_m(first)?.filter(|_| self.route.is_some());
        if let Some([_, sigma_m]) = route_m
            && !changed.contains_key("route_progress.start_sigma_m")
        {
            config.route_progress.start_sigma_m = sigma_m;
        }
        let setting = RunSetting {
            config: &config,
            camera: &self.camera,
            route: self.route.as_ref(),
            start_m: route_m.map(|[route_m, _]| route_m),
            sequence: Sequence::Drive,
        };
        let task = match kept.ahead.as_ref().filter(|(of, _)| *of == index) {
            Some((_, known)) => AheadTask::with_changes(known, changed),
            None => AheadTask::whole(),
        };
        let loaded: Vec<StretchFrame<'_>> = kept.pictures.loaded(&self.frames).collect();
        let followed = thread::scope(|scope| {
            let find = || task.run(&config, &self.camera, &loaded, deadline);
            let ahead = (!task.is_done()).then(|| scope.spawn(find));
            let followed = follow(setting, &task.found, &loaded, deadline);
            match ahead.map(ScopedJoinHandle::join) {
                None | Some(Ok(Ok(()))) => followed,
                Some(Ok(Err(cause))) => Err(cause),
                Some(Err(_)) => bail!("the program failed at this stretch; its standard error says why"),
            }
        })?;
        if changed.is_empty() {
            kept.ahead = Some((index, task.found));
        }
        let of = self.frames.time(index);
        let last = followed.last.filter(|(record, _)| record.frame == of.frame);
        let (record, drawn) =
            last.with_context(|| format!("frame {} cannot be used; choose another", of.frame))?;
        let FrameTime { frame, t_s } = self.frames.time(first);
        let beginning = Beginning { frame, duration_s: of.t_s - t_s, frames: followed.frames, route_m };
        let stages = drawn.pictures.into_par_iter().map(stage_view).collect::<Result<_>>()?;
        Ok(Stretch { beginning, record, stages })
    }
}

/// What came of a stretch.
struct Followed {
    /// Its frames that could be used.
    frames: usize,
    /// The record of its last frame, with its pictures; none where that could not be used.
    last: Option<(FrameRecord, StagePictures)>,
}

/// Follows the route through a stretch of which the stages ahead are known, or found meanwhile.
fn follow(
    setting: RunSetting<'_>,
    ahead: &FoundAhead,
    frames: &[StretchFrame<'_>],
    deadline: Deadline,
) -> Result<Followed> {
    let parts = ahead.repeating_parts(setting.config)?;
    let wishes = Wishes::records_alone();
    let mut driver = Driver::with_parts(setting, &wishes, None, parts)?.without_key_frames();
    let mut followed = Followed { frames: 0, last: None };
    for (index, frame) in frames.iter().enumerate() {
        deadline.check(index, frames.len())?;
        let is_last = index + 1 == frames.len();
        let mut drawn = None;
        let mut draw = |scene: &Scene<'_>| drawn = is_last.then(|| StagePictures::draw_on_all_cores(scene));
        let result = driver.step_showing(frame.time, frame.picture, Sensors::default(), &mut draw)?;
        if let Ok(seen) = result.outcome {
            followed.frames += 1;
            followed.last = Some(seen.record).zip(drawn);
        }
    }
    Ok(followed)
}

fn stage_view(StagePicture { stage, legend, picture }: StagePicture) -> Result<StageView> {
    let bytes = jpeg_file(&picture, STAGE_QUALITY, ChromaSampling::Halved)?;
    Ok(StageView { name: stage, legend, picture: Picture { content_type: "image/jpeg", bytes } })
}

/// What the method refuses, with the setting where it names one.
fn refusal(error: Error) -> Refusal {
    let key = match error.downcast_ref::<PipelineError>() {
        Some(PipelineError::Config(ConfigError { key, .. })) => Some(key.clone()),
        _ => None,
    };
    Refusal { key, cause: format!("{error:#}").into() }
}

impl Reruns for RunAgain {
    fn run_again(
        &self,
        index: usize,
        changed: &TriedSettings,
        longest: Duration,
    ) -> Result<Stretch, Refusal> {
        let config = self.changed(changed)?;
        self.stretch(index, config, changed, Deadline(Instant::now() + longest)).map_err(refusal)
    }

    fn save(&self, changed: &TriedSettings) -> Result<SavedSettings, Refusal> {
        let config = self.changed(changed)?;
        self.file.save(&config).map_err(refusal)
    }
}

/// The schema of the settings that can be felt.
fn schema() -> Value {
    let mut schema = Config::schema().clone();
    for table in NOT_FELT {
        let (place, name) = match table.rsplit_once('.') {
            Some((table, name)) => {
                (format!("/properties/{}/properties", table.replace('.', "/properties/")), name)
            }
            None => ("/properties".to_owned(), table),
        };
        if let Some(properties) = schema.pointer_mut(&place).and_then(Value::as_object_mut) {
            properties.remove(name);
        }
    }
    schema
}
