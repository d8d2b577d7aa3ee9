//! Painted lines along the edges of an arm's road.
//!
//! Where a grey pavement lies beside a road, the probability of road falls two metres too far out, or not within reach at all.
//! But a road that is wide enough has lines along its edges: narrow ridges in the grey values across it. Two lines as far
//! apart as the map says the road is wide are its edges; a line inside an edge of the probability is the edge.
//!
//! Limits: a bright seam may be taken for a line; a bright kerb stone as well, but it lies where the edge is.

use super::profile::Profile;

/// Narrowest road that is given edge lines, metres.
const NARROWEST_ROAD_M: f64 = 5.0;
/// Distance of an edge line's middle from the road's edge, metres.
const FROM_EDGE_M: f64 = 0.25;
/// Half the width over which a line's own grey value is taken, what is left out beside it, and the width of road on either
/// side that it is held against, metres.
const COMPARED_M: [f64; 3] = [0.1, 0.2, 0.4];
/// How much brighter than either side a line is, as a share of the sum.
const LEAST_SHARE: f64 = 0.05;
/// A line so bright is believed even where no piece beside it shows it.
const CLEAR_SHARE: f64 = 0.1;
/// What is brighter says no more.
const PLAIN_SHARE: f64 = 0.2;
/// Lines that are nearer to each other are one, and so are those of neighbouring pieces, metres.
const SAME_LINE_M: f64 = 0.45;
/// How far a line may lie outside the edge of the probability, metres.
const OUTSIDE_M: f64 = 0.05;
/// How far inside an edge a line may lie, metres: as wide as pavements are.
const FARTHEST_INSIDE_M: f64 = 3.0;
/// Room that a line keeps from the road's middle, where there is another line, metres.
const FROM_MIDDLE_M: f64 = 0.4;
/// Of several lines inside an edge the outermost counts that has at least this share of the clearest.
const OUTER_SHARE: f64 = 0.6;
/// Farthest edge of the probability outside or inside of one of two lines, metres.
const FARTHEST_EDGE_M: f64 = 3.5;
/// How much brighter two lines must be to be one standard deviation of the width farther off the map's, as a share.
const SHARE_OF_MISFIT: f64 = 0.2;

/// A narrow bright ridge across an arm.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct BrightLine {
    /// Its middle, metres to the left of the arm.
    left_m: f64,
    /// How much brighter than either side it is, as a share of the sum.
    share: f64,
}

impl BrightLine {
    /// Whether it is one that also the neighbouring piece with these lines shows.
    pub(super) fn goes_on_in(&self, neighbour: &[Self]) -> bool {
        neighbour.iter().any(|line| (line.left_m - self.left_m).abs() < SAME_LINE_M)
    }

    /// Whether it needs no neighbour to be believed.
    pub(super) fn is_clear(&self) -> bool {
        self.share >= CLEAR_SHARE
    }
}

/// The lines that a road of this width shows in the grey values across it, `step_m` apart, from right to left, in place of
/// those in `lines`.
pub(super) fn find(grey: &Profile, step_m: f64, width_m: f64, lines: &mut Vec<BrightLine>) {
    lines.clear();
    if width_m < NARROWEST_ROAD_M {
        return;
    }
    let [half, gap, side] = COMPARED_M.map(|length_m| (length_m / step_m).round() as usize);
    let end = grey.shifts_m().len();
    let stands_out = |i: usize| {
        let (inner, outer) = (half + gap, half + gap + side);
        let line = grey.level(i.saturating_sub(half), (i + half + 1).min(end), 2 * half + 1)?;
        let right = grey.level(i.saturating_sub(outer), i.saturating_sub(inner), side)?;
        let left = grey.level((i + inner + 1).min(end), (i + outer + 1).min(end), side)?;
        let beside = left.max(right);
        Some((line - beside) / (line + beside).max(f64::EPSILON))
    };
    for (i, &left_m) in grey.shifts_m().iter().enumerate() {
        let Some(share) = stands_out(i).filter(|share| *share >= LEAST_SHARE) else { continue };
        match lines.last_mut() {
            Some(last) if left_m - last.left_m < SAME_LINE_M => {
                if share > last.share {
                    *last = BrightLine { left_m, share };
                }
            }
            _ => lines.push(BrightLine { left_m, share }),
        }
    }
}

/// The road's left and right edge by its lines, metres to the left, where the probability falls at `edges_m`; the map says
/// how wide the road is, with a standard deviation, metres. None where no line says it.
pub(super) fn edges_m(
    lines: &[BrightLine],
    width: (f64, f64),
    edges_m: [Option<f64>; 2],
) -> [Option<f64>; 2] {
    if let Some(both) = both_edges_m(lines, width, edges_m) {
        return both.map(Some);
    }
    let farthest_m = FARTHEST_INSIDE_M.min(0.5 * width.0 - FROM_MIDDLE_M);
    [0, 1].map(|side| {
        let (edge_m, outwards) = (edges_m[side]?, if side == 0 { 1.0 } else { -1.0 });
        let inside = || {
            lines
                .iter()
                .filter(|line| (-OUTSIDE_M..=farthest_m).contains(&(outwards * (edge_m - line.left_m))))
        };
        let clearest = inside().map(|line| line.share).max_by(f64::total_cmp)?;
        let clear = inside().filter(|line| line.share >= OUTER_SHARE * clearest);
        let outermost = clear.max_by(|a, b| (outwards * a.left_m).total_cmp(&(outwards * b.left_m)))?;
        Some(outermost.left_m + outwards * FROM_EDGE_M)
    })
}

/// The edges by two lines that are as far apart as the map says, metres to the left.
fn both_edges_m(
    lines: &[BrightLine],
    (width_m, width_sigma_m): (f64, f64),
    edges_m: [Option<f64>; 2],
) -> Option<[f64; 2]> {
    let pairs = lines
        .iter()
        .enumerate()
        .flat_map(|(i, right)| lines.iter().skip(i + 1).map(move |left| [left, right]));
    let scored = pairs.filter_map(|pair| {
        let [left, right] = pair;
        let misfit = (left.left_m - right.left_m + 2.0 * FROM_EDGE_M - width_m) / width_sigma_m;
        let is_beside = |side: usize| {
            edges_m[side].is_none_or(|edge_m| (edge_m - pair[side].left_m).abs() < FARTHEST_EDGE_M)
        };
        let share = left.share.min(PLAIN_SHARE) + right.share.min(PLAIN_SHARE);
        let score = share - SHARE_OF_MISFIT * misfit * misfit;
        (misfit.abs() < 1.0 && is_beside(0) && is_beside(1))
            .then_some((score, [left.left_m + FROM_EDGE_M, right.left_m - FROM_EDGE_M]))
    });
    scored.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, both_m)| both_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP_M: f64 = 0.1;
    /// Width of the road in the tests, and its standard deviation, metres.
    const WIDTH: (f64, f64) = (5.5, 0.88);

    /// The lines of a road of which the grey values are brighter at `painted`, metres to the left.
    fn lines(painted: &[f64], width_m: f64) -> Vec<BrightLine> {
        let mut grey = Profile::default();
        let level = |x: f64| if painted.iter().any(|line_m| (x - line_m).abs() < 0.12) { 0.5 } else { 0.3 };
        grey.take((-80..=80).map(|k| STEP_M * f64::from(k)).map(|x| (x, Some(level(x) + 0.004 * x))));
        let mut lines = Vec::new();
        find(&grey, STEP_M, width_m, &mut lines);
        lines
    }

    fn near(edge: Option<f64>, expected_m: f64) -> bool {
        edge.is_some_and(|m| (m - expected_m).abs() < 0.08)
    }

    #[test]
    fn a_line_is_a_ridge_and_not_a_step() {
        let found = lines(&[-2.5, 2.5], 5.5);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(found[0].left_m < found[1].left_m && found.iter().all(BrightLine::is_clear), "{found:?}");
        let mut step = Profile::default();
        step.take(
            (-40..=40).map(|k| STEP_M * f64::from(k)).map(|x| (x, Some(if x < 0.0 { 0.3 } else { 0.5 }))),
        );
        let mut none = found;
        find(&step, STEP_M, 5.5, &mut none);
        assert_eq!(none, []);
        assert_eq!(lines(&[-2.5, 2.5], 3.5), [], "a narrow road has no edge lines");
    }

    #[test]
    fn two_lines_as_far_apart_as_the_road_is_wide_are_its_edges() {
        // Edge lines and a centre line of a road that lies 1.3 m further to the left than believed, without any edge.
        let found = lines(&[-1.2, 1.3, 3.8], 5.5);
        let [left, right] = edges_m(&found, WIDTH, [None, None]);
        assert!(near(left, 4.05) && near(right, -1.45), "{left:?} {right:?}");
        assert_eq!(edges_m(&lines(&[-1.2, 1.3], 5.5), WIDTH, [None, None]), [None, None], "half a road");
        let far_off = [Some(9.0), None];
        assert_eq!(edges_m(&found, WIDTH, far_off), [None, None], "the edge belongs to something else");
    }

    #[test]
    fn a_line_inside_an_edge_is_the_edge() {
        let inside = lines(&[2.5], 5.5);
        assert!(near(edges_m(&inside, WIDTH, [Some(4.7), None])[0], 2.75));
        let right = lines(&[-2.5], 5.5);
        assert!(near(edges_m(&right, WIDTH, [None, Some(-4.7)])[1], -2.75));
        assert_eq!(edges_m(&inside, WIDTH, [Some(1.5), None]), [None, None], "a line beyond the edge");
        let centre = lines(&[0.0], 5.5);
        assert_eq!(edges_m(&centre, WIDTH, [Some(2.75), None]), [None, None], "the centre line");
    }

    #[test]
    fn a_line_goes_on_where_the_next_piece_shows_it() {
        let (here, there) = (lines(&[2.5], 5.5), lines(&[2.7], 5.5));
        assert!(here[0].goes_on_in(&there));
        assert!(!here[0].goes_on_in(&lines(&[3.1], 5.5)) && !here[0].goes_on_in(&[]));
    }
}
