//! The lines along a street where every street has its own: what its builders chose, from none to double ones.

use fingerpost_format::MarkingColour;

use crate::markings::{DOUBLE_GAP_M, Line};
use crate::noise::Stream;

/// How a line runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Stripe {
    /// There is none.
    None,
    /// Without gaps.
    Continuous,
    /// Dashes.
    Broken,
    /// Two beside each other, without gaps.
    Double,
}

/// The lines along a street.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct StreetPaint {
    /// On the axis, between the two directions.
    centre: Stripe,
    /// Colour of that.
    centre_colour: MarkingColour,
    /// Along both edges.
    edges: Stripe,
    /// Colour of these.
    edge_colour: MarkingColour,
    /// Distance of their middle from the road's edge, metres.
    pub(crate) edges_m: f32,
    /// Width of a line, metres.
    line_width_m: f32,
    /// Length of a dash, and of a dash and a gap together, metres.
    dash_m: [f32; 2],
}

// Counts of how streets are painted are not at hand. The shares below are assumptions: that every kind which a street of the
// world may have comes up within some ten drives, and that many side streets have no lines.

/// Kinds of centre line by their share.
const CENTRES: [(f64, Stripe); 4] =
    [(0.40, Stripe::None), (0.35, Stripe::Broken), (0.15, Stripe::Continuous), (0.10, Stripe::Double)];
/// Kinds of edge lines by their share.
const EDGES: [(f64, Stripe); 3] = [(0.55, Stripe::None), (0.33, Stripe::Continuous), (0.12, Stripe::Broken)];
/// The same where edges are marked as anywhere: Britain's double yellow lines, France's broken ones, none.
const EDGES_ANYWHERE: [(f64, Stripe); 4] =
    [(0.25, Stripe::None), (0.3, Stripe::Continuous), (0.15, Stripe::Broken), (0.3, Stripe::Double)];
/// Their distance from the edge, metres: from beside the kerb to a gutter and a hard strip within (Britain's TSRGD, diagrams 1012 and 1018).
const EDGES_ANYWHERE_M: [f64; 2] = [0.15, 0.9];
/// Distance of an edge line's middle from the road's edge else, metres.
pub(crate) const EDGE_LINE_M: f32 = 0.25;
/// Colours of a centre line by their share: the Vienna Convention on Road Signs and Signals (1968), article 29, allows both, the
/// Americas have yellow.
const COLOURS: [(f64, MarkingColour); 2] = [(0.7, MarkingColour::White), (0.3, MarkingColour::Yellow)];
/// Dash, and dash and gap together, metres: Germany's in towns and outside (RMS-1), Britain's diagram 1008, the American MUTCD's.
const DASHES_M: [(f64, [f32; 2]); 4] =
    [(1.0, [3.0, 9.0]), (1.0, [4.0, 12.0]), (1.0, [2.0, 6.0]), (1.0, [3.0, 12.2])];
/// Width of a line, metres: the narrow and the broad one of the same rules.
const LINE_WIDTHS_M: [f64; 2] = [0.10, 0.20];

impl StreetPaint {
    /// A dashed centre line and edge lines, all white.
    pub(crate) const USUAL: Self = Self {
        centre: Stripe::Broken,
        centre_colour: MarkingColour::White,
        edges: Stripe::Continuous,
        edge_colour: MarkingColour::White,
        edges_m: EDGE_LINE_M,
        line_width_m: 0.14,
        dash_m: [3.0, 9.0],
    };

    /// The lines that `seed` draws for the street of a chain; a share of the streets has edges marked as anywhere.
    pub(crate) fn drawn(seed: u64, chain: u32, edge_paint: f64) -> Self {
        let mut stream = Stream::new(seed ^ 0x5354_5245, u64::from(chain));
        let usual = Self {
            centre: stream.choose(&CENTRES).unwrap_or(Stripe::None),
            centre_colour: stream.choose(&COLOURS).unwrap_or(MarkingColour::White),
            edges: stream.choose(&EDGES).unwrap_or(Stripe::None),
            line_width_m: stream.between(LINE_WIDTHS_M[0], LINE_WIDTHS_M[1]) as f32,
            dash_m: stream.choose(&DASHES_M).unwrap_or(Self::USUAL.dash_m),
            ..Self::USUAL
        };
        if stream.unit() >= edge_paint {
            return usual;
        }
        let colours = [(0.5, MarkingColour::White), (0.5, MarkingColour::Yellow)];
        Self {
            edges: stream.choose(&EDGES_ANYWHERE).unwrap_or(Stripe::None),
            edge_colour: stream.choose(&colours).unwrap_or(MarkingColour::White),
            edges_m: stream.between(EDGES_ANYWHERE_M[0], EDGES_ANYWHERE_M[1]) as f32,
            ..usual
        }
    }

    /// The lines on the axis, from the right to the left.
    pub(crate) fn centre_lines(&self) -> Vec<Line> {
        self.lines(self.centre, 0.0, self.centre_colour)
    }

    /// The line whose middle is so far left of the axis, metres.
    pub(crate) fn edge_lines(&self, middle_m: f32) -> Vec<Line> {
        self.lines(self.edges, middle_m, self.edge_colour)
    }

    fn lines(&self, stripe: Stripe, middle_m: f32, colour: MarkingColour) -> Vec<Line> {
        let line = |aside_m: f32, dash_m: Option<[f32; 2]>| Line {
            middle_m: middle_m + aside_m,
            width_m: self.line_width_m,
            dash_m,
            colour,
        };
        let apart_m = 0.5 * (DOUBLE_GAP_M + self.line_width_m);
        match stripe {
            Stripe::None => Vec::new(),
            Stripe::Continuous => vec![line(0.0, None)],
            Stripe::Broken => vec![line(0.0, Some(self.dash_m))],
            Stripe::Double => vec![line(-apart_m, None), line(apart_m, None)],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streets_differ_and_every_kind_comes_up() {
        let streets: Vec<StreetPaint> = (0..300).map(|chain| StreetPaint::drawn(5, chain, 0.0)).collect();
        let share = |is: &dyn Fn(&StreetPaint) -> bool| {
            streets.iter().filter(|street| is(street)).count() as f64 / streets.len() as f64
        };
        for (expected, stripe) in CENTRES {
            assert!((share(&|street| street.centre == stripe) - expected).abs() < 0.09, "{stripe:?}");
        }
        for (expected, stripe) in EDGES {
            assert!((share(&|street| street.edges == stripe) - expected).abs() < 0.09, "{stripe:?}");
        }
        assert!((share(&|street| street.centre_colour == MarkingColour::Yellow) - 0.3).abs() < 0.09);
        assert_eq!(StreetPaint::drawn(5, 7, 0.0), StreetPaint::drawn(5, 7, 0.0));
        assert_ne!(StreetPaint::drawn(5, 7, 0.0), StreetPaint::drawn(6, 7, 0.0));
    }

    #[test]
    fn edges_marked_as_anywhere_leave_the_axis_as_it_is() {
        let streets =
            (0..300).map(|chain| [0.0, 1.0].map(|edge_paint| StreetPaint::drawn(5, chain, edge_paint)));
        let mut yellow = 0;
        for [usual, other] in streets {
            assert_eq!(usual.centre_lines(), other.centre_lines());
            assert!((0.15..=0.9).contains(&other.edges_m), "{other:?}");
            let lines = other.edge_lines(2.0);
            yellow += usize::from(lines.len() == 2 && lines[0].colour == MarkingColour::Yellow);
        }
        assert!((20..80).contains(&yellow), "{yellow} of 300 with double yellow lines");
    }

    #[test]
    fn a_double_line_lies_about_the_axis() {
        let street = StreetPaint { centre: Stripe::Double, line_width_m: 0.12, ..StreetPaint::USUAL };
        let middles: Vec<f32> = street.centre_lines().iter().map(|line| line.middle_m).collect();
        assert!((middles[0] + 0.12).abs() < 1e-6 && (middles[1] - 0.12).abs() < 1e-6, "{middles:?}");
        assert!(StreetPaint { edges: Stripe::None, ..street }.edge_lines(2.0).is_empty());
    }
}
