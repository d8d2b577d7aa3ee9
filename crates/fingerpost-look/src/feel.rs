//! Settings felt: a stretch of a run that is run again with other settings, each stage before and after.

use std::collections::VecDeque;
use std::fmt;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use fingerpost_format::{FrameRecord, TriedSettings};
use fingerpost_server::{Answer, Cause, Limits, Picture, Request};
use serde::Serialize;
use serde_json::{Value, json};

/// Stretches with changed settings whose pictures are kept: pages may still be asking for them.
const KEPT: usize = 8;
/// What of the time that the server grants a request each of its two stretches may take; the rest is for what their pictures take.
const SHARE_OF_REQUEST: f64 = 0.4;

/// Runs the last seconds up to a frame again.
pub trait Reruns: Send + Sync {
    /// Runs the stretch up to the record at `index` again, with these settings in place of the run's. What takes longer than `longest` is given up.
    ///
    /// # Errors
    /// [`Refusal`] says what it cannot be run with, or how far it came.
    fn run_again(&self, index: usize, changed: &TriedSettings, longest: Duration)
    -> Result<Stretch, Refusal>;

    /// Saves settings that differ from the run's, and gives the command line that runs a drive with them.
    ///
    /// # Errors
    /// [`Refusal`] says what cannot be used, or why it could not be saved.
    fn save(&self, changed: &TriedSettings) -> Result<SavedSettings, Refusal>;
}

/// What cannot be done, and by which setting, where one is to blame.
#[derive(Debug)]
pub struct Refusal {
    /// Key of the setting, with its tables.
    pub key: Option<String>,
    /// Why.
    pub cause: Cause,
}

/// A stretch of a run that was run again.
#[derive(Debug)]
pub struct Stretch {
    /// Where it began.
    pub beginning: Beginning,
    /// What its last frame's record would be.
    pub record: FrameRecord,
    /// What the stages made of that frame, in their order.
    pub stages: Vec<StageView>,
}

/// Where a stretch began.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Beginning {
    /// Number of its first frame in the input.
    pub frame: u64,
    /// Seconds from it to the last.
    pub duration_s: f64,
    /// Its frames that could be used.
    pub frames: usize,
    /// Distance along the route at which it began by the run's record, and its standard deviation, metres; none where the record knows none.
    pub route_m: Option<[f64; 2]>,
}

/// What a stage made of a frame.
#[derive(Debug)]
pub struct StageView {
    /// Its name.
    pub name: &'static str,
    /// What is to be seen.
    pub legend: &'static str,
    /// The picture.
    pub picture: Picture,
}

/// Settings that are saved.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct SavedSettings {
    /// Their file.
    pub file: String,
    /// The command line that runs the drive with them.
    pub command: String,
}

/// What may be felt.
#[derive(Debug, Serialize)]
pub struct Feelable {
    /// The schema of the settings: unit, range, meaning and default of each.
    pub schema: Value,
    /// The run's settings.
    pub values: Value,
    /// Settings that a search has found; none without one.
    pub points: Vec<FoundPoint>,
}

/// Settings that a search has found, to be taken over all at once.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FoundPoint {
    /// What it is called.
    pub name: String,
    /// What came of it on the search's drives, in words.
    pub results: String,
    /// The settings that were searched.
    pub settings: TriedSettings,
}

/// The part of a run's page on which settings are felt.
pub struct FeelPage {
    feelable: Feelable,
    reruns: Box<dyn Reruns>,
    kept: Mutex<Kept>,
}

/// Stretches whose pictures can be asked for.
#[derive(Default)]
struct Kept {
    /// With the run's own settings, up to the record of that index: it is the same for all changes.
    before: Option<(usize, Arc<NumberedStretch>)>,
    /// With others, oldest first.
    after: VecDeque<Arc<NumberedStretch>>,
    next_number: u64,
}

struct NumberedStretch {
    number: u64,
    stretch: Stretch,
}

impl fmt::Debug for FeelPage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("FeelPage").finish_non_exhaustive()
    }
}

impl FeelPage {
    /// A page on which these settings are felt.
    pub fn new(feelable: Feelable, reruns: Box<dyn Reruns>) -> Self {
        Self { feelable, reruns, kept: Mutex::default() }
    }

    /// Answers what is asked beneath `api/feel` of a run of so many records.
    pub(crate) fn answer(&self, records: usize, request: Request<'_>, path: &[&str]) -> Answer {
        let found = |index: &str| index.parse().ok().filter(|index| *index < records);
        match (request.method, path) {
            ("GET", ["settings"]) => Answer::json(200, &self.feelable),
            ("GET", ["stretches", number, stage]) => self.picture(number, stage),
            ("POST", ["records", index]) => match found(index) {
                Some(index) => with_changes(request.body, |changed| self.felt(index, changed)),
                None => {
                    Answer::refused(404, &format!("there is no record {index}; there are {records}, from 0"))
                }
            },
            ("POST", ["saved"]) => {
                with_changes(request.body, |changed| Ok(Answer::json(200, &self.reruns.save(changed)?)))
            }
            _ => Answer::refused(404, "there is no such page; open / instead"),
        }
    }

    fn felt(&self, index: usize, changed: &TriedSettings) -> Result<Answer, Refusal> {
        let longest = Limits::default().request_time.mul_f64(SHARE_OF_REQUEST);
        let before = self.before(index, longest)?;
        let after = if changed.is_empty() { None } else { Some(self.after(index, changed, longest)?) };
        let shown = json!({
            "beginning": before.stretch.beginning,
            "before": before.shown(&[]),
            "after": after.map(|after| after.shown(&before.stretch.stages)),
        });
        Ok(Answer::json(200, &shown))
    }

    /// The stretch with the run's own settings, run once a frame.
    fn before(&self, index: usize, longest: Duration) -> Result<Arc<NumberedStretch>, Refusal> {
        if let Some((_, known)) = self.kept().before.as_ref().filter(|(of, _)| *of == index) {
            return Ok(Arc::clone(known));
        }
        let stretch = self.reruns.run_again(index, &TriedSettings::new(), longest)?;
        let mut kept = self.kept();
        let made = kept.numbered(stretch);
        kept.before = Some((index, Arc::clone(&made)));
        Ok(made)
    }

    fn after(
        &self,
        index: usize,
        changed: &TriedSettings,
        longest: Duration,
    ) -> Result<Arc<NumberedStretch>, Refusal> {
        let stretch = self.reruns.run_again(index, changed, longest)?;
        let mut kept = self.kept();
        let made = kept.numbered(stretch);
        if kept.after.len() == KEPT {
            kept.after.pop_front();
        }
        kept.after.push_back(Arc::clone(&made));
        Ok(made)
    }

    fn kept(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn picture(&self, number: &str, stage: &str) -> Answer {
        let (Ok(number), Ok(stage)) = (number.parse::<u64>(), stage.parse::<usize>()) else {
            return Answer::refused(404, "a picture is NUMBER/STAGE");
        };
        let kept = self.kept();
        let mut all = kept.before.iter().map(|(_, before)| before).chain(&kept.after);
        let found = all.find(|kept| kept.number == number);
        match found.and_then(|kept| kept.stretch.stages.get(stage)) {
            Some(StageView { picture: Picture { content_type, bytes }, .. }) => {
                Answer { status: 200, content_type, body: bytes.clone() }
            }
            None => Answer::refused(404, "this picture is no longer kept; change a setting again"),
        }
    }
}

impl Kept {
    fn numbered(&mut self, stretch: Stretch) -> Arc<NumberedStretch> {
        self.next_number += 1;
        Arc::new(NumberedStretch { number: self.next_number, stretch })
    }
}

impl NumberedStretch {
    /// What a page is told of it; a picture that is the same as `before` is not there twice.
    fn shown(&self, before: &[StageView]) -> Value {
        let stages = self.stretch.stages.iter().enumerate().map(|(index, stage)| {
            let is_same =
                before.iter().any(|other| (other.name, &other.picture) == (stage.name, &stage.picture));
            let picture = (!is_same).then(|| format!("api/feel/stretches/{}/{index}", self.number));
            json!({ "name": stage.name, "legend": stage.legend, "picture": picture })
        });
        json!({ "record": self.stretch.record, "stages": stages.collect::<Vec<_>>() })
    }
}

/// Answers with settings that came as a JSON object, table and all in their keys.
fn with_changes(body: &[u8], answer: impl Fn(&TriedSettings) -> Result<Answer, Refusal>) -> Answer {
    match serde_json::from_slice(body) {
        Ok(changed) => answer(&changed).unwrap_or_else(|Refusal { key, cause }| {
            Answer::json(400, &json!({ "error": cause.to_string(), "key": key }))
        }),
        Err(cause) => Answer::refused(400, &format!("changed settings are a JSON object ({cause})")),
    }
}
