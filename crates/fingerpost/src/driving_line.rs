//! Driving line: the way through a feature that the vehicle can steer.
//!
//! Paper 1, section V-B: a quadratic Bezier curve from the approach over the feature to the exit, whose ends are set back from
//! the node until it respects the vehicle's turning circle. Here it follows the lane and the corner that is there (`corner`):
//! the lanes' middles are its tangents, and its radius is that of a path concentric with the kerb, wider only where the
//! turning circle asks for it and the road has room. With its corner weighted by cos(turn / 2) a rational curve of the
//! papers' three points is the arc of that radius (Farin: Curves and surfaces for CAGD, 2002, section 12.5).
//!
//! What a feature is found by is not this line but the papers' own curve ([`MaskCurve`](crate::feature_masks::MaskCurve)).
//!
//! Limits: where the arc is still too tight, as a circle of 25 m at a right angle, a line that the vehicle can drive would
//! leave the road. The line then stays, and [`DrivingLine::within_turning_circle`] and the frame's `why` say it. The kerb is an
//! arc, as assumed or measured; a chamfer is taken for one.

mod corner;
mod joining;

use fingerpost_geometry::{GeometryError, Polyline};
use nalgebra::{Point2, Vector2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::conic::Conic;
use crate::feature_model::FeatureModel;
use crate::vehicle::VehicleConfig;

pub(crate) use self::joining::driving_lines;

use self::corner::Corner;

/// Settings of the driving line.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct DrivingLineConfig {
    /// Shortest distance of the curve's ends from the node, metres.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub min_setback_m: f64,
    /// Longest distance of the curve's ends from the node, metres: farther away the next junction may begin.
    #[schemars(range(min = 0.5, max = 40.0))]
    pub max_setback_m: f64,
    /// Distance between the points that are handed out, metres.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub step_m: f64,
    /// Length of approach before and of exit behind the curve that is handed out too, metres.
    #[schemars(range(min = 0.0, max = 200.0))]
    pub lead_m: f64,
}

impl Default for DrivingLineConfig {
    fn default() -> Self {
        Self { min_setback_m: 3.0, max_setback_m: 20.0, step_m: 0.5, lead_m: 15.0 }
    }
}

impl DrivingLineConfig {
    /// Points of approach before and of exit behind the curve.
    fn lead_points(&self) -> usize {
        (self.lead_m / self.step_m.max(0.05)).floor() as usize
    }
}

/// The driving line through a feature, in the feature frame.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivingLine {
    /// The three control points: approach, corner, exit; metres.
    pub control: [Point2<f64>; 3],
    /// How far before the node on the approach the curve begins, and behind it on the exit ends, metres.
    pub setbacks_m: [f64; 2],
    /// The curve alone, sampled, metres.
    pub curve: Polyline,
    /// Approach, curve and exit, `step_m` apart, metres.
    pub points: Vec<Point2<f64>>,
    /// Signed curvature at each of `points`, 1/m, positive to the left.
    pub curvature_per_m: Vec<f64>,
    /// Radius at the tightest place of the curve, metres (infinite on a straight one).
    pub tightest_radius_m: f64,
    /// Radius of the vehicle's turning circle, metres.
    pub turning_radius_m: f64,
}

/// Distance on either side of a point of approach or exit over which its curvature is measured, metres.
const CORNER_SPREAD_M: f64 = 3.0;
/// Pieces of a bend's length whose ends are averaged: half a metre each.
const BEND_PLACES: usize = 12;
/// Times that a curve is widened, a twentieth each, until it is as wide as is needed.
const MOST_WIDENED: usize = 8;
/// Radius of the kerbs where none is known, metres: German residential streets join with 4 to 6 m (RASt 06, table 45).
pub const ASSUMED_KERB_M: f64 = 4.0;

/// What a feature's arms do not say of its corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CornerSetting {
    /// Radius of the kerb between approach and exit, metres.
    pub kerb_radius_m: f64,
    /// Lengths of approach and exit that the curve may take, metres: farther away another turn of the route needs the road.
    pub own_m: [f64; 2],
}

impl Default for CornerSetting {
    /// A kerb of [`ASSUMED_KERB_M`], and no other turn near.
    fn default() -> Self {
        Self { kerb_radius_m: ASSUMED_KERB_M, own_m: [f64::INFINITY; 2] }
    }
}

impl DrivingLine {
    /// The driving line of `vehicle` through `feature` round a corner; none when the feature has no approach or exit.
    ///
    /// # Errors
    /// [`GeometryError`] when the arms leave no room for a curve.
    pub fn new(
        config: &DrivingLineConfig,
        vehicle: &VehicleConfig,
        feature: &FeatureModel,
        setting: &CornerSetting,
    ) -> Result<Option<Self>, GeometryError> {
        let (Some(approach), Some(exit)) = (feature.approach(), feature.exit()) else { return Ok(None) };
        let lane_m = |width_m: f64| vehicle.traffic.lane_left_m(width_m);
        let inbound = approach.course.reversed().offset(lane_m(approach.width_m))?;
        let outbound = exit.course.offset(lane_m(exit.width_m))?;
        let mut corner = Corner::of(vehicle, feature.kind, [approach, exit], setting.kerb_radius_m);
        let longest_m = setting.own_m.map(|own_m| config.max_setback_m.min(own_m));
        let shortest_m = longest_m.map(|longest_m| config.min_setback_m.min(longest_m));
        let within_m = [shortest_m, longest_m];
        let mut setbacks_m = corner.setbacks_m(within_m, &inbound, &outbound);
        let mut curve = corner.curve(&inbound, &outbound, setbacks_m);
        // Between arms that bend the curve is tighter somewhere than its arc.
        for _ in 0..MOST_WIDENED {
            if curve.tightest_radius_m() >= corner.needed_m() {
                break;
            }
            corner.widen();
            setbacks_m = corner.setbacks_m(within_m, &inbound, &outbound);
            curve = corner.curve(&inbound, &outbound, setbacks_m);
        }
        let sampled = curve.sampled()?;
        let (points, curvature_per_m) = hand_out(config, &inbound, &curve, &sampled, &outbound, setbacks_m);
        Ok(Some(Self {
            control: curve.control,
            setbacks_m,
            curve: sampled,
            points,
            curvature_per_m,
            tightest_radius_m: curve.tightest_radius_m(),
            turning_radius_m: vehicle.turning_radius_m,
        }))
    }

    /// Whether the vehicle can drive it.
    pub fn within_turning_circle(&self) -> bool {
        // An arc of just that radius is, whatever its last digit says.
        self.tightest_radius_m >= self.turning_radius_m * (1.0 - 1e-9)
    }

    /// Where the curve begins, feature frame, metres.
    pub const fn start(&self) -> Point2<f64> {
        self.control[0]
    }

    /// Where the curve ends, feature frame, metres.
    pub const fn end(&self) -> Point2<f64> {
        self.control[2]
    }
}

fn hand_out(
    config: &DrivingLineConfig,
    inbound: &Polyline,
    curve: &Conic,
    sampled: &Polyline,
    outbound: &Polyline,
    [before_m, behind_m]: [f64; 2],
) -> (Vec<Point2<f64>>, Vec<f64>) {
    let step = config.step_m.max(0.05);
    let lead = config.lead_points();
    let led =
        |arm: &Polyline, along_m: f64, i: usize| bent(arm, along_m, CORNER_SPREAD_M.min(step * i as f64));
    let mut points: Vec<Point2<f64>> =
        (1..=lead).rev().map(|i| led(inbound, inbound.length_m() - before_m - step * i as f64, i)).collect();
    let pieces = (sampled.length_m() / step).ceil().max(1.0) as usize;
    let parameters: Vec<f64> =
        (0..=pieces).map(|i| parameter_at(sampled, sampled.length_m() * i as f64 / pieces as f64)).collect();
    points.extend(parameters.iter().map(|&t| curve.at(t)));
    points.extend((1..=lead).map(|i| led(outbound, behind_m + step * i as f64, i)));
    let reach = (CORNER_SPREAD_M / step).ceil() as usize;
    let curvature = (0..points.len())
        .map(|i| match i.checked_sub(lead).and_then(|k| parameters.get(k)) {
            Some(&t) => curve.curvature_per_m(t),
            None => {
                // The map's corners are spread over the length in which a vehicle steers through them.
                let (before, after) = (i.saturating_sub(reach), (i + reach).min(points.len() - 1));
                three_point_curvature(points[before], points[i], points[after])
            }
        })
        .collect();
    (points, curvature)
}

/// The place on a line whose corners are bends over `spread_m` before and behind them, metres: the mean of the line over as much about
/// `along_m`, which is the line itself where that is straight, and a parabola at a corner. It leaves a corner of 30 degrees by 0.4 m,
/// as much as the middle of a road leaves the nodes of its map.
fn bent(line: &Polyline, along_m: f64, spread_m: f64) -> Point2<f64> {
    let places = (1..BEND_PLACES).map(|i| {
        let share = 2.0 * i as f64 / BEND_PLACES as f64 - 1.0;
        line.at(along_m + spread_m * share).0.coords
    });
    Point2::from(places.sum::<Vector2<f64>>() / (BEND_PLACES - 1) as f64)
}

/// Signed curvature of the circle through three points, 1/m, positive to the left.
fn three_point_curvature(a: Point2<f64>, b: Point2<f64>, c: Point2<f64>) -> f64 {
    let sides = (b - a).norm() * (c - b).norm() * (c - a).norm();
    if sides > 0.0 { 2.0 * (b - a).perp(&(c - b)) / sides } else { 0.0 }
}

/// Bezier parameter at an arc length, by linear interpolation between the samples, which are equal steps of it.
fn parameter_at(sampled: &Polyline, along_m: f64) -> f64 {
    let mut walked = 0.0;
    let pieces = sampled.points().len() - 1;
    for (i, ends) in sampled.points().windows(2).enumerate() {
        let length = (ends[1] - ends[0]).norm();
        if walked + length >= along_m {
            return (i as f64 + (along_m - walked) / length) / pieces as f64;
        }
        walked += length;
    }
    1.0
}
