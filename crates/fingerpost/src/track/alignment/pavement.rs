//! Kerbs: the edges of a road beside which a pavement looks like road.
//!
//! Grey pavements have the colour of asphalt, so that the probability of road falls where the pavement ends and the road
//! seems two metres too wide. But the pavement is another grey than the road, and it begins at the kerb. A change of the
//! grey inside an edge is taken for the kerb where the width between the edges then fits the map better. Where only one edge
//! is seen the map cannot tell: then it is as likely a kerb as the edges of the drive's other sections were, and its place
//! lies between the two, with a doubt that covers both.
//!
//! Where a line along the road shows its edge (`lines.rs`) no kerb is asked.
//!
//! Limits: the border of a shadow or of a patch along the road is a change of the grey as well.

use super::profile::Profile;

/// How wide pavements are, from the narrowest to the widest, metres: what is narrower hardly moves the road's middle, and
/// what is wider is a lane.
const PAVEMENT_M: [f64; 2] = [0.9, 3.0];
/// Width on either side of a kerb over which grey values are compared, and what is left out beside it, where the kerb's own
/// stone may lie, metres.
const COMPARED_M: (f64, f64) = (0.5, 0.1);
/// Least change of the grey at a kerb, as a share of the sum of both sides.
const LEAST_CHANGE: f64 = 0.05;
/// What a kerb must gain to be believed, square standard deviations of the width.
const LEAST_GAIN: f64 = 1.0;

/// How often edges of the surface were a pavement's, by the sections of which both edges are known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pavements {
    with: f64,
    without: f64,
}

/// Nothing is seen yet: a change of the grey just inside an edge is a kerb more often than not.
const BEFORE_ANY: Pavements = Pavements { with: 1.0, without: 0.3 };
/// What is left of what was counted, for each edge that is: those of the last junctions count.
const KEPT: f64 = 0.99975;
/// A section counts when its width fits the map's to so many standard deviations.
const FITS_SIGMAS: f64 = 2.0;
/// However often edges were kerbs, or were none, the next one may differ.
const NEVER_SURER: [f64; 2] = [0.05, 0.95];
/// Least standard deviation of a width, metres.
const LEAST_WIDTH_SIGMA_M: f64 = 0.1;

impl Default for Pavements {
    fn default() -> Self {
        BEFORE_ANY
    }
}

impl Pavements {
    /// How probable it is that an edge with a change of the grey inside is a kerb.
    fn probability(self) -> f64 {
        (self.with / (self.with + self.without)).clamp(NEVER_SURER[0], NEVER_SURER[1])
    }

    /// Counts an edge of the surface: a pavement's, or the road's own.
    fn count(&mut self, has_pavement: bool) {
        self.with *= KEPT;
        self.without *= KEPT;
        *(if has_pavement { &mut self.with } else { &mut self.without }) += 1.0;
    }
}

/// The edges of a road.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RoadEdges {
    /// Left and right edge, metres to the left; none where an edge is not seen.
    pub(super) edges_m: [Option<f64>; 2],
    /// What is not known of them because a pavement may lie inside, standard deviations, metres.
    pub(super) pavement_sigma_m: [f64; 2],
    /// Whether a line on the road shows the edge.
    pub(super) by_line: [bool; 2],
}

impl RoadEdges {
    /// Edges without a doubt of pavements.
    pub(super) const fn certain(edges_m: [Option<f64>; 2]) -> Self {
        Self { edges_m, pavement_sigma_m: [0.0; 2], by_line: [false; 2] }
    }
}

/// The edges of a road, metres to its left, without the pavements that `edges_m` may hold. `grey` are the grey values across
/// it, `step_m` apart; `lines_m` are the edges that lines show, which hold; the map says how wide the road is, with a standard
/// deviation, metres. `pavements` learns from what is seen of both edges.
pub(super) fn without_pavements(
    grey: &Profile,
    step_m: f64,
    (width_m, width_sigma_m): (f64, f64),
    (edges_m, lines_m): ([Option<f64>; 2], [Option<f64>; 2]),
    pavements: &mut Pavements,
) -> RoadEdges {
    let [nearest_m, farthest_m] = PAVEMENT_M;
    // Further in lie the road's own middle and its other lane.
    let farthest_m = farthest_m.min(0.5 * width_m);
    let kerb_inside = |side: usize| {
        let (edge_m, inwards) = (edges_m[side]?, if side == 0 { -1.0 } else { 1.0 });
        let (a, b) = (edge_m + inwards * nearest_m, edge_m + inwards * farthest_m);
        let change = grey.greatest_change(step_m, COMPARED_M, &(a.min(b)..=a.max(b)));
        change.filter(|(_, share)| *share >= LEAST_CHANGE).map(|(at_m, _)| at_m)
    };
    let by_line = lines_m.map(|line_m| line_m.is_some());
    let kerbs_m = [0, 1].map(|side| lines_m[side].or_else(|| kerb_inside(side)));
    let seen_m = [0, 1].map(|side| edges_m[side].or(lines_m[side]));
    if seen_m.iter().any(Option::is_none) {
        let p = by_line.map(|by_line| if by_line { 1.0 } else { pavements.probability() });
        return RoadEdges { by_line, ..either_or(p, seen_m, kerbs_m) };
    }
    let width_sigma_m = width_sigma_m.max(LEAST_WIDTH_SIGMA_M);
    let ways = [[false, false], [true, false], [false, true], [true, true]];
    let ways = ways.into_iter().filter(|is_kerb| (0..2).all(|side| is_kerb[side] || !by_line[side]));
    let misfits = ways.filter_map(|is_kerb| {
        let place_m = |side: usize| if is_kerb[side] { kerbs_m[side] } else { seen_m[side] };
        let misfit = ((place_m(0)? - place_m(1)? - width_m) / width_sigma_m).powi(2);
        Some((misfit, is_kerb))
    });
    let cost = |(misfit, is_kerb): &(f64, [bool; 2])| {
        misfit + LEAST_GAIN * is_kerb.iter().filter(|is_kerb| **is_kerb).count() as f64
    };
    let Some((misfit, is_kerb)) = misfits.min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
        return RoadEdges { by_line, ..RoadEdges::certain(seen_m) };
    };
    if misfit < FITS_SIGMAS * FITS_SIGMAS {
        for (side, outwards) in [(0, 1.0), (1, -1.0)] {
            // Beside a line without an edge of the surface nothing is known of a pavement.
            let (Some(edge_m), kerb_m) = (edges_m[side], kerbs_m[side]) else { continue };
            let beside_m = kerb_m.map_or(0.0, |kerb_m| outwards * (edge_m - kerb_m));
            pavements.count(is_kerb[side] && beside_m >= nearest_m);
        }
    }
    RoadEdges { by_line, ..either_or(is_kerb.map(|is_kerb| f64::from(u8::from(is_kerb))), seen_m, kerbs_m) }
}

/// Edges of which each is a kerb with its probability: mean and standard deviation of the two places.
fn either_or(probability: [f64; 2], edges_m: [Option<f64>; 2], kerbs_m: [Option<f64>; 2]) -> RoadEdges {
    let mut road = RoadEdges::certain(edges_m);
    for side in 0..2 {
        if let (Some(edge_m), Some(kerb_m)) = (edges_m[side], kerbs_m[side]) {
            let p = probability[side];
            road.edges_m[side] = Some(edge_m + p * (kerb_m - edge_m));
            road.pavement_sigma_m[side] = (p * (1.0 - p)).sqrt() * (kerb_m - edge_m).abs();
        }
    }
    road
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grey values of a road whose surroundings are another grey beyond `left_m` and `right_m`.
    fn road(left_m: f64, right_m: f64) -> Profile {
        let mut profile = Profile::default();
        let grey = |x: f64| if x > right_m && x < left_m { 0.3 } else { 0.4 };
        profile.take((-80..=80).map(|k| 0.1 * f64::from(k)).map(|x| (x, Some(grey(x)))));
        profile
    }

    fn edges_m(grey: &Profile, edges_m: [Option<f64>; 2]) -> [Option<f64>; 2] {
        let no_lines = [None, None];
        without_pavements(grey, 0.1, (5.5, 0.88), (edges_m, no_lines), &mut Pavements::default()).edges_m
    }

    fn near(edge: Option<f64>, expected_m: f64, within_m: f64) -> bool {
        edge.is_some_and(|m| (m - expected_m).abs() < within_m)
    }

    #[test]
    fn a_pavement_on_one_side_is_left_out() {
        let is_road = |edges: [Option<f64>; 2]| near(edges[0], 2.75, 0.06) && near(edges[1], -2.75, 0.06);
        for (left_m, right_m) in [(4.75, -2.75), (2.75, -4.75), (4.75, -4.75)] {
            let edges = edges_m(&road(2.75, -2.75), [Some(left_m), Some(right_m)]);
            assert!(is_road(edges), "{edges:?}");
        }
    }

    #[test]
    fn a_road_as_wide_as_on_the_map_keeps_its_edges() {
        let inside = road(1.2, -9.0);
        assert_eq!(edges_m(&inside, [Some(2.75), Some(-2.75)]), [Some(2.75), Some(-2.75)]);
    }

    #[test]
    fn a_road_that_is_too_wide_without_a_kerb_keeps_its_edges() {
        let even = road(9.0, -9.0);
        assert_eq!(edges_m(&even, [Some(4.0), Some(-4.0)]), [Some(4.0), Some(-4.0)]);
    }

    #[test]
    fn a_single_edge_lies_between_itself_and_the_kerb_as_other_edges_did() {
        let single = |pavements: &mut Pavements| {
            let edges_m = ([None, Some(-4.75)], [None, None]);
            without_pavements(&road(9.0, -2.75), 0.1, (5.5, 0.88), edges_m, pavements)
        };
        let mut pavements = Pavements::default();
        let unsure = single(&mut pavements);
        assert!(unsure.edges_m[1].is_some_and(|m| m > -4.0 && m < -2.8), "{unsure:?}");
        assert!(unsure.pavement_sigma_m[1] > 0.5, "{unsure:?}");
        let learn = |grey: &Profile, edges_m: [f64; 2]| {
            let mut pavements = Pavements::default();
            for _ in 0..100 {
                let edges_m = (edges_m.map(Some), [None, None]);
                without_pavements(grey, 0.1, (5.5, 0.88), edges_m, &mut pavements);
            }
            single(&mut pavements)
        };
        let kerb = learn(&road(2.75, -2.75), [4.75, -4.75]);
        assert!(near(kerb.edges_m[1], -2.75, 0.3) && kerb.pavement_sigma_m[1] < 0.65, "{kerb:?}");
        let edge = learn(&road(1.2, -1.2), [2.75, -2.75]);
        assert!(near(edge.edges_m[1], -4.75, 0.4) && edge.pavement_sigma_m[1] < 0.7, "{edge:?}");
        let edges_m = ([Some(2.0), None], [None, None]);
        let even = without_pavements(&road(9.0, -9.0), 0.1, (5.5, 0.88), edges_m, &mut pavements);
        assert_eq!(even, RoadEdges::certain([Some(2.0), None]));
    }

    #[test]
    fn a_line_holds_and_says_whether_a_pavement_lies_beside_it() {
        let edge_of = |edges_m: [Option<f64>; 2], lines_m: [Option<f64>; 2], pavements: &mut Pavements| {
            without_pavements(&road(9.0, -9.0), 0.1, (5.5, 0.88), (edges_m, lines_m), pavements)
        };
        let mut pavements = Pavements::default();
        let single = edge_of([Some(4.75), None], [Some(2.75), None], &mut pavements);
        assert_eq!((single.edges_m, single.by_line), ([Some(2.75), None], [true, false]));
        assert!(single.pavement_sigma_m[0] < 1e-9, "{single:?}");
        let both = edge_of([None, None], [Some(2.75), Some(-2.75)], &mut pavements);
        assert_eq!((both.edges_m, both.by_line), ([Some(2.75), Some(-2.75)], [true, true]));
        for (outer_m, probability) in [(4.75, 0.5..1.0), (2.8, 0.0..0.5), (0.8, 0.0..0.5)] {
            let mut pavements = Pavements::default();
            for _ in 0..10 {
                edge_of([Some(outer_m), Some(-outer_m)], [Some(2.75), Some(-2.75)], &mut pavements);
            }
            assert!(probability.contains(&pavements.probability()), "{outer_m} {pavements:?}");
        }
        let mut pavements = Pavements::default();
        edge_of([None, None], [Some(2.75), Some(-2.75)], &mut pavements);
        assert_eq!(pavements, Pavements::default(), "without an edge of the surface no pavement is known");
    }
}
