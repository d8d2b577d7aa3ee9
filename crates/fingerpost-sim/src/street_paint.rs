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
    /// Along both edges; white.
    edges: Stripe,
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
        line_width_m: 0.14,
        dash_m: [3.0, 9.0],
    };

    /// The lines that `seed` draws for the street of a chain.
    pub(crate) fn drawn(seed: u64, chain: u32) -> Self {
        let mut stream = Stream::new(seed ^ 0x5354_5245, u64::from(chain));
        Self {
            centre: stream.choose(&CENTRES).unwrap_or(Stripe::None),
            centre_colour: stream.choose(&COLOURS).unwrap_or(MarkingColour::White),
            edges: stream.choose(&EDGES).unwrap_or(Stripe::None),
            line_width_m: stream.between(LINE_WIDTHS_M[0], LINE_WIDTHS_M[1]) as f32,
            dash_m: stream.choose(&DASHES_M).unwrap_or(Self::USUAL.dash_m),
        }
    }

    /// The lines on the axis, from the right to the left.
    pub(crate) fn centre_lines(&self) -> Vec<Line> {
        self.lines(self.centre, 0.0, self.centre_colour)
    }

    /// The line whose middle is so far left of the axis, metres.
    pub(crate) fn edge_lines(&self, middle_m: f32) -> Vec<Line> {
        self.lines(self.edges, middle_m, MarkingColour::White)
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
        let streets: Vec<StreetPaint> = (0..300).map(|chain| StreetPaint::drawn(5, chain)).collect();
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
        assert_eq!(StreetPaint::drawn(5, 7), StreetPaint::drawn(5, 7));
        assert_ne!(StreetPaint::drawn(5, 7), StreetPaint::drawn(6, 7));
    }

    #[test]
    fn a_double_line_lies_about_the_axis() {
        let street = StreetPaint { centre: Stripe::Double, line_width_m: 0.12, ..StreetPaint::USUAL };
        let middles: Vec<f32> = street.centre_lines().iter().map(|line| line.middle_m).collect();
        assert!((middles[0] + 0.12).abs() < 1e-6 && (middles[1] - 0.12).abs() < 1e-6, "{middles:?}");
        assert!(StreetPaint { edges: Stripe::None, ..street }.edge_lines(2.0).is_empty());
    }
}
