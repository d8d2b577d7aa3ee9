//! Other vehicles: one ahead in the own lane, more in the next lanes and oncoming, some that stand beside the road.
//!
//! They follow the route's line at a distance of their own from it, each at its own steady speed, so that where they are
//! follows from the time alone. Nothing gives way to anything: vehicles of one lane keep their distance because they have
//! one speed.

mod parked;

use fingerpost_geometry::Polyline;
use nalgebra::{Point2, Vector2};

use crate::markings::lanes_beside;
use crate::noise::{Stream, mix};
use crate::object::{Object, Shape};
use crate::roads::RoadNetwork;
use crate::vehicle::VehicleShape;
use crate::{SimConfig, TrafficSide};

/// Mean distance between vehicles of a lane at a traffic of 1, metres.
const SPACING_M: f64 = 80.0;
/// Speeds against the own cruising speed: of the next lane, and of oncoming vehicles.
const NEXT_LANE_SPEED: [f64; 2] = [0.93, 1.12];
const ONCOMING_SPEED: [f64; 2] = [0.8, 1.1];
/// The vehicle ahead is so much later at the same place, seconds.
pub(crate) const HEADWAY_S: f64 = 2.2;
/// Vehicles that stand keep this far from the road's edge, metres, from their side.
const PARKED_ASIDE_M: f64 = 0.35;
/// Share of lorries and vans.
const LORRIES: f64 = 0.15;
/// Vehicles farther off are not seen, metres.
pub(crate) const SIGHT_M: f64 = 260.0;

/// A vehicle that keeps its speed.
#[derive(Debug, Clone, Copy)]
struct Vehicle {
    /// Where along the route it is when the drive begins, metres.
    start_m: f64,
    /// Along the route, negative for oncoming ones, m/s.
    speed_mps: f64,
    /// Left of the route's line, metres.
    aside_m: f64,
    /// Against the route's direction.
    oncoming: bool,
    shape: VehicleShape,
    hash: u64,
}

/// All vehicles of a drive.
#[derive(Debug, Clone)]
pub(crate) struct Traffic {
    route: Polyline,
    vehicles: Vec<Vehicle>,
    ahead: Option<Vehicle>,
}

impl Traffic {
    /// The vehicles of a drive that takes `duration_s`.
    pub(crate) fn new(route: Polyline, roads: &RoadNetwork, config: &SimConfig, duration_s: f64) -> Self {
        let mut traffic = Self { route, vehicles: Vec::new(), ahead: None };
        let conditions = &config.conditions;
        traffic.vehicles = parked::rows(&traffic.route, roads, config);
        if conditions.traffic <= 0.0 && conditions.parked_per_100_m <= 0.0 {
            return traffic;
        }
        let (place, direction) = traffic.route.at(config.start_m);
        let Some((stroke, _)) = roads.along(place, direction) else { return traffic };
        let lanes = lanes_beside(stroke, conditions, config.traffic);
        let mut stream = Stream::new(config.seed, 0x5452_4146);
        let cruise_mps = config.cruise_speed_mps;
        if conditions.traffic > 0.0 {
            let spacing_m = SPACING_M / conditions.traffic;
            for aside_m in lanes.same_direction_m {
                let speed = stream.between(NEXT_LANE_SPEED[0], NEXT_LANE_SPEED[1]);
                let reach_m = SIGHT_M + duration_s * cruise_mps * (speed - 1.0).abs();
                let range = [config.start_m - reach_m, config.start_m + reach_m];
                traffic.fill(&mut stream, range, spacing_m, aside_m, speed * cruise_mps);
            }
            for aside_m in lanes.oncoming_m {
                let speed = stream.between(ONCOMING_SPEED[0], ONCOMING_SPEED[1]);
                let to_m = config.start_m + SIGHT_M + duration_s * cruise_mps * (1.0 + speed);
                traffic.fill(&mut stream, [config.start_m, to_m], spacing_m, aside_m, -speed * cruise_mps);
            }
            let ahead = Self::draw(&mut stream, lanes.own_m, 0.0);
            traffic.ahead = Some(ahead);
        }
        if conditions.parked_per_100_m > 0.0 {
            let sign = if config.traffic == TrafficSide::Left { 1.0 } else { -1.0 };
            let range = [config.start_m, traffic.route.length_m()];
            let first = traffic.vehicles.len();
            traffic.fill(&mut stream, range, 100.0 / conditions.parked_per_100_m, 0.0, 0.0);
            for parked in &mut traffic.vehicles[first..] {
                let half_width_m = f64::from(parked.shape.half_m[1]);
                parked.aside_m = sign * (stroke.half_width_m + PARKED_ASIDE_M + half_width_m);
            }
            let route = traffic.route.clone();
            let mut number = 0;
            traffic.vehicles.retain(|vehicle| {
                let is_single = number >= first;
                number += 1;
                !is_single || !stands_on_road(vehicle, &route, roads)
            });
        }
        traffic
    }

    fn fill(
        &mut self,
        stream: &mut Stream,
        [from_m, to_m]: [f64; 2],
        spacing_m: f64,
        aside_m: f64,
        speed_mps: f64,
    ) {
        let mut start_m = from_m + spacing_m * stream.unit();
        while start_m < to_m {
            let drawn = Self::draw(stream, aside_m, speed_mps);
            self.vehicles.push(Vehicle { start_m, ..drawn });
            start_m += spacing_m * stream.between(0.5, 1.5);
        }
    }

    fn draw(stream: &mut Stream, aside_m: f64, speed_mps: f64) -> Vehicle {
        let hash = mix((stream.unit() * 1e9) as u64);
        let mut size = |low: f64, high: f64| stream.between(low, high) as f32;
        let (half_m, height_m) = if f64::from(size(0.0, 1.0)) < LORRIES {
            let height_m = size(2.4, 3.6);
            ([size(2.8, 4.5), size(1.0, 1.22)], [height_m; 2])
        } else {
            let waist_m = size(0.86, 1.0);
            ([size(2.0, 2.4), size(0.85, 0.93)], [waist_m, waist_m + size(0.5, 0.62)])
        };
        let shape = VehicleShape { half_m, height_m, direction: [1.0, 0.0] };
        Vehicle { start_m: 0.0, speed_mps, aside_m, oncoming: speed_mps < 0.0, shape, hash }
    }

    /// The vehicles that can be seen from a place of the route, at a time. The one that drives ahead in the own lane is
    /// `leader_m` along the route.
    pub(crate) fn seen(
        &self,
        p_in_map: Point2<f64>,
        t_s: f64,
        leader_m: f64,
        height_m: impl Fn(Point2<f64>) -> f64,
    ) -> Vec<Object> {
        let ahead = self.ahead.map(|ahead| (leader_m, ahead));
        let steady =
            self.vehicles.iter().map(|vehicle| (vehicle.start_m + vehicle.speed_mps * t_s, *vehicle));
        steady
            .chain(ahead)
            .filter_map(|(route_m, vehicle)| {
                let (axis, along) = self.route.at(route_m);
                let place = axis + Vector2::new(-along.y, along.x) * vehicle.aside_m;
                let near = (place - p_in_map).norm() < SIGHT_M;
                let along = if vehicle.oncoming { -along } else { along };
                let shape = VehicleShape { direction: [along.x as f32, along.y as f32], ..vehicle.shape };
                let foot = [place.x as f32, place.y as f32, height_m(place) as f32];
                near.then_some(Object { foot, shape: Shape::Vehicle(shape), hash: vehicle.hash })
            })
            .collect()
    }
}

/// Whether one that stands would do so on a road: where another joins, or where the route's is wider than at its start.
fn stands_on_road(vehicle: &Vehicle, route: &Polyline, roads: &RoadNetwork) -> bool {
    let [half_length_m, half_width_m] = vehicle.shape.half_m.map(f64::from);
    [-half_length_m, 0.0, half_length_m].into_iter().any(|along_m| {
        let (axis, along) = route.at(vehicle.start_m);
        let place = axis + Vector2::new(-along.y, along.x) * vehicle.aside_m + along * along_m;
        !roads.within(place, half_width_m).is_empty()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Conditions, RoadCourse};

    #[test]
    fn all_but_the_one_ahead_keep_out_of_the_own_lane() {
        for course in [RoadCourse::highway(1, 600.0), RoadCourse::country(1, 600.0)] {
            let (graph, route) = course.roads().unwrap();
            let line = route.polyline().unwrap();
            let low = Point2::new(-100.0, -500.0);
            let roads = RoadNetwork::new(&graph, &route.plane().unwrap(), low, Point2::new(900.0, 500.0));
            for traffic in [TrafficSide::Right, TrafficSide::Left] {
                let conditions = Conditions::LANE_TRAFFIC;
                let config =
                    SimConfig { conditions, traffic, cruise_speed_mps: 20.0, ..SimConfig::default() };
                let drawn = Traffic::new(line.clone(), &roads, &config, 30.0);
                let own_m = drawn.ahead.unwrap().aside_m;
                assert!(drawn.vehicles.iter().any(|vehicle| vehicle.oncoming));
                assert!(drawn.vehicles.iter().any(|vehicle| vehicle.speed_mps.abs() < 1e-9));
                for vehicle in &drawn.vehicles {
                    assert!((vehicle.aside_m - own_m).abs() > 1.6, "{vehicle:?}, {own_m}");
                }
            }
        }
    }
}
