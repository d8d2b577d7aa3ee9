//! An arm of a feature as a strip of road about its course.

use nalgebra::{Point2, Vector2};

use crate::feature_model::ArmModel;

/// An arm: a strip about its course.
#[derive(Debug, Clone)]
pub(super) struct Strip {
    /// Course from the node outwards, feature frame: start, direction and length of every straight piece.
    pub(super) pieces: Vec<Piece>,
    pub(super) half_width_m: f64,
    /// Distance from the node up to which it is known, metres: the map's course ends there, or the next feature begins.
    pub(super) reach_m: f64,
    /// Which of the features before and behind it leads to; none of a side arm.
    pub(super) leads_to: Option<usize>,
    /// Whether an arc joins its left edge and the right one of the next arm, and the product of the normals of the two.
    pub(super) corner: Option<f64>,
}

/// A straight piece of a course.
#[derive(Debug, Clone, Copy)]
pub(super) struct Piece {
    start: Point2<f64>,
    pub(super) along: Vector2<f64>,
    length_m: f64,
    before_m: f64,
}

/// Where a place lies beside an arm.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beside {
    pub(super) left_m: f64,
    pub(super) left: Vector2<f64>,
    /// Distance outwards from the node; negative behind it.
    pub(super) along_m: f64,
}

/// Beside an arm that is not there.
pub(super) const NOWHERE: Beside =
    Beside { left_m: f64::INFINITY, left: Vector2::new(0.0, 1.0), along_m: 0.0 };

/// The pieces of an arm's course.
pub(super) fn pieces(arm: &ArmModel) -> Vec<Piece> {
    let points = arm.course.points();
    let mut before_m = 0.0;
    let mut pieces = Vec::new();
    for pair in points.windows(2) {
        let step = pair[1] - pair[0];
        let length_m = step.norm();
        if length_m > 1e-6 {
            pieces.push(Piece { start: pair[0], along: step / length_m, length_m, before_m });
            before_m += length_m;
        }
    }
    pieces
}

impl Piece {
    /// The direction to its left.
    pub(super) fn left(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }
}

impl Strip {
    /// The place on the axis so far outwards, and what is left there.
    pub(super) fn at(&self, along_m: f64) -> (Point2<f64>, Vector2<f64>) {
        let piece = self.pieces.iter().rev().find(|piece| piece.before_m <= along_m).or(self.pieces.first());
        piece.map_or((Point2::origin(), Vector2::y()), |piece| {
            (piece.start + (along_m - piece.before_m) * piece.along, piece.left())
        })
    }

    /// Where a place lies beside it.
    pub(super) fn beside(&self, p: Point2<f64>) -> Beside {
        let last = self.pieces.len().saturating_sub(1);
        let mut nearest: Option<(f64, f64, f64, f64, &Piece)> = None;
        for (i, piece) in self.pieces.iter().enumerate() {
            let from = p - piece.start;
            let along_m = piece.along.dot(&from);
            // The first piece goes on behind the node and the last one beyond its end.
            let least = if i == 0 { f64::NEG_INFINITY } else { 0.0 };
            let most = if i == last { f64::INFINITY } else { piece.length_m };
            let off_m = along_m - along_m.clamp(least, most);
            let left_m = piece.left().dot(&from);
            let squared = off_m * off_m + left_m * left_m;
            if nearest.is_none_or(|(least, ..)| squared < least) {
                nearest = Some((squared, off_m, left_m, along_m, piece));
            }
        }
        nearest.map_or(NOWHERE, |(squared, off_m, left_m, along_m, piece)| Beside {
            left_m: if off_m == 0.0 { left_m } else { squared.sqrt().copysign(left_m) },
            left: piece.left(),
            along_m: piece.before_m + along_m,
        })
    }
}
