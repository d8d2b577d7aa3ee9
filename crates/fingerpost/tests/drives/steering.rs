//! The direction to steer in on simulated roads without markings that turn sharply, with a route and without one.
#![allow(clippy::unwrap_used, reason = "a failed expectation is a failed test")]

use std::ops::RangeInclusive;
use std::sync::OnceLock;

use fingerpost::vehicle::Traffic;
use fingerpost::{Config, Pipeline, Sensors};
use fingerpost_geometry::{Camera, Distortion, Intrinsics, Mount, wrap_angle};
use fingerpost_map::{
    FeatureOptions, LatLon, OsmData, OsmNode, OsmWay, RoadGraph, Route, TangentPlane, plan,
};
use fingerpost_sim::{Conditions, SimConfig, Simulator, TrafficSide};
use nalgebra::{Isometry2, Point2, Vector2};

/// Metres east and north.
type Place = (f64, f64);

/// How far ahead the steering direction aims, metres: the default of `centreline.look_ahead_m`.
const LOOK_AHEAD_M: f64 = 8.0;
/// Directions beyond this are a turn, radians: 6 degrees, 0.8 m beside the vehicle's line at the look-ahead.
const TURNING_RAD: f64 = 0.105;
/// The road's middle is judged so far behind a bend, metres.
const BEHIND_BEND_M: f64 = 20.0;
/// From here on the vehicle is along the road behind the bend, metres: the arc's tangents have 4 to 6 m, and as much again is
/// driven until the road beneath the rear axle has been seen from along it.
const ALONG_M: f64 = 10.0;

fn camera() -> Camera {
    let intrinsics = Intrinsics { fx: 315.0, fy: 315.0, cx: 239.5, cy: 179.5 };
    let mount = Mount { pitch_rad: 0.14, x_m: 1.5, ..Mount::level(1.5) };
    Camera::calibrated(480, 360, intrinsics, Distortion::None, mount).unwrap()
}

/// An arm of a junction.
#[derive(Clone, Copy, PartialEq)]
enum Arm {
    Left,
    Right,
}

/// Unmarked roads and the way that is driven on them.
struct Farm {
    roads: Vec<Vec<Place>>,
    width_m: f64,
    from: Place,
    to: Place,
}

impl Farm {
    fn graph_and_route(&self) -> (RoadGraph, Route) {
        let plane = TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 });
        let at = |(x, y): Place| plane.wgs84_from_map(Point2::new(x, y));
        let mut map = OsmData::default();
        let mut known: Vec<Place> = Vec::new();
        for road in &self.roads {
            let mut nodes = Vec::new();
            for &place in road {
                let found =
                    known.iter().position(|&other| libm::hypot(place.0 - other.0, place.1 - other.1) < 0.01);
                let index = found.unwrap_or_else(|| {
                    known.push(place);
                    map.nodes.push(OsmNode { id: known.len() as i64, at: at(place) });
                    known.len() - 1
                });
                nodes.push(index as i64 + 1);
            }
            let width = self.width_m.to_string();
            let tags = [("highway", "unclassified"), ("surface", "asphalt"), ("width", &width)];
            let tags = tags.map(|(key, value)| (key.to_owned(), value.to_owned())).into();
            map.ways.push(OsmWay { id: map.ways.len() as i64 + 1, nodes, tags });
        }
        let graph = RoadGraph::from_osm(&map).unwrap();
        let route = plan(&graph, &[at(self.from), at(self.to)], &FeatureOptions::default()).unwrap();
        (graph, route)
    }

    /// A road of straight pieces of 55 m with a turn after each, degrees, positive to the left.
    fn bends(turns_deg: &[f64], width_m: f64) -> Self {
        let mut road = vec![(0.0, 0.0), (60.0, 0.0)];
        let mut heading = 0.0_f64;
        for turn in turns_deg {
            heading += turn.to_radians();
            let (x, y) = road[road.len() - 1];
            road.push((x + 55.0 * libm::cos(heading), y + 55.0 * libm::sin(heading)));
        }
        let to = road[road.len() - 1];
        Self { roads: vec![road], width_m, from: (0.0, 0.0), to }
    }

    /// A road that ends at another, into an arm of which the way turns; `skew_deg` from a right angle.
    fn tee(taken: Arm, skew_deg: f64, width_m: f64) -> Self {
        let (sin, cos) = libm::sincos(skew_deg.to_radians());
        let up = (60.0 + 60.0 * sin, 60.0 * cos);
        let down = (60.0 - 60.0 * sin, -60.0 * cos);
        let roads = vec![vec![(0.0, 0.0), (60.0, 0.0)], vec![down, (60.0, 0.0), up]];
        Self { roads, width_m, from: (0.0, 0.0), to: if taken == Arm::Left { up } else { down } }
    }
}

/// What a frame of a drive gave, and what was true.
#[derive(Debug, Clone)]
struct Judged {
    /// Direction of the vehicle's own way at the look-ahead, radians.
    driven_rad: f64,
    /// Steering direction, radians.
    steer_rad: Option<f64>,
    offset_error_m: Option<f64>,
    /// How far behind the last bend the vehicle is, metres.
    behind_m: Option<f64>,
    /// How far it has turned from the first road, which leads east, radians.
    turned_rad: f64,
}

/// Whether the method is given the route.
#[derive(Clone, Copy, PartialEq)]
enum Known {
    Route,
    Nothing,
}

/// One rendered drive, judged for each of what the method may be given.
fn drive<const N: usize>(
    farm: &Farm,
    seed: u64,
    known: [Known; N],
    traffic: TrafficSide,
) -> [Vec<Judged>; N] {
    let (graph, route) = farm.graph_and_route();
    let config = SimConfig {
        seed,
        conditions: Conditions::UNMARKED,
        traffic,
        cruise_speed_mps: 7.0,
        ..SimConfig::default()
    };
    let simulator = Simulator::new(&graph, &route, &camera(), &config).unwrap();
    let mut settings = Config::default();
    settings.vehicle.traffic = match traffic {
        TrafficSide::Left => Traffic::Left,
        TrafficSide::Right => Traffic::Right,
        TrafficSide::Centre => Traffic::Centre,
    };
    let mut pipelines = known.map(|known| {
        let given = (known == Known::Route).then_some(&route);
        Pipeline::new(&settings, &camera(), given, given.map(|_| config.start_m)).unwrap()
    });
    let truths: Vec<_> = (0..simulator.frames()).map(|index| simulator.truth(index)).collect();
    let pose = |i: usize| Isometry2::new(Vector2::new(truths[i].x_m, truths[i].y_m), truths[i].heading_rad);
    let line = route.polyline().unwrap();
    let corners: Vec<Point2<f64>> = line.points()[1..line.points().len() - 1].to_vec();
    let mut judged = [(); N].map(|()| Vec::new());
    for index in 0..simulator.frames() {
        let vehicle_from_map = pose(index).inverse();
        let ahead = (index..truths.len())
            .map(|i| vehicle_from_map * Point2::new(truths[i].x_m, truths[i].y_m))
            .find(|p| p.coords.norm() >= LOOK_AHEAD_M);
        let Some(ahead) = ahead else { break };
        let place = simulator.road_place(index).unwrap();
        let here = Point2::new(truths[index].x_m, truths[index].y_m);
        let along_m = line.nearest(here).along_m;
        let behind_m = corners.iter().map(|corner| along_m - line.nearest(*corner).along_m);
        let behind_m = behind_m.filter(|m| *m > 0.0).reduce(f64::min);
        let true_m = -place.left_m / libm::cos(place.heading_rad);
        let picture = simulator.frame(index).picture;
        for (pipeline, judged) in pipelines.iter_mut().zip(&mut judged) {
            let sensors = Sensors { dt_s: (index > 0).then_some(1.0 / config.fps), ..Sensors::default() };
            let (output, _) = pipeline.step(&picture, sensors, &mut |_| ()).unwrap();
            let found = output.centreline;
            judged.push(Judged {
                driven_rad: libm::atan2(ahead.y, ahead.x),
                steer_rad: found.and_then(|found| found.steer).map(|steer| steer.direction_rad),
                offset_error_m: found.map(|found| found.offset_m - true_m),
                behind_m,
                turned_rad: truths[index].heading_rad,
            });
        }
    }
    judged
}

/// Whether the direction is that of the turn: to its side, and nearer to the way that is driven than to straight on.
fn is_right(judged: &Judged) -> bool {
    judged.steer_rad.is_some_and(|steer_rad| {
        steer_rad * judged.driven_rad > 0.0
            && wrap_angle(steer_rad - judged.driven_rad).abs() < 0.5 * judged.driven_rad.abs().max(0.2)
    })
}

/// Turning frames and how many of them are right; the offset's errors so far behind bends, sorted, infinite where there is none.
fn summed(drives: &[Vec<Judged>], behind_m: RangeInclusive<f64>) -> (usize, usize, Vec<f64>) {
    let all = || drives.iter().flatten();
    let turning = all().filter(|judged| judged.driven_rad.abs() > TURNING_RAD);
    let right = turning.clone().filter(|judged| is_right(judged)).count();
    let behind = all().filter(|judged| judged.behind_m.is_some_and(|m| behind_m.contains(&m)));
    let mut errors_m: Vec<f64> =
        behind.map(|judged| judged.offset_error_m.map_or(f64::INFINITY, f64::abs)).collect();
    errors_m.sort_by(f64::total_cmp);
    (turning.count(), right, errors_m)
}

/// Share of the turning frames whose direction is right, and the 95th percentile of the offset's errors behind bends, metres.
fn figures(drives: &[Vec<Judged>], behind_m: RangeInclusive<f64>) -> (f64, f64) {
    let (turning, right, errors_m) = summed(drives, behind_m);
    assert!(turning >= 20 && errors_m.len() >= 12, "{turning} turning, {} behind bends", errors_m.len());
    (right as f64 / turning as f64, errors_m[errors_m.len() * 95 / 100])
}

/// The direction is right in 95 % of the turning frames, and the middle is found again behind the bend.
fn assert_steers(name: &str, judged: &[Vec<Judged>]) {
    let (right, p95_m) = figures(judged, ALONG_M..=BEHIND_BEND_M);
    assert!(right >= 0.95 && p95_m < 0.25, "{name}: {right} right, {p95_m} m");
    let (_, anywhere_m) = figures(judged, 0.0..=BEHIND_BEND_M);
    assert!(anywhere_m < 2.5, "{name}: {anywhere_m} m in the corner itself");
}

#[test]
fn a_sharp_bend_is_steered_round_with_a_route_and_without() {
    let drives = drive(&Farm::bends(&[60.0], 6.0), 11, [Known::Route, Known::Nothing], TrafficSide::Right);
    for judged in drives {
        assert_steers("a bend", &[judged]);
    }
}

#[test]
fn a_sharp_bend_is_steered_round_on_the_other_side() {
    assert_steers("a bend", &drive(&Farm::bends(&[-70.0], 5.0), 12, [Known::Nothing], TrafficSide::Left));
}

/// Into both arms of a tee, each with the route and with nothing.
fn tees() -> &'static [[Vec<Judged>; 2]; 2] {
    static TEES: OnceLock<[[Vec<Judged>; 2]; 2]> = OnceLock::new();
    TEES.get_or_init(|| {
        [(Farm::tee(Arm::Left, 0.0, 6.0), 13), (Farm::tee(Arm::Right, 10.0, 5.5), 14)]
            .map(|(farm, seed)| drive(&farm, seed, [Known::Route, Known::Nothing], TrafficSide::Right))
    })
}

#[test]
fn the_route_says_which_arm_of_a_tee_is_taken() {
    assert_steers("a tee", &tees().each_ref().map(|[with_route, _]| with_route.clone()));
}

/// How far a vehicle has turned when it is plain which arm it takes, radians (15 degrees): twice as far as drivers swing out.
const DECIDED_RAD: f64 = 0.26;

#[test]
fn without_a_route_the_end_of_a_road_is_ambiguous_until_the_vehicle_turns() {
    let judged: Vec<Judged> = tees().iter().flat_map(|[_, without]| without.clone()).collect();
    let turning = || judged.iter().filter(|judged| judged.driven_rad.abs() > TURNING_RAD);
    let open: Vec<&Judged> = turning().filter(|judged| judged.turned_rad.abs() < DECIDED_RAD).collect();
    let silent = open.iter().filter(|judged| judged.steer_rad.is_none()).count();
    assert!(open.len() > 20 && silent * 10 >= open.len() * 9, "{silent} of {}", open.len());
    let decided: Vec<&Judged> = turning().filter(|judged| judged.turned_rad.abs() > DECIDED_RAD).collect();
    let steered = decided.iter().filter(|judged| judged.steer_rad.is_some()).count();
    assert!(decided.len() > 20 && steered * 20 >= decided.len() * 19, "{steered} of {}", decided.len());
}
