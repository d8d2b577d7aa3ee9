//! Where the edges of the vehicle's lane are.
//!
//! The edges are those of the paint that the renderer draws: at every sample of the route the axis of its road and the
//! layout painted about it. An edge is followed at its marking's inner side, through the gaps of a broken one.

use fingerpost_format::MarkingRecord;
use fingerpost_geometry::{Camera, Pixel, Polyline, heading_of, wrap_angle};
use nalgebra::{Isometry3, Point2, Point3, Vector2};

use crate::markings::{Layout, lane_middle_m};
use crate::roads::RoadNetwork;
use crate::{SimConfig, SimVehicle, TrafficSide};

/// Spacing of the samples along the route, metres.
const SPACING_M: f64 = 0.25;
/// Farther than this ahead of the rear axle, metres, only each [`THINNED`]th sample is a point of an edge: in a picture 640
/// pixels wide straight pieces of a metre between them are then within a tenth of a pixel of a bend of 60 m.
const DENSE_TO_M: f64 = 16.0;
const THINNED: usize = 4;
/// Nearest and farthest point of a lane's edge ahead of the rear axle, metres along the route. No camera of a vehicle sees
/// ground behind its axle; beyond the farthest a line is narrower than a quarter of a pixel.
const FROM_M: f64 = -1.0;
const TO_M: f64 = 80.0;
/// A lane ends where the route turns away from the vehicle's heading by more than this, radians (60 degrees).
const TURNED_AWAY_RAD: f64 = 1.05;

/// The road at a place of the route.
#[derive(Debug, Clone, Copy)]
struct Sample {
    /// On the road's axis.
    on_axis: Point2<f64>,
    /// Unit vector to the left of who drives the route.
    left: Vector2<f64>,
    /// What is painted, in the route's direction; none off the roads.
    layout: Option<usize>,
    /// How far left of the axis the vehicle's lane is.
    home_m: f64,
    /// Half of the road's width; none off the roads.
    half_width_m: Option<f64>,
}

/// Where a vehicle is on its road.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RoadPlace {
    /// How far left of the road's middle its rear axle's middle is, metres. Of a highway it is the middle of the
    /// carriageway.
    pub left_m: f64,
    /// Its direction against the road's, radians, positive to the left.
    pub heading_rad: f64,
    /// Half of the road's width, metres.
    pub half_width_m: f64,
}

/// The lane's edges along the route.
#[derive(Debug, Clone)]
pub(crate) struct LaneEdges {
    route: Polyline,
    /// Every [`SPACING_M`] along the route.
    samples: Vec<Sample>,
    layouts: Vec<Layout>,
    vehicle: SimVehicle,
}

/// How many lines the wheels of a vehicle have passed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct LinesPassed {
    /// What is painted there; counts are only alike on the same.
    pub(crate) layout: usize,
    /// Markings whose right edge is to the right of a left wheel's outer side.
    pub(crate) by_left_wheels: usize,
    /// Markings whose left edge is to the left of a right wheel's outer side.
    pub(crate) by_right_wheels: usize,
}

/// An edge of the lane ahead.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeAhead {
    /// Points, near to far, map frame, metres.
    pub(crate) points: Vec<Point2<f64>>,
    /// The marking at the nearest of them.
    pub(crate) marking: Option<MarkingRecord>,
}

impl LaneEdges {
    pub(crate) fn new(route: Polyline, roads: &RoadNetwork, config: &SimConfig) -> Self {
        let SimConfig { conditions, traffic, vehicle, .. } = config;
        let mut layouts: Vec<Layout> = Vec::new();
        let count = (route.length_m() / SPACING_M) as usize;
        let samples = (0..=count).map(|i| {
            let (place, direction) = route.at(i as f64 * SPACING_M);
            let left = Vector2::new(-direction.y, direction.x);
            let Some((stroke, _)) = roads.along(place, direction) else {
                return Sample { on_axis: place, left, layout: None, home_m: 0.0, half_width_m: None };
            };
            let with_route = stroke.direction.dot(&direction).signum();
            let left = Vector2::new(-stroke.direction.y, stroke.direction.x) * with_route;
            let layout = Layout::of(stroke, conditions, *traffic);
            let layout = if with_route < 0.0 { layout.mirrored() } else { layout };
            let layout = if *traffic == TrafficSide::Centre { layout.without_centre() } else { layout };
            let home_m = lane_middle_m(stroke, conditions, *traffic);
            let index = layouts.iter().position(|known| *known == layout).unwrap_or_else(|| {
                layouts.push(layout);
                layouts.len() - 1
            });
            let on_axis = place - left * left.dot(&(place - stroke.start));
            let half_width_m = Some(stroke.half_width_m);
            Sample { on_axis, left, layout: Some(index), home_m, half_width_m }
        });
        let samples = samples.collect();
        Self { route, samples, layouts, vehicle: *vehicle }
    }

    /// Where a vehicle is on its road; none off the roads.
    pub(crate) fn road_place(
        &self,
        p_in_map: Point2<f64>,
        route_m: f64,
        heading_rad: f64,
    ) -> Option<RoadPlace> {
        let sample = self.samples.get((route_m / SPACING_M).round() as usize)?;
        let along = Vector2::new(sample.left.y, -sample.left.x);
        Some(RoadPlace {
            left_m: sample.left.dot(&(p_in_map - sample.on_axis)),
            heading_rad: wrap_angle(heading_rad - heading_of(along)),
            half_width_m: sample.half_width_m?,
        })
    }

    /// The lines that a vehicle's wheels have passed; none off the roads.
    pub(crate) fn lines_passed(
        &self,
        p_in_map: Point2<f64>,
        route_m: f64,
        heading_rad: f64,
    ) -> Option<LinesPassed> {
        let (sin, cos) = libm::sincos(heading_rad);
        let (mut leftmost_m, mut rightmost_m) = (f64::NEG_INFINITY, f64::INFINITY);
        let mut layout = None;
        for ahead_m in [self.vehicle.wheelbase_m, 0.0] {
            let i = ((route_m + ahead_m) / SPACING_M).round() as usize;
            let sample = self.samples.get(i)?;
            for aside_m in [0.5, -0.5].map(|side| side * self.vehicle.width_m) {
                let wheel = p_in_map + Vector2::new(cos, sin) * ahead_m + Vector2::new(-sin, cos) * aside_m;
                let left_m = sample.left.dot(&(wheel - sample.on_axis));
                (leftmost_m, rightmost_m) = (leftmost_m.max(left_m), rightmost_m.min(left_m));
            }
            layout = sample.layout;
        }
        let layout = layout?;
        let markings = self.layouts[layout].markings();
        Some(LinesPassed {
            layout,
            by_left_wheels: markings.iter().filter(|marking| marking.right_m < leftmost_m).count(),
            by_right_wheels: markings.iter().filter(|marking| marking.left_m > rightmost_m).count(),
        })
    }

    /// The left and the right edge ahead of a vehicle where lines are `painted`.
    pub(crate) fn ahead(
        &self,
        p_in_map: Point2<f64>,
        route_m: f64,
        heading_rad: f64,
        painted: impl Fn(Point2<f64>) -> bool,
    ) -> [EdgeAhead; 2] {
        let mut edges = [EdgeAhead::default(), EdgeAhead::default()];
        let here = ((route_m / SPACING_M).round() as usize).min(self.samples.len() - 1);
        let vehicle = self.samples[here];
        let vehicle_m = vehicle.left.dot(&(p_in_map - vehicle.on_axis));
        let first = ((route_m + FROM_M) / SPACING_M).ceil().max(0.0) as usize;
        let dense_to = ((route_m + DENSE_TO_M) / SPACING_M) as usize;
        let last = ((route_m + TO_M) / SPACING_M) as usize;
        for i in (first..dense_to).chain((dense_to..=last).step_by(THINNED)) {
            let Some(sample) = self.samples.get(i) else { break };
            let direction = self.route.at(i as f64 * SPACING_M).1;
            if wrap_angle(heading_of(direction) - heading_rad).abs() > TURNED_AWAY_RAD {
                break;
            }
            let Some(layout) = sample.layout else { continue };
            let in_lane_m = if sample.layout == vehicle.layout { vehicle_m } else { sample.home_m };
            let [left, right] = self.layouts[layout].around(in_lane_m);
            let inner_m = [left.map(|marking| marking.right_m), right.map(|marking| marking.left_m)];
            for ((edge, inner_m), marking) in edges.iter_mut().zip(inner_m).zip([left, right]) {
                let point = inner_m.map(|inner_m| sample.on_axis + sample.left * inner_m);
                if let Some(point) = point.filter(|point| painted(*point)) {
                    edge.points.push(point);
                    edge.marking = edge.marking.or(marking.map(|marking| marking.look));
                }
            }
        }
        edges
    }
}

/// An edge as a camera shows it, near to far.
#[derive(Debug, Clone, Default)]
pub(crate) struct EdgeSeen {
    /// `[u, v]` pixels.
    pub(crate) px: Vec<[f64; 2]>,
    /// The same points in the vehicle frame, `[forward, left]` metres.
    pub(crate) m: Vec<[f64; 2]>,
}

/// Halvings of the piece that crosses the picture's border: a metre becomes a thousandth of a millimetre.
const BORDER_HALVINGS: usize = 20;

impl EdgeSeen {
    /// The part of an edge (map frame, on the ground) that the picture shows, to the picture's very border. What lies
    /// lower in the picture than a nearer point is behind a crest.
    pub(crate) fn new(edge: &[Point3<f64>], camera: &Camera, map_from_vehicle: &Isometry3<f64>) -> Self {
        let in_vehicle: Vec<Point3<f64>> =
            edge.iter().map(|p| map_from_vehicle.inverse_transform_point(p)).collect();
        let shown = |p: Point3<f64>| camera.project(p).filter(|pixel| camera.contains(*pixel));
        let mut seen = Self::default();
        for (i, &p) in in_vehicle.iter().enumerate() {
            let before = i.checked_sub(1).map(|before| in_vehicle[before]);
            match (before.map(|before| (before, shown(before))), shown(p)) {
                (Some((before, Some(pixel))), None) => seen.add(border((before, pixel), p, shown)),
                (Some((before, None)), Some(pixel)) => {
                    seen.add(border((p, pixel), before, shown));
                    seen.add((p, pixel));
                }
                (_, Some(pixel)) => seen.add((p, pixel)),
                (_, None) => {}
            }
        }
        seen
    }

    fn add(&mut self, (p_in_vehicle, pixel): (Point3<f64>, Pixel)) {
        if self.px.last().is_none_or(|nearer| pixel.v < nearer[1]) {
            self.px.push([pixel.u, pixel.v]);
            self.m.push([p_in_vehicle.x, p_in_vehicle.y]);
        }
    }
}

/// The last point that is shown on the way from one that is to one that is not, and its pixel.
fn border(
    mut inside: (Point3<f64>, Pixel),
    mut outside: Point3<f64>,
    shown: impl Fn(Point3<f64>) -> Option<Pixel>,
) -> (Point3<f64>, Pixel) {
    for _ in 0..BORDER_HALVINGS {
        let middle = nalgebra::center(&inside.0, &outside);
        match shown(middle) {
            Some(pixel) => inside = (middle, pixel),
            None => outside = middle,
        }
    }
    inside
}
