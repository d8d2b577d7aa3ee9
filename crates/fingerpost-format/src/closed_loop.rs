//! `closed_loop.jsonl` and `closed_loop.json`: drives in which the advice moves the vehicle.

use serde::{Deserialize, Serialize};

use crate::ErrorQuantiles;

/// How a closed-loop drive came to its end.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum LoopEnd {
    /// At the route's end, on the road all along.
    Arrived,
    /// At the route's end, with half of the vehicle off the road on the way.
    ArrivedOffRoad,
    /// The advice stopped the vehicle and said that it is lost.
    StoppedLost,
    /// The advice stopped the vehicle, or left it standing, and did not say that it is lost.
    StoppedUnsaid,
    /// Half of the vehicle was off the road, and it did not find back.
    LeftRoad,
    /// It went on along a road that is not the route's.
    WrongRoad,
    /// It did not come to the end in any sensible time.
    TimedOut,
    /// The drive could not be simulated, or the method gave an error.
    #[default]
    Failed,
}

impl LoopEnd {
    /// All of them, the good one first.
    pub const ALL: [Self; 8] = [
        Self::Arrived,
        Self::ArrivedOffRoad,
        Self::StoppedLost,
        Self::StoppedUnsaid,
        Self::LeftRoad,
        Self::WrongRoad,
        Self::TimedOut,
        Self::Failed,
    ];

    /// Its name in words.
    pub const fn words(self) -> &'static str {
        match self {
            Self::Arrived => "arrived",
            Self::ArrivedOffRoad => "arrived, off the road on the way",
            Self::StoppedLost => "stopped, lost",
            Self::StoppedUnsaid => "stopped, not said to be lost",
            Self::LeftRoad => "left the road",
            Self::WrongRoad => "on another road than the route's",
            Self::TimedOut => "out of time",
            Self::Failed => "failed",
        }
    }
}

/// One frame of a closed-loop drive: what was advised, and where the vehicle then really was.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopFrame {
    /// Seconds since the first frame.
    pub t_s: f64,
    /// Middle of the rear axle, map frame, metres.
    pub x_m: f64,
    /// The same.
    pub y_m: f64,
    /// Direction of the body, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Distance along the route, metres.
    pub route_m: f64,
    /// Left of the middle of the lane, metres.
    pub left_m: f64,
    /// How far beyond the road's edge the wheel is that is farthest off, metres; negative on the road.
    pub wheel_off_m: f64,
    /// Whether the middle of an axle is off the road.
    pub axle_off: bool,
    /// Whether a feature of the route is within [`JUNCTION_M`] along it.
    pub junction: bool,
    /// Whether the advice has a line to steer along.
    pub has_line: bool,
    /// Whether the method says that it is lost.
    pub lost: bool,
    /// What is steered along; empty for nothing.
    pub line: String,
    /// Angle advised, radians.
    pub advised_steer_rad: f64,
    /// Speed advised, m/s.
    pub advised_speed_mps: f64,
    /// Why.
    pub because: String,
}

/// So near to a feature along the route a vehicle is in the junction, metres: the corner's arc and the metres in which it
/// is entered and left.
pub const JUNCTION_M: f64 = 15.0;

/// How often something was how far aside, the vehicle from its lane's middle every half metre of its way among others: counts in steps
/// of [`Self::STEP_M`]; the last holds all beyond.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct CrossTrackCounts(Vec<u64>);

impl CrossTrackCounts {
    /// Width of a step, metres.
    pub const STEP_M: f64 = 0.02;
    /// Steps: to 4 m.
    const STEPS: usize = 200;

    /// Counts a distance, metres, to either side.
    pub fn add(&mut self, left_m: f64) {
        let step = ((left_m.abs() / Self::STEP_M) as usize).min(Self::STEPS - 1);
        if self.0.len() <= step {
            self.0.resize(step + 1, 0);
        }
        self.0[step] += 1;
    }

    /// Counts what another has counted.
    pub fn merge(&mut self, other: &Self) {
        if self.0.len() < other.0.len() {
            self.0.resize(other.0.len(), 0);
        }
        self.0.iter_mut().zip(&other.0).for_each(|(count, more)| *count += more);
    }

    /// How many were counted.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// Median, 95th percentile and largest, each the upper end of its step, metres; none of none.
    pub fn quantiles(&self) -> Option<ErrorQuantiles> {
        let total = self.total();
        let at = |percent: u64| {
            let rank = (total * percent).div_ceil(100).max(1);
            let mut so_far = 0;
            let step = self.0.iter().position(|count| {
                so_far += count;
                so_far >= rank
            });
            // Hundredths of a metre, so that the upper end of a step is a short number.
            step.map(|step| ((step + 1) as f64 * Self::STEP_M * 100.0).round() / 100.0)
        };
        Some(ErrorQuantiles { p50: at(50)?, p95: at(95)?, max: at(100)? })
    }
}

/// A closed-loop drive in numbers: one line of `closed_loop.jsonl`.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopDrive {
    /// The seed it follows from.
    pub seed: u64,
    /// Its conditions.
    pub conditions: String,
    /// The controller that steered.
    pub controller: String,
    /// Length of the route, metres.
    pub route_m: f64,
    /// Features of the route.
    pub features: u64,
    /// How it ended.
    pub end: LoopEnd,
    /// Where along the route it ended, metres.
    pub end_m: f64,
    /// What was said at its end.
    pub because: String,
    /// Frames that the camera took.
    pub frames: u64,
    /// How long it took, seconds.
    pub duration_s: f64,
    /// Distance from the middle of the lane between junctions.
    pub straight: CrossTrackCounts,
    /// The same within [`JUNCTION_M`] of the route's features.
    pub junction: CrossTrackCounts,
    /// The same in metres.
    pub straight_m: Option<ErrorQuantiles>,
    /// The same in metres.
    pub junction_m: Option<ErrorQuantiles>,
    /// How far beyond the road's edge a wheel came, metres; 0 where all stayed on the road.
    pub wheel_off_m: f64,
    /// Frames in which the middle of a wheel was off the road.
    pub wheel_off_frames: u64,
    /// Frames in which the middle of an axle was off the road.
    pub axle_off_frames: u64,
    /// Of these, those in which the method had a line to steer along and did not say that it is lost.
    pub claimed_off_frames: u64,
    /// Where along the route the middle of an axle first left the road, metres.
    pub left_road_at_m: Option<f64>,
    /// Why there are no numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// Closed-loop drives of one controller, and of some conditions or of all, in numbers.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct LoopGroup {
    /// The controller that steered.
    pub controller: String,
    /// Conditions of the drives; none for all.
    pub conditions: Option<String>,
    /// Drives done.
    pub drives: u64,
    /// Of these, arrived, on the road all along.
    pub arrived: u64,
    /// How the drives ended, and how many so.
    pub ends: Vec<(LoopEnd, u64)>,
    /// Features of the routes of all of them.
    pub features: u64,
    /// Distance from the middle of the lane between junctions, every half metre of all drives, metres.
    pub straight_m: Option<ErrorQuantiles>,
    /// The same through junctions.
    pub junction_m: Option<ErrorQuantiles>,
    /// Drives in which the middle of a wheel came off the road.
    pub wheel_off_drives: u64,
    /// Drives in which the middle of an axle came off the road while the method had a line and did not say that it is lost.
    pub claimed_off_drives: u64,
}

/// `closed_loop.json`: the drives of all controllers in a table.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ClosedLoop {
    /// Drives asked for, over all controllers.
    pub drives_wanted: u64,
    /// Whether it was ended before all of them were done.
    pub interrupted: bool,
    /// Controllers in the order they were asked for, of each all drives and then those of each of the conditions.
    pub groups: Vec<LoopGroup>,
    /// Drives that did not arrive on the road, in the order of seeds.
    pub not_arrived: Vec<LoopDrive>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_counts_are_those_of_the_numbers_to_a_step() {
        let mut counts = CrossTrackCounts::default();
        (0..100).for_each(|i| counts.add(if i % 2 == 0 { 0.005 } else { -0.01 } * f64::from(i)));
        let quantiles = counts.quantiles().unwrap();
        assert!((quantiles.max - 1.0).abs() < 0.02 && quantiles.p50 < quantiles.p95);
        assert_eq!(counts.total(), 100);
        assert_eq!(CrossTrackCounts::default().quantiles(), None);
    }

    #[test]
    fn counts_of_two_drives_are_those_of_both() {
        let mut both = CrossTrackCounts::default();
        let (mut one, mut other) = (CrossTrackCounts::default(), CrossTrackCounts::default());
        for i in 0..50 {
            let left_m = 0.013 * f64::from(i);
            both.add(left_m);
            if i % 3 == 0 { one.add(left_m) } else { other.add(-left_m) }
        }
        one.merge(&other);
        assert_eq!(one, both);
        let far = {
            let mut far = CrossTrackCounts::default();
            far.add(1e9);
            far
        };
        assert!((far.quantiles().unwrap().max - 4.0).abs() < 1e-9);
    }
}
