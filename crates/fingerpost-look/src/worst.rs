//! The frames of a run in which most speaks against what it claims, by its records alone: no truth is needed.

use fingerpost_format::{FeatureRecord, FrameRecord};

use crate::events::{Event, EventKind};
use crate::peaks::greatest_apart;

/// A followed feature that is there with more than this probability is not in doubt.
const SURE: f64 = 0.95;
/// Standard deviations that a place may move against the motion: what was known of it before is in it, so that most move far less.
const LEAST_JUMP_SIGMAS: f64 = 1.0;
/// Standard deviations that a measurement may lie from where it was expected, as one in twenty does.
const LEAST_SIGMAS: f64 = 2.0;
/// How many times as long as half of the frames one takes that is slow.
const SLOW: f64 = 1.5;

/// What speaks against a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Against {
    /// A followed feature is hardly there.
    Doubt,
    /// Its place moves against the motion.
    Jump,
    /// A measurement lies far from where the vehicle's place on the map had it.
    Innovation,
    /// It took long.
    Time,
}

/// What speaks against a frame: the more, the greater.
#[derive(Debug, Clone)]
struct Objection {
    index: usize,
    frame: u64,
    against: Against,
    value: f64,
    text: String,
}

/// What speaks against each frame, gathered record by record.
#[derive(Debug, Clone, Default)]
pub(crate) struct Worst {
    objections: Vec<Objection>,
    before: Option<FeatureRecord>,
}

impl Worst {
    /// Goes on with the record of an index.
    pub(crate) fn add(&mut self, index: usize, record: &FrameRecord) {
        let found = [
            (Against::Doubt, doubt(record)),
            (Against::Jump, jump(self.before.as_ref(), record)),
            (Against::Innovation, innovation(record)),
            (Against::Time, time(record)),
        ];
        let frame = record.frame;
        self.objections.extend(found.into_iter().filter_map(|(against, found)| {
            let (value, text) = found?;
            value.is_finite().then_some(Objection { index, frame, against, value, text })
        }));
        self.before = record.feature.clone();
    }

    /// The frames against which most speaks, a few of each kind. `times_s` has the time of every record.
    pub(crate) fn events(&self, times_s: &[f64]) -> Vec<Event> {
        let kinds = [Against::Doubt, Against::Jump, Against::Innovation, Against::Time];
        kinds.into_iter().flat_map(|against| self.events_of(against, times_s)).collect()
    }

    fn events_of(&self, against: Against, times_s: &[f64]) -> Vec<Event> {
        let of_kind: Vec<&Objection> =
            self.objections.iter().filter(|objection| objection.against == against).collect();
        let least = if against == Against::Time { SLOW * median(&of_kind) } else { 0.0 };
        let great = of_kind.iter().filter(|objection| objection.value > least);
        let worst = greatest_apart(great.map(|objection| (objection.index, objection.value)), times_s);
        let objection = |(index, _)| of_kind.iter().find(|objection| objection.index == index);
        let event = |objection: &&Objection| Event {
            index: objection.index,
            frame: objection.frame,
            kind: EventKind::Worst,
            text: objection.text.clone(),
        };
        worst.into_iter().filter_map(objection).map(event).collect()
    }
}

fn median(objections: &[&Objection]) -> f64 {
    let mut values: Vec<f64> = objections.iter().map(|objection| objection.value).collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

fn doubt(record: &FrameRecord) -> Option<(f64, String)> {
    let feature = record.feature.as_ref()?;
    let present = feature.present.filter(|present| *present < SURE)?;
    Some((1.0 - present, format!("in doubt: {} is there with probability {present:.2}", feature.id)))
}

/// How far the feature lies from where its last place and the motion put it.
fn jump(before: Option<&FeatureRecord>, record: &FrameRecord) -> Option<(f64, String)> {
    let (before, feature) = (before?, record.feature.as_ref()?);
    let motion = record.motion.as_ref().filter(|motion| motion.doubt.is_none())?;
    let (x, y) = (before.forward_m - motion.forward_m, before.left_m - motion.left_m);
    let (sin, cos) = libm::sincos(motion.yaw_rad);
    let [forward_m, left_m] = [cos * x + sin * y, cos * y - sin * x];
    let off_m = [feature.forward_m - forward_m, feature.left_m - left_m];
    let jumps = sigmas(off_m, feature.sigma_m).filter(|sigmas| *sigmas > LEAST_JUMP_SIGMAS)?;
    let text = format!(
        "jump: {} lies {:.2} m from where the motion puts it, {jumps:.1} sigma",
        feature.id,
        libm::hypot(off_m[0], off_m[1])
    );
    (before.id == feature.id).then_some((jumps, text))
}

/// The measurement of the place on the map that lies farthest from where it was expected, for its doubt.
fn innovation(record: &FrameRecord) -> Option<(f64, String)> {
    let measured = record.fix.as_ref()?.measurements.iter();
    let far = measured.filter_map(|measurement| {
        Some((sigmas(measurement.innovation_m?, measurement.sigma_m?)?, measurement))
    });
    let (contradicts, measurement) = far.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let [x, y] = measurement.innovation_m?;
    let what = match measurement.id {
        Some(id) => id.to_string(),
        None if measurement.kind == "gps" => "GPS".to_owned(),
        None => measurement.kind.clone(),
    };
    let used = if measurement.accepted { "used all the same" } else { "not used" };
    let off_m = libm::hypot(x, y);
    let text = format!(
        "contradiction: {what} puts the vehicle {off_m:.1} m from its place on the map, {contradicts:.1} sigma; {used}"
    );
    (contradicts > LEAST_SIGMAS).then_some((contradicts, text))
}

/// How many standard deviations an offset is; none where it has none.
fn sigmas([x, y]: [f64; 2], [sigma_x, sigma_y]: [f64; 2]) -> Option<f64> {
    Some(libm::hypot(x / sigma_x, y / sigma_y)).filter(|sigmas| sigmas.is_finite())
}

fn time(record: &FrameRecord) -> Option<(f64, String)> {
    let (stage, most_ms) = record.stage_ms.iter().max_by(|a, b| a.1.total_cmp(b.1))?;
    let total_ms: f64 = record.stage_ms.values().sum();
    let stage = stage.replace('_', " ");
    Some((total_ms, format!("slow: {total_ms:.0} ms, of which {most_ms:.0} ms {stage}")))
}

#[cfg(test)]
mod tests;
