//! From the advice to its part of a line of `frames.jsonl`.

use fingerpost::advice::{Advice, Stop};
use fingerpost_format::{AdviceRecord, FiredRuleRecord};

use crate::frame::{ANGLE_DIGITS, DIGITS, rounded};

pub(crate) fn advice_record(advice: &Advice) -> AdviceRecord {
    let rules = advice
        .rules
        .iter()
        .map(|fired| FiredRuleRecord { rule: fired.number, strength: rounded(fired.strength, DIGITS) });
    AdviceRecord {
        steer_rad: rounded(advice.steer_rad, ANGLE_DIGITS),
        speed_mps: rounded(advice.speed_mps, DIGITS),
        controller: advice.controller.name().to_owned(),
        line: advice.line.map(|line| line.name().to_owned()),
        offset_m: advice.line.map(|_| rounded(advice.offset_m, DIGITS)),
        stop: advice.stop.map(|stop| stop_name(stop).to_owned()),
        rules: rules.collect(),
        because: advice.because.clone(),
    }
}

const fn stop_name(stop: Stop) -> &'static str {
    match stop {
        Stop::MotionNotBelieved => "motion_not_believed",
        Stop::NoLine => "no_line",
        Stop::Strayed { .. } => "strayed",
        Stop::LineEnds(_) => "line_ends",
        Stop::Control(_) => "no_rule",
    }
}
