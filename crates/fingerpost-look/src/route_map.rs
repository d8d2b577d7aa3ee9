//! A route on its map: from above, and as a camera sees it whose vehicle stands on the route.

use fingerpost_geometry::{Camera, Polyline};
use nalgebra::{Isometry2, Point2};
use serde::Serialize;

use crate::shapes::{Lens, Shape, ShapeKind};

/// How far about the vehicle roads and route are drawn into the picture, metres.
const SEEN_M: f64 = 80.0;
/// Step along them, metres: a lens bends what is straight.
const STEP_M: f64 = 0.5;
/// How far beside the route's bounds the map is shown, metres.
const BESIDE_M: f64 = 200.0;

/// A place of a route by which it is known.
#[derive(Debug, Clone, PartialEq)]
pub struct RoutePlace {
    /// Where it is, metres in the route's map frame.
    pub p_in_map: Point2<f64>,
    /// What it is.
    pub label: String,
}

/// A route with the roads about it, metres in its map frame.
#[derive(Debug, Clone)]
pub struct RouteMap {
    line: Polyline,
    roads: Vec<Vec<Point2<f64>>>,
    places: Vec<RoutePlace>,
}

/// What the page is told of it, east and north in metres.
#[derive(Debug, Serialize)]
pub(crate) struct PageMap {
    length_m: f64,
    line_m: Vec<[f64; 2]>,
    roads_m: Vec<Vec<[f64; 2]>>,
    places: Vec<PagePlace>,
}

/// Where a run has the vehicle on the map, metres in the route's map frame, or east and north of its first place.
#[derive(Debug, Clone, Default)]
pub struct RunMap {
    /// The route with the roads about it, where it is known.
    pub route: Option<RouteMap>,
    /// The vehicle's place in each frame; none where it is not known.
    pub fixes: Vec<Option<Point2<f64>>>,
}

/// What the page is told of that.
#[derive(Debug, Serialize)]
pub(crate) struct PageRunMap {
    route: Option<PageMap>,
    fixes_m: Vec<Option<[f64; 2]>>,
}

impl RunMap {
    /// The map as the page draws it.
    pub(crate) fn page_map(&self) -> PageRunMap {
        PageRunMap {
            route: self.route.as_ref().map(RouteMap::page_map),
            fixes_m: self.fixes.iter().map(|fix| fix.as_ref().map(rounded)).collect(),
        }
    }
}

/// A place to the centimetre.
fn rounded(point: &Point2<f64>) -> [f64; 2] {
    [point.x, point.y].map(|m| (m * 100.0).round() / 100.0)
}

#[derive(Debug, Serialize)]
struct PagePlace {
    at_m: [f64; 2],
    label: String,
}

impl RouteMap {
    /// A route, the roads of its map and its features. Of the roads what lies far from the route is left out.
    pub fn new(line: Polyline, roads: Vec<Vec<Point2<f64>>>, places: Vec<RoutePlace>) -> Self {
        let coordinates = |axis: usize| line.points().iter().map(move |point| point[axis]);
        let least = [0, 1].map(|axis| coordinates(axis).fold(f64::INFINITY, f64::min) - BESIDE_M);
        let most = [0, 1].map(|axis| coordinates(axis).fold(f64::NEG_INFINITY, f64::max) + BESIDE_M);
        let is_beside = |ends: &[Point2<f64>]| {
            (0..2).all(|axis| {
                ends.iter().any(|end| end[axis] >= least[axis])
                    && ends.iter().any(|end| end[axis] <= most[axis])
            })
        };
        let roads = roads.iter().flat_map(|road| stretches(road, is_beside)).collect();
        Self { line, roads, places }
    }

    /// Length of the route, metres.
    pub fn length_m(&self) -> f64 {
        self.line.length_m()
    }

    /// The map as the page draws it.
    pub(crate) fn page_map(&self) -> PageMap {
        let line = |points: &[Point2<f64>]| points.iter().map(rounded).collect();
        let of_place = |of: &RoutePlace| PagePlace { at_m: rounded(&of.p_in_map), label: of.label.clone() };
        PageMap {
            length_m: self.length_m(),
            line_m: line(self.line.points()),
            roads_m: self.roads.iter().map(|road| line(road)).collect(),
            places: self.places.iter().map(of_place).collect(),
        }
    }

    /// Roads, route and its places as a vehicle sees them that stands `start_m` along the route and heads along it.
    pub(crate) fn shapes(&self, camera: &Camera, start_m: f64) -> Vec<Shape> {
        let lens = Lens { camera: Some(camera.clone()) };
        let vehicle_from_map = self.line.frame_at(start_m).inverse();
        let drawn = |kind, label: &str, points: &[Point2<f64>]| -> Vec<Shape> {
            let stretches = seen_stretches(points, &vehicle_from_map).into_iter();
            stretches.map(|places| lens.shape(kind, label, places)).collect()
        };
        let roads = self.roads.iter().flat_map(|road| drawn(ShapeKind::Road, "roads of the map", road));
        let ahead = self.line.part(start_m, start_m + SEEN_M);
        let ahead = ahead.map(|line| drawn(ShapeKind::Route, "the route from here on", line.points()));
        let places = self.places.iter().filter_map(|RoutePlace { p_in_map, label }| {
            let p_in_vehicle = vehicle_from_map * p_in_map;
            let is_seen = p_in_vehicle.x > 0.0 && p_in_vehicle.coords.norm() <= SEEN_M;
            is_seen.then(|| lens.shape(ShapeKind::Feature, label, vec![[p_in_vehicle.x, p_in_vehicle.y]]))
        });
        roads.chain(ahead.into_iter().flatten()).chain(places).collect()
    }
}

/// The stretches of a line whose pieces are wanted.
fn stretches(line: &[Point2<f64>], is_wanted: impl Fn(&[Point2<f64>]) -> bool) -> Vec<Vec<Point2<f64>>> {
    let mut stretches: Vec<Vec<Point2<f64>>> = Vec::new();
    let mut goes_on = false;
    for ends in line.windows(2) {
        if is_wanted(ends) {
            match stretches.last_mut().filter(|_| goes_on) {
                Some(stretch) => stretch.push(ends[1]),
                None => stretches.push(ends.to_vec()),
            }
            goes_on = true;
        } else {
            goes_on = false;
        }
    }
    stretches
}

/// The stretches of a line that are near the vehicle, `[forward, left]` metres in steps.
fn seen_stretches(line: &[Point2<f64>], vehicle_from_map: &Isometry2<f64>) -> Vec<Vec<[f64; 2]>> {
    let mut stretches = vec![Vec::new()];
    for ends in line.windows(2) {
        let [from, to] = [vehicle_from_map * ends[0], vehicle_from_map * ends[1]];
        let along = to - from;
        let length = along.norm();
        if length == 0.0 {
            continue;
        }
        // The part of the piece between the two places at which a circle about the vehicle cuts it.
        let foot = -from.coords.dot(&along) / length;
        let beside = (from + along * (foot / length)).coords.norm();
        if beside > SEEN_M {
            stretches.push(Vec::new());
            continue;
        }
        let half = libm::sqrt(SEEN_M * SEEN_M - beside * beside);
        let (first, last) = ((foot - half).max(0.0), (foot + half).min(length));
        if first > 0.0 {
            stretches.push(Vec::new());
        }
        let steps = ((last - first) / STEP_M).ceil().max(0.0) as usize;
        let places =
            (0..=steps).map(|step| from + along * ((first + STEP_M * step as f64).min(last) / length));
        if let Some(stretch) = stretches.last_mut().filter(|_| first < last) {
            stretch.extend(places.map(|place| [place.x, place.y]));
        }
        if last < length {
            stretches.push(Vec::new());
        }
    }
    stretches.retain(|stretch| stretch.len() > 1);
    stretches
}

#[cfg(test)]
mod tests;
