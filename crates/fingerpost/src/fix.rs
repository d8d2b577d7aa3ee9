//! The fix: where the vehicle is on the map, from its own motion and GPS, with or without a route (paper 1, section VII; paper 2,
//! sections 5 and 7.2).
//!
//! `fingerpost-locate` keeps the possibilities; here the motion from frame to frame, of the camera or the vehicle's bus, becomes
//! what it takes in, and so does a feature of the route that is followed: its node has a place on the map. Limits: lanes and the road's
//! edges do not correct it yet, and frames need times.

use fingerpost_geometry::wrap_angle;
use fingerpost_locate::{
    Fix, GpsEvidence, Locator, MotionInterval, Sighting, SightingEvidence, Start, Status,
    Traffic as TrafficSide, YAW_RATE_NOISE,
};
use fingerpost_map::{LatLon, RoadGraph, TangentPlane};
use nalgebra::Isometry2;

use crate::motion::Motion;
use crate::track::{Followed, RouteStop};
use crate::vehicle::Traffic;
use crate::vehicle_signals::VehicleState;

/// Seed of where on the roads the possibilities begin; any other gives the same fixes within their bounds.
const SEED: u64 = 1;
/// How much a turn may differ from what the frames before had where nothing shows it, rad/s: a corner in town traffic.
const UNSEEN_TURN_RPS: f64 = 0.3;
/// Standard deviation of how a driver changes the speed where nothing shows it, m/s2: comfortable braking and starting in towns are
/// 1.5 to 2.
const UNSEEN_ACCELERATION_MPS2: f64 = 1.5;

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
    /// Root of the mean square of the vehicle's distance from the place, in the direction in which that is greatest, metres: of the place's
    /// own uncertainty and of all other places that are possible by how far they are and how probable, but for the farthest that have no
    /// more than [`fingerpost_locate::RISK`] together. A rival a hundred metres off with a tenth of the probability makes it some 30 m.
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
    /// How long the speed has not been known, seconds.
    unseen_s: f64,
    /// Where the route's features lie in the plane of the map's graph.
    map_from_feature: Vec<Isometry2<f64>>,
}

/// What a frame says of the vehicle's place beside its motion.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FixInput<'a> {
    /// Position by GPS.
    pub(crate) gps: Option<LatLon>,
    /// The feature that is followed.
    pub(crate) followed: Option<&'a Followed>,
}

/// What was made of the measurements of a frame; none of those that it did not have, or that wait for the next look at the road.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct FixEvidence {
    /// Of the position by GPS.
    pub gps: Option<GpsEvidence>,
    /// Of the feature that is followed.
    pub feature: Option<SightingEvidence>,
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
        Self { locator, plane, last: [0.0; 2], unseen_s: 0.0, map_from_feature: Vec::new() }
    }

    /// With the features of a route, whose plane lies about its first node.
    pub(crate) fn with_route(mut self, stops: &[RouteStop], route: Option<&TangentPlane>) -> Self {
        let Some(route) = route else { return self };
        let in_graph = |stop: &RouteStop| {
            let in_route = &stop.model.map_from_feature;
            let place_m = self.plane.map_from_wgs84(route.wgs84_from_map(in_route.translation.vector.into()));
            Isometry2::new(place_m.coords, in_route.rotation.angle())
        };
        self.map_from_feature = stops.iter().map(in_graph).collect();
        self
    }

    /// Takes in a frame: seconds since the one before, how the vehicle moves, and what else says where it is.
    pub(crate) fn step(
        &mut self,
        dt_s: Option<f64>,
        vehicle: &VehicleState,
        motion: Option<&Motion>,
        input: FixInput<'_>,
    ) -> (Option<MapFix>, FixEvidence) {
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
        let distance_variance_m2 = self.unseen_distance_variance_m2(vehicle.speed_mps.is_none(), time_s);
        let interval =
            MotionInterval { time_s, speed_mps, yaw_rate_rps, turn_variance_rad2, distance_variance_m2 };
        self.locator.go_on(&interval);
        let sighting = input.followed.and_then(|followed| self.sighting(followed));
        let evidence = FixEvidence {
            feature: sighting.and_then(|sighting| self.locator.sight(&sighting)),
            gps: input.gps.and_then(|gps| self.locator.gps(self.plane.map_from_wgs84(gps))),
        };
        (self.locator.now().map(|fix| self.on_earth(&fix)), evidence)
    }

    /// What a time adds to the variance of the distance driven. While the speed is not known, a driver who began to brake goes on braking:
    /// the error grows with the square of the time.
    fn unseen_distance_variance_m2(&mut self, is_unseen: bool, time_s: f64) -> f64 {
        if !is_unseen {
            self.unseen_s = 0.0;
            return 0.0;
        }
        let variance_m2 = |unseen_s: f64| (0.5 * UNSEEN_ACCELERATION_MPS2 * unseen_s * unseen_s).powi(2);
        let before_s = self.unseen_s;
        self.unseen_s += time_s;
        variance_m2(self.unseen_s) - variance_m2(before_s)
    }

    fn sighting(&self, followed: &Followed) -> Option<Sighting> {
        Some(Sighting {
            landmark: followed.index,
            map_from_landmark: *self.map_from_feature.get(followed.index)?,
            vehicle_from_landmark: followed.vehicle_from_feature,
            covariance: followed.covariance,
            present: followed.present_by_sight,
        })
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
mod tests;
