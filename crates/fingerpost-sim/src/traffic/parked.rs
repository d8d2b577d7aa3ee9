//! Rows of vehicles along the kerbs.

use fingerpost_geometry::Polyline;
use nalgebra::Vector2;

use super::{Traffic, Vehicle};
use crate::noise::Stream;
use crate::roads::RoadNetwork;
use crate::{SimConfig, TrafficSide};

/// Length of a roadside that is lined or not, metres.
const STRETCH_M: f64 = 45.0;
/// Space between two vehicles of a row, metres, and share of the places that are free.
const BETWEEN_M: [f64; 2] = [0.5, 1.8];
const FREE: f64 = 0.12;
/// Distance of wheels from the kerb, metres.
const FROM_KERB_M: f64 = 0.25;
/// How far beyond the road's edge they stand, share of their width: on the road, half on the pavement, beside the road.
const BEYOND: [(f64, f64); 3] = [(0.6, 0.0), (0.2, 0.5), (0.2, 1.2)];
/// Space between a row and who drives by, metres.
const PASSING_M: f64 = 0.45;
/// Half of the width that oncoming traffic takes, metres.
const ONCOMING_HALF_M: f64 = 1.25;
/// No row is nearer to another road than 5 m (German road traffic act, section 12: from the intersection of the edges).
const FROM_CORNERS_M: f64 = 5.0;

/// The rows of a route.
pub(super) fn rows(route: &Polyline, roads: &RoadNetwork, config: &SimConfig) -> Vec<Vehicle> {
    let share = config.conditions.streetscape.parked_rows;
    let mut vehicles = Vec::new();
    for side in [-1.0, 1.0] {
        let mut stream = Stream::new(config.seed ^ 0x524f_5753, u64::from(side > 0.0));
        let mut at_m = 0.0;
        while share > 0.0 && at_m < route.length_m() {
            let end_m = at_m + STRETCH_M;
            let is_lined = stream.unit() < share;
            let beyond = stream.choose(&BEYOND).unwrap_or(0.0);
            while is_lined && at_m < end_m {
                let drawn = Traffic::draw(&mut stream, 0.0, 0.0);
                let length_m = 2.0 * f64::from(drawn.shape.half_m[0]);
                let middle_m = at_m + 0.5 * length_m;
                at_m += length_m + stream.between(BETWEEN_M[0], BETWEEN_M[1]);
                let is_free = stream.unit() < FREE;
                let vehicle =
                    Vehicle { start_m: middle_m, oncoming: stream.unit() < 0.5 * (1.0 + side), ..drawn };
                let aside_m = aside_m(&vehicle, side, beyond, route, roads, config);
                if let Some(aside_m) = aside_m.filter(|_| !is_free) {
                    vehicles.push(Vehicle { aside_m, ..vehicle });
                }
            }
            at_m = at_m.max(end_m);
        }
    }
    vehicles
}

/// How far left of the route's line it stands, metres; none where another road is near.
fn aside_m(
    vehicle: &Vehicle,
    side: f64,
    beyond: f64,
    route: &Polyline,
    roads: &RoadNetwork,
    config: &SimConfig,
) -> Option<f64> {
    let (axis, along) = route.at(vehicle.start_m);
    let (stroke, _) = roads.along(axis, along)?;
    let half_width_m = f64::from(vehicle.shape.half_m[1]);
    let own_half_m = 0.5 * config.vehicle.width_m;
    let lane_m = 0.5 * stroke.half_width_m;
    let driven_side = match config.traffic {
        TrafficSide::Left => 1.0,
        TrafficSide::Right => -1.0,
        TrafficSide::Centre => 0.0,
    };
    // Where the row's inner side may be at the nearest, from the axis.
    let own_m = lane_m * driven_side * side + own_half_m + config.habits.aside_m * side;
    let others_m = if config.conditions.traffic > 0.0 { lane_m + ONCOMING_HALF_M } else { 0.0 };
    let inner_m = own_m.max(others_m) + PASSING_M;
    let at_kerb_m = stroke.half_width_m - FROM_KERB_M - half_width_m + beyond * 2.0 * half_width_m;
    let middle_m = side * at_kerb_m.max(inner_m + half_width_m);
    let place = axis + Vector2::new(-along.y, along.x) * middle_m;
    let is_other = |&i: &u32| roads.strokes()[i as usize].chain != stroke.chain;
    let nearby = roads.within(place, half_width_m + FROM_CORNERS_M);
    (!nearby.iter().any(is_other)).then_some(middle_m)
}
