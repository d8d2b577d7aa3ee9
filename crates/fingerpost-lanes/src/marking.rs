//! What kind of marking an edge belongs to: continuous, broken or double; white or yellow.
//!
//! Paint that is seen, and gaps, are noted along the road; the vehicle's motion carries the notes, so that a line that is
//! seen piece by piece is judged as a whole.

use super::lane_filter::EdgePoint;
use super::paint::PaintEdge;
use super::paint_odds::{BarLooks, LineOdds, PLACE_M};

/// How a marking is painted along the road.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MarkingKind {
    /// One line without gaps.
    Continuous,
    /// One line with gaps.
    Broken,
    /// Two lines beside each other.
    Double,
    /// Too little has been seen.
    #[default]
    Unknown,
}

/// The colour of a marking's paint.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum MarkingColour {
    /// White, or as grey as that is in the light.
    White,
    /// Yellow or orange.
    Yellow,
    /// Not told.
    #[default]
    Unknown,
}

/// A marking.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Marking {
    /// How it is painted.
    pub kind: MarkingKind,
    /// Its colour.
    pub colour: MarkingColour,
}

/// Notes kept: 40 m, some periods of a broken line.
const NOTES: usize = 80;
/// Notes of a frame begin so far behind the vehicle's axle, metres.
const BEHIND_M: f64 = 15.0;
/// Farthest place that is noted, metres: beyond it thin lines drop out.
const FARTHEST_M: f64 = 22.0;
/// Notes needed for a judgement.
const FEWEST_NOTES: usize = 16;
/// Share of the looks at a place that must show paint.
const PAINTED_SHARE: f32 = 0.3;
/// Shares of painted places: a line with more is continuous, one with less than the other is too faint to be judged.
const CONTINUOUS_SHARE: f64 = 0.86;
const BROKEN_SHARE: f64 = 0.1;
/// Distance at which a second line makes a double one, metres between inner edges.
const SECOND_M: [f64; 2] = [0.12, 0.55];
/// Share of the paint that must have a second line beside it.
const DOUBLE_SHARE: f64 = 0.45;
/// Yellowness against brightness from which paint is yellow, and below which it is white.
const YELLOW: f64 = 0.30;
const WHITE: f64 = 0.18;
/// How fast older looks fade, per frame.
const KEPT: f64 = 0.95;
/// Points with paint needed for a colour.
const FEWEST_POINTS: f64 = 6.0;

#[derive(Debug, Clone, Copy, Default)]
struct Note {
    looks: f32,
    paint: f32,
    bar: BarLooks,
}

/// What has been seen of a marking.
#[derive(Debug, Clone)]
pub(super) struct MarkingNotes {
    notes: Vec<Note>,
    /// Distance driven since the first note began, metres.
    driven_m: f64,
    points: f64,
    doubled: f64,
    brightness: f64,
    yellowness: f64,
}

impl Default for MarkingNotes {
    fn default() -> Self {
        Self {
            notes: vec![Note::default(); NOTES],
            driven_m: 0.0,
            points: 0.0,
            doubled: 0.0,
            brightness: 0.0,
            yellowness: 0.0,
        }
    }
}

impl MarkingNotes {
    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        self.notes.fill(Note::default());
        (self.driven_m, self.points, self.doubled) = (0.0, 0.0, 0.0);
        (self.brightness, self.yellowness) = (0.0, 0.0);
    }

    /// The vehicle has moved on.
    pub(super) fn advance(&mut self, forward_m: f64) {
        self.driven_m += forward_m;
        while self.driven_m >= PLACE_M {
            self.driven_m -= PLACE_M;
            self.notes.rotate_left(1);
            if let Some(last) = self.notes.last_mut() {
                *last = Note::default();
            }
        }
        for total in [&mut self.points, &mut self.doubled, &mut self.brightness, &mut self.yellowness] {
            *total *= KEPT;
        }
    }

    /// A place on the edge has been looked at; `px_per_m` is the picture's scale across the lane there.
    pub(super) fn note(&mut self, ahead_m: f64, paint: Option<&PaintEdge>, px_per_m: f64) {
        let index = (ahead_m + self.driven_m + BEHIND_M) / PLACE_M;
        let within = ahead_m <= FARTHEST_M && index >= 0.0;
        if let Some(note) = self.notes.get_mut(index as usize).filter(|_| within) {
            note.looks += 1.0;
            note.paint += if paint.is_some() { 1.0 } else { 0.0 };
        }
        let Some(paint) = paint.filter(|_| ahead_m <= FARTHEST_M) else { return };
        self.points += 1.0;
        self.brightness += paint.step;
        self.yellowness += paint.yellowness();
        let second = |px: f64| (SECOND_M[0]..=SECOND_M[1]).contains(&(px / px_per_m));
        if paint.second_px.is_some_and(second) {
            self.doubled += 1.0;
        }
    }

    /// Paint lies on the edge at a place; `point` is what the fit made of it.
    pub(super) fn note_bar(&mut self, ahead_m: f64, paint: &PaintEdge, px_per_m: f64, point: &EdgePoint) {
        let index = (ahead_m + self.driven_m + BEHIND_M) / PLACE_M;
        let within = ahead_m <= FARTHEST_M && index >= 0.0;
        if let Some(note) = self.notes.get_mut(index as usize).filter(|_| within) {
            note.bar.merge(&BarLooks::at(paint, px_per_m, point));
        }
    }

    /// Logarithm of the odds that the line is painted, by all that has been seen.
    pub(super) fn log_odds(&self) -> f64 {
        let mut line = LineOdds::default();
        for (place, note) in self.notes.iter().enumerate().filter(|(_, note)| note.bar.is_seen()) {
            line.add(place, &note.bar, f64::from(note.looks));
        }
        line.log_odds()
    }

    /// What the marking is by all that has been seen.
    pub(super) fn marking(&self) -> Marking {
        Marking { kind: self.kind(), colour: self.colour() }
    }

    fn kind(&self) -> MarkingKind {
        let looked = self.notes.iter().filter(|note| note.looks > 0.0);
        let (count, painted) = looked.fold((0_usize, 0_usize), |(count, painted), note| {
            (count + 1, painted + usize::from(note.paint >= PAINTED_SHARE * note.looks))
        });
        if count < FEWEST_NOTES {
            return MarkingKind::Unknown;
        }
        let share = painted as f64 / count as f64;
        if self.points >= FEWEST_POINTS && self.doubled >= DOUBLE_SHARE * self.points {
            MarkingKind::Double
        } else if share >= CONTINUOUS_SHARE {
            MarkingKind::Continuous
        } else if share >= BROKEN_SHARE {
            MarkingKind::Broken
        } else {
            MarkingKind::Unknown
        }
    }

    fn colour(&self) -> MarkingColour {
        let share = self.yellowness / self.brightness.max(1e-9);
        if self.points < FEWEST_POINTS {
            MarkingColour::Unknown
        } else if share > YELLOW {
            MarkingColour::Yellow
        } else if share < WHITE {
            MarkingColour::White
        } else {
            MarkingColour::Unknown
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::paint::PaintSides;

    fn paint(yellowness: f64, second_px: Option<f64>) -> PaintEdge {
        let road = [90.0; 3];
        let sides = PaintSides { inside: road, paint: [190.0, 190.0, 190.0 - yellowness], outside: road };
        PaintEdge { u: 0.0, width_px: 8.0, step: 100.0, second_px, sides }
    }

    /// A drive of 60 m past a line that is painted where `painted` says, looked at from 5 to 20 m ahead.
    fn driven(painted: impl Fn(f64) -> bool, paint: &PaintEdge) -> Marking {
        let mut notes = MarkingNotes::default();
        for frame in 0..60 {
            notes.advance(1.0);
            for step in 0..31 {
                let ahead_m = 5.0 + 0.5 * f64::from(step);
                let seen = painted(f64::from(frame) + ahead_m);
                notes.note(ahead_m, seen.then_some(paint), 60.0);
            }
        }
        notes.marking()
    }

    #[test]
    fn lines_without_gaps_are_continuous_and_dashes_broken() {
        let white = paint(2.0, None);
        let continuous = driven(|_| true, &white);
        assert_eq!(continuous, Marking { kind: MarkingKind::Continuous, colour: MarkingColour::White });
        let broken = driven(|along| along.rem_euclid(12.0) < 3.0, &white);
        assert_eq!(broken.kind, MarkingKind::Broken);
        assert_eq!(driven(|_| false, &white), Marking::default());
    }

    #[test]
    fn a_second_line_makes_a_double_one_and_yellow_is_told() {
        let double = driven(|_| true, &paint(70.0, Some(15.0)));
        assert_eq!(double, Marking { kind: MarkingKind::Double, colour: MarkingColour::Yellow });
        // A line a metre further out is another lane's.
        assert_eq!(driven(|_| true, &paint(0.0, Some(60.0))).kind, MarkingKind::Continuous);
    }
}
