//! Map matching: the route that a GPS track was driven on.
//!
//! A hidden Markov model after Newson and Krumm, "Hidden Markov Map Matching Through Noise and Sparseness" (2009): the
//! states are places on roads near each point, the likelier the nearer (Gaussian); a transition is the likelier the
//! closer the driven distance is to the straight-line distance (exponential); Viterbi's algorithm finds the likeliest
//! sequence. States are directed here, so that noise along the road cannot make the route turn round.

use nalgebra::Point2;

use crate::cut::cut;
use crate::path::Path;
use crate::search::{Aim, Leg, OnStep, on_steps, shortest};
use crate::{FeatureOptions, LatLon, RoadGraph, Route, RouteError, Snap};

/// Standard deviation of a track point across the road, metres: a car's receiver between houses, and the map's own
/// error (Newson and Krumm measured 4).
const POINT_SIGMA_M: f64 = 5.0;
/// Scale of the difference of driven and straight distance, metres: the noise of two points and the corners between.
const DETOUR_SCALE_M: f64 = 5.0;
/// Points nearer than this to the last one used say nothing new, metres: two standard deviations.
const SPACING_M: f64 = 10.0;
/// Roads farther than this from a point did not give rise to it, metres: ten standard deviations, past any outlier
/// that is worth following.
const REACH_M: f64 = 50.0;
/// Candidate segments of one point: the nearest ones; more are only found in car parks.
const MOST_CANDIDATES: usize = 12;
/// A track may be this far from roads before it has left the map, metres (single outliers are passed over).
const LONGEST_GAP_M: f64 = 150.0;
/// Driven distances up to this factor of the straight distance, and [`DETOUR_REACH_M`] more, are looked at.
const DETOUR_FACTOR: f64 = 2.0;
/// See [`DETOUR_FACTOR`], metres: round the block between two near points.
const DETOUR_REACH_M: f64 = 100.0;

/// The route that a track was driven on, from its likeliest place on a road at the start to that at the end.
///
/// Up to 150 m of the track that are off every road are passed over; at its ends, too, so the route may be shorter.
///
/// # Errors
/// [`RouteError::TrackTooShort`], [`RouteError::TrackOffRoad`] where the track is off every road for longer than an
/// outlier, [`RouteError::TrackBroken`] where no connected roads follow it, [`RouteError::NoLength`].
pub fn match_track(
    graph: &RoadGraph,
    track: &[LatLon],
    options: &FeatureOptions,
) -> Result<Route, RouteError> {
    let points = candidate_points(graph, track)?;
    if points.len() < 2 {
        return Err(RouteError::TrackTooShort { found: points.len(), spacing_m: SPACING_M });
    }
    let mut columns: Vec<Vec<Arrival>> = vec![points[0].states.iter().map(Arrival::first).collect()];
    for (before, here) in points.iter().zip(&points[1..]) {
        let last = columns.last().map_or(&[][..], Vec::as_slice);
        let next = advance(graph, before, last, here);
        if next.iter().all(|arrival| arrival.cost.is_infinite()) {
            let LatLon { lat_deg, lon_deg } = track[here.index];
            return Err(RouteError::TrackBroken { point: here.index + 1, lat_deg, lon_deg });
        }
        columns.push(next);
    }
    cut(graph, &Path::along(graph, &likeliest(&columns)), options)
}

/// A track point with the places on roads that may have given rise to it.
struct CandidatePoint {
    /// Index in the track.
    index: usize,
    p_in_map: Point2<f64>,
    states: Vec<Candidate>,
}

struct Candidate {
    place: OnStep,
    distance_m: f64,
}

/// The best way of coming to a candidate. The cost is a negative log-likelihood.
struct Arrival {
    cost: f64,
    /// Where the vehicle is then: the candidate, or the place ahead of it where it stood already.
    place: OnStep,
    from: usize,
    leg: Option<Leg>,
}

impl Arrival {
    fn first(candidate: &Candidate) -> Self {
        let cost = point_cost(candidate.distance_m);
        Self { cost, place: candidate.place, from: 0, leg: None }
    }
}

fn point_cost(distance_m: f64) -> f64 {
    0.5 * (distance_m / POINT_SIGMA_M).powi(2)
}

fn candidate_points(graph: &RoadGraph, track: &[LatLon]) -> Result<Vec<CandidatePoint>, RouteError> {
    let mut points: Vec<CandidatePoint> = Vec::new();
    let mut last_used = None;
    let mut gap_m = 0.0;
    let mut gap_from = None;
    for (index, &at) in track.iter().enumerate() {
        let p_in_map = graph.plane().map_from_wgs84(at);
        let is_last = index + 1 == track.len();
        let step_m = last_used.map_or(f64::INFINITY, |last: Point2<f64>| (p_in_map - last).norm());
        if step_m < SPACING_M && !is_last {
            continue;
        }
        last_used = Some(p_in_map);
        let states = candidates(graph, p_in_map);
        if states.is_empty() {
            // The way out to the first such point may be an outlier's leap; the way between them is driven.
            gap_m += if gap_from.is_some() { step_m } else { 0.0 };
            let first = *gap_from.get_or_insert(index);
            if gap_m > LONGEST_GAP_M || is_last && points.is_empty() {
                let LatLon { lat_deg, lon_deg } = track[first];
                return Err(RouteError::TrackOffRoad {
                    point: first + 1,
                    lat_deg,
                    lon_deg,
                    reach_m: REACH_M,
                });
            }
        } else {
            (gap_m, gap_from) = (0.0, None);
            points.push(CandidatePoint { index, p_in_map, states });
        }
    }
    Ok(points)
}

fn candidates(graph: &RoadGraph, p_in_map: Point2<f64>) -> Vec<Candidate> {
    let snaps = graph.within(p_in_map, REACH_M);
    let directed = |snap: &Snap| {
        let distance_m = snap.distance_m;
        on_steps(graph, snap).into_iter().map(move |place| Candidate { place, distance_m })
    };
    snaps.iter().take(MOST_CANDIDATES).flat_map(directed).collect()
}

/// One step of Viterbi's algorithm: the best way of coming to each candidate of `here`.
fn advance(
    graph: &RoadGraph,
    before: &CandidatePoint,
    last: &[Arrival],
    here: &CandidatePoint,
) -> Vec<Arrival> {
    let straight_m = (here.p_in_map - before.p_in_map).norm();
    let aim = Aim::Within(straight_m * DETOUR_FACTOR + DETOUR_REACH_M);
    let goals: Vec<OnStep> = here.states.iter().map(|state| state.place).collect();
    let unreached = |place: &OnStep| Arrival { cost: f64::INFINITY, place: *place, from: 0, leg: None };
    let mut next: Vec<Arrival> = goals.iter().map(unreached).collect();
    for (from, arrival) in last.iter().enumerate() {
        if arrival.cost.is_infinite() {
            continue;
        }
        let legs = shortest(graph, &[arrival.place], &goals, aim);
        for (to, leg) in legs.into_iter().enumerate() {
            let Some(leg) = slip_back(arrival.place, goals[to]).or(leg) else { continue };
            let detour = (leg.length_m - straight_m).abs() / DETOUR_SCALE_M;
            let cost = arrival.cost + detour + point_cost(here.states[to].distance_m);
            if cost < next[to].cost {
                next[to] = Arrival { cost, place: leg.to, from, leg: Some(leg) };
            }
        }
    }
    next
}

/// Standing still, where noise puts the next place a little behind the last one on the same step.
fn slip_back(from: OnStep, to: OnStep) -> Option<Leg> {
    let back_m = from.along_m - to.along_m;
    (from.step == to.step && back_m > 0.0 && back_m < 2.0 * SPACING_M).then(|| Leg {
        steps: vec![from.step],
        from,
        to: from,
        length_m: 0.0,
    })
}

/// The legs of the likeliest sequence, in the order of driving; of equally likely ones the first.
fn likeliest(columns: &[Vec<Arrival>]) -> Vec<Leg> {
    let mut state = columns.last().map_or(0, |column| {
        let best = column.iter().enumerate().min_by(|(_, a), (_, b)| a.cost.total_cmp(&b.cost));
        best.map_or(0, |(index, _)| index)
    });
    let mut legs = Vec::with_capacity(columns.len());
    for column in columns[1..].iter().rev() {
        legs.extend(column[state].leg.clone());
        state = column[state].from;
    }
    legs.reverse();
    legs
}
