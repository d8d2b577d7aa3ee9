//! Two runs of one drive: how far each frame of one differs from the same frame of the other, and where most.

use fingerpost_format::{FrameRecord, TrackState};
use serde::Serialize;
use serde_json::Value;

use crate::events::state_text;
use crate::peaks::greatest_apart;

/// In what two records differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Distance between the places of the feature that both follow.
    Place,
    /// Difference of the probability that the feature which is followed or searched for is there.
    Present,
    /// Difference of the distance along the route.
    Route,
    /// Difference of the road's middle beside the vehicle.
    Centreline,
    /// Difference of the steering angle that is advised.
    Steer,
    /// Difference of the speed that is advised.
    Speed,
}

impl Measure {
    /// All of them, in the order in which a page shows them.
    pub const ALL: [Self; 6] =
        [Self::Place, Self::Present, Self::Route, Self::Centreline, Self::Steer, Self::Speed];

    /// What people call it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Place => "feature's place",
            Self::Present => "present",
            Self::Route => "place on the route",
            Self::Centreline => "road's middle",
            Self::Steer => "steering angle",
            Self::Speed => "speed advised",
        }
    }

    /// Its unit; empty for probabilities.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Place | Self::Route | Self::Centreline => "m",
            Self::Present => "",
            Self::Steer => "°",
            Self::Speed => "m/s",
        }
    }

    /// Its value between two records of a frame; none where either does not say it.
    fn between(self, one: &FrameRecord, other: &FrameRecord) -> Option<f64> {
        let apart = |of: fn(&FrameRecord) -> Option<f64>| Some((of(one)? - of(other)?).abs());
        match self {
            Self::Place => {
                let (one, other) = (one.feature.as_ref()?, other.feature.as_ref()?);
                let apart_m = libm::hypot(one.forward_m - other.forward_m, one.left_m - other.left_m);
                (one.id == other.id).then_some(apart_m)
            }
            Self::Present => {
                let id = |record: &FrameRecord| Some(present(record)?.0);
                (id(one)? == id(other)?).then(|| apart(|record| present(record)?.1)).flatten()
            }
            Self::Route => apart(|record| record.route_m),
            Self::Centreline => apart(|record| Some(record.centreline.as_ref()?.offset_m)),
            Self::Steer => apart(|record| Some(record.advice.as_ref()?.steer_rad.to_degrees())),
            Self::Speed => apart(|record| Some(record.advice.as_ref()?.speed_mps)),
        }
    }
}

/// The feature that is followed or searched for, and how probably it is there.
fn present(record: &FrameRecord) -> Option<(i64, Option<f64>)> {
    let followed = record.feature.as_ref().map(|feature| (feature.id, feature.present));
    followed.or_else(|| record.sought.as_ref().map(|sought| (sought.id, sought.present)))
}

/// Two runs, frame by frame.
#[derive(Debug, Clone, Serialize)]
pub struct Differences {
    /// Number in the input of each frame that both have, rising.
    frames: Vec<u64>,
    /// Seconds since the first frame, of each.
    times_s: Vec<f64>,
    /// Index of its record in either run.
    indices: Vec<[usize; 2]>,
    curves: Vec<DifferenceCurve>,
    /// Where states differ, and where the measures are greatest.
    events: Vec<Difference>,
    /// Settings that differ: key, and the value in either run.
    pub settings: Vec<(String, [Value; 2])>,
    #[serde(skip)]
    standing: Option<Standing>,
}

/// A measure over the frames.
#[derive(Debug, Clone, Serialize)]
struct DifferenceCurve {
    measure: Measure,
    name: &'static str,
    unit: &'static str,
    values: Vec<Option<f64>>,
}

/// A place where the runs differ.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Difference {
    /// Which of the frames that both have, from zero.
    pub index: usize,
    /// Its number in the input.
    pub frame: u64,
    /// How.
    pub kind: DifferenceKind,
    /// The same in words.
    pub text: String,
}

/// How runs differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DifferenceKind {
    /// They come to be in other states, or to follow other features.
    State,
    /// A measure is great.
    Peak,
}

/// State and followed feature of either run.
type Standing = [(TrackState, Option<i64>); 2];

impl Default for Differences {
    fn default() -> Self {
        let curve = |measure: Measure| DifferenceCurve {
            measure,
            name: measure.name(),
            unit: measure.unit(),
            values: Vec::new(),
        };
        Self {
            frames: Vec::new(),
            times_s: Vec::new(),
            indices: Vec::new(),
            curves: Measure::ALL.map(curve).into(),
            events: Vec::new(),
            settings: Vec::new(),
            standing: None,
        }
    }
}

impl Differences {
    /// Goes on with the next frame that both runs have: its records, and their indices in the runs.
    pub fn add(&mut self, indices: [usize; 2], [one, other]: [&FrameRecord; 2]) {
        for curve in &mut self.curves {
            let value = curve.measure.between(one, other).filter(|value| value.is_finite());
            // Finer than a pixel of any curve, and short.
            curve.values.push(value.map(|value| (value * 1e3).round() / 1e3));
        }
        let standing =
            [one, other].map(|record| (record.state, record.feature.as_ref().map(|feature| feature.id)));
        if standing[0] != standing[1] && self.standing != Some(standing) {
            let [first, second] = standing.map(words);
            let (index, frame) = (self.frames.len(), one.frame);
            let text = format!("{first}, the other {second}");
            self.events.push(Difference { index, frame, kind: DifferenceKind::State, text });
        }
        self.standing = Some(standing);
        self.frames.push(one.frame);
        self.times_s.push(one.t_s);
        self.indices.push(indices);
    }

    /// Names the frames in which the runs differ most, once all are there, in the order of the drive.
    pub fn finish(&mut self) {
        for curve in &self.curves {
            let known = curve.values.iter().enumerate().filter_map(|(index, value)| Some((index, (*value)?)));
            for (index, value) in greatest_apart(known.filter(|(_, value)| *value > 0.0), &self.times_s) {
                let text = format!("{} {value:.2} {} apart", curve.name, curve.unit).replace("  ", " ");
                let (frame, kind) = (self.frames[index], DifferenceKind::Peak);
                self.events.push(Difference { index, frame, kind, text });
            }
        }
        self.events.sort_by_key(|event| event.index);
    }

    /// Number in the input of each frame that both runs have.
    pub fn frames(&self) -> &[u64] {
        &self.frames
    }

    /// Where they differ, in the order of the drive once they are finished.
    pub fn events(&self) -> &[Difference] {
        &self.events
    }
}

/// State and followed feature in words.
fn words((state, feature): (TrackState, Option<i64>)) -> String {
    let feature = feature.map_or_else(String::new, |id| format!(" {id}"));
    format!("{}{feature}", state_text(state))
}

#[cfg(test)]
mod tests;
