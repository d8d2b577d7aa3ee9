//! The road's edges: where the road surface ends to the left and to the right, against where the road does.
//!
//! Sections across the road lie [`EDGES_AHEAD_M`] ahead of the vehicle, one each [`EDGES_EVERY_M`]. In each the way goes from the
//! vehicle's axis, where that is on the road, outwards to either side.

use fingerpost_format::{CrossTrackCounts, RoadEdgeSummary};

use crate::surface_end::{GAP_M, STEP_M, SurfaceEnd, is_called_road, places_aside};

/// How far ahead of the vehicle edges count, metres: from the near end of the ground view to where a lane keeper looks.
pub const EDGES_AHEAD_M: [f64; 2] = [4.0, 12.0];
/// Distance from one section to the next, metres.
pub const EDGES_EVERY_M: f64 = 1.0;
/// How far aside edges are looked for, metres: as far as the ground view reaches.
pub const EDGES_ASIDE_M: f64 = 10.0;
/// Nearer than this an edge is in its place, metres. A car of 1.9 m has 0.55 m on either side of it in a lane of 3 m, and a lane keeper
/// spends some of that: an edge that is off by more leads a wheel over it.
pub const EDGE_WITHIN_M: f64 = 0.3;
/// An edge is shown where the road so far inside of it is, metres: some pixels of a picture, less than anything that hides one.
const INSIDE_M: f64 = 0.2;
/// A step in which the road ends is halved so often: to a millimetre.
const HALVINGS: u32 = 5;

/// What there is at a place of one frame, metres forward and left.
#[derive(Debug, Clone, Copy)]
pub struct EdgeScene<IsRoad, Shown, Probability> {
    /// Whether it is road.
    pub is_road: IsRoad,
    /// Whether the picture shows road there: nothing hides it.
    pub is_shown: Shown,
    /// Probability of road that was found, 0 to 1; none where the camera does not look.
    pub probability: Probability,
}

/// What the road surfaces of one or more drives make of the road's edges.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RoadEdgeScores {
    /// Distance of the surface's end from each edge.
    errors: CrossTrackCounts,
    /// Edges in their places.
    within: u64,
    /// Edges beyond which the surface goes on to the end of what is seen.
    missed: u64,
}

impl RoadEdgeScores {
    /// Adds a frame.
    pub fn add<IsRoad, Shown, Probability>(&mut self, scene: &EdgeScene<IsRoad, Shown, Probability>)
    where
        IsRoad: Fn([f64; 2]) -> bool,
        Shown: Fn([f64; 2]) -> bool,
        Probability: Fn([f64; 2]) -> Option<f64>,
    {
        let [from_m, to_m] = EDGES_AHEAD_M;
        let last = ((to_m - from_m) / EDGES_EVERY_M).round() as u32;
        for forward_m in (0..=last).map(|i| from_m + EDGES_EVERY_M * f64::from(i)) {
            for side in [1.0, -1.0] {
                let place = |aside_m: f64| [forward_m, side * aside_m];
                let edge_m = edge_aside_m(|aside_m| (scene.is_road)(place(aside_m)));
                let Some(edge_m) = edge_m else { continue };
                if (scene.is_shown)(place((edge_m - INSIDE_M).max(0.0))) {
                    let surface = surface_aside(|aside_m| (scene.probability)(place(aside_m)));
                    self.add_edge(edge_m, &surface);
                }
            }
        }
    }

    /// Adds an edge so far aside of the vehicle's axis, and the surface there.
    fn add_edge(&mut self, edge_m: f64, surface: &SurfaceEnd) {
        // Whether a surface ends in the edge's place is seen a gap behind that.
        if surface.last_m < edge_m + EDGE_WITHIN_M + GAP_M {
            return;
        }
        let error_m = surface.end_m - edge_m;
        self.errors.add(error_m);
        self.within += u64::from(surface.ended && error_m.abs() <= EDGE_WITHIN_M);
        self.missed += u64::from(!surface.ended);
    }

    /// Adds what other drives made of theirs.
    pub fn extend(&mut self, other: &Self) {
        self.errors.merge(&other.errors);
        self.within += other.within;
        self.missed += other.missed;
    }

    /// The numbers; none without an edge.
    pub fn summary(&self) -> Option<RoadEdgeSummary> {
        let error_m = self.errors.quantiles()?;
        let edges = self.errors.total();
        let within_share = self.within as f64 / edges as f64;
        Some(RoadEdgeSummary { edges, missed: self.missed, within_share, error_m })
    }
}

/// How far aside of the vehicle's axis the road ends, metres; none where the axis is beside the road, and where the road goes on.
fn edge_aside_m(is_road: impl Fn(f64) -> bool) -> Option<f64> {
    if !is_road(0.0) {
        return None;
    }
    let mut places = places_aside().take_while(|&aside_m| aside_m < EDGES_ASIDE_M);
    let mut beyond_m = places.find(|&aside_m| !is_road(aside_m))?;
    let mut inside_m = (beyond_m - STEP_M).max(0.0);
    for _ in 0..HALVINGS {
        let middle_m = 0.5 * (inside_m + beyond_m);
        *(if is_road(middle_m) { &mut inside_m } else { &mut beyond_m }) = middle_m;
    }
    Some(0.5 * (inside_m + beyond_m))
}

/// The surface on the way aside, as far as it is seen; `across` gives its probability.
fn surface_aside(across: impl Fn(f64) -> Option<f64>) -> SurfaceEnd {
    let mut surface = SurfaceEnd::default();
    let places = places_aside().take_while(|&aside_m| aside_m < EDGES_ASIDE_M);
    let seen = places.map_while(|aside_m| Some((aside_m, across(aside_m)?)));
    seen.for_each(|(aside_m, probability)| surface.take(aside_m, is_called_road(probability)));
    surface
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A road from 2 m right of the axis to 3 m left, seen 6 m to each side; the surface ends so far left and right.
    fn summary_of(surface_m: [f64; 2], hides: impl Fn([f64; 2]) -> bool) -> Option<RoadEdgeSummary> {
        scores(surface_m, 6.0, hides).summary()
    }

    fn scores(surface_m: [f64; 2], seen_m: f64, hides: impl Fn([f64; 2]) -> bool) -> RoadEdgeScores {
        let [surface_left_m, surface_right_m] = surface_m;
        let mut scores = RoadEdgeScores::default();
        scores.add(&EdgeScene {
            is_road: |[_, left_m]: [f64; 2]| left_m > -2.0 && left_m < 3.0,
            is_shown: |place| !hides(place),
            probability: |[_, left_m]: [f64; 2]| {
                let is_road = left_m > -surface_right_m && left_m < surface_left_m;
                (left_m.abs() < seen_m).then_some(if is_road { 0.9 } else { 0.1 })
            },
        });
        scores
    }

    const NOTHING: fn([f64; 2]) -> bool = |_| false;

    #[test]
    fn edges_in_their_places_are_within() {
        let both = summary_of([3.0, 2.0], NOTHING).unwrap();
        assert_eq!((both.edges, both.missed), (18, 0), "two edges in each of nine sections");
        assert!(both.within_share > 0.99 && both.error_m.max < 0.05, "{both:?}");
    }

    #[test]
    fn left_and_right_are_told_apart() {
        let scores = scores([3.5, 1.9], 6.0, NOTHING);
        let both = scores.summary().unwrap();
        assert!((both.within_share - 0.5).abs() < 1e-9, "0.5 m too far to the left: {both:?}");
        assert!((both.error_m.p50 - 0.1).abs() < 0.05, "0.1 m short to the right: {both:?}");
        assert!((both.error_m.p95 - 0.5).abs() < 0.05, "{both:?}");
    }

    #[test]
    fn the_true_edge_is_found_to_a_millimetre() {
        for true_m in [0.01, 0.33, 2.0, 3.512, 9.9] {
            let found_m = edge_aside_m(|aside_m| aside_m < true_m).unwrap();
            assert!((found_m - true_m).abs() < 1e-3, "{found_m} for {true_m}");
        }
    }

    #[test]
    fn a_surface_too_short_is_as_far_off_as_one_too_long() {
        for (surface_m, is_within) in [(2.6, false), (2.75, true), (3.25, true), (3.4, false)] {
            let mut scores = RoadEdgeScores::default();
            let surface = surface_aside(|aside_m| Some(if aside_m < surface_m { 0.9 } else { 0.1 }));
            scores.add_edge(3.0, &surface);
            assert_eq!(scores.within, u64::from(is_within), "{surface_m}: {surface:?}");
            assert_eq!(scores.missed, 0);
        }
    }

    #[test]
    fn a_hidden_edge_does_not_count() {
        let by_a_vehicle = |[forward_m, left_m]: [f64; 2]| forward_m > 7.5 && left_m > 0.0;
        let shown = summary_of([3.0, 2.0], by_a_vehicle).unwrap();
        assert_eq!(shown.edges, 9 + 4);
        assert!(summary_of([3.0, 2.0], |_| true).is_none());
    }

    #[test]
    fn an_edge_out_of_view_does_not_count() {
        let right_alone = scores([2.6, 2.0], 3.2, NOTHING).summary().unwrap();
        assert_eq!(right_alone.edges, 9, "the left edge's place is not seen whole");
        assert!(scores([3.0, 2.0], 1.9, NOTHING).summary().is_none());
    }

    #[test]
    fn a_surface_that_goes_on_or_is_not_there_is_not_within() {
        let goes_on = summary_of([9.0, 9.0], NOTHING).unwrap();
        assert_eq!((goes_on.edges, goes_on.missed), (18, 18));
        assert!(goes_on.within_share < 1e-9 && (goes_on.error_m.max - 4.0).abs() < 0.05, "{goes_on:?}");
        let none = summary_of([0.0, 0.0], NOTHING).unwrap();
        assert!(none.within_share < 1e-9 && (none.error_m.max - 3.0).abs() < 0.05, "{none:?}");
    }

    #[test]
    fn beside_the_road_and_where_it_has_no_edge_nothing_counts() {
        let count = |is_road: fn([f64; 2]) -> bool| {
            let mut scores = RoadEdgeScores::default();
            scores.add(&EdgeScene { is_road, is_shown: |_| true, probability: |_| Some(0.9) });
            scores.errors.total()
        };
        assert_eq!(count(|[_, left_m]| left_m > 1.0 && left_m < 4.0), 0, "the axis is beside the road");
        assert_eq!(count(|_| true), 0);
        assert_eq!(count(|[_, left_m]| left_m < 4.0), 9, "a side road to the right");
    }

    #[test]
    fn scores_of_several_drives_add_up() {
        let mut all = scores([3.0, 2.0], 6.0, NOTHING);
        all.extend(&scores([9.0, 9.0], 6.0, NOTHING));
        let all = all.summary().unwrap();
        assert_eq!((all.edges, all.missed), (36, 18));
        assert!((all.within_share - 0.5).abs() < 1e-9);
    }
}
