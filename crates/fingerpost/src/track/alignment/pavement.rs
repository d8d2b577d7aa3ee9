//! Kerbs: the edges of a road beside which a pavement looks like road.
//!
//! Grey pavements have the colour of asphalt, so that the probability of road falls where the pavement ends and the road
//! seems two metres too wide. But the pavement is another grey than the road, and it begins at the kerb. A change of the
//! grey inside an edge is taken for the kerb where the width between the edges then fits the map better. Where only one edge
//! is seen the map cannot tell: then it is as likely a kerb as the edges of the drive's other sections were, and its place
//! lies between the two, with a doubt that covers both.
//!
//! Limits: a painted line, the border of a shadow or of a patch along the road is a change of the grey as well; lines along
//! a road's edge lie where the kerb does.

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

/// How often edges had a pavement outside, by the sections of which both are seen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pavements {
    with: f64,
    without: f64,
}

/// Nothing is seen yet: a change of the grey just inside an edge is a kerb more often than not.
const BEFORE_ANY: Pavements = Pavements { with: 1.0, without: 0.3 };
/// What is left of what was counted, for each section that is: some hundred sections count.
const KEPT: f64 = 0.998;
/// A section counts when its width fits the map's to so many standard deviations.
const FITS_SIGMAS: f64 = 2.0;

impl Default for Pavements {
    fn default() -> Self {
        BEFORE_ANY
    }
}

impl Pavements {
    /// How probable it is that an edge with a change of the grey inside is a pavement's.
    fn probability(self) -> f64 {
        self.with / (self.with + self.without)
    }

    fn count_section(&mut self, kerbs: f64) {
        self.with = KEPT * self.with + kerbs;
        self.without = KEPT * self.without + (2.0 - kerbs);
    }
}

/// The edges of a road.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct RoadEdges {
    /// Left and right edge, metres to the left; none where an edge is not seen.
    pub(super) edges_m: [Option<f64>; 2],
    /// What is not known of them because a pavement may lie inside, standard deviations, metres.
    pub(super) pavement_sigma_m: [f64; 2],
}

impl RoadEdges {
    /// Edges without a doubt of pavements.
    pub(super) const fn certain(edges_m: [Option<f64>; 2]) -> Self {
        Self { edges_m, pavement_sigma_m: [0.0; 2] }
    }
}

/// The edges of a road, metres to its left, without the pavements that `edges_m` may hold. `grey` are the grey values across
/// it, `step_m` apart; the map says how wide the road is, with a standard deviation, metres. `pavements` learns from what is
/// seen of both edges.
pub(super) fn without_pavements(
    grey: &Profile,
    step_m: f64,
    (width_m, width_sigma_m): (f64, f64),
    edges_m: [Option<f64>; 2],
    pavements: &mut Pavements,
) -> RoadEdges {
    let [nearest_m, farthest_m] = PAVEMENT_M;
    let kerb = |edge_m: f64, between_m| {
        let change = grey.greatest_change(step_m, COMPARED_M, &between_m);
        change.filter(|(_, share)| *share >= LEAST_CHANGE).map_or(edge_m, |(at_m, _)| at_m)
    };
    let kerbs_m = [
        edges_m[0].map(|left_m| kerb(left_m, left_m - farthest_m..=left_m - nearest_m)),
        edges_m[1].map(|right_m| kerb(right_m, right_m + nearest_m..=right_m + farthest_m)),
    ];
    let ([Some(left_m), Some(right_m)], [Some(left_kerb_m), Some(right_kerb_m)]) = (edges_m, kerbs_m) else {
        return either_or(pavements.probability(), edges_m, kerbs_m);
    };
    let misfit = |left_m: f64, right_m: f64| ((left_m - right_m - width_m) / width_sigma_m).powi(2);
    let ways = [
        (left_m, right_m, 0.0),
        (left_kerb_m, right_m, 1.0),
        (left_m, right_kerb_m, 1.0),
        (left_kerb_m, right_kerb_m, 2.0),
    ];
    let cost = |&(left_m, right_m, kerbs): &(f64, f64, f64)| misfit(left_m, right_m) + LEAST_GAIN * kerbs;
    let Some((left_m, right_m, kerbs)) = ways.into_iter().min_by(|a, b| cost(a).total_cmp(&cost(b))) else {
        return RoadEdges::certain(edges_m);
    };
    if misfit(left_m, right_m) < FITS_SIGMAS * FITS_SIGMAS {
        pavements.count_section(kerbs);
    }
    RoadEdges::certain([Some(left_m), Some(right_m)])
}

/// Edges of which each is a kerb with this probability: mean and standard deviation of the two places.
fn either_or(probability: f64, edges_m: [Option<f64>; 2], kerbs_m: [Option<f64>; 2]) -> RoadEdges {
    let mut road = RoadEdges::certain(edges_m);
    for side in 0..2 {
        if let (Some(edge_m), Some(kerb_m)) = (edges_m[side], kerbs_m[side]) {
            road.edges_m[side] = Some(edge_m + probability * (kerb_m - edge_m));
            road.pavement_sigma_m[side] =
                (probability * (1.0 - probability)).sqrt() * (kerb_m - edge_m).abs();
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
        without_pavements(grey, 0.1, (5.5, 0.88), edges_m, &mut Pavements::default()).edges_m
    }

    fn near(edge: Option<f64>, expected_m: f64) -> bool {
        edge.is_some_and(|m| (m - expected_m).abs() < 0.11)
    }

    #[test]
    fn a_pavement_on_one_side_is_left_out() {
        let left = edges_m(&road(2.75, -2.75), [Some(4.75), Some(-2.75)]);
        assert!(near(left[0], 2.75) && near(left[1], -2.75), "{left:?}");
        let right = edges_m(&road(2.75, -2.75), [Some(2.75), Some(-4.75)]);
        assert!(near(right[0], 2.75) && near(right[1], -2.75), "{right:?}");
        let both = edges_m(&road(2.75, -2.75), [Some(4.75), Some(-4.75)]);
        assert!(near(both[0], 2.75) && near(both[1], -2.75), "{both:?}");
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
            without_pavements(&road(9.0, -2.75), 0.1, (5.5, 0.88), [None, Some(-4.75)], pavements)
        };
        let mut pavements = Pavements::default();
        let unsure = single(&mut pavements);
        assert!(unsure.edges_m[1].is_some_and(|m| m > -4.0 && m < -2.8), "{unsure:?}");
        assert!(unsure.pavement_sigma_m[1] > 0.5, "{unsure:?}");
        let both = [Some(4.75), Some(-4.75)];
        for _ in 0..100 {
            without_pavements(&road(2.75, -2.75), 0.1, (5.5, 0.88), both, &mut pavements);
        }
        let kerb = single(&mut pavements);
        assert!(near(kerb.edges_m[1], -2.75) && kerb.pavement_sigma_m[1] < 0.15, "{kerb:?}");
        let mut verges = Pavements::default();
        for _ in 0..100 {
            let narrow = [Some(2.75), Some(-2.75)];
            without_pavements(&road(9.0, -9.0), 0.1, (5.5, 0.88), narrow, &mut verges);
        }
        let edge = single(&mut verges);
        assert!(near(edge.edges_m[1], -4.75) && edge.pavement_sigma_m[1] < 0.2, "{edge:?}");
        let even = without_pavements(&road(9.0, -9.0), 0.1, (5.5, 0.88), [Some(2.0), None], &mut pavements);
        assert_eq!(even, RoadEdges::certain([Some(2.0), None]));
    }
}
