//! Crossings with their columns and rows.

use std::collections::{BTreeMap, VecDeque};

use crate::picture::PlaneView;

use super::crossing::{Crossing, crossing_near};
use super::links::Links;

/// Steps to the neighbours, clockwise: column to the right, row down, and back.
const STEPS: [(i32, i32); 4] = [(1, 0), (0, 1), (-1, 0), (0, -1)];
/// Farthest that a crossing lies from where its neighbours make it expected, as a share of their distance.
const MOST_OFF: f64 = 0.2;
/// Widest lattice: twice the largest board.
const WIDEST: i32 = 128;

/// Crossings by column and row, which count from anywhere; columns and rows run clockwise one after the other.
#[derive(Debug, Clone, Default)]
pub(super) struct Lattice {
    places: BTreeMap<(i32, i32), Crossing>,
}

impl Lattice {
    /// The lattice of most crossings that links make.
    pub(super) fn largest(crossings: &[Crossing], links: &Links) -> Self {
        let mut seen = vec![false; crossings.len()];
        let mut largest = Self::default();
        for first in 0..crossings.len() {
            if !seen[first] {
                let lattice = Self::from(first, crossings, links, &mut seen);
                if lattice.len() > largest.len() {
                    largest = lattice;
                }
            }
        }
        largest
    }

    /// All crossings that links lead to from one.
    fn from(first: usize, crossings: &[Crossing], links: &Links, seen: &mut [bool]) -> Self {
        let mut places = BTreeMap::from([((0, 0), crossings[first])]);
        seen[first] = true;
        // A crossing's first direction leads along the step with the number `turned`.
        let mut waiting = VecDeque::from([(first, (0, 0), 0)]);
        while let Some((from, (column, row), turned)) = waiting.pop_front() {
            for (direction, to) in links[from].iter().enumerate() {
                let Some(to) = to.filter(|&to| !seen[to]) else { continue };
                let Some(back) = links[to].iter().position(|&link| link == Some(from)) else { continue };
                let step = (direction + turned) % 4;
                let place = (column + STEPS[step].0, row + STEPS[step].1);
                if places.contains_key(&place) || place.0.abs().max(place.1.abs()) > WIDEST / 2 {
                    continue;
                }
                seen[to] = true;
                places.insert(place, crossings[to]);
                // From there, the way back is half a turn from the way here.
                waiting.push_back((to, place, (step + 2 + 4 - back) % 4));
            }
        }
        Self { places }
    }

    pub(super) fn len(&self) -> usize {
        self.places.len()
    }

    /// Place of the crossing in a column and row, pixels.
    pub(super) fn at(&self, place: (i32, i32)) -> Option<[f64; 2]> {
        self.places.get(&place).map(|crossing| crossing.at)
    }

    /// All places, pixels.
    pub(super) fn points(&self) -> impl Iterator<Item = [f64; 2]> + '_ {
        self.places.values().map(|crossing| crossing.at)
    }

    /// First and last column, first and last row; none of an empty lattice.
    pub(super) fn bounds(&self) -> Option<[i32; 4]> {
        let columns = || self.places.keys().map(|&(column, _)| column);
        let rows = || self.places.keys().map(|&(_, row)| row);
        Some([columns().min()?, columns().max()?, rows().min()?, rows().max()?])
    }

    /// With the crossings that it lacks, inside and around, where the picture shows them.
    pub(super) fn completed(mut self, grey: PlaneView<'_, u8>) -> Self {
        while let Some([left, right, top, bottom]) = self.bounds() {
            let before = self.len();
            let margin = i32::from(right - left < WIDEST && bottom - top < WIDEST);
            for row in top - margin..=bottom + margin {
                for column in left - margin..=right + margin {
                    if !self.places.contains_key(&(column, row))
                        && let Some(crossing) = self.looked_for(grey, (column, row))
                    {
                        self.places.insert((column, row), crossing);
                    }
                }
            }
            if self.len() == before {
                break;
            }
        }
        self
    }

    /// The crossing at a place where its neighbours make one expected.
    fn looked_for(&self, grey: PlaneView<'_, u8>, (column, row): (i32, i32)) -> Option<Crossing> {
        STEPS.into_iter().find_map(|(right, down)| {
            let along = |steps: i32| self.places.get(&(column + steps * right, row + steps * down));
            let (next, second) = (along(1)?, along(2)?);
            let ahead = |a: f64, b: f64, third: Option<f64>| match third {
                // Places in perspective run apart or together: the change of their distance goes on.
                Some(c) => 3.0 * a - 3.0 * b + c,
                None => 2.0 * a - b,
            };
            let third = along(3).map(|crossing| crossing.at);
            let expected: [f64; 2] =
                std::array::from_fn(|i| ahead(next.at[i], second.at[i], third.map(|third| third[i])));
            let found = crossing_near(grey, expected)?;
            let off = libm::hypot(found.at[0] - expected[0], found.at[1] - expected[1]);
            let apart = libm::hypot(found.at[0] - next.at[0], found.at[1] - next.at[1]);
            (off < MOST_OFF * apart && found.is_opposite(next)).then_some(found)
        })
    }
}
