//! The advice over time: what it went by, what it said, and the rules that fired.

use std::collections::BTreeMap;

use fingerpost_format::FrameRecord;

use super::Listed;
use crate::series::{Series, Stretches};

/// The advice of a run over time.
#[derive(Debug, Clone, Default)]
pub(crate) struct AdviceTimeline {
    /// What was steered along.
    pub(crate) lines: Stretches<Option<String>>,
    /// Why the vehicle was to stop.
    pub(crate) stops: Stretches<Option<String>>,
    pub(crate) steer_deg: Series,
    pub(crate) speed_mps: Series,
    pub(crate) offset_m: Series,
    pub(crate) stops_begun: Listed,
    /// By the rule's number.
    pub(crate) rules: BTreeMap<usize, Fired>,
    stopped: bool,
}

/// How a rule took part.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Fired {
    pub(crate) frames: u64,
    /// Sum of its strengths.
    pub(crate) sum: f64,
    pub(crate) most: f64,
}

impl AdviceTimeline {
    pub(super) fn add(&mut self, record: &FrameRecord) {
        let advice = record.advice.as_ref();
        self.lines.push(record.t_s, advice.and_then(|advice| advice.line.clone()));
        self.stops.push(record.t_s, advice.and_then(|advice| advice.stop.clone()));
        self.steer_deg.push(record.t_s, advice.map(|advice| advice.steer_rad.to_degrees()));
        self.speed_mps.push(record.t_s, advice.map(|advice| advice.speed_mps));
        self.offset_m.push(record.t_s, advice.and_then(|advice| advice.offset_m));
        let Some(advice) = advice else { return };
        if advice.stop.is_some() && !self.stopped {
            self.stops_begun.add(record, &advice.because);
        }
        self.stopped = advice.stop.is_some();
        for fired in &advice.rules {
            let rule = self.rules.entry(fired.rule).or_default();
            rule.frames += 1;
            rule.sum += fired.strength;
            rule.most = rule.most.max(fired.strength);
        }
    }
}
