//! A drive on a road that is made up: `simulate --course`.

use clap::{Args, ValueEnum};
use fingerpost_sim::{DrivingManner, DrivingPlan, RoadCourse, SimConfig};

use crate::arguments::CourseLength;

/// Which made-up road, and how it is driven.
#[derive(Debug, Args)]
pub(super) struct CourseArgs {
    /// A made-up road in place of a map and a route, seen by a windscreen camera: 58 degrees, 1.3 m above the road, 1.7 m
    /// ahead of the rear axle, looking 3 degrees down. crossings.jsonl then says when a wheel crosses a line.
    #[arg(long, value_enum, conflicts_with_all = ["map", "route"])]
    pub(super) course: Option<Course>,
    /// Length of the drive on it, 2 to 19000 metres.
    #[arg(long, value_name = "M", default_value_t = CourseLength(1000.0), requires = "course")]
    length_m: CourseLength,
    /// How it is driven.
    #[arg(long, value_enum, default_value = "keeping", requires = "course")]
    driving: Driving,
}

/// A made-up road.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(super) enum Course {
    /// Two lanes a direction, gentle bends, 30 m/s.
    Highway,
    /// One lane a direction, bends of 80 m radius and more, 20 m/s.
    Country,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Driving {
    /// Swaying a little about the lane's middle.
    Keeping,
    /// Leaving the lane to a side now and then, and coming back.
    Drifting,
    /// Changing lanes with the turn signal on.
    Changing,
    /// Standing still now and then.
    Stopping,
}

/// What is left of the road at the drive's end, metres: as far as lines are seen.
const END_GAP_M: f64 = 150.0;

impl CourseArgs {
    /// The road of that kind and its drive.
    pub(super) fn drive(&self, course: Course, seed: u64, config: SimConfig) -> (RoadCourse, SimConfig) {
        let CourseLength(length_m) = self.length_m;
        let road_m = length_m + END_GAP_M + config.start_m;
        let (road, speed_mps) = match course {
            Course::Highway => (RoadCourse::highway(seed, road_m), 30.0),
            Course::Country => (RoadCourse::country(seed, road_m), 20.0),
        };
        let manner = match self.driving {
            Driving::Keeping => DrivingManner::Keeping,
            Driving::Drifting => DrivingManner::Drifting,
            Driving::Changing => DrivingManner::Changing,
            Driving::Stopping => DrivingManner::Stopping,
        };
        let to_m = config.start_m + length_m;
        let config = SimConfig {
            cruise_speed_mps: speed_mps,
            end_gap_m: road.length_m() - to_m,
            driving: DrivingPlan::draw(manner, seed, config.start_m, to_m, speed_mps),
            ..config
        };
        (road, config)
    }
}
