//! The simulator: a vehicle, its camera, its surroundings; any frame on demand.

mod truth;

use fingerpost_format::TruthRecord;
use fingerpost_geometry::{Camera, Mount, Polyline, View};
use fingerpost_map::{RoadGraph, Route, TangentPlane};
use fingerpost_vision::picture::{Plane, RgbImage};
use nalgebra::{Isometry3, Point2, Rotation3, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::bus;
use crate::camera_knock::CameraKnock;
use crate::crossing::{Crossing, crossings};
use crate::drive::{Drive, VehicleState};
use crate::driving::PlannedDriving;
use crate::ground::{GroundMap, REACH_M};
use crate::lane_middle::LaneMiddle;
use crate::object::Object;
use crate::path::DrivenLine;
use crate::relief::{Relief, ReliefRaster};
use crate::render::{FrameView, Rendered, Renderer};
use crate::roads::{RoadNetwork, Stroke};
use crate::scenery::Scenery;
use crate::steered::RoadStrip;
use crate::surface::Painter;
use crate::traffic::{HEADWAY_S, Traffic};
use crate::truth::{LaneEdges, RoadPlace};
use crate::{Markings, SimConfig, SimError, SimVehicle};

/// Shortest route that can be driven, metres.
pub(crate) const MIN_ROUTE_M: f64 = 20.0;
/// Longest route whose surroundings are held at once, metres: about 1 GB.
const MAX_ROUTE_M: f64 = 20_000.0;

/// One frame of a drive.
#[derive(Debug, Clone, PartialEq)]
pub struct SimFrame {
    /// The camera's picture.
    pub picture: RgbImage,
    /// 255 where the picture shows road, 0 elsewhere; what stands in front of the road hides it.
    pub road: Plane<u8>,
    /// What each pixel shows: the number of its [`PixelClass`](crate::PixelClass).
    pub classes: Plane<u8>,
    /// Height of the ground that each pixel shows above the plane on which the vehicle stands, where streets have heights of their own
    /// ([`Conditions::kerbs`](crate::Conditions::kerbs)): 32768 for none and a step more for each millimetre up; 0 where something else
    /// than ground is seen.
    pub heights: Option<Plane<u16>>,
    /// Where everything really was.
    pub truth: TruthRecord,
}

/// A route feature as the truth needs it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Target {
    id: i64,
    p_in_map: Point2<f64>,
    pub(crate) route_m: f64,
}

/// A drive along a route with a camera, rendered on demand.
///
/// Frame `i` depends on what the simulator was made from and on `i` alone: frames can be rendered in any order, on any
/// number of threads, and are the same to the byte.
#[derive(Debug, Clone)]
pub struct Simulator {
    camera: Camera,
    mount: Mount,
    knock: Option<CameraKnock>,
    plane: TangentPlane,
    pub(crate) fps: f64,
    frames: usize,
    pub(crate) vehicle: SimVehicle,
    pub(crate) drive: Drive,
    planned: Option<PlannedDriving>,
    traffic: Traffic,
    relief: Relief,
    lanes: LaneEdges,
    pub(crate) lane_middle: LaneMiddle,
    pub(crate) targets: Vec<Target>,
    pub(crate) strips: Vec<RoadStrip>,
    pub(crate) renderer: Renderer,
}

/// The vehicle at the time of a frame, driven as planned or as it is steered.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Moment {
    /// Number of the frame.
    pub(crate) frame: u64,
    /// Its time, seconds.
    pub(crate) t_s: f64,
    /// The vehicle.
    pub(crate) state: VehicleState,
    /// Where along the route the one that drives ahead is, metres.
    pub(crate) leader_m: f64,
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
        let needed_m = (config.start_m + config.end_gap_m + 1.0).max(MIN_ROUTE_M);
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
        let roads = if conditions.markings == Markings::Streets {
            roads.painted(config.seed, conditions.streetscape.edge_paint)
        } else {
            roads
        };
        let driven = DrivenLine::new(&line, &roads, config)?;
        let (drive, planned) = plan_drive(&driven, line.length_m(), config)?;
        let relief =
            Relief::new(config.seed, conditions.undulation_m).with_hills(config.seed, conditions.hill_slope);
        let near_route = |p: Point2<f64>| line.nearest(p).left_m.abs() < REACH_M;
        let scenery = Scenery::new(config.seed, conditions, &roads, &relief, near_route);
        let ground = GroundMap::new(config.seed, &line, &roads, config.corners, &scenery);
        let raster = ReliefRaster::new(&relief, low, high);
        let painter = Painter::new(config.seed, conditions, &roads, config.traffic);
        let renderer = Renderer::new(camera, conditions, config.seed, ground, raster, scenery, painter)?;
        let traffic = Traffic::new(line.clone(), &roads, config, drive.duration_s());
        let route_frames = (drive.duration_s() * config.fps).floor() as usize + 1;
        Ok(Self {
            camera: camera.clone(),
            mount: *mount,
            knock: CameraKnock::new(
                config.seed,
                conditions.camera_knock_rad,
                [drive.start_m(), drive.end_m()],
            ),
            plane,
            fps: config.fps,
            frames: config.frames.map_or(route_frames, |most| most.min(route_frames)),
            vehicle: config.vehicle,
            drive,
            planned,
            traffic,
            relief,
            targets: targets(route, &plane),
            lanes: LaneEdges::new(line, &roads, config),
            lane_middle: LaneMiddle::new(driven.lane_middle()),
            strips: strips(&roads),
            renderer,
        })
    }

    /// How many frames the drive has.
    pub fn frames(&self) -> usize {
        self.frames
    }

    /// The frame of that number, rendered. Numbers beyond the drive's end show its end.
    pub fn frame(&self, index: usize) -> SimFrame {
        self.frame_of(&self.moment(index))
    }

    pub(crate) fn frame_of(&self, moment: &Moment) -> SimFrame {
        let Rendered { picture, road, classes, heights } = self.renderer.render(&self.view(moment));
        SimFrame { picture, road, classes, heights, truth: self.truth_of(moment) }
    }

    /// Whether streets have heights of their own: [`Conditions::kerbs`](crate::Conditions::kerbs).
    pub fn has_heights(&self) -> bool {
        self.renderer.has_street()
    }

    fn view(&self, moment: &Moment) -> FrameView {
        let map_from_vehicle = self.map_from_vehicle(&moment.state);
        FrameView {
            map_from_vehicle,
            frame: moment.frame,
            t_s: moment.t_s,
            map_from_camera: map_from_vehicle * self.mount_of(&moment.state).vehicle_from_camera(),
            ground_m: map_from_vehicle.translation.vector.z,
            vehicles: self.vehicles(moment),
        }
    }

    fn moment(&self, index: usize) -> Moment {
        let t_s = index as f64 / self.fps;
        let leader_m = self.drive.route_m_at(t_s + HEADWAY_S);
        Moment { frame: index as u64, t_s, state: self.state(index), leader_m }
    }

    /// Where the vehicle is on its road in that frame, marked or not; none off the roads.
    pub fn road_place(&self, index: usize) -> Option<RoadPlace> {
        let state = self.state(index);
        self.lanes.road_place(state.p_in_map, state.route_m, state.heading_rad)
    }

    /// Whether a place, metres in the map frame, is on a road as pictures and their masks show it: islands are none, nor are parking bays.
    pub fn is_on_road(&self, p_in_map: Point2<f64>) -> bool {
        self.renderer.ground_at(p_in_map.x as f32, p_in_map.y as f32).edge_m < 0.0
    }

    /// When a wheel's outer side comes over the inner edge of a line, from the first frame to the last, in the order of
    /// time: into another lane or off the road, with or without a turn signal.
    pub fn crossings(&self) -> Vec<Crossing> {
        crossings(&self.drive, &self.lanes, self.frames, self.fps)
    }

    /// What the vehicle's bus says from the first frame to the last: a log as `candump -L` writes it, whose clock begins with the
    /// first frame. [`crate::BUS_DATABASE`] and [`crate::BUS_SETTINGS`] read it.
    pub fn bus_log(&self) -> String {
        bus::log(&self.drive, self.planned.as_ref(), self.frames.saturating_sub(1) as f64 / self.fps)
    }

    /// The camera as it is in that frame: its mount with the body's pitch and roll about the road's plane.
    ///
    /// # Errors
    /// [`SimError::Geometry`] when body motion takes the mount out of its limits.
    pub fn camera_at(&self, index: usize) -> Result<Camera, SimError> {
        Ok(self.camera.with_mount(self.mount_of(&self.state(index)))?)
    }

    fn state(&self, index: usize) -> VehicleState {
        self.drive.at(index as f64 / self.fps)
    }

    fn mount_of(&self, state: &VehicleState) -> Mount {
        let mount = self.knock.map_or(self.mount, |knock| knock.on(self.mount, state.route_m));
        Mount {
            pitch_rad: mount.pitch_rad + state.pitch_rad,
            roll_rad: mount.roll_rad + state.roll_rad,
            ..mount
        }
    }

    /// The other vehicles that can be seen in a frame.
    fn vehicles(&self, moment: &Moment) -> Vec<Object> {
        let Moment { t_s, state, leader_m, .. } = *moment;
        self.traffic.seen(state.p_in_map, t_s, leader_m, |p| self.height_m(p))
    }

    /// Height of the ground at a place of the map, metres.
    fn height_m(&self, p_in_map: Point2<f64>) -> f64 {
        let street_m = self.renderer.street_height_m(p_in_map.x as f32, p_in_map.y as f32);
        self.relief.height_m(p_in_map) + f64::from(street_m)
    }

    /// The road's plane below the wheels.
    fn map_from_vehicle(&self, state: &VehicleState) -> Isometry3<f64> {
        let (sin, cos) = libm::sincos(state.heading_rad);
        let (forward, left) = (Vector2::new(cos, sin), Vector2::new(-sin, cos));
        let wheel = |x: f64, y: f64| self.height_m(state.p_in_map + forward * x + left * y);
        let SimVehicle { wheelbase_m, track_m, .. } = self.vehicle;
        let half = 0.5 * track_m;
        let (rear_left, rear_right) = (wheel(0.0, half), wheel(0.0, -half));
        let (front_left, front_right) = (wheel(wheelbase_m, half), wheel(wheelbase_m, -half));
        let rear = 0.5 * (rear_left + rear_right);
        let uphill = (0.5 * (front_left + front_right) - rear) / wheelbase_m;
        let left_up = 0.5 * (rear_left + front_left - rear_right - front_right) / track_m;
        let rotation = Rotation3::from_axis_angle(&Vector3::z_axis(), state.heading_rad)
            * Rotation3::from_axis_angle(&Vector3::y_axis(), -libm::atan(uphill))
            * Rotation3::from_axis_angle(&Vector3::x_axis(), libm::atan(left_up));
        Isometry3::from_parts(
            Translation3::new(state.p_in_map.x, state.p_in_map.y, rear),
            UnitQuaternion::from_rotation_matrix(&rotation),
        )
    }
}

/// The drive along a line, and what the driver does on it.
fn plan_drive(
    driven: &DrivenLine,
    route_m: f64,
    config: &SimConfig,
) -> Result<(Drive, Option<PlannedDriving>), SimError> {
    let within = config.start_m..=route_m - config.end_gap_m;
    let drive = |aside_m: &dyn Fn(f64) -> f64, stops: &[(f64, f64)]| {
        let path = driven.path(aside_m).into_iter().filter(|point| within.contains(&point.route_m));
        Drive::new(path.collect(), stops, config.cruise_speed_mps, &config.conditions, config.seed)
    };
    let plain = drive(&|_| 0.0, &[])?;
    if config.driving.is_empty() {
        return Ok((plain, None));
    }
    let lane_width_m = config.conditions.lanes.lane_width_m;
    let planned = PlannedDriving::new(&config.driving, config.seed, lane_width_m, plain.clock());
    let stops: Vec<(f64, f64)> = planned.stops().collect();
    Ok((drive(&|route_m| planned.aside_m(route_m), &stops)?, Some(planned)))
}

/// The rectangle around the route within which roads are drawn.
fn surroundings(line: &Polyline) -> (Point2<f64>, Point2<f64>) {
    let margin = Vector2::repeat(2.0 * REACH_M);
    let points = line.points();
    let low = points.iter().fold(points[0], |low, p| low.inf(p));
    let high = points.iter().fold(points[0], |high, p| high.sup(p));
    (low - margin, high + margin)
}

fn strips(roads: &RoadNetwork) -> Vec<RoadStrip> {
    let strip = |stroke: &Stroke| RoadStrip {
        axis: [stroke.start, stroke.start + stroke.direction * stroke.length_m],
        half_width_m: stroke.half_width_m,
    };
    roads.strokes().iter().map(strip).collect()
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
pub(crate) mod tests;
