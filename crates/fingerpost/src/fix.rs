//! The fix: where the vehicle is on the map, from its own motion and GPS, with or without a route (paper 1, section VII; paper 2,
//! sections 5 and 7.2).
//!
//! `fingerpost-locate` keeps the possibilities; here the motion from frame to frame, of the camera or the vehicle's bus, becomes
//! what it takes in. Limits: features, lanes and the road's edges do not correct it yet, and frames need times.

use fingerpost_geometry::wrap_angle;
use fingerpost_locate::{
    Fix, Locator, MotionInterval, Start, Status, Traffic as TrafficSide, YAW_RATE_NOISE,
};
use fingerpost_map::{LatLon, RoadGraph, TangentPlane};

use crate::motion::Motion;
use crate::vehicle::Traffic;
use crate::vehicle_signals::VehicleState;

/// Seed of where on the roads the possibilities begin; any other gives the same fixes within their bounds.
const SEED: u64 = 1;
/// How much a turn may differ from what the frames before had where nothing shows it, rad/s: a corner in town traffic.
const UNSEEN_TURN_RPS: f64 = 0.3;

/// A place that the vehicle starts near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NearPlace {
    /// The place.
    pub at: LatLon,
    /// Its standard deviation east and north, metres.
    pub sigma_m: f64,
}

/// Where the vehicle is on the map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MapFix {
    /// Place of the rear axle's middle.
    pub at: LatLon,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Standard deviation of the place in its least sure direction, metres.
    pub sigma_m: f64,
    /// Protection level: the vehicle is farther away with at most the probability [`fingerpost_locate::RISK`], metres; none where
    /// that cannot be said.
    pub bound_m: Option<f64>,
    /// What it is worth.
    pub status: Status,
}

/// The stage with the possibilities that it keeps.
#[derive(Debug)]
pub(crate) struct FixStage {
    locator: Locator,
    plane: TangentPlane,
    /// Speed (m/s) and yaw rate (rad/s) when they were last known.
    last: [f64; 2],
}

impl FixStage {
    pub(crate) fn new(graph: &RoadGraph, traffic: Traffic, start: Option<NearPlace>) -> Self {
        let plane = *graph.plane();
        let side = match traffic {
            Traffic::Left => TrafficSide::Left,
            Traffic::Right => TrafficSide::Right,
            Traffic::Centre => TrafficSide::Centre,
        };
        let locator = match start {
            Some(NearPlace { at, sigma_m }) => {
                let start = Start { place_m: plane.map_from_wgs84(at), sigma_m, heading_rad: None };
                Locator::near(graph, side, SEED, &start)
            }
            None => Locator::new(graph, side, SEED),
        };
        Self { locator, plane, last: [0.0; 2] }
    }

    /// Takes in a frame: seconds since the one before, how the vehicle moves, and a position of GPS.
    pub(crate) fn step(
        &mut self,
        dt_s: Option<f64>,
        vehicle: &VehicleState,
        motion: Option<&Motion>,
        gps: Option<LatLon>,
    ) -> Option<MapFix> {
        let time_s = dt_s.unwrap_or_default();
        let shown = motion.filter(|motion| motion.quality > 0.0);
        let turn_variance_rad2 = match (vehicle.yaw_rate_rps, shown) {
            (Some(_), Some(motion)) => motion.covariance[(2, 2)].max(YAW_RATE_NOISE.powi(2) * time_s),
            (Some(_), None) => YAW_RATE_NOISE.powi(2) * time_s,
            (None, _) => (UNSEEN_TURN_RPS * time_s).powi(2),
        };
        let [speed_mps, yaw_rate_rps] =
            [vehicle.speed_mps.unwrap_or(self.last[0]), vehicle.yaw_rate_rps.unwrap_or(self.last[1])];
        self.last = [speed_mps, yaw_rate_rps];
        let interval = MotionInterval { time_s, speed_mps, yaw_rate_rps, turn_variance_rad2 };
        let fix = self.locator.go_on(&interval)?;
        if let Some(gps) = gps {
            // What it says is part of the next frame's fix.
            self.locator.gps(self.plane.map_from_wgs84(gps));
        }
        Some(self.on_earth(&fix))
    }

    fn on_earth(&self, fix: &Fix) -> MapFix {
        MapFix {
            at: self.plane.wgs84_from_map(fix.place_m),
            heading_rad: wrap_angle(fix.heading_rad),
            sigma_m: fix.covariance_m2.symmetric_eigenvalues().max().max(0.0).sqrt(),
            bound_m: fix.level_m,
            status: fix.status,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use fingerpost_map::{OsmData, OsmNode, OsmWay};
    use nalgebra::Point2;

    use super::*;

    const DT_S: f64 = 0.1;
    const SPEED_MPS: f64 = 8.0;

    fn plane() -> TangentPlane {
        TangentPlane::new(LatLon { lat_deg: 47.0, lon_deg: 9.0 })
    }

    /// A road of 200 m to the east, with a street to the north at 90 m and one to the south at 150 m.
    fn roads() -> RoadGraph {
        let places = [(0.0, 0.0), (90.0, 0.0), (150.0, 0.0), (200.0, 0.0), (90.0, 120.0), (150.0, -120.0)];
        let nodes = places.iter().zip(1..).map(|((east, north), id)| OsmNode {
            id,
            at: plane().wgs84_from_map(Point2::new(*east, *north)),
        });
        let way = |id: i64, nodes: &[i64]| {
            let tags = [("highway".to_owned(), "residential".to_owned())].into();
            OsmWay { id, nodes: nodes.to_vec(), tags }
        };
        let ways = vec![way(1, &[1, 2, 3, 4]), way(2, &[2, 5]), way(3, &[3, 6])];
        RoadGraph::from_osm(&OsmData { nodes: nodes.collect(), ways }).unwrap()
    }

    /// Along the road to the east from 10 m on, then into a street with an arc of 6 m; the vehicle's true places and fixes.
    fn drive(corner_m: f64, left: f64, off_m: f64) -> Vec<(Point2<f64>, f64, MapFix)> {
        let near = plane().wgs84_from_map(Point2::new(10.0 + off_m, 0.0));
        let near = NearPlace { at: near, sigma_m: 20.0 };
        let mut stage = FixStage::new(&roads(), Traffic::Centre, Some(near));
        let radius_m = 6.0;
        let (mut place, mut heading) = (Point2::new(10.0, 0.0), 0.0_f64);
        let mut fixes = Vec::new();
        for _ in 0..(corner_m + 70.0) as usize {
            let turns = place.x > corner_m - radius_m && heading.abs() < FRAC_PI_2 - 1e-3;
            let yaw_rate_rps = if turns { left * SPEED_MPS / radius_m } else { 0.0 };
            let middle = heading + 0.5 * yaw_rate_rps * DT_S;
            place += SPEED_MPS * DT_S * nalgebra::Vector2::new(middle.cos(), middle.sin());
            heading = (heading + yaw_rate_rps * DT_S).clamp(-FRAC_PI_2, FRAC_PI_2);
            let vehicle = VehicleState {
                speed_mps: Some(SPEED_MPS),
                yaw_rate_rps: Some(yaw_rate_rps),
                ..VehicleState::default()
            };
            fixes.extend(stage.step(Some(DT_S), &vehicle, None, None).map(|fix| (place, heading, fix)));
        }
        fixes
    }

    #[test]
    fn a_corner_to_either_side_tells_where_the_vehicle_is() {
        for (corner_m, left, off_m) in [(90.0, 1.0, 15.0), (150.0, -1.0, -15.0)] {
            let fixes = drive(corner_m, left, off_m);
            let error_m = |(place, _, fix): &(Point2<f64>, f64, MapFix)| {
                (plane().map_from_wgs84(fix.at) - place).norm()
            };
            let first = &fixes[0];
            assert!(first.2.status != Status::Converged, "a place known to 20 m is none yet");
            let last = fixes.last().unwrap();
            assert!(error_m(last) < 4.0, "corner at {corner_m} m: {} m off", error_m(last));
            assert!((last.2.heading_rad - last.1).abs() < 0.1, "corner at {corner_m} m");
            assert!(last.2.sigma_m < 5.0 && last.2.sigma_m < 0.7 * first.2.sigma_m);
        }
    }

    #[test]
    fn frames_without_times_move_nothing_and_unseen_ones_go_on() {
        let mut stage = FixStage::new(&roads(), Traffic::Right, None);
        let vehicle =
            VehicleState { speed_mps: Some(SPEED_MPS), yaw_rate_rps: Some(0.0), ..VehicleState::default() };
        let first = stage.step(None, &vehicle, None, None).unwrap();
        assert_eq!(stage.step(None, &vehicle, None, None), Some(first));
        let near = NearPlace { at: plane().wgs84_from_map(Point2::new(10.0, 0.0)), sigma_m: 3.0 };
        let mut stage = FixStage::new(&roads(), Traffic::Right, Some(near));
        let place = |fix: MapFix| plane().map_from_wgs84(fix.at);
        let before = place(stage.step(Some(DT_S), &vehicle, None, None).unwrap());
        let after = (0..4)
            .filter_map(|_| stage.step(Some(DT_S), &VehicleState::default(), None, None))
            .last()
            .unwrap();
        assert!(((place(after) - before).norm() - 4.0 * SPEED_MPS * DT_S).abs() < 0.5);
    }
}
