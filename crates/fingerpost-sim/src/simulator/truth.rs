//! Where everything really is in a frame.

use fingerpost_format::{MarkingRecord, TruthRecord};
use nalgebra::{Point2, Point3, Vector2};

use super::{Moment, Simulator};
use crate::drive::VehicleState;
use crate::kerb_lines::kerbs_ahead;
use crate::truth::EdgeSeen;

impl Simulator {
    /// The truth of that frame, without rendering it.
    pub fn truth(&self, index: usize) -> TruthRecord {
        self.truth_of(&self.moment(index))
    }

    pub(crate) fn truth_of(&self, moment: &Moment) -> TruthRecord {
        let state = moment.state;
        let place = self.plane.wgs84_from_map(state.p_in_map);
        let target = self.targets.iter().find(|target| target.route_m > state.route_m);
        let (sin, cos) = libm::sincos(state.heading_rad);
        let in_vehicle = target.map(|target| {
            let offset = target.p_in_map - state.p_in_map;
            Vector2::new(cos * offset.x + sin * offset.y, cos * offset.y - sin * offset.x)
        });
        let [kerb_left_m, kerb_right_m] =
            if self.has_heights() { self.kerbs_ahead(moment) } else { Default::default() };
        let [(left, lane_left_marking), (right, lane_right_marking)] = self.lanes_of(&state);
        TruthRecord {
            frame: moment.frame,
            t_s: moment.t_s,
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
            picture_px: Some([self.camera.width(), self.camera.height()].map(|side| side as u32)),
            lane_left_px: left.px,
            lane_right_px: right.px,
            lane_left_m: left.m,
            lane_right_m: right.m,
            lane_left_marking,
            lane_right_marking,
            kerb_left_m,
            kerb_right_m,
            turn_signal: self.planned.as_ref().and_then(|planned| planned.turn_signal(state.route_m)),
        }
    }

    fn kerbs_ahead(&self, moment: &Moment) -> [Vec<[f64; 3]>; 2] {
        // A mount that body motion takes out of its limits sees nothing.
        let Ok(camera) = self.camera.with_mount(self.mount_of(&moment.state)) else {
            return Default::default();
        };
        kerbs_ahead(&self.renderer, &self.view(moment), &camera, |p| self.height_m(p))
    }

    /// The left and the right edge of the vehicle's lane as the picture shows them, with their markings.
    fn lanes_of(&self, state: &VehicleState) -> [(EdgeSeen, Option<MarkingRecord>); 2] {
        let Ok(camera) = self.camera.with_mount(self.mount_of(state)) else { return Default::default() };
        let map_from_vehicle = self.map_from_vehicle(state);
        let painted = |p: Point2<f64>| self.renderer.bears_lines(p.x as f32, p.y as f32);
        let on_ground = |p: &Point2<f64>| Point3::new(p.x, p.y, self.height_m(*p));
        self.lanes.ahead(state.p_in_map, state.route_m, state.heading_rad, painted).map(|edge| {
            let points: Vec<Point3<f64>> = edge.points.iter().map(on_ground).collect();
            let seen = EdgeSeen::new(&points, &camera, &map_from_vehicle);
            let marking = edge.marking.filter(|_| !seen.px.is_empty());
            (seen, marking)
        })
    }
}
