//! Advice on painted roads, followed by a kinematic bicycle: it gets round a corner by it, or stops and says why.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use crate::painted::{Junction, Place, World, camera_of_width, route};
use fingerpost::advice::{ControllerName, LineKind, RoadEnd, Stop};
use fingerpost::vehicle::Traffic;
use fingerpost::vehicle_signals::{Sample, VehicleSamples};
use fingerpost::{Config, FrameOutput, Pipeline, Sensors};
use fingerpost_geometry::Camera;
use fingerpost_map::FeatureKind;
use fingerpost_vision::picture::RgbImage;
use nalgebra::{Isometry2, Vector2};

const WIDTH_M: f64 = 5.5;
const DT_S: f64 = 0.1;
/// How far left of the road's middle drives begin, metres.
const STARTS_M: [f64; 4] = [0.3, 0.35, 0.4, 0.45];
const SOUTH: &[Place] = &[(0.0, 0.0), (0.0, -60.0)];
const EAST: &[Place] = &[(0.0, 0.0), (60.0, 0.0)];
const WEST: &[Place] = &[(0.0, 0.0), (-60.0, 0.0)];

fn config(controller: ControllerName) -> Config {
    let mut config = crate::painted::config();
    // The painted roads meet at sharp corners.
    config.track.kerb_radius_m = 0.0;
    config.vehicle.traffic = Traffic::Centre;
    config.advice.controller = controller;
    config
}

/// A vehicle that does what it is advised to.
struct Vehicle {
    map_from_vehicle: Isometry2<f64>,
    speed_mps: f64,
    steer_rad: f64,
    asked: [f64; 2],
    camera: Camera,
    wheelbase_m: f64,
}

impl Vehicle {
    fn northward(left_m: f64, y_m: f64, config: &Config) -> Self {
        let map_from_vehicle = Isometry2::new(Vector2::new(-left_m, y_m), std::f64::consts::FRAC_PI_2);
        let camera = camera_of_width(320);
        let wheelbase_m = config.vehicle.wheelbase_m;
        Self { map_from_vehicle, speed_mps: 4.0, steer_rad: 0.0, asked: [0.0, 4.0], camera, wheelbase_m }
    }

    fn drive_on(&mut self) {
        const PIECES: usize = 10;
        let [steer_rad, speed_mps] = self.asked;
        for _ in 0..PIECES {
            let dt_s = DT_S / PIECES as f64;
            self.steer_rad += ((steer_rad - self.steer_rad) / 0.2).clamp(-0.4, 0.4) * dt_s;
            self.speed_mps += ((speed_mps - self.speed_mps) / 0.3).clamp(-4.0, 1.5) * dt_s;
            self.speed_mps = self.speed_mps.max(0.0);
            let turn_rad = self.speed_mps * libm::tan(self.steer_rad) / self.wheelbase_m * dt_s;
            self.map_from_vehicle *= Isometry2::new(Vector2::new(self.speed_mps * dt_s, 0.0), turn_rad);
        }
    }

    fn frame(&mut self, pipeline: &mut Pipeline, picture: &RgbImage, first: bool) -> FrameOutput {
        let speed = Sample { value: self.speed_mps, age_s: 0.0 };
        let sensors = Sensors {
            signals: Some(VehicleSamples { speed_mps: Some(speed), ..VehicleSamples::default() }),
            dt_s: (!first).then_some(DT_S),
            ..Sensors::default()
        };
        let output = pipeline.step(picture, sensors, &mut |_| {}).unwrap().0.clone();
        let advice = &output.advice;
        assert!(advice.line.is_some() || advice.stop.is_some(), "{}", advice.because);
        assert!((advice.speed_mps <= 0.0) == advice.stop.is_some(), "{}", advice.because);
        self.asked = [advice.steer_rad, advice.speed_mps];
        output
    }
}

/// Drives by the advice from so far left of the road's middle towards its end at another, which is left by `exit`.
fn drive(
    config: &Config,
    left_m: f64,
    exit: &[Place],
    side: &[Place],
    frames: usize,
) -> (Vehicle, Vec<FrameOutput>) {
    let world = World::new(&[(SOUTH, WIDTH_M), (EAST, WIDTH_M), (WEST, WIDTH_M)]);
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit, sides: &[side], width_m: WIDTH_M };
    let mut vehicle = Vehicle::northward(left_m, -32.0, config);
    let (route, _) = route(&junction);
    let mut pipeline = Pipeline::new(config, &vehicle.camera, Some(&route), Some(60.0 - 32.0)).unwrap();
    let mut outputs = Vec::new();
    for i in 0..frames {
        let picture = world.picture(&vehicle.camera, &vehicle.map_from_vehicle);
        outputs.push(vehicle.frame(&mut pipeline, &picture, i == 0));
        vehicle.drive_on();
        let east_m = vehicle.map_from_vehicle.translation.x.abs();
        if east_m > 16.0 {
            break;
        }
    }
    (vehicle, outputs)
}

#[test]
fn every_controller_takes_the_vehicle_round_a_corner() {
    let round_a_corner = |controller: ControllerName| {
        let mut off_m = Vec::new();
        for (exit, side, left) in [(WEST, EAST, 1.0), (EAST, WEST, -1.0)] {
            for start_m in STARTS_M {
                let (vehicle, outputs) = drive(&config(controller), start_m, exit, side, 220);
                let place = vehicle.map_from_vehicle.translation;
                let because = &outputs.last().unwrap().advice.because;
                assert!(-left * place.x > 16.0, "{controller:?} to {left}: {place}, {because}");
                off_m.push(place.y.abs());
                let led = |kind| outputs.iter().filter(|output| output.advice.line == Some(kind)).count();
                assert!(led(LineKind::DrivingLine) > 20, "{controller:?} to {left}");
                let most = outputs.iter().map(|output| left * output.advice.steer_rad).fold(0.0, f64::max);
                assert!(most > 0.2, "{controller:?}: {most} rad");
            }
        }
        // Ten metres behind the corner. A drive among many that comes out of it wide is on its way back.
        off_m.sort_unstable_by(f64::total_cmp);
        let mean_m = off_m.iter().sum::<f64>() / off_m.len() as f64;
        assert!(mean_m < 0.9 && off_m[off_m.len() - 2] < 1.0, "{controller:?}: {off_m:?}");
        // And all of the vehicle, two metres wide, is on the road.
        assert!(off_m[off_m.len() - 1] < 0.5 * WIDTH_M - 1.0, "{controller:?}: {off_m:?}");
    };
    // A drive has one thread.
    std::thread::scope(|scope| {
        for controller in ControllerName::ALL {
            scope.spawn(move || round_a_corner(controller));
        }
    });
}

#[test]
fn a_corner_that_the_vehicle_cannot_get_round_stops_it_before() {
    let mut config = config(ControllerName::Fuzzy);
    config.vehicle.turning_radius_m = 25.0;
    let (vehicle, outputs) = drive(&config, STARTS_M[2], EAST, WEST, 220);
    let advice = &outputs.last().unwrap().advice;
    assert!(
        matches!(advice.stop, Some(Stop::LineEnds(RoadEnd::TooTight { turning_radius_m, .. })) if turning_radius_m > 24.0)
    );
    assert!(advice.because.contains("the vehicle at no less than 25.00 m"), "{}", advice.because);
    assert!(vehicle.speed_mps < 0.1 && vehicle.map_from_vehicle.translation.y < -5.0);
}

#[test]
fn a_vehicle_that_sees_nothing_more_stops_within_what_it_saw() {
    let config = config(ControllerName::Stanley);
    let world = World::new(&[(&[(0.0, -200.0), (0.0, 200.0)], WIDTH_M)]);
    let mut vehicle = Vehicle::northward(0.3, -100.0, &config);
    let mut pipeline = Pipeline::new(&config, &vehicle.camera, None, None).unwrap();
    for i in 0..40 {
        let picture = world.picture(&vehicle.camera, &vehicle.map_from_vehicle);
        vehicle.frame(&mut pipeline, &picture, i == 0);
        vehicle.drive_on();
    }
    assert!(vehicle.speed_mps > 3.0, "{}", vehicle.speed_mps);
    let covered_at_m = vehicle.map_from_vehicle.translation.y;
    let black = RgbImage::new(320, 240);
    let mut last = vehicle.frame(&mut pipeline, &black, false);
    // It drives on along the line that it saw.
    assert!(
        last.advice.speed_mps > 1.0 && last.advice.because.contains("last seen"),
        "{}",
        last.advice.because
    );
    for _ in 0..150 {
        vehicle.drive_on();
        last = vehicle.frame(&mut pipeline, &black, false);
    }
    assert_eq!(last.advice.stop, Some(Stop::NoLine), "{}", last.advice.because);
    let went_m = vehicle.map_from_vehicle.translation.y - covered_at_m;
    assert!(vehicle.speed_mps < 0.01 && went_m < config.ground_view.far_m, "{went_m} m");
}

#[test]
fn a_turn_of_the_route_is_come_to_slowly_where_nothing_shows_it() {
    let config = config(ControllerName::Stanley);
    // The road goes straight on; the route turns off it after 60 m.
    let world = World::new(&[(&[(0.0, -200.0), (0.0, 200.0)], WIDTH_M)]);
    let kind = FeatureKind::Junction;
    let junction = Junction { kind, approach: SOUTH, exit: EAST, sides: &[WEST], width_m: WIDTH_M };
    let (route, _) = route(&junction);
    let mut vehicle = Vehicle::northward(0.0, -55.0, &config);
    let mut pipeline = Pipeline::new(&config, &vehicle.camera, Some(&route), Some(5.0)).unwrap();
    let (mut fastest_far, mut slowest_near, mut said) = (0.0_f64, f64::INFINITY, false);
    for i in 0..120 {
        let picture = world.picture(&vehicle.camera, &vehicle.map_from_vehicle);
        let output = vehicle.frame(&mut pipeline, &picture, i == 0);
        let to_node_m = -vehicle.map_from_vehicle.translation.y;
        if to_node_m > 30.0 {
            fastest_far = fastest_far.max(output.advice.speed_mps);
        } else if (0.0..8.0).contains(&to_node_m) {
            slowest_near = slowest_near.min(output.advice.speed_mps);
        }
        said |= output.advice.because.contains("slower for a turn of");
        assert!(output.track.followed.is_none(), "there is nothing to follow");
        vehicle.drive_on();
    }
    // Round the lane's arc of some 3 m at 2 m/s² the vehicle drives less than 3 m/s.
    assert!(fastest_far > 6.0 && slowest_near < 3.5, "{fastest_far} m/s, then {slowest_near} m/s");
    assert!(said);
}
