//! Roads made up for a drive: straights, bends and the easing between them, as a map and a route in memory.
//!
//! Curvature is piecewise linear along the axis, as on roads that are laid out with clothoids: a bend is eased into and
//! out of. The map's nodes are as far apart as keeps its straight pieces within [`SAG_M`] of the axis; the route's line,
//! which the vehicle follows, is finer.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use fingerpost_map::{LatLon, OsmData, OsmNode, OsmWay, RoadGraph, Route, RoutePoint, TangentPlane};
use nalgebra::{Point2, Vector2};
use serde::{Deserialize, Serialize};

use crate::SimError;
use crate::error::check_range;
use crate::noise::Stream;

/// Spacing of the route's line, metres.
const STEP_M: f64 = 0.5;
/// Farthest that the map's straight pieces leave the axis, metres.
const SAG_M: f64 = 0.001;
/// Longest straight piece, metres.
const LONGEST_PIECE_M: f64 = 8.0;
/// Longest easing into a bend, metres.
const EASING_M: f64 = 60.0;
/// Tightest bend, metres: half of a country road still has room for a car's path inside.
const TIGHTEST_M: f64 = 40.0;
/// Width of the grass between a highway's carriageways, metres.
pub(crate) const MEDIAN_M: f64 = 6.0;
/// Where made-up roads lie; any place away from the poles would do.
const ORIGIN_DEG: [f64; 2] = [47.0, 9.0];

/// A piece of a course.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CoursePiece {
    /// Straight on.
    Straight {
        /// Length, metres.
        length_m: f64,
    },
    /// A bend with its easing.
    Bend {
        /// Radius where it is tightest, metres, 40 or more.
        radius_m: f64,
        /// How far it turns, radians, positive to the left.
        turn_rad: f64,
    },
}

/// A made-up road that starts eastwards.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoadCourse {
    /// Its pieces in the order of driving.
    pub pieces: Vec<CoursePiece>,
    /// Width of the road, or of a highway's carriageway, metres.
    pub width_m: f64,
    /// Whether both directions share the road; otherwise the other direction has a carriageway of its own to the left.
    pub two_way: bool,
}

/// What a course is drawn from.
struct Draft {
    straight_m: [f64; 2],
    radius_m: [f64; 2],
    turn_rad: [f64; 2],
    width_m: f64,
    two_way: bool,
}

/// Bends of 25 to 33 m/s, two lanes a direction with room for shoulders.
const HIGHWAY: Draft = Draft {
    straight_m: [120.0, 600.0],
    radius_m: [700.0, 2500.0],
    turn_rad: [0.1, 0.45],
    width_m: 9.4,
    two_way: false,
};
/// Bends of 12 to 25 m/s, one lane a direction.
const COUNTRY: Draft = Draft {
    straight_m: [40.0, 250.0],
    radius_m: [80.0, 450.0],
    turn_rad: [0.2, 0.9],
    width_m: 8.0,
    two_way: true,
};
/// The course keeps within this of eastwards, radians, so that it never meets itself.
const MOST_TURNED_RAD: f64 = 1.1;

impl RoadCourse {
    /// A straight road with one lane a direction.
    pub fn straight(length_m: f64) -> Self {
        let pieces = vec![CoursePiece::Straight { length_m }];
        Self { pieces, width_m: COUNTRY.width_m, two_way: true }
    }

    /// A highway at least so long, drawn from a seed: two lanes a direction, a carriageway each, gentle bends.
    pub fn highway(seed: u64, length_m: f64) -> Self {
        HIGHWAY.course(seed, length_m)
    }

    /// A country road at least so long, drawn from a seed: one lane a direction, bends of 80 m radius and more.
    pub fn country(seed: u64, length_m: f64) -> Self {
        COUNTRY.course(seed, length_m)
    }

    /// Length of the axis, metres.
    pub fn length_m(&self) -> f64 {
        self.sections().iter().map(|section| section.length_m).sum()
    }

    /// The course as a map and the route along it.
    ///
    /// # Errors
    /// [`SimError::OutOfRange`]: a length, radius or turn that is not finite or makes no road.
    pub fn roads(&self) -> Result<(RoadGraph, Route), SimError> {
        self.check()?;
        let axis = self.axis();
        let [lat_deg, lon_deg] = ORIGIN_DEG;
        let plane = TangentPlane::new(LatLon { lat_deg, lon_deg });
        let nodes = node_places(&axis);
        let mut map = OsmData::default();
        let mut add = |place_of: &dyn Fn(&AxisPoint) -> Point2<f64>, backwards: bool| {
            let first = map.nodes.len() as i64 + 1;
            let places = nodes.iter().map(|&i| plane.wgs84_from_map(place_of(&axis[i])));
            map.nodes.extend((first..).zip(places).map(|(id, at)| OsmNode { id, at }));
            let mut ids: Vec<i64> = (first..first + nodes.len() as i64).collect();
            if backwards {
                ids.reverse();
            }
            map.ways.push(OsmWay { id: map.ways.len() as i64 + 1, nodes: ids, tags: self.tags() });
        };
        add(&|point| point.place, false);
        if !self.two_way {
            add(&|point| point.place + point.left() * (self.width_m + MEDIAN_M), true);
        }
        let mut line: Vec<RoutePoint> = axis
            .iter()
            .map(|point| RoutePoint { node: None, at: plane.wgs84_from_map(point.place) })
            .collect();
        for (id, &i) in (1..).zip(&nodes) {
            line[i].node = Some(id);
        }
        Ok((RoadGraph::from_osm(&map)?, Route { name: String::new(), line, features: Vec::new() }))
    }

    fn tags(&self) -> BTreeMap<String, String> {
        let (class, one_way) = if self.two_way { ("secondary", "no") } else { ("motorway", "yes") };
        let width = self.width_m.to_string();
        [("highway", class), ("oneway", one_way), ("surface", "asphalt"), ("width", &width)]
            .map(|(key, value)| (key.to_owned(), value.to_owned()))
            .into()
    }

    fn check(&self) -> Result<(), SimError> {
        check_range("width_m", self.width_m, 2.6, 30.0, "2.6 to 30 metres")?;
        for piece in &self.pieces {
            match *piece {
                CoursePiece::Straight { length_m } => {
                    check_range("length_m", length_m, 0.0, 1e5, "0 to 100000 metres")?;
                }
                CoursePiece::Bend { radius_m, turn_rad } => {
                    check_range("radius_m", radius_m, TIGHTEST_M, 1e5, "40 to 100000 metres")?;
                    check_range("turn_rad", turn_rad, -PI, PI, "half a turn at most, radians")?;
                }
            }
        }
        Ok(())
    }

    /// The pieces as stretches of linear curvature.
    fn sections(&self) -> Vec<Section> {
        let mut sections = Vec::new();
        for piece in &self.pieces {
            match *piece {
                CoursePiece::Straight { length_m } => {
                    sections.push(Section { length_m, curvature_per_m: [0.0; 2] });
                }
                CoursePiece::Bend { radius_m, turn_rad } => {
                    // Each easing turns by half of what an arc of its length would.
                    let easing_m = EASING_M.min(0.5 * radius_m * turn_rad.abs());
                    let arc_m = radius_m * turn_rad.abs() - easing_m;
                    let tightest = turn_rad.signum() / radius_m;
                    sections.extend(
                        [(easing_m, [0.0, tightest]), (arc_m, [tightest; 2]), (easing_m, [tightest, 0.0])]
                            .map(|(length_m, curvature_per_m)| Section { length_m, curvature_per_m }),
                    );
                }
            }
        }
        sections
    }

    /// Points about [`STEP_M`] apart.
    fn axis(&self) -> Vec<AxisPoint> {
        let mut here = AxisPoint { place: Point2::origin(), heading_rad: 0.0, curvature_per_m: 0.0 };
        let mut axis = vec![here];
        for section in self.sections().iter().filter(|section| section.length_m > 0.0) {
            let steps = (section.length_m / STEP_M).ceil().max(1.0);
            let step_m = section.length_m / steps;
            let [from, to] = section.curvature_per_m;
            for i in 0..steps as usize {
                let curvature = |share: f64| from + (to - from) * (i as f64 + share) / steps;
                // Of a linear curvature the chord's direction is the heading in the middle, but for a part in a million.
                let middle_rad = here.heading_rad + 0.5 * step_m * curvature(0.25);
                let (sin, cos) = libm::sincos(middle_rad);
                here = AxisPoint {
                    place: here.place + Vector2::new(cos, sin) * step_m,
                    heading_rad: here.heading_rad + step_m * curvature(0.5),
                    curvature_per_m: curvature(1.0),
                };
                axis.push(here);
            }
        }
        axis
    }
}

/// A stretch of linear curvature, from its start's to its end's.
struct Section {
    length_m: f64,
    curvature_per_m: [f64; 2],
}

#[derive(Debug, Clone, Copy)]
struct AxisPoint {
    place: Point2<f64>,
    heading_rad: f64,
    curvature_per_m: f64,
}

impl AxisPoint {
    fn left(&self) -> Vector2<f64> {
        Vector2::new(-libm::sin(self.heading_rad), libm::cos(self.heading_rad))
    }
}

/// Which points of the axis become nodes of the map.
fn node_places(axis: &[AxisPoint]) -> Vec<usize> {
    let mut nodes = vec![0];
    let (mut piece_m, mut turned_rad) = (0.0, 0.0);
    for i in 1..axis.len() {
        let step_m = (axis[i].place - axis[i - 1].place).norm();
        piece_m += step_m;
        turned_rad += step_m * axis[i].curvature_per_m.abs();
        let next_m = piece_m + STEP_M;
        // An arc of that length and turn leaves its chord by an eighth of their product.
        let too_bent = next_m * (turned_rad + STEP_M * axis[i].curvature_per_m.abs()) > 8.0 * SAG_M;
        if too_bent || next_m > LONGEST_PIECE_M || i + 1 == axis.len() {
            nodes.push(i);
            (piece_m, turned_rad) = (0.0, 0.0);
        }
    }
    nodes
}

impl Draft {
    fn course(&self, seed: u64, length_m: f64) -> RoadCourse {
        let mut stream = Stream::new(seed, 0x434f_5552);
        let mut course = RoadCourse {
            pieces: vec![CoursePiece::Straight { length_m: self.straight_m[1].min(150.0) }],
            width_m: self.width_m,
            two_way: self.two_way,
        };
        let (mut heading_rad, mut done_m) = (0.0_f64, course.length_m());
        while done_m < length_m {
            let [low, high] = self.turn_rad;
            let turn_rad = stream.between(low, high);
            // Turns that would lead too far from eastwards go the other way, and now and then two make an S.
            let left = if heading_rad.abs() + turn_rad > MOST_TURNED_RAD {
                heading_rad < 0.0
            } else {
                stream.unit() < 0.5
            };
            let turn_rad = if left { turn_rad } else { -turn_rad };
            let radius_m = stream.between(self.radius_m[0], self.radius_m[1]);
            let bend = CoursePiece::Bend { radius_m, turn_rad };
            course.pieces.push(bend);
            heading_rad += turn_rad;
            if stream.unit() < STRAIGHTS {
                let length_m = stream.between(self.straight_m[0], self.straight_m[1]);
                course.pieces.push(CoursePiece::Straight { length_m });
            }
            done_m = course.length_m();
        }
        course
    }
}

/// Share of the bends that a straight follows; the others run into the next bend.
const STRAIGHTS: f64 = 0.6;

#[cfg(test)]
mod tests;
