//! The path that is steered along: points in the vehicle frame with their direction and curvature.

use std::f64::consts::{PI, TAU};

use nalgebra::{Isometry2, Point2, Vector2};

/// A point of a path.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct PathPoint {
    /// Metres forward of the rear axle's middle.
    pub x_m: f64,
    /// Metres to the left of it.
    pub y_m: f64,
    /// Direction of the path against the vehicle's, radians, positive to the left.
    pub heading_rad: f64,
    /// Its curvature, 1/m, positive to the left.
    pub curvature_per_m: f64,
    /// Length of path from the place beside the rear axle, metres; negative behind it.
    pub along_m: f64,
}

impl PathPoint {
    /// The place.
    pub const fn place(&self) -> Point2<f64> {
        Point2::new(self.x_m, self.y_m)
    }

    /// The direction as a vector of length one.
    pub fn direction(&self) -> Vector2<f64> {
        Vector2::new(libm::cos(self.heading_rad), libm::sin(self.heading_rad))
    }

    /// So far on along its direction, metres.
    fn straight_on(&self, by_m: f64) -> Self {
        let place = self.place() + self.direction() * by_m;
        Self { x_m: place.x, y_m: place.y, curvature_per_m: 0.0, along_m: self.along_m + by_m, ..*self }
    }
}

/// The place of a path nearest to another place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    /// The path there.
    pub on_path: PathPoint,
    /// How far left of the path the other place is, metres.
    pub left_m: f64,
}

/// An angle in the range of -pi to pi.
fn wrapped(angle_rad: f64) -> f64 {
    (angle_rad + PI).rem_euclid(TAU) - PI
}

/// Lays points with their curvatures (1/m, positive left) as a path into `path`, whose memory is reused; points on top of each
/// other are left out. Curvatures that are missing are zero.
pub fn lay(points: &[Point2<f64>], curvature_per_m: &[f64], path: &mut Vec<PathPoint>) {
    path.clear();
    for (i, place) in points.iter().enumerate() {
        let along_m = match path.last() {
            Some(last) => {
                let step_m = (place - last.place()).norm();
                if step_m <= 1e-9 {
                    continue;
                }
                last.along_m + step_m
            }
            None => 0.0,
        };
        let curvature_per_m = curvature_per_m.get(i).copied().unwrap_or(0.0);
        path.push(PathPoint { x_m: place.x, y_m: place.y, heading_rad: 0.0, curvature_per_m, along_m });
    }
    let last = path.len().saturating_sub(1);
    for i in 0..path.len() {
        // Between its neighbours, the direction of an arc is that of its chord.
        let chord = path[(i + 1).min(last)].place() - path[i.saturating_sub(1)].place();
        let at_end_m = if i == 0 || i == last { 0.5 * chord.norm() } else { 0.0 };
        let towards = if i == 0 { -1.0 } else { 1.0 };
        path[i].heading_rad =
            wrapped(libm::atan2(chord.y, chord.x) + towards * at_end_m * path[i].curvature_per_m);
    }
    begin_beside_vehicle(path);
}

/// Lays an arc that passes `left_m` beside the rear axle in the direction `heading_rad`, from there `length_m` on in steps of
/// `step_m`, into `path`.
pub fn arc(
    left_m: f64,
    heading_rad: f64,
    curvature_per_m: f64,
    [length_m, step_m]: [f64; 2],
    path: &mut Vec<PathPoint>,
) {
    path.clear();
    let steps = (length_m.max(0.0) / step_m.max(1e-3)).ceil().max(1.0) as usize;
    for i in 0..=steps {
        let along_m = length_m * i as f64 / steps as f64;
        let turned = 0.5 * curvature_per_m * along_m;
        let chord_m = chord_m(along_m, 2.0 * turned);
        let towards = heading_rad + turned;
        path.push(PathPoint {
            x_m: chord_m * libm::cos(towards),
            y_m: left_m + chord_m * libm::sin(towards),
            heading_rad: wrapped(heading_rad + 2.0 * turned),
            curvature_per_m,
            along_m,
        });
    }
    begin_beside_vehicle(path);
}

/// Chord of an arc, metres, by its length and by the angle through which it turns, radians.
pub(crate) fn chord_m(length_m: f64, turn_rad: f64) -> f64 {
    let half_rad = 0.5 * turn_rad;
    if half_rad.abs() > 1e-6 { length_m * libm::sin(half_rad) / half_rad } else { length_m }
}

/// Copies a path as it is seen from another pose of the vehicle, `vehicle_from_other`, into `seen`.
pub fn seen_from(vehicle_from_other: &Isometry2<f64>, path: &[PathPoint], seen: &mut Vec<PathPoint>) {
    let (other_from_vehicle, turn_rad) = (vehicle_from_other.inverse(), vehicle_from_other.rotation.angle());
    seen.clear();
    seen.extend(path.iter().map(|point| {
        let place = other_from_vehicle * point.place();
        let heading_rad = wrapped(point.heading_rad - turn_rad);
        PathPoint { x_m: place.x, y_m: place.y, heading_rad, ..*point }
    }));
    begin_beside_vehicle(seen);
}

/// Counts lengths from the place beside the rear axle.
fn begin_beside_vehicle(path: &mut [PathPoint]) {
    let Some(beside) = foot(path, Point2::origin()) else { return };
    for point in path {
        point.along_m -= beside.on_path.along_m;
    }
}

/// The nearest place of a path; none of a path without length. Before its first and behind its last point a path goes on straight.
pub fn foot(path: &[PathPoint], place: Point2<f64>) -> Option<Foot> {
    let last = path.len().checked_sub(2)?;
    let on_piece = |i: usize| {
        let (from, to) = (path[i].place(), path[i + 1].place());
        let piece = to - from;
        let share = (piece.dot(&(place - from)) / piece.norm_squared().max(1e-12)).clamp(0.0, 1.0);
        (i, share, (place - (from + piece * share)).norm_squared())
    };
    let (i, share, _) = (0..=last).map(on_piece).min_by(|a, b| a.2.total_cmp(&b.2))?;
    let on_path = between(path, i, share);
    let beyond_m = on_path.direction().dot(&(place - on_path.place()));
    let ends = (i == 0 && share <= 0.0 && beyond_m < 0.0) || (i == last && share >= 1.0 && beyond_m > 0.0);
    let on_path = if ends { on_path.straight_on(beyond_m) } else { on_path };
    let apart = place - on_path.place();
    Some(Foot { on_path, left_m: apart.norm().copysign(on_path.direction().perp(&apart)) })
}

/// The path so far along, metres from the place beside the rear axle; none of a path without length.
pub fn at(path: &[PathPoint], along_m: f64) -> Option<PathPoint> {
    let last = path.len().checked_sub(2)?;
    let i = path.partition_point(|point| point.along_m <= along_m).saturating_sub(1).min(last);
    let length_m = (path[i + 1].along_m - path[i].along_m).max(1e-9);
    Some(between(path, i, (along_m - path[i].along_m) / length_m))
}

/// Between a point and the next one; beyond the path's ends straight on.
fn between(path: &[PathPoint], i: usize, share: f64) -> PathPoint {
    let (from, to) = (&path[i], &path[i + 1]);
    if !(0.0..=1.0).contains(&share) {
        let end = if share < 0.0 { from } else { to };
        let length_m = to.along_m - from.along_m;
        let beyond_m = length_m * if share < 0.0 { share } else { share - 1.0 };
        return end.straight_on(beyond_m);
    }
    let mixed = |a: f64, b: f64| a + share * (b - a);
    PathPoint {
        x_m: mixed(from.x_m, to.x_m),
        y_m: mixed(from.y_m, to.y_m),
        heading_rad: wrapped(from.heading_rad + share * wrapped(to.heading_rad - from.heading_rad)),
        curvature_per_m: mixed(from.curvature_per_m, to.curvature_per_m),
        along_m: mixed(from.along_m, to.along_m),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_arc_to_the_left_ends_where_a_circle_does() {
        let mut path = Vec::new();
        arc(0.5, 0.0, 0.1, [5.0 * PI, 0.5], &mut path);
        let end = path[path.len() - 1];
        assert!((end.x_m - 10.0).abs() < 1e-9 && (end.y_m - 10.5).abs() < 1e-9, "{end:?}");
        assert!((end.heading_rad - 0.5 * PI).abs() < 1e-9);
        assert!(path[0].along_m.abs() < 1e-9);
    }

    #[test]
    fn points_on_a_circle_have_its_directions() {
        let at = |i: i32| 0.05 * f64::from(i);
        let points: Vec<_> =
            (-10..30).map(|i| Point2::new(8.0 * libm::sin(at(i)), -8.0 * (1.0 - libm::cos(at(i))))).collect();
        let mut path = Vec::new();
        lay(&points, &vec![-1.0 / 8.0; points.len()], &mut path);
        for (i, point) in (-10..30).zip(&path) {
            assert!((point.heading_rad + at(i)).abs() < 1e-3, "{point:?}");
            assert!((point.along_m - 8.0 * at(i)).abs() < 0.01, "{point:?}");
        }
    }

    #[test]
    fn left_of_a_path_is_positive() {
        let mut path = Vec::new();
        arc(-2.0, 0.0, 0.0, [20.0, 1.0], &mut path);
        let beside = foot(&path, Point2::origin()).unwrap();
        assert!((beside.left_m - 2.0).abs() < 1e-12);
        assert!((foot(&path, Point2::new(3.0, -3.0)).unwrap().left_m + 1.0).abs() < 1e-12);
        let ahead = at(&path, 7.25).unwrap();
        assert!((ahead.x_m - 7.25).abs() < 1e-12 && (ahead.y_m + 2.0).abs() < 1e-12);
        let beyond = at(&path, 25.0).unwrap();
        assert!((beyond.x_m - 25.0).abs() < 1e-9);
        assert_eq!(foot(&path[..1], Point2::origin()), None);
    }
}
