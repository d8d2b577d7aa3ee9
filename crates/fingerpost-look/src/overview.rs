//! A whole run in short.

use fingerpost_format::FrameRecord;
use serde::Serialize;

use crate::curves::{Curve, Quantity};
use crate::events::{Event, Standing, happened};
use crate::worst::Worst;

/// Curves and events of a run, gathered record by record. A record's place in the run is its index; the number of its frame
/// in the input differs from it where not every frame was used.
#[derive(Debug, Clone, Serialize)]
pub struct Overview {
    /// Number of each frame in the input, rising.
    frames: Vec<u64>,
    /// Seconds since the first frame, of each.
    times_s: Vec<f64>,
    curves: Vec<Curve>,
    events: Vec<Event>,
    #[serde(skip)]
    standing: Option<Standing>,
    #[serde(skip)]
    worst: Worst,
}

impl Default for Overview {
    fn default() -> Self {
        Self {
            frames: Vec::new(),
            times_s: Vec::new(),
            curves: Quantity::ALL.map(Curve::of).into(),
            events: Vec::new(),
            standing: None,
            worst: Worst::default(),
        }
    }
}

impl Overview {
    /// Goes on with the next record.
    pub fn add(&mut self, record: &FrameRecord) {
        let before_s = self.times_s.last().copied();
        self.curves.iter_mut().for_each(|curve| curve.add(record, before_s));
        let (events, standing) = happened(self.standing, self.frames.len(), record);
        self.events.extend(events);
        self.worst.add(self.frames.len(), record);
        self.standing = Some(standing);
        self.frames.push(record.frame);
        self.times_s.push(record.t_s);
    }

    /// Names the frames in which most speaks against the run, once all are there.
    pub fn finish(&mut self) {
        self.events.extend(std::mem::take(&mut self.worst).events(&self.times_s));
        self.events.sort_by_key(|event| event.index);
    }

    /// Number of each frame in the input.
    pub fn frames(&self) -> &[u64] {
        &self.frames
    }

    /// Seconds since the first frame, of each.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// Its curves, in the order of [`Quantity::ALL`].
    pub fn curves(&self) -> &[Curve] {
        &self.curves
    }

    /// What happened, and what speaks against the run once it is finished, in the order of the run.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
}

#[cfg(test)]
mod tests;
