//! Looking for an edge where none is followed: lines of the sections that bound paint are tried, a lane is fitted through
//! each, and what shows too little of a marking is not taken.

use fingerpost_geometry::Camera;

use super::{CROSSED_M, LaneFinder, MISSED_FRAMES, NEW_ROWS};
use crate::lane_filter::LaneFilter;
use crate::paint_odds::of_both;
use crate::road_view::RoadView;
use crate::sections::{LineCandidate, LineVerdict};
use crate::tracing::{PaintAlong, PaintLook, Quality, Reach};
use crate::{LaneInput, LanesConfig, Side};

/// Candidates of a side that are tried in a frame while no edge is followed there.
const TRIALS: usize = 3;
/// How far a candidate's first guess may be off, metres.
const SEED_SIGMA_M: f64 = 0.15;
/// What a new edge must show, beside odds that it is rather painted than not: paint over a length, in rows, near the fit, of
/// an even width.
const NEW_PAINTED_M: f64 = 2.5;
const NEW_NEAR_M: f64 = 1.2;
const MOST_RESIDUAL_SIGMAS: f64 = 1.5;
const MOST_WIDTH_SPREAD: f64 = 0.45;
/// Rows with paint off the fit against those on it, at most.
const MOST_OUTLIERS: f64 = 0.6;
/// An edge that makes no lane with the other replaces it where it shows more than so many times its rows.
const STRONGER: usize = 2;
/// A line so near to an edge that is kept is that edge, metres: lanes are wider, and so are the lines of a double marking.
const SAME_M: f64 = 0.3;
/// Frames in which a line elsewhere must be the better one before it replaces the edge that is followed.
const RIVAL_FRAMES: u32 = 5;
/// Frames that must have shown an edge before another line has to last to replace it while it is kept.
const ESTABLISHED_TIMES: u32 = 20;
/// A rival must show at least this part of the rows of the edge that it replaces: a half.
const RIVAL_PART: usize = 2;
/// How far off a rival is, metres.
const RIVAL_M: f64 = 0.5;
/// Distance ahead at which candidates are compared, metres.
const BESIDE_AHEAD_M: f64 = 6.0;
/// Share of the most paint that a candidate must bound.
const PAINT_SHARE: f64 = 0.2;
/// Share from which a candidate's paint is clear, and share of the strongest step in clear ones below which it is faint.
const CLEAR_SHARE: f64 = 0.5;
const FAINT_SHARE: f64 = 0.33;

/// A candidate that bounds paint.
#[derive(Debug, Clone, Copy)]
pub(super) struct Painted {
    index: usize,
    paint: PaintAlong,
    /// How far beside the vehicle it passes, metres.
    beside_m: f64,
}

/// A lane that a candidate leads to.
struct Trial {
    filter: LaneFilter,
    quality: Quality,
    look: PaintLook,
}

/// What became of a candidate.
enum Tried {
    /// It is the edge that is followed now.
    Taken,
    /// It lies beside an edge that has been seen for long and is kept: a light's image in a wet road does not last.
    NotYet,
    /// It bounds no marking.
    NoMarking,
}

impl LaneFinder {
    /// Looks for an edge where none is followed, or where a better one shows.
    pub(super) fn acquire(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side) {
        let followed = &self.followed[side.index()];
        if followed.active && followed.kept_frames < MISSED_FRAMES {
            let rival = self.lines.candidates().iter().position(|c| {
                c.side == side && c.section == 0 && c.verdict == LineVerdict::Kept && self.is_rival(camera, c)
            });
            let followed = &mut self.followed[side.index()];
            followed.rival_frames = if rival.is_some() { followed.rival_frames + 1 } else { 0 };
            if let Some(index) = rival.filter(|_| followed.rival_frames >= RIVAL_FRAMES) {
                let least_rows = followed.quality.used / RIVAL_PART;
                self.try_candidate(camera, input, side, index, least_rows);
                self.followed[side.index()].rival_frames = 0;
            }
            return;
        }
        // Those that bound paint, the innermost first; what is faint beside the others is dirt before it is a line.
        let view = RoadView::new(camera, self.filter.pitch_rad());
        self.painted.clear();
        for (index, candidate) in self.lines.candidates().iter().enumerate() {
            let possible = !matches!(
                candidate.verdict,
                LineVerdict::Direction | LineVerdict::Distance | LineVerdict::Turns
            );
            if candidate.side == side && possible {
                let paint = self.tracer.paint_along(&view, input.frame, candidate);
                let beside_m = beside_m(&view, candidate);
                self.painted.extend(beside_m.map(|beside_m| Painted { index, paint, beside_m }));
            }
        }
        let most = self.painted.iter().map(|candidate| candidate.paint.sum).fold(0.0, f64::max);
        self.painted.retain(|candidate| candidate.paint.sum > PAINT_SHARE * most);
        let clear = self.painted.iter().filter(|candidate| candidate.paint.sum >= CLEAR_SHARE * most);
        let strong_step = clear.map(|candidate| candidate.paint.step()).fold(0.0, f64::max);
        let faint = |candidate: &Painted| candidate.paint.step() < FAINT_SHARE * strong_step;
        self.painted.sort_unstable_by(|a, b| {
            let inner = a.beside_m.total_cmp(&b.beside_m).then(a.index.cmp(&b.index));
            faint(a).cmp(&faint(b)).then(inner)
        });
        let mut rival = false;
        for trial in 0..TRIALS.min(self.painted.len()) {
            match self.try_candidate(camera, input, side, self.painted[trial].index, NEW_ROWS) {
                Tried::Taken => return,
                Tried::NotYet => rival = true,
                Tried::NoMarking => {}
            }
        }
        let followed = &mut self.followed[side.index()];
        followed.rival_frames = if rival { followed.rival_frames + 1 } else { 0 };
    }

    fn is_rival(&self, camera: &Camera, candidate: &LineCandidate) -> bool {
        let view = RoadView::new(camera, self.filter.pitch_rad());
        view.ground_of_pixel(candidate.lower_px)
            .is_some_and(|place| (place.y - self.filter.left_at(candidate.side, place.x)).abs() > RIVAL_M)
    }

    /// Fits a lane through a candidate and keeps it where it is one of paint that shows in so many rows.
    fn try_candidate(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        side: Side,
        index: usize,
        least_rows: usize,
    ) -> Tried {
        let candidate = self.lines.candidates()[index];
        let trial = self.trial(camera, input, &candidate);
        let Some(mut trial) = trial.filter(|trial| trial.quality.used >= least_rows) else {
            self.lines.candidates_mut()[index].verdict = LineVerdict::NoPaint;
            return Tried::NoMarking;
        };
        let followed = &self.followed[side.index()];
        let off_m = trial.filter.offset_m(side) - self.filter.offset_m(side);
        let is_same = followed.active && off_m.abs() <= SAME_M;
        let is_established = followed.active && followed.times_seen >= ESTABLISHED_TIMES;
        if is_established && !is_same && followed.rival_frames + 1 < RIVAL_FRAMES {
            return Tried::NotYet;
        }
        let width_m = trial.filter.offset_m(Side::Left) - trial.filter.offset_m(Side::Right);
        let makes_lane = (self.config.min_width_m..=self.config.max_width_m).contains(&width_m);
        let other = &mut self.followed[side.other().index()];
        if other.active && !makes_lane {
            // The pitch that the other one had led to goes with it.
            other.forget();
            self.filter.forget_lane();
            trial = self.trial(camera, input, &candidate).unwrap_or(trial);
        }
        self.filter = trial.filter;
        let followed = &mut self.followed[side.index()];
        // What is known of an edge that is seen again is known of it still.
        if !is_same {
            followed.forget();
        }
        (followed.active, followed.look, followed.rival_frames) = (true, trial.look, 0);
        self.lines.candidates_mut()[index].verdict = LineVerdict::Kept;
        self.tracer.evidence(&[side], &mut self.evidence.traced);
        self.note_quality(side, trial.quality);
        self.shape.note(camera, &self.filter, side, self.tracer.points());
        // Inside an edge that is seen again a line has to last, as inside one that is followed.
        if !is_same && let Some(inside_m) = self.inner_line_m(camera, input, side) {
            self.step_inside(camera, input, side, inside_m);
        }
        Tried::Taken
    }

    fn trial(&mut self, camera: &Camera, input: &LaneInput<'_>, candidate: &LineCandidate) -> Option<Trial> {
        let side = candidate.side;
        let view = RoadView::new(camera, self.filter.pitch_rad());
        let (near, far) =
            (view.ground_of_pixel(candidate.lower_px)?, view.ground_of_pixel(candidate.upper_px)?);
        let mut guess = self.filter.clone();
        let heading = (far.y - near.y) / (far.x - near.x).max(1e-3);
        let other = &self.followed[side.other().index()];
        let other_known = other.active && other.kept_frames < MISSED_FRAMES;
        if !other_known {
            guess.place_direction(heading);
        }
        let bend_m = guess.left_at(side, near.x) - guess.offset_m(side);
        guess.place_edge(side, near.y - bend_m, SEED_SIGMA_M);
        let off_m = guess.offset_m(side) - self.filter.offset_m(side);
        let is_kept = self.followed[side.index()].active && off_m.abs() < SAME_M;
        let mut along = guess.clone();
        self.tracer.read(camera, &guess, input.frame, side, Reach::Seed);
        let mut look = self.tracer.look(side, PaintLook::default());
        self.tracer.drop_unlike(side, &mut look);
        self.tracer.fit(camera, &mut along, &[side], [look; 2]);
        // Once more where the first fit says, for what the straight guess had missed.
        // What is known of an edge that is seen again stays known.
        let mut settled = if is_kept { self.filter.clone() } else { guess };
        self.tracer.read(camera, &along, input.frame, side, Reach::Follow(look));
        let mut look = self.tracer.look(side, PaintLook::default());
        self.tracer.drop_unlike(side, &mut look);
        self.tracer.fit(camera, &mut settled, &[side], [look; 2]);
        let quality = self.tracer.quality(camera, &settled, side);
        let taken = is_sound(&self.config, &settled, &quality)
            && self.is_rather_paint(&quality, side)
            && self.makes_lane(&settled, &quality, side);
        taken.then_some(Trial { filter: settled, quality, look })
    }

    /// Whether a new edge is rather painted than not, by what it shows and by the other one.
    fn is_rather_paint(&self, quality: &Quality, side: Side) -> bool {
        let mut log_odds = [quality.log_odds; 2];
        log_odds[side.other().index()] = self.followed[side.other().index()].notes.log_odds();
        of_both(log_odds)[side.index()] >= 0.0
    }

    /// Whether a new edge is beside the vehicle and makes a lane with the other one, or is the one of both that is right.
    fn makes_lane(&self, settled: &LaneFilter, quality: &Quality, side: Side) -> bool {
        let other = &self.followed[side.other().index()];
        let other_known = other.active && other.kept_frames < MISSED_FRAMES;
        let width_m = settled.offset_m(Side::Left) - settled.offset_m(Side::Right);
        // Of two edges that make no lane the one that is seen far better is right.
        let stronger = quality.used > STRONGER * other.quality.used;
        let fits = !other_known
            || stronger
            || (self.config.min_width_m..=self.config.max_width_m).contains(&width_m);
        // An edge across the vehicle's middle is the other side's.
        let beside_m = -side.outward() * settled.offset_m(side);
        fits && (-CROSSED_M..=1.1 * self.config.max_offset_m).contains(&beside_m)
    }
}

/// Whether what was read along a new edge is a marking's paint.
fn is_sound(config: &LanesConfig, settled: &LaneFilter, quality: &Quality) -> bool {
    quality.used >= NEW_ROWS
        && quality.painted_m >= NEW_PAINTED_M
        && quality.near_m >= NEW_NEAR_M
        && quality.residual_sigmas <= MOST_RESIDUAL_SIGMAS
        && quality.width_spread <= MOST_WIDTH_SPREAD
        && (quality.outliers as f64) <= MOST_OUTLIERS * quality.used as f64
        && settled.heading_rad().abs() <= 1.5 * config.max_heading_deg.to_radians()
}

/// How far outside the vehicle's middle a candidate's straight continuation passes, metres.
fn beside_m(view: &RoadView<'_>, candidate: &LineCandidate) -> Option<f64> {
    let near = view.ground_of_pixel(candidate.lower_px)?;
    let far = view.ground_of_pixel(candidate.upper_px)?;
    let slope = (far.y - near.y) / (far.x - near.x).max(1e-3);
    Some(-candidate.side.outward() * (near.y + (BESIDE_AHEAD_M - near.x) * slope))
}
