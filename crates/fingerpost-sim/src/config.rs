//! What a drive is made from, apart from map, route and camera.

use serde::{Deserialize, Serialize};

use crate::error::check_range;
use crate::{Conditions, CornerStyle, DrivingPlan, SimError};

/// The side of the road on which traffic keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrafficSide {
    /// Left of the centre line, a quarter of the road's width away from it.
    Left,
    /// Right of the centre line, a quarter of the road's width away from it.
    #[default]
    Right,
    /// On the centre line.
    Centre,
}

/// The vehicle that drives.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimVehicle {
    /// Distance from rear to front axle, metres, 1 to 8.
    pub wheelbase_m: f64,
    /// Distance between left and right wheels, metres, 0.5 to 2.5.
    pub track_m: f64,
    /// Width of the body, metres, 0.5 to 3.
    pub width_m: f64,
    /// Radius of the tightest turn of the rear axle's middle, metres, 2 to 15; where corners are drawn one by one.
    pub turning_radius_m: f64,
}

impl Default for SimVehicle {
    /// A medium car.
    fn default() -> Self {
        Self { wheelbase_m: 2.7, track_m: 1.6, width_m: 1.8, turning_radius_m: 5.2 }
    }
}

/// How the driver keeps to the road.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct DrivingHabits {
    /// How far left of the lane's middle the vehicle keeps where there is room, metres, -1 to 1.
    pub aside_m: f64,
    /// How much wider than the road turns across the other lane are driven, share of the radius, 0 to 1; where corners are
    /// drawn one by one.
    pub corner_cutting: f64,
}

/// Settings of a simulated drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SimConfig {
    /// Everything random follows from it.
    pub seed: u64,
    /// Frames a second.
    pub fps: f64,
    /// At most so many frames; none: as many as the route takes.
    pub frames: Option<usize>,
    /// What the drive looks like.
    pub conditions: Conditions,
    /// The vehicle's side of the road.
    pub traffic: TrafficSide,
    /// How the edges of roads are joined where they meet.
    pub corners: CornerStyle,
    /// The vehicle.
    pub vehicle: SimVehicle,
    /// How it keeps to the road.
    pub habits: DrivingHabits,
    /// Speed on a straight road, m/s.
    pub cruise_speed_mps: f64,
    /// Distance along the route at which the first frame is taken, metres.
    pub start_m: f64,
    /// The drive ends so far before the route's end, metres: what lies beyond is not there to be seen.
    pub end_gap_m: f64,
    /// What the driver does on the way.
    pub driving: DrivingPlan,
}

impl Default for SimConfig {
    fn default() -> Self {
        Self {
            seed: 1,
            fps: 10.0,
            frames: None,
            conditions: Conditions::CLEAR,
            traffic: TrafficSide::Right,
            corners: CornerStyle::Alike,
            vehicle: SimVehicle::default(),
            habits: DrivingHabits::default(),
            // 29 km/h, a side street's pace.
            cruise_speed_mps: 8.0,
            start_m: 5.0,
            end_gap_m: 5.0,
            driving: DrivingPlan::default(),
        }
    }
}

impl SimConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`] names the first that is not finite or makes no drive.
    pub fn check(&self) -> Result<(), SimError> {
        check_range("fps", self.fps, 0.1, 1000.0, "0.1 to 1000 frames a second")?;
        check_range("cruise_speed_mps", self.cruise_speed_mps, 1.0, 40.0, "1 to 40 m/s")?;
        check_range("start_m", self.start_m, 0.0, 1e6, "0 or more metres along the route")?;
        check_range("end_gap_m", self.end_gap_m, 0.0, 1e6, "0 or more metres before the route's end")?;
        check_range("vehicle.wheelbase_m", self.vehicle.wheelbase_m, 1.0, 8.0, "1 to 8 metres")?;
        check_range("vehicle.track_m", self.vehicle.track_m, 0.5, 2.5, "0.5 to 2.5 metres")?;
        check_range("vehicle.width_m", self.vehicle.width_m, 0.5, 3.0, "0.5 to 3 metres")?;
        check_range("vehicle.turning_radius_m", self.vehicle.turning_radius_m, 2.0, 15.0, "2 to 15 metres")?;
        check_range("habits.aside_m", self.habits.aside_m, -1.0, 1.0, "-1 to 1 metre")?;
        check_range(
            "habits.corner_cutting",
            self.habits.corner_cutting,
            0.0,
            1.0,
            "a share between 0 and 1",
        )?;
        self.driving.check()?;
        self.conditions.check()
    }
}
