//! Which crossings are neighbours on a board.
//!
//! Neighbours lie along each other's edges, exchange light and dark, and have one edge all the way between them. The last
//! tells a neighbour from the one three squares on, the second from the one two squares on.

use std::f64::consts::PI;

use crate::picture::PlaneView;

use super::crossing::Crossing;
use super::subpixel::brightness;

/// Farthest that a neighbour lies beside an edge's direction, radians: what ring and lens leave of its precision, 12 degrees.
const ASIDE_RAD: f64 = PI / 15.0;
/// Where between two crossings the edge is looked at, as shares of the way.
const LOOKS: [f64; 3] = [0.3, 0.5, 0.7];
/// How far to either side of the edge, as a share of the way, and at the most in pixels.
const ASIDE_SHARE: f64 = 0.15;
const MOST_ASIDE_PX: f64 = 6.0;
/// Least difference across the edge, as a share of the weaker crossing's contrast.
const LEAST_STEP: f64 = 0.4;

/// For each crossing, its neighbour along each of [`Crossing::directions_rad`].
pub(super) type Links = Vec<[Option<usize>; 4]>;

/// The links of neighbours that hold both ways.
pub(super) fn links(grey: PlaneView<'_, u8>, crossings: &[Crossing]) -> Links {
    let one_way: Links = (0..crossings.len()).map(|from| nearest(grey, crossings, from)).collect();
    let holds = |from: usize, to: usize| one_way[to].contains(&Some(from));
    let both_ways = one_way.iter().enumerate();
    both_ways.map(|(from, links)| links.map(|to| to.filter(|&to| holds(from, to)))).collect()
}

fn nearest(grey: PlaneView<'_, u8>, crossings: &[Crossing], from: usize) -> [Option<usize>; 4] {
    let here = &crossings[from];
    let mut best: [Option<(f64, usize)>; 4] = [None; 4];
    for (to, there) in crossings.iter().enumerate() {
        let (right, down) = (there.at[0] - here.at[0], there.at[1] - here.at[1]);
        let (way_px, heading_rad) = (libm::hypot(right, down), libm::atan2(down, right));
        let along =
            here.directions_rad().into_iter().position(|edge| turn(edge, heading_rad, 2.0 * PI) < ASIDE_RAD);
        let Some(direction) = along.filter(|_| to != from) else { continue };
        if best[direction].is_none_or(|(least_px, _)| way_px < least_px)
            && there.edges_rad.iter().any(|&edge| turn(edge, heading_rad, PI) < ASIDE_RAD)
            && here.is_opposite(there)
            && edge_between(grey, here, there)
        {
            best[direction] = Some((way_px, to));
        }
    }
    best.map(|found| found.map(|(_, to)| to))
}

/// Angle between two directions that are the same after `period` radians.
fn turn(a: f64, b: f64, period: f64) -> f64 {
    let difference = (a - b).rem_euclid(period);
    difference.min(period - difference)
}

/// Whether one edge leads from one crossing to the other, light on the same side throughout.
fn edge_between(grey: PlaneView<'_, u8>, a: &Crossing, b: &Crossing) -> bool {
    let way = [b.at[0] - a.at[0], b.at[1] - a.at[1]];
    let way_px = libm::hypot(way[0], way[1]);
    let aside = (ASIDE_SHARE * way_px).min(MOST_ASIDE_PX) / way_px;
    let least = LEAST_STEP * a.contrast.min(b.contrast);
    let step = |share: f64| {
        let [u, v] = [a.at[0] + share * way[0], a.at[1] + share * way[1]];
        let left = brightness(grey, [u + aside * way[1], v - aside * way[0]])?;
        let right = brightness(grey, [u - aside * way[1], v + aside * way[0]])?;
        Some(left - right)
    };
    let steps = LOOKS.map(|share| step(share).unwrap_or(0.0));
    steps.iter().all(|&step| step >= least) || steps.iter().all(|&step| step <= -least)
}
