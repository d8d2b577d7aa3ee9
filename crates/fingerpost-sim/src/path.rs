//! The line that the vehicle's rear axle follows: the route, rounded at its corners, on the vehicle's side of the road.
//!
//! The route's corners are rounded by curvature flow (each sample moves towards the middle of its neighbours while the
//! curve there is tighter than the vehicle may turn), which leaves arcs of that radius whatever the spacing of the
//! map's nodes. The rounded line is shifted sideways and read as a uniform cubic B-spline, whose curvature, and with it
//! the steering angle, is continuous. Samples keep their distance along the route throughout.

use std::f64::consts::TAU;

use fingerpost_geometry::{Polyline, heading_of, wrap_angle};
use nalgebra::{Point2, Vector2};

use crate::corners::CornerStyle;
use crate::markings::lane_middle_m;
use crate::noise::Stream;
use crate::roads::RoadNetwork;
use crate::turns::Turn;
use crate::{SimConfig, SimError};

/// Spacing of the samples along the route, metres.
const SAMPLE_M: f64 = 0.5;
/// Radius of the road axis' turn at an ordinary corner, metres: with rounded kerbs of 4 m on a 5.5 m road the lanes are
/// then concentric with the kerb.
const TURN_RADIUS_M: f64 = 6.75;
/// The same where the route doubles back by more than a right angle, metres: a car's full lock.
const TIGHT_RADIUS_M: f64 = 5.0;
/// The kinks of a curved road are driven on arcs that leave its axis by this much, metres, and not on tighter ones.
const CUT_M: f64 = 0.4;
/// Radius above which a kink needs no slowing down, metres.
const GENTLE_RADIUS_M: f64 = 40.0;
/// Half of the window over which a corner's turn is measured, metres.
const TURN_WINDOW_M: f64 = 8.0;
/// Upper bound of the flow's steps; a right angle takes about 600.
const FLOW_STEPS: usize = 6000;
/// Length over which a changed road width shifts the line, metres.
const SHIFT_M: f64 = 16.0;
/// Wavelengths of the driver's wander, metres.
const WANDER_LENGTHS_M: [f64; 3] = [97.0, 61.0, 37.0];

/// A point of the driven line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PathPoint {
    /// Place of the rear axle's middle, map frame, metres.
    pub(crate) p_in_map: Point2<f64>,
    /// Direction of the line, radians.
    pub(crate) heading_rad: f64,
    /// Change of heading for each metre, positive to the left.
    pub(crate) curvature_per_m: f64,
    /// Distance along the route, metres.
    pub(crate) route_m: f64,
}

/// Spline points for each sample: 0.1 m apart, so that straight pieces between them are within a millimetre.
const SUBSAMPLES: usize = 5;

/// The line that a vehicle follows along a route when it does nothing else.
#[derive(Debug, Clone)]
pub(crate) struct DrivenLine {
    /// Every [`SAMPLE_M`] along the route.
    control: Vec<Point2<f64>>,
    /// Unit vectors to its left.
    lefts: Vec<Vector2<f64>>,
    /// How far to the left of it the vehicle's lane is, metres.
    shifts_m: Vec<f64>,
    /// How far to the left of that its driver wanders, metres.
    wander_m: Vec<f64>,
}

impl DrivenLine {
    /// The line for `route`, from its start to its end.
    pub(crate) fn new(route: &Polyline, roads: &RoadNetwork, config: &SimConfig) -> Result<Self, SimError> {
        let SimConfig { conditions, seed, .. } = config;
        let turns = match config.corners {
            CornerStyle::Alike => Vec::new(),
            CornerStyle::Drawn => Turn::of_route(route, roads, config),
        };
        let count = (route.length_m() / SAMPLE_M).floor() as usize;
        let axis: Vec<Point2<f64>> = (0..=count).map(|i| route.at(i as f64 * SAMPLE_M).0).collect();
        let mut shifts_m = side_shifts(route, &axis, roads, config)?;
        for (i, shift_m) in shifts_m.iter_mut().enumerate() {
            let kept = turns.iter().map(|turn| turn.kept_shift(i as f64 * SAMPLE_M, *shift_m));
            *shift_m *= kept.fold(1.0, f64::min);
        }
        let control = rounded(axis, route, &turns);
        let mut stream = Stream::new(*seed, 0x5741_4e44);
        let waves: Vec<(f64, f64)> =
            WANDER_LENGTHS_M.iter().map(|length| (TAU / length, stream.between(0.0, TAU))).collect();
        let wander = |i: usize| {
            let along = i as f64 * SAMPLE_M;
            let wave = waves.iter().map(|(k, phase)| libm::sin(k * along + phase)).sum::<f64>();
            conditions.wander_m / waves.len() as f64 * wave
        };
        let wander_m = (0..shifts_m.len()).map(wander).collect();
        let lefts = (0..control.len())
            .map(|i| {
                let along = control[(i + 1).min(control.len() - 1)] - control[i.saturating_sub(1)];
                Vector2::new(-along.y, along.x).normalize()
            })
            .collect();
        Ok(Self { control, lefts, shifts_m, wander_m })
    }

    /// The path of a vehicle that is `aside_m` to the left of the line at a distance along the route, metres.
    pub(crate) fn path(&self, aside_m: impl Fn(f64) -> f64) -> Vec<PathPoint> {
        let place = |i: usize| {
            let wandered_m = self.shifts_m[i] + self.wander_m[i];
            self.control[i] + self.lefts[i] * (wandered_m + aside_m(i as f64 * SAMPLE_M))
        };
        spline(&(0..self.control.len()).map(place).collect::<Vec<_>>())
    }

    /// The line itself, without the driver's wander: the middle of the lane, rounded at the corners.
    pub(crate) fn lane_middle(&self) -> Vec<PathPoint> {
        let place = |i: usize| self.control[i] + self.lefts[i] * self.shifts_m[i];
        spline(&(0..self.control.len()).map(place).collect::<Vec<_>>())
    }
}

/// How far left of the axis the vehicle keeps at each sample, metres.
fn side_shifts(
    route: &Polyline,
    axis: &[Point2<f64>],
    roads: &RoadNetwork,
    config: &SimConfig,
) -> Result<Vec<f64>, SimError> {
    /// Routes are made of the map's own nodes; farther off than this it is another map.
    const OFF_MAP_M: f64 = 5.0;
    let mut shifts = Vec::with_capacity(axis.len());
    for (i, &place) in axis.iter().enumerate() {
        let along_m = i as f64 * SAMPLE_M;
        let direction = route.at(along_m).1;
        let found = roads.along(place, direction);
        let distance_m = found.map_or(f64::INFINITY, |(_, distance_m)| distance_m);
        match found {
            // Trimmed side roads leave up to half of the main road's width without a stroke of their own.
            Some((stroke, distance_m)) if distance_m < OFF_MAP_M + 5.0 => {
                let middle_m = lane_middle_m(stroke, &config.conditions, config.traffic);
                let room_m = (stroke.half_width_m - middle_m.abs() - 0.5 * config.vehicle.width_m).max(0.0);
                shifts.push(middle_m + config.habits.aside_m.clamp(-room_m, room_m));
            }
            _ => return Err(SimError::RouteOffTheMap { along_m, distance_m }),
        }
    }
    let half = (0.5 * SHIFT_M / SAMPLE_M) as usize;
    Ok((0..shifts.len())
        .map(|i| {
            let window = &shifts[i.saturating_sub(half)..(i + half + 1).min(shifts.len())];
            window.iter().sum::<f64>() / window.len() as f64
        })
        .collect())
}

/// Curvature flow until no corner is tighter than the vehicle may turn.
fn rounded(mut points: Vec<Point2<f64>>, route: &Polyline, turns: &[Turn]) -> Vec<Point2<f64>> {
    let radius_m = |along_m: f64| {
        let drawn = turns.iter().filter_map(|turn| turn.radius_at_m(along_m)).reduce(f64::min);
        drawn.unwrap_or_else(|| turn_radius_m(route, along_m))
    };
    let limits: Vec<f64> = (0..points.len()).map(|i| 1.0 / radius_m(i as f64 * SAMPLE_M)).collect();
    for _ in 0..FLOW_STEPS {
        let before = points.clone();
        let mut moved = false;
        for i in 1..points.len() - 1 {
            if curvature_per_m(before[i - 1], before[i], before[i + 1]) > limits[i] {
                let middle = nalgebra::center(&before[i - 1], &before[i + 1]);
                points[i] += 0.5 * (middle - before[i]);
                moved = true;
            }
        }
        if !moved {
            break;
        }
    }
    points
}

fn turn_radius_m(route: &Polyline, along_m: f64) -> f64 {
    let (before, after) = (route.at(along_m - TURN_WINDOW_M).1, route.at(along_m + TURN_WINDOW_M).1);
    let turn = wrap_angle(heading_of(after) - heading_of(before)).abs();
    // An arc of radius r cuts a corner by r (1 / cos(turn / 2) - 1).
    let gentle = CUT_M / (1.0 / libm::cos(0.5 * turn).max(0.1) - 1.0).max(1e-9);
    // From 100 to 140 degrees.
    let tightness = ((turn - 1.75) / 0.7).clamp(0.0, 1.0);
    let ordinary = TURN_RADIUS_M + (TIGHT_RADIUS_M - TURN_RADIUS_M) * tightness;
    gentle.clamp(ordinary, GENTLE_RADIUS_M)
}

/// Curvature of the circle through three points (Menger), unsigned.
fn curvature_per_m(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    let (ab, bc, ac) = (b - a, c - b, c - a);
    let product = ab.norm() * bc.norm() * ac.norm();
    // A doubled-back line has no circle and is as sharp as can be.
    if product > 1e-9 { 2.0 * ab.perp(&bc).abs() / product } else { f64::INFINITY }
}

/// The uniform cubic B-spline over `control`, evaluated [`SUBSAMPLES`] times between neighbours.
fn spline(control: &[Point2<f64>]) -> Vec<PathPoint> {
    let mut path = Vec::new();
    for i in 1..control.len().saturating_sub(2) {
        let [a, b, c, d] = [i - 1, i, i + 1, i + 2].map(|k| control[k].coords);
        for j in 0..SUBSAMPLES {
            let t = j as f64 / SUBSAMPLES as f64;
            let (t2, t3) = (t * t, t * t * t);
            let weights = [
                1.0 - 3.0 * t + 3.0 * t2 - t3,
                4.0 - 6.0 * t2 + 3.0 * t3,
                1.0 + 3.0 * t + 3.0 * t2 - 3.0 * t3,
                t3,
            ];
            let place = (a * weights[0] + b * weights[1] + c * weights[2] + d * weights[3]) / 6.0;
            let speeds = [-1.0 + 2.0 * t - t2, -4.0 * t + 3.0 * t2, 1.0 + 2.0 * t - 3.0 * t2, t2];
            let velocity = (a * speeds[0] + b * speeds[1] + c * speeds[2] + d * speeds[3]) * 0.5;
            let turning = a * (1.0 - t) + b * (3.0 * t - 2.0) + c * (1.0 - 3.0 * t) + d * t;
            path.push(PathPoint {
                p_in_map: place.into(),
                heading_rad: heading_of(velocity),
                curvature_per_m: velocity.perp(&turning) / velocity.norm().powi(3),
                route_m: (i as f64 + t) * SAMPLE_M,
            });
        }
    }
    path
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Polyline {
        Polyline::new([(0.0, 0.0), (60.0, 0.0), (60.0, 60.0)].map(|(x, y)| Point2::new(x, y))).unwrap()
    }

    #[test]
    fn a_right_angle_becomes_an_arc_of_the_turning_radius() {
        let route = corner();
        let samples = (0..=240).map(|i| route.at(f64::from(i) * SAMPLE_M).0).collect();
        let path = spline(&rounded(samples, &route, &[]));
        let tightest = path.iter().map(|p| p.curvature_per_m.abs()).fold(0.0, f64::max);
        assert!((tightest * TURN_RADIUS_M - 1.0).abs() < 0.1, "radius {} m", 1.0 / tightest);
        let middle = path.iter().find(|p| p.route_m >= 60.0).unwrap();
        let cut = (middle.p_in_map - Point2::new(60.0, 0.0)).norm();
        assert!((cut - TURN_RADIUS_M * (2.0_f64.sqrt() - 1.0)).abs() < 0.3, "{cut} m inside of the corner");
        assert!(middle.curvature_per_m > 0.0, "a left turn");
    }

    #[test]
    fn heading_is_the_direction_of_the_line() {
        let route = corner();
        let samples = (0..=240).map(|i| route.at(f64::from(i) * SAMPLE_M).0).collect();
        for pair in spline(&rounded(samples, &route, &[])).windows(2) {
            let chord = heading_of(pair[1].p_in_map - pair[0].p_in_map);
            let mean = pair[0].heading_rad + 0.5 * wrap_angle(pair[1].heading_rad - pair[0].heading_rad);
            assert!(wrap_angle(chord - mean).abs() < 1e-3);
        }
    }
}
