//! What was measured on the pieces of an arm, and what they say together.

use nalgebra::{Point2, RowVector3, Vector2};

use super::mean;
use super::section::{CrossSection, CrossSectionUse};
use super::slide::Slid;

/// Standard deviation of an edge within a piece, metres: what the direction of an arm is measured with.
const EDGE_SIGMA_M: f64 = 0.12;
/// How many times what is not known of a pavement counts: it is the same from frame to frame, and does not average out.
const PAVEMENT_LASTS: f64 = 2.0;
/// An edge that lies farther from where the arm's lines show it is another thing: mostly a pavement's, metres.
const BESIDE_LINES_M: f64 = 0.6;

/// One piece of an arm with what was measured on it.
#[derive(Debug)]
pub(super) struct Measured {
    pub(super) section: CrossSection,
    /// Distance of its middle from the node along the arm, metres.
    pub(super) along_m: f64,
    /// Edges without what the kerbs widen the road by, metres to the left of the arm.
    pub(super) edges: [Option<Edge>; 2],
}

/// One edge of a road.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub(super) left_m: f64,
    pub(super) sigma_m: f64,
}

impl Measured {
    /// What was measured on a piece.
    pub(super) fn of(Slid { section, along_m, flare_m }: Slid) -> Self {
        let believable = section.section_use == CrossSectionUse::InTheMouth;
        let edges = [0, 1].map(|side| {
            let measured_m = section.edges_m[side].filter(|_| believable)?;
            // Lines do not curve with the kerb: they end.
            let flare_m = if section.by_line[side] { flare_m[side].map(|_| 0.0) } else { flare_m[side] }?;
            let outwards = if side == 0 { 1.0 } else { -1.0 };
            // The radius of a real kerb is anybody's guess within half.
            let pavement_sigma_m = PAVEMENT_LASTS * section.pavement_sigma_m[side];
            let sigma_m = libm::hypot(libm::hypot(EDGE_SIGMA_M, 0.5 * flare_m), pavement_sigma_m);
            Some(Edge { left_m: measured_m - outwards * flare_m, sigma_m })
        });
        Self { section, along_m, edges }
    }
}

/// Takes the edges out that lie elsewhere than where lines show the same edge of the arm.
pub(super) fn leave_out_beside_lines(pieces: &mut [Measured]) {
    for side in 0..2 {
        let by_lines = pieces.iter().filter(|piece| piece.section.by_line[side]);
        let Some(line_m) = mean(by_lines.filter_map(|piece| piece.edges[side]).map(|edge| edge.left_m))
        else {
            continue;
        };
        for piece in pieces.iter_mut().filter(|piece| !piece.section.by_line[side]) {
            piece.edges[side] =
                piece.edges[side].filter(|edge| (edge.left_m - line_m).abs() <= BESIDE_LINES_M);
        }
    }
}

/// The arm's width where both of its edges are seen, metres.
pub(super) fn measured_width_m(pieces: &[Measured]) -> Option<f64> {
    let widths_m = pieces.iter().filter_map(|piece| match piece.edges {
        [Some(left), Some(right)] if left.is_sharp() && right.is_sharp() => Some(left.left_m - right.left_m),
        _ => None,
    });
    mean(widths_m)
}

impl Edge {
    /// Whether the edge is the road's own, not a kerb that curves.
    fn is_sharp(self) -> bool {
        self.sigma_m < 1.5 * EDGE_SIGMA_M
    }
}

/// How far the feature must turn for the arm to run along each of its edges, and the standard deviation, radians.
pub(super) fn heading(pieces: &[Measured]) -> Option<(f64, f64)> {
    let side = |side: usize| {
        let sharp = |piece: &Measured| piece.edges[side].filter(|edge| edge.is_sharp());
        slope(pieces.iter().filter_map(move |piece| Some((piece.along_m, sharp(piece)?.left_m))))
    };
    match (side(0), side(1)) {
        (Some(left), Some(right)) => Some((0.5 * (left.0 + right.0), 0.5 * libm::hypot(left.1, right.1))),
        (left, right) => left.or(right),
    }
}

/// How an arm's curve turns with its course: what its slope says of the feature's heading and of its place.
///
/// A straight arm shows its slope however far the feature is moved. A bend may be slid along its own arc, turning with it, and fits
/// as before: with curvature c, direction t and place p from the node, a move d and a turn a change the slope by
/// a - c t (d + a J p), J the quarter turn.
pub(super) fn slope_by_pose(pieces: &[Measured], node: Point2<f64>) -> RowVector3<f64> {
    let (Some(first), Some(last)) = (pieces.first(), pieces.last()) else {
        return RowVector3::new(0.0, 0.0, 1.0);
    };
    let (left, far_left) = (first.section.left, last.section.left);
    let turned_rad = libm::atan2(left.perp(&far_left), left.dot(&far_left));
    let apart_m = last.along_m - first.along_m;
    let curvature_per_m = if apart_m > 0.0 { turned_rad / apart_m } else { 0.0 };
    let middle = &pieces[pieces.len() / 2].section;
    let along = Vector2::new(middle.left.y, -middle.left.x);
    let from_node = middle.p_in_vehicle - node;
    let by_turn = along.dot(&Vector2::new(-from_node.y, from_node.x));
    let by_move = -curvature_per_m * along;
    RowVector3::new(by_move.x, by_move.y, 1.0 - curvature_per_m * by_turn)
}

/// Slope of the line through an edge's places, and its standard deviation, radians: that of the edges, or more where they
/// scatter more, as beside parked cars.
fn slope(edge: impl Iterator<Item = (f64, f64)> + Clone) -> Option<(f64, f64)> {
    let (along_m, left_m) = (mean(edge.clone().map(|p| p.0))?, mean(edge.clone().map(|p| p.1))?);
    let sum = |of: fn(f64, f64) -> f64| edge.clone().map(|(x, y)| of(x - along_m, y - left_m)).sum::<f64>();
    let (spread, count) = (sum(|x, _| x * x), edge.clone().count() as f64);
    if spread <= 0.0 {
        return None;
    }
    let slope = sum(|x, y| x * y) / spread;
    let unexplained = (sum(|_, y| y * y) - slope * slope * spread).max(0.0);
    let scatter_m = (unexplained / (count - 2.0).max(1.0)).sqrt();
    Some((libm::atan(slope), EDGE_SIGMA_M.max(scatter_m) / spread.sqrt()))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;

    /// A piece with a left edge only, beside which the kerb stands back by half a metre.
    fn piece(along_m: f64, left_m: f64, by_line: [bool; 2]) -> Measured {
        let section = CrossSection {
            label: Arc::from("side_1"),
            p_in_vehicle: Point2::new(10.0, along_m),
            left: Vector2::new(-1.0, 0.0),
            edges_m: [Some(left_m), None],
            pavement_sigma_m: [0.0; 2],
            by_line,
            leaves_the_line: true,
            section_use: CrossSectionUse::InTheMouth,
        };
        Measured::of(Slid { section, along_m, flare_m: [Some(0.5), None] })
    }

    fn left_m(piece: &Measured) -> Option<f64> {
        piece.edges[0].map(|edge| edge.left_m)
    }

    #[test]
    fn a_kerb_curves_into_the_next_arm_and_a_line_does_not() {
        let (kerb, line) = (piece(5.0, 3.0, [false; 2]), piece(5.0, 3.0, [true, false]));
        assert_eq!((left_m(&kerb), left_m(&line)), (Some(2.5), Some(3.0)));
        assert!(line.edges[0].is_some_and(Edge::is_sharp) && !kerb.edges[0].is_some_and(Edge::is_sharp));
    }

    #[test]
    fn an_edge_away_from_the_arms_lines_is_left_out() {
        let by_line = [true, false];
        let mut pieces = [
            piece(5.0, 2.6, by_line),
            piece(6.5, 2.8, by_line),
            piece(8.0, 5.2, [false; 2]),
            piece(9.5, 3.4, [false; 2]),
        ];
        leave_out_beside_lines(&mut pieces);
        assert_eq!(pieces.each_ref().map(left_m), [Some(2.6), Some(2.8), None, Some(2.9)]);
        let mut without = [piece(5.0, 2.8, [false; 2]), piece(6.5, 5.2, [false; 2])];
        leave_out_beside_lines(&mut without);
        assert!(without.iter().all(|piece| piece.edges[0].is_some()), "nothing says which is the road's");
    }
}
