//! The simulator: a vehicle, its camera, its surroundings; any frame on demand.

use fingerpost_format::TruthRecord;
use fingerpost_geometry::{Camera, Mount, Polyline, View};
use fingerpost_map::{RoadGraph, Route, TangentPlane};
use fingerpost_vision::picture::{Plane, RgbImage};
use nalgebra::{Isometry3, Point2, Point3, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::drive::{Drive, VehicleState};
use crate::ground::{GroundMap, REACH_M};
use crate::path::{PathPoint, driven_path};
use crate::relief::{Relief, ReliefRaster};
use crate::render::{FrameView, Renderer};
use crate::roads::RoadNetwork;
use crate::scenery::Scenery;
use crate::surface::Painter;
use crate::truth::LaneEdges;
use crate::{SimConfig, SimError};

/// Shortest route that can be driven, metres.
pub(crate) const MIN_ROUTE_M: f64 = 20.0;
/// Longest route whose surroundings are held at once, metres: about 1 GB.
const MAX_ROUTE_M: f64 = 20_000.0;
/// The drive ends so far before the route's end, metres.
const END_GAP_M: f64 = 5.0;
/// Distance from rear to front axle, metres, a medium car's.
pub(crate) const WHEELBASE_M: f64 = 2.7;
/// Distance between left and right wheels, metres.
const TRACK_M: f64 = 1.6;

/// One frame of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct SimFrame {
    /// The camera's picture.
    pub picture: RgbImage,
    /// 255 where the picture shows road, 0 elsewhere; what stands in front of the road hides it.
    pub road: Plane<u8>,
    /// Where everything really was.
    pub truth: TruthRecord,
}

/// A route feature as the truth needs it.
#[derive(Debug, Clone, Copy)]
struct Target {
    id: i64,
    p_in_map: Point2<f64>,
    route_m: f64,
}

/// A drive along a route with a camera, rendered on demand.
///
/// Frame `i` depends on what the simulator was made from and on `i` alone: frames can be rendered in any order, on any
/// number of threads, and are the same to the byte.
#[derive(Debug, Clone)]
pub struct Simulator {
    camera: Camera,
    mount: Mount,
    plane: TangentPlane,
    fps: f64,
    frames: usize,
    drive: Drive,
    relief: Relief,
    lanes: LaneEdges,
    targets: Vec<Target>,
    renderer: Renderer,
}

impl Simulator {
    /// A drive along `route` on the roads of `graph` (in any plane), seen by `camera`.
    ///
    /// # Errors
    /// [`SimError`]: numbers out of range, a camera without a lens, a route that is too short, too long or not on the
    /// map's roads.
    pub fn new(
        graph: &RoadGraph,
        route: &Route,
        camera: &Camera,
        config: &SimConfig,
    ) -> Result<Self, SimError> {
        config.check()?;
        let View::Calibrated { mount, .. } = camera.view() else {
            return Err(SimError::CameraWithoutLens);
        };
        let line = route.polyline()?;
        let needed_m = (config.start_m + END_GAP_M + 1.0).max(MIN_ROUTE_M);
        if line.length_m() < needed_m {
            return Err(SimError::RouteTooShort { length_m: line.length_m(), needed_m });
        }
        if line.length_m() > MAX_ROUTE_M {
            return Err(SimError::RouteTooLong { length_m: line.length_m(), limit_m: MAX_ROUTE_M });
        }
        let plane = route.plane().ok_or(SimError::RouteTooShort { length_m: 0.0, needed_m })?;
        let conditions = &config.conditions;
        let (low, high) = surroundings(&line);
        let roads = RoadNetwork::new(graph, &plane, low, high);
        let path = driven_path(&line, &roads, config.traffic, conditions.wander_m, config.seed)?;
        let driven =
            |point: &PathPoint| (config.start_m..=line.length_m() - END_GAP_M).contains(&point.route_m);
        let path: Vec<PathPoint> = path.into_iter().filter(driven).collect();
        let drive = Drive::new(path, config.cruise_speed_mps, conditions, config.seed)?;
        let relief = Relief::new(config.seed, conditions.undulation_m);
        let near_route = |p: Point2<f64>| line.nearest(p).left_m.abs() < REACH_M;
        let scenery = Scenery::new(config.seed, conditions, &roads, &relief, near_route);
        let ground = GroundMap::new(config.seed, &line, &roads, &scenery);
        let raster = ReliefRaster::new(&relief, low, high);
        let painter = Painter::new(config.seed, conditions, &roads);
        let renderer = Renderer::new(camera, conditions, config.seed, ground, raster, scenery, painter)?;
        let route_frames = (drive.duration_s() * config.fps).floor() as usize + 1;
        Ok(Self {
            camera: camera.clone(),
            mount: *mount,
            plane,
            fps: config.fps,
            frames: config.frames.map_or(route_frames, |most| most.min(route_frames)),
            drive,
            relief,
            targets: targets(route, &plane),
            lanes: LaneEdges::new(line, &roads, conditions.markings, config.traffic),
            renderer,
        })
    }

    /// How many frames the drive has.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The frame of that number, rendered. Numbers beyond the drive's end show its end.
    pub fn frame(&self, index: usize) -> SimFrame {
        let state = self.state(index);
        let map_from_vehicle = self.map_from_vehicle(&state);
        let view = FrameView {
            frame: index as u64,
            t_s: index as f64 / self.fps,
            map_from_camera: map_from_vehicle * self.mount_of(&state).vehicle_from_camera(),
            ground_m: map_from_vehicle.translation.vector.z,
        };
        let (picture, road) = self.renderer.render(&view);
        SimFrame { picture, road, truth: self.truth(index) }
    }

    /// The camera as it is in that frame: its mount with the body's pitch and roll about the road's plane.
    ///
    /// # Errors
    /// [`SimError::Geometry`] when body motion takes the mount out of its limits.
    pub fn camera_at(&self, index: usize) -> Result<Camera, SimError> {
        Ok(self.camera.with_mount(self.mount_of(&self.state(index)))?)
    }

    /// The truth of that frame, without rendering it.
    pub fn truth(&self, index: usize) -> TruthRecord {
        let state = self.state(index);
        let place = self.plane.wgs84_from_map(state.p_in_map);
        let target = self.targets.iter().find(|target| target.route_m > state.route_m);
        let (sin, cos) = state.heading_rad.sin_cos();
        let in_vehicle = target.map(|target| {
            let offset = target.p_in_map - state.p_in_map;
            Vector2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
        });
        let [lane_left_px, lane_right_px] = self.lanes_of(&state);
        TruthRecord {
            frame: index as u64,
            t_s: index as f64 / self.fps,
            x_m: state.p_in_map.x,
            y_m: state.p_in_map.y,
            heading_rad: state.heading_rad,
            lat: place.lat_deg,
            lon: place.lon_deg,
            speed_mps: state.speed_mps,
            yaw_rate_rps: state.yaw_rate_rps,
            feature_id: target.map(|target| target.id),
            feature_forward_m: in_vehicle.map(|p| p.x),
            feature_left_m: in_vehicle.map(|p| p.y),
            lane_left_px,
            lane_right_px,
        }
    }

    fn state(&self, index: usize) -> VehicleState {
        self.drive.at(index as f64 / self.fps)
    }

    fn mount_of(&self, state: &VehicleState) -> Mount {
        Mount {
            pitch_rad: self.mount.pitch_rad + state.pitch_rad,
            roll_rad: self.mount.roll_rad + state.roll_rad,
            ..self.mount
        }
    }

    /// The road's plane below the wheels.
    fn map_from_vehicle(&self, state: &VehicleState) -> Isometry3<f64> {
        let (sin, cos) = state.heading_rad.sin_cos();
        let (forward, left) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let wheel = |x: f64, y: f64| self.relief.height_m(state.p_in_map + forward * x + left * y);
        let half = 0.5 * TRACK_M;
        let (rear_left, rear_right) = (wheel(0.0, half), wheel(0.0, -half));
        let (front_left, front_right) = (wheel(WHEELBASE_M, half), wheel(WHEELBASE_M, -half));
        let rear = 0.5 * (rear_left + rear_right);
        let uphill = (0.5 * (front_left + front_right) - rear) / WHEELBASE_M;
        let left_up = 0.5 * (rear_left + front_left - rear_right - front_right) / TRACK_M;
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), state.heading_rad)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), -uphill.atan())
            * Rotation3::from_axis_angle(&Vector3::x_axis(), left_up.atan());
        Isometry3::from_parts(
            Translation3::new(state.p_in_map.x, state.p_in_map.y, rear),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }

    fn lanes_of(&self, state: &VehicleState) -> [Vec<[f64; 2]>; 2] {
        let Ok(camera) = self.camera.with_mount(self.mount_of(state)) else {
            return [Vec::new(), Vec::new()];
        };
        let map_from_vehicle = self.map_from_vehicle(state);
        self.lanes.ahead(&self.renderer.ground, state.route_m, state.heading_rad).map(|edge| {
            edge.into_iter()
                .map(|p| Point3::new(p.x, p.y, self.relief.height_m(p)))
                .filter_map(|p| camera.project(map_from_vehicle.inverse_transform_point(&p)))
                .filter(|pixel| camera.contains(*pixel))
                .map(|pixel| [pixel.u, pixel.v])
                .collect()
        })
    }
}

/// The rectangle around the route within which roads are drawn.
fn surroundings(line: &Polyline) -> (Point2<f64>, Point2<f64>) {
    let margin = Vector2::repeat(2.0 * REACH_M);
    let points = line.points();
    let low = points.iter().fold(points[0], |low, p| low.inf(p));
    let high = points.iter().fold(points[0], |high, p| high.sup(p));
    (low - margin, high + margin)
}

fn targets(route: &Route, plane: &TangentPlane) -> Vec<Target> {
    route
        .features
        .iter()
        .map(|feature| Target {
            id: feature.id,
            p_in_map: plane.map_from_wgs84(feature.at),
            route_m: feature.route_m,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use fingerpost_geometry::{Distortion, Intrinsics};
    use fingerpost_map::{OsmData, read_route};

    use super::*;
    use crate::TrafficSide;

    fn in_town(config: &SimConfig) -> Simulator {
        let town = OsmData::from_bytes(include_bytes!("../assets/town.osm")).unwrap();
        let graph = RoadGraph::from_osm(&town).unwrap();
        let route = read_route(include_str!("../assets/town_route.geojson")).unwrap();
        let intrinsics = Intrinsics { fx: 42.0, fy: 42.0, cx: 31.5, cy: 23.5 };
        let camera = Camera::calibrated(64, 48, intrinsics, Distortion::None, Mount::level(1.5)).unwrap();
        Simulator::new(&graph, &route, &camera, config).unwrap()
    }

    #[test]
    fn all_wheels_stay_on_the_towns_roads() {
        for traffic in [TrafficSide::Right, TrafficSide::Left, TrafficSide::Centre] {
            let simulator = in_town(&SimConfig { traffic, ..SimConfig::default() });
            let (mut worst_m, mut where_m) = (f32::NEG_INFINITY, 0.0);
            for index in 0..simulator.frames() {
                let state = simulator.state(index);
                let map_from_vehicle = simulator.map_from_vehicle(&state);
                // The outer faces of the tyres of a car 1.8 m wide.
                for (x, y) in [(0.0, 0.9), (0.0, -0.9), (WHEELBASE_M, 0.9), (WHEELBASE_M, -0.9)] {
                    let wheel = map_from_vehicle * Point3::new(x, y, 0.0);
                    let edge_m = simulator.renderer.ground.at(wheel.x as f32, wheel.y as f32).edge_m;
                    if edge_m > worst_m {
                        (worst_m, where_m) = (edge_m, state.route_m);
                    }
                }
            }
            assert!(worst_m < 0.0, "{traffic:?}: {worst_m} m off the road at {where_m} m of the route");
        }
    }

    #[test]
    fn the_town_has_its_features_in_order() {
        let simulator = in_town(&SimConfig::default());
        let mut seen: Vec<i64> =
            (0..simulator.frames()).filter_map(|i| simulator.truth(i).feature_id).collect();
        seen.dedup();
        let wanted: Vec<i64> = simulator.targets.iter().map(|target| target.id).collect();
        assert_eq!(seen, wanted);
        assert!(wanted.len() >= 8, "{} features", wanted.len());
    }

    #[test]
    fn nothing_stands_on_or_near_the_roads() {
        let town = OsmData::from_bytes(include_bytes!("../assets/town.osm")).unwrap();
        let graph = RoadGraph::from_osm(&town).unwrap();
        let (low, high) = (Point2::new(-200.0, -200.0), Point2::new(200.0, 200.0));
        let roads = RoadNetwork::new(&graph, graph.plane(), low, high);
        let relief = Relief::new(1, 0.0);
        let scenery = Scenery::new(1, &crate::Conditions::SHADOWS, &roads, &relief, |_| true);
        assert!(scenery.objects().len() > 100, "{} objects", scenery.objects().len());
        for object in scenery.objects() {
            let foot = Point2::new(f64::from(object.foot[0]), f64::from(object.foot[1]));
            let free_m = 1.5 + f64::from(object.radius_m());
            assert!(roads.within(foot, free_m).is_empty(), "{object:?}");
        }
    }
}
