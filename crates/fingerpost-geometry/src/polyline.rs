//! Lines of straight pieces on the road plane, measured by their arc length.

use nalgebra::{Isometry2, Point2, Vector2};

use crate::{GeometryError, heading_of};

/// A line of straight pieces, metres; consecutive points differ.
#[derive(Debug, Clone, PartialEq)]
pub struct Polyline {
    points: Vec<Point2<f64>>,
    /// Arc length at each point, metres.
    along_m: Vec<f64>,
}

/// The place on a line that is nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Footpoint {
    /// Arc length of the place, metres from the line's start.
    pub along_m: f64,
    /// Signed distance of the point from the line, metres; positive on the line's left.
    pub left_m: f64,
    /// The place itself.
    pub point: Point2<f64>,
}

/// Points closer together than this are one point, metres; map coordinates are no finer.
const SAME_POINT_M: f64 = 1e-6;

impl Polyline {
    /// The line through `points`; repeated points are dropped.
    ///
    /// # Errors
    /// [`GeometryError::TooFewPoints`] when fewer than two different points remain, and
    /// [`GeometryError::OutOfRange`] for a coordinate that is not finite.
    pub fn new(points: impl IntoIterator<Item = Point2<f64>>) -> Result<Self, GeometryError> {
        let mut kept: Vec<Point2<f64>> = Vec::new();
        let mut along_m = Vec::new();
        for point in points {
            if !(point.x.is_finite() && point.y.is_finite()) {
                let value = if point.x.is_finite() { point.y } else { point.x };
                return Err(GeometryError::OutOfRange {
                    name: "line point",
                    value,
                    expected: "finite metres",
                });
            }
            match kept.last() {
                Some(last) if (point - last).norm() < SAME_POINT_M => {}
                Some(last) => {
                    along_m.push(along_m.last().copied().unwrap_or(0.0) + (point - last).norm());
                    kept.push(point);
                }
                None => {
                    along_m.push(0.0);
                    kept.push(point);
                }
            }
        }
        if kept.len() < 2 {
            return Err(GeometryError::TooFewPoints { found: kept.len() });
        }
        Ok(Self { points: kept, along_m })
    }

    /// The corner points, metres.
    pub fn points(&self) -> &[Point2<f64>] {
        &self.points
    }

    /// Length of the whole line, metres.
    pub fn length_m(&self) -> f64 {
        self.along_m.last().copied().unwrap_or(0.0)
    }

    /// The place `along_m` metres along the line and the line's direction there (unit vector). Before the start and
    /// beyond the end the line goes straight on.
    pub fn at(&self, along_m: f64) -> (Point2<f64>, Vector2<f64>) {
        let i = self.along_m.partition_point(|&a| a <= along_m).clamp(1, self.points.len() - 1) - 1;
        let direction = (self.points[i + 1] - self.points[i]) / (self.along_m[i + 1] - self.along_m[i]);
        (self.points[i] + direction * (along_m - self.along_m[i]), direction)
    }

    /// The frame whose origin is `along_m` metres along the line and whose x axis follows it.
    pub fn frame_at(&self, along_m: f64) -> Isometry2<f64> {
        let (point, direction) = self.at(along_m);
        Isometry2::new(point.coords, heading_of(direction))
    }

    /// The place on the line nearest to `point`.
    pub fn nearest(&self, point: Point2<f64>) -> Footpoint {
        self.nearest_within(point, 0.0, self.length_m())
    }

    /// The place nearest to `point` on the part from `from_m` to `to_m` along the line (metres), clamped to the line's
    /// ends; none when nothing of the line lies between.
    pub fn nearest_on_part(&self, point: Point2<f64>, from_m: f64, to_m: f64) -> Option<Footpoint> {
        let (from_m, to_m) = (from_m.max(0.0), to_m.min(self.length_m()));
        (from_m < to_m).then(|| self.nearest_within(point, from_m, to_m))
    }

    fn nearest_within(&self, point: Point2<f64>, from_m: f64, to_m: f64) -> Footpoint {
        let mut best = Footpoint { along_m: 0.0, left_m: f64::INFINITY, point };
        for (i, ends) in self.points.windows(2).enumerate() {
            let (start, end) = (self.along_m[i], self.along_m[i + 1]);
            if end < from_m || start > to_m {
                continue;
            }
            let (piece, to_point) = (ends[1] - ends[0], point - ends[0]);
            let length = end - start;
            let (nearest, farthest) = ((from_m - start).max(0.0), (to_m - start).min(length));
            let along = (to_point.dot(&piece) / length).clamp(nearest, farthest);
            let foot = ends[0] + piece * (along / length);
            let distance = (point - foot).norm();
            if distance < best.left_m.abs() {
                let side = if piece.perp(&to_point) < 0.0 { -1.0 } else { 1.0 };
                best = Footpoint { along_m: start + along, left_m: side * distance, point: foot };
            }
        }
        best
    }

    /// The part from `from_m` to `to_m` along the line (metres), clamped to the line's ends.
    ///
    /// # Errors
    /// [`GeometryError::TooFewPoints`] when nothing of the line lies between.
    pub fn part(&self, from_m: f64, to_m: f64) -> Result<Self, GeometryError> {
        let (from_m, to_m) = (from_m.max(0.0), to_m.min(self.length_m()));
        if to_m <= from_m {
            return Err(GeometryError::TooFewPoints { found: 0 });
        }
        let inner =
            self.points.iter().zip(&self.along_m).filter(|&(_, &a)| a > from_m && a < to_m).map(|(p, _)| *p);
        Self::new([self.at(from_m).0].into_iter().chain(inner).chain([self.at(to_m).0]))
    }

    /// The parallel line `left_m` metres to the left (negative: right), mitred at the corners.
    ///
    /// # Errors
    /// [`GeometryError::TooFewPoints`] when the offset swallows the whole line.
    pub fn offset(&self, left_m: f64) -> Result<Self, GeometryError> {
        let normals: Vec<Vector2<f64>> = self
            .points
            .windows(2)
            .map(|ends| (ends[1] - ends[0]).normalize())
            .map(|direction| Vector2::new(-direction.y, direction.x))
            .collect();
        let moved = self.points.iter().enumerate().map(|(i, point)| {
            let (before, after) = (normals[i.saturating_sub(1)], normals[i.min(normals.len() - 1)]);
            let sum = before + after;
            // A mitre longer than three offsets would throw the corner of a hairpin far off the road.
            let mitre = if sum.norm_squared() > 0.44 { sum * (2.0 / sum.norm_squared()) } else { after };
            point + mitre * left_m
        });
        Self::new(moved)
    }

    /// The line through `transform`, e.g. `map_from_vehicle` for a line in the vehicle frame.
    pub fn transformed(&self, transform: &Isometry2<f64>) -> Self {
        Self { points: self.points.iter().map(|p| transform * p).collect(), along_m: self.along_m.clone() }
    }

    /// The same line walked from its end.
    pub fn reversed(&self) -> Self {
        let length = self.length_m();
        Self {
            points: self.points.iter().rev().copied().collect(),
            along_m: self.along_m.iter().rev().map(|a| length - a).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner() -> Polyline {
        Polyline::new([(0.0, 0.0), (0.0, 0.0), (10.0, 0.0), (10.0, 5.0)].map(|(x, y)| Point2::new(x, y)))
            .unwrap()
    }

    #[test]
    fn arc_length_and_direction() {
        let line = corner();
        assert!((line.length_m() - 15.0).abs() < 1e-12);
        let (point, direction) = line.at(12.0);
        assert!((point - Point2::new(10.0, 2.0)).norm() < 1e-12);
        assert!((direction - Vector2::y()).norm() < 1e-12);
        assert!((line.at(-3.0).0 - Point2::new(-3.0, 0.0)).norm() < 1e-12, "straight on before the start");
        assert!((line.at(20.0).0 - Point2::new(10.0, 10.0)).norm() < 1e-12, "straight on beyond the end");
    }

    #[test]
    fn left_is_positive() {
        let line = corner();
        assert!((line.nearest(Point2::new(4.0, 1.5)).left_m - 1.5).abs() < 1e-12);
        let right = line.nearest(Point2::new(12.0, 3.0));
        assert!((right.left_m + 2.0).abs() < 1e-12 && (right.along_m - 13.0).abs() < 1e-12);
        let parallel = line.offset(1.0).unwrap();
        assert!((parallel.points()[1] - Point2::new(9.0, 1.0)).norm() < 1e-12, "inside of a left corner");
    }

    #[test]
    fn the_nearest_place_on_a_part_leaves_the_rest_of_the_line_out() {
        let line = corner();
        let along_m = |from_m, to_m| {
            line.nearest_on_part(Point2::new(12.0, 3.0), from_m, to_m).map(|foot| foot.along_m)
        };
        assert_eq!(along_m(0.0, 11.0), Some(11.0));
        assert_eq!(along_m(2.0, 14.0), Some(13.0));
        assert_eq!(along_m(14.0, 99.0), Some(14.0));
        assert_eq!((along_m(-9.0, -4.0), along_m(20.0, 30.0)), (None, None));
    }

    #[test]
    fn parts_and_reversal() {
        let line = corner();
        let part = line.part(8.0, 12.0).unwrap();
        assert_eq!(part.points().len(), 3);
        assert!((part.length_m() - 4.0).abs() < 1e-12);
        assert!((line.reversed().at(2.0).0 - line.at(13.0).0).norm() < 1e-12);
        assert!(line.part(16.0, 20.0).is_err());
    }

    #[test]
    fn lines_without_extent_are_refused() {
        assert_eq!(Polyline::new([Point2::new(1.0, 1.0); 3]), Err(GeometryError::TooFewPoints { found: 1 }));
        assert!(Polyline::new([Point2::new(f64::NAN, 0.0), Point2::new(1.0, 1.0)]).is_err());
    }
}
