//! A drive in which the vehicle goes where it is steered, frame by frame.

use nalgebra::{Point2, Vector2};

use crate::bicycle::{Actuation, Bicycle, DriveCommand};
use crate::drive::VehicleState;
use crate::lane_middle::LinePlace;
use crate::simulator::Moment;
use crate::traffic::HEADWAY_S;
use crate::{SimError, SimFrame, Simulator};

/// Time constant with which an acceleration reaches the body, seconds: springs do not follow a jump.
const SOFTNESS_S: f64 = 0.3;
/// The vehicle ahead drives no slower than this, m/s: nobody waits for one that stands.
const LEADER_MPS: f64 = 3.0;

/// Where a steered vehicle is against where it should be.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SteeredPlace {
    /// Middle of the rear axle, map frame, metres.
    pub p_in_map: Point2<f64>,
    /// Direction of the body, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Speed, m/s.
    pub speed_mps: f64,
    /// Angle of the front wheels, radians, positive to the left.
    pub steer_rad: f64,
    /// Distance along the route, metres.
    pub route_m: f64,
    /// Left of the middle of its lane, metres.
    pub left_m: f64,
    /// Direction against the lane's, radians, positive to the left.
    pub lane_heading_rad: f64,
    /// How far beyond the road's edge the middle of the wheel is that is farthest off, metres; negative on the road.
    pub wheel_off_m: f64,
    /// Whether the middle of the front or of the rear axle is off the road.
    pub axle_off: bool,
}

/// A vehicle that is steered along the roads of a simulator. It begins standing in the middle of its lane where the
/// simulator's own drive begins.
#[derive(Debug, Clone)]
pub struct SteeredDrive<'a> {
    simulator: &'a Simulator,
    vehicle: Bicycle,
    place: LinePlace,
    frame: u64,
    /// How long the vehicle has moved, seconds.
    moved_s: f64,
    /// Accelerations as the body feels them, along and across, m/s2.
    felt_mps2: [f64; 2],
}

impl<'a> SteeredDrive<'a> {
    /// A vehicle before its first command.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`] for an actuation that no vehicle has.
    pub fn new(simulator: &'a Simulator, actuation: Actuation) -> Result<Self, SimError> {
        actuation.check()?;
        let start_m = simulator.drive.start_m();
        let points = simulator.lane_middle.points();
        let at = points.partition_point(|point| point.route_m < start_m).min(points.len() - 1);
        let point = points[at];
        let shape = simulator.vehicle;
        let (wheelbase_m, radius_m) = (shape.wheelbase_m, shape.turning_radius_m);
        let vehicle = Bicycle::standing(point.p_in_map, point.heading_rad, wheelbase_m, radius_m, actuation);
        let place = simulator.lane_middle.place(point.p_in_map, point.heading_rad, start_m);
        Ok(Self { simulator, vehicle, place, frame: 0, moved_s: 0.0, felt_mps2: [0.0; 2] })
    }

    /// Number of the frame that the camera takes now.
    pub const fn frame_index(&self) -> u64 {
        self.frame
    }

    /// Its time, seconds.
    pub fn t_s(&self) -> f64 {
        self.frame as f64 / self.simulator.fps
    }

    /// What the camera sees now.
    pub fn frame(&self) -> SimFrame {
        self.simulator.frame_of(&self.moment())
    }

    /// Where the vehicle is now.
    pub fn place(&self) -> SteeredPlace {
        let Bicycle { p_in_map, heading_rad, speed_mps, steer_rad, .. } = self.vehicle;
        let (sin, cos) = libm::sincos(heading_rad);
        let (forward, left) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let shape = self.simulator.vehicle;
        let edge_m = |ahead_m: f64, aside_m: f64| {
            let p = p_in_map + forward * ahead_m + left * aside_m;
            f64::from(self.simulator.renderer.ground.at(p.x as f32, p.y as f32).edge_m)
        };
        let (wheelbase_m, half_m) = (shape.wheelbase_m, 0.5 * shape.track_m);
        let wheels = [(0.0, half_m), (0.0, -half_m), (wheelbase_m, half_m), (wheelbase_m, -half_m)];
        SteeredPlace {
            p_in_map,
            heading_rad,
            speed_mps,
            steer_rad,
            route_m: self.place.route_m,
            left_m: self.place.left_m,
            lane_heading_rad: self.place.heading_rad,
            wheel_off_m: wheels.iter().map(|&(x, y)| edge_m(x, y)).fold(f64::NEG_INFINITY, f64::max),
            axle_off: [0.0, wheelbase_m].into_iter().any(|x| edge_m(x, 0.0) > 0.0),
        }
    }

    /// Lets the time to the next frame pass while `command` holds.
    pub fn drive(&mut self, command: DriveCommand) {
        let dt_s = 1.0 / self.simulator.fps;
        self.vehicle.drive(command, dt_s);
        self.frame += 1;
        let Bicycle { p_in_map, heading_rad, speed_mps, .. } = self.vehicle;
        self.moved_s += if speed_mps > 0.0 { dt_s } else { 0.0 };
        let share = 1.0 - libm::exp(-dt_s / SOFTNESS_S);
        let across_mps2 = speed_mps * speed_mps * self.vehicle.curvature_per_m();
        for (felt, now) in self.felt_mps2.iter_mut().zip([self.vehicle.lengthwise_mps2(), across_mps2]) {
            *felt += share * (now - *felt);
        }
        self.place = self.simulator.lane_middle.place(p_in_map, heading_rad, self.place.route_m);
    }

    fn moment(&self) -> Moment {
        let Bicycle { p_in_map, heading_rad, speed_mps, .. } = self.vehicle;
        let [lengthwise_mps2, lateral_mps2] = self.felt_mps2;
        let [pitch_rad, roll_rad] =
            self.simulator.drive.body_rad(self.moved_s, lengthwise_mps2, lateral_mps2);
        let state = VehicleState {
            p_in_map,
            heading_rad,
            speed_mps,
            yaw_rate_rps: speed_mps * self.vehicle.curvature_per_m(),
            route_m: self.place.route_m,
            pitch_rad,
            roll_rad,
        };
        let leader_m = self.place.route_m + HEADWAY_S * speed_mps.max(LEADER_MPS);
        Moment { frame: self.frame, t_s: self.t_s(), state, leader_m }
    }
}

/// A straight piece of a road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadStrip {
    /// Its axis from end to end, map frame, metres.
    pub axis: [Point2<f64>; 2],
    /// Half of its width, metres.
    pub half_width_m: f64,
}

impl Simulator {
    /// The roads about the route.
    pub fn road_strips(&self) -> &[RoadStrip] {
        &self.strips
    }

    /// Where along the route its features are, metres.
    pub fn features_m(&self) -> impl Iterator<Item = f64> + '_ {
        self.targets.iter().map(|target| target.route_m)
    }

    /// Where along the route a drive ends, metres.
    pub fn end_m(&self) -> f64 {
        self.drive.end_m()
    }

    /// The middle of the vehicle's lane from the route's start to its end: distance along the route, metres, and place,
    /// map frame, metres.
    pub fn lane_middle(&self) -> impl Iterator<Item = (f64, Point2<f64>)> + '_ {
        self.lane_middle.points().iter().map(|point| (point.route_m, point.p_in_map))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::SimConfig;
    use crate::simulator::tests::in_town;

    /// Pure pursuit of the lane's middle by truth: what the loop can do with nothing unknown.
    fn follow(drive: &SteeredDrive<'_>) -> DriveCommand {
        let place = drive.place();
        let (sin, cos) = libm::sincos(place.heading_rad);
        let ahead = drive.simulator.lane_middle().find(|(route_m, _)| *route_m > place.route_m + 5.0);
        let Some((_, target)) = ahead else { return DriveCommand::default() };
        let offset = target - place.p_in_map;
        let left_m = -sin * offset.x + cos * offset.y;
        let curvature_per_m = 2.0 * left_m / offset.norm_squared();
        DriveCommand { steer_rad: libm::atan(2.7 * curvature_per_m), speed_mps: 5.0 }
    }

    #[test]
    fn a_follower_of_the_truth_drives_the_town_from_end_to_end() {
        let simulator = in_town(&SimConfig::default());
        let mut drive = SteeredDrive::new(&simulator, Actuation::default()).unwrap();
        assert!(drive.place().left_m.abs() < 0.02 && drive.place().speed_mps.abs() < 1e-12);
        let (mut worst_m, mut off_m) = (0.0_f64, f64::NEG_INFINITY);
        while drive.place().route_m < simulator.end_m() - 5.0 {
            assert!(drive.frame_index() < 5000, "stuck at {:?}", drive.place());
            drive.drive(follow(&drive));
            worst_m = worst_m.max(drive.place().left_m.abs());
            off_m = off_m.max(drive.place().wheel_off_m);
        }
        assert!(worst_m < 0.8, "{worst_m} m from the lane's middle");
        assert!(off_m < 0.0 && !drive.place().axle_off, "{off_m} m off the road");
    }

    #[test]
    fn truth_and_picture_are_those_of_where_the_vehicle_is() {
        let simulator = in_town(&SimConfig::default());
        let mut drive = SteeredDrive::new(&simulator, Actuation::default()).unwrap();
        for _ in 0..30 {
            drive.drive(DriveCommand { steer_rad: 0.05, speed_mps: 4.0 });
        }
        let (place, frame) = (drive.place(), drive.frame());
        assert!(place.left_m > 0.2 && place.lane_heading_rad > 0.0, "steered to the left: {place:?}");
        assert!((frame.truth.x_m - place.p_in_map.x).abs() < 1e-12);
        assert!((frame.truth.heading_rad - place.heading_rad).abs() < 1e-12);
        assert!((frame.truth.t_s - 3.0).abs() < 1e-9 && frame.truth.frame == 30);
        assert!(frame.truth.yaw_rate_rps > 0.0);
        let stays = SteeredDrive::new(&simulator, Actuation::default()).unwrap();
        assert_ne!(stays.frame().picture, frame.picture);
    }

    #[test]
    fn off_the_road_is_off_the_road() {
        let simulator = in_town(&SimConfig::default());
        let mut drive = SteeredDrive::new(&simulator, Actuation::default()).unwrap();
        assert!(drive.place().wheel_off_m < 0.0 && !drive.place().axle_off);
        let (mut wheels, mut axles) = (None, None);
        for index in 0..60 {
            drive.drive(DriveCommand { steer_rad: -0.2, speed_mps: 4.0 });
            wheels = wheels.or((drive.place().wheel_off_m > 0.0).then_some(index));
            axles = axles.or(drive.place().axle_off.then_some(index));
        }
        assert!(wheels < axles && wheels.is_some(), "wheels at {wheels:?}, axles at {axles:?}");
    }
}
