//! The course that a hypothesis drives: a chain of directed edges as one smooth line.

use std::collections::BTreeMap;
use std::sync::Arc;

use fingerpost_geometry::Polyline;
use nalgebra::{Point2, Vector2};

use crate::roads::Roads;

/// Distance between samples of a course, metres.
pub(crate) const SPACING_M: f64 = 1.0;
/// Half the width of the moving average that rounds a course's corners, samples. A right angle becomes a bend of about 9 m radius,
/// as cars turn at junctions of streets.
const ROUNDING: usize = 10;
/// The same, metres.
pub(crate) const ROUNDING_M: f64 = ROUNDING as f64 * SPACING_M;
/// Road kept behind the vehicle, metres beyond what its place is unsure by.
const KEPT_BEHIND_M: f64 = 40.0;

/// A place of a course.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    /// Where it is, metres in the map's plane.
    pub(crate) point: Point2<f64>,
    /// Direction of travel, unit vector.
    pub(crate) ahead: Vector2<f64>,
    /// The same as an angle, radians anticlockwise from east.
    pub(crate) heading_rad: f64,
}

/// A chain of edges as a smooth line with samples at equal distances.
#[derive(Debug, PartialEq)]
pub(crate) struct Course {
    /// Its edges, in the order of driving.
    pub(crate) edges: Vec<u32>,
    /// Distance of each edge's start from the course's, metres.
    pub(crate) starts_m: Vec<f64>,
    /// Length, metres.
    pub(crate) length_m: f64,
    /// Two at least.
    samples: Vec<Sample>,
}

impl Course {
    fn of(roads: &Roads, edges: Vec<u32>) -> Option<Self> {
        let mut starts_m = Vec::with_capacity(edges.len());
        let mut points = Vec::new();
        let mut length_m = 0.0;
        for &edge in &edges {
            let line = &roads.edge(edge).line;
            starts_m.push(length_m);
            length_m += line.length_m();
            points.extend_from_slice(line.points());
        }
        let line = Polyline::new(points).ok()?;
        let samples = smooth(&line);
        (samples.len() >= 2).then_some(Self { edges, starts_m, length_m, samples })
    }

    /// The samples from one distance along the course to another (metres), clamped to its ends, with the first one's number.
    pub(crate) fn between(&self, from_m: f64, to_m: f64) -> (usize, &[Sample]) {
        let last = self.samples.len() - 1;
        let number = |along_m: f64| ((along_m / SPACING_M).round().max(0.0) as usize).min(last);
        let (first, end) = (number(from_m), number(to_m) + 1);
        (first, self.samples.get(first..end).unwrap_or_default())
    }

    /// Whether a number is that of the course's last sample.
    pub(crate) fn is_last(&self, number: usize) -> bool {
        number + 1 >= self.samples.len()
    }
}

/// Whether a line is long enough for a course.
pub(crate) fn has_course(line: &Polyline) -> bool {
    sample_count(line) >= 2
}

fn sample_count(line: &Polyline) -> usize {
    (line.length_m() / SPACING_M).floor() as usize + 1
}

fn smooth(line: &Polyline) -> Vec<Sample> {
    let count = sample_count(line);
    // Beyond its ends a polyline goes straight on, so that the average is that of the line there as well.
    let raw: Vec<Point2<f64>> =
        (0..count + 2 * ROUNDING).map(|i| line.at((i as f64 - ROUNDING as f64) * SPACING_M).0).collect();
    let averaged: Vec<Point2<f64>> = raw
        .windows(2 * ROUNDING + 1)
        .map(|window| {
            let sum: Vector2<f64> = window.iter().map(|point| point.coords).sum();
            Point2::from(sum / window.len() as f64)
        })
        .collect();
    let chord = |i: usize| {
        let (before, after) = (i.saturating_sub(1), (i + 1).min(averaged.len() - 1));
        (averaged[after] - averaged[before]).try_normalize(1e-9)
    };
    let mut ahead = line.at(0.0).1;
    let sample = |(i, &point): (usize, &Point2<f64>)| {
        // A hairpin's average can stand still; it keeps its direction there.
        ahead = chord(i).unwrap_or(ahead);
        Sample { point, ahead, heading_rad: fingerpost_geometry::heading_of(ahead) }
    };
    averaged.iter().enumerate().map(sample).collect()
}

/// All courses in use, each made once.
#[derive(Debug, Clone, Default)]
pub(crate) struct Courses {
    known: BTreeMap<Vec<u32>, Arc<Course>>,
}

impl Courses {
    /// The course along a single edge; none for an edge that has no length.
    pub(crate) fn of_edge(&mut self, roads: &Roads, edge: u32) -> Option<Arc<Course>> {
        self.along(roads, vec![edge])
    }

    /// A course with one more edge, without what lies far behind a place along it; and how much shorter it has become at its
    /// start, metres.
    pub(crate) fn extended(
        &mut self,
        roads: &Roads,
        course: &Course,
        exit: u32,
        behind_m: f64,
    ) -> Option<(Arc<Course>, f64)> {
        let left =
            course.starts_m.iter().skip(1).filter(|start_m| **start_m < behind_m - KEPT_BEHIND_M).count();
        let shorter_m = course.starts_m.get(left).copied().unwrap_or_default();
        let edges = course.edges.iter().skip(left).copied().chain([exit]).collect();
        Some((self.along(roads, edges)?, shorter_m))
    }

    fn along(&mut self, roads: &Roads, edges: Vec<u32>) -> Option<Arc<Course>> {
        if let Some(known) = self.known.get(&edges) {
            return Some(Arc::clone(known));
        }
        let course = Arc::new(Course::of(roads, edges.clone())?);
        self.known.insert(edges, Arc::clone(&course));
        Some(course)
    }

    /// Forgets the courses that nobody drives.
    pub(crate) fn forget_unused(&mut self) {
        self.known.retain(|_, course| Arc::strong_count(course) > 1);
    }
}
