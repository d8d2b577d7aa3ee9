//! The stage: a frame in, the lane out.

use fingerpost_geometry::Camera;

use super::edges::{LaneEdges, LaneError};
use super::lane_filter::{LaneFilter, LaneMotion};
use super::marking::MarkingNotes;
use super::road_view::RoadView;
use super::sections::{LineCandidate, LineVerdict, SectionLines};
use super::shape::EdgeShape;
use super::tracing::{PaintLook, Quality, Reach, Tracer};
use super::{Lane, LaneEvidence, LaneInput, LanesConfig, Side};

/// Candidates of a side that are tried in a frame while no edge is followed there.
const TRIALS: usize = 3;
/// How far a candidate's first guess may be off, metres.
const SEED_SIGMA_M: f64 = 0.15;
/// How well the place of a line inside another is known when it is first seen, metres.
const INNER_SIGMA_M: f64 = 0.03;
/// What a new edge must show: paint over a length, in rows, near the fit, of an even width.
const NEW_PAINTED_M: f64 = 2.5;
const NEW_NEAR_M: f64 = 1.2;
const NEW_ROWS: usize = 9;
const MOST_RESIDUAL_SIGMAS: f64 = 1.5;
const MOST_WIDTH_SPREAD: f64 = 0.45;
/// Rows with paint off the fit against those on it, at most.
const MOST_OUTLIERS: f64 = 0.6;
/// An edge that makes no lane with the other replaces it where it shows more than so many times its rows.
const STRONGER: usize = 2;
/// Share of the rows with paint that a motion must keep.
const LOST_SHARE: f64 = 0.5;
/// Frames without any paint after which an edge is looked for anew, while it is still kept.
const MISSED_FRAMES: u32 = 2;
/// Edges with so much paint together are given out at once, metres.
const CLEAR_PAINTED_M: f64 = 6.0;
/// What a followed edge must show in a frame to count as seen.
const SEEN_NEAR_M: f64 = 0.6;
const SEEN_ROWS: usize = 4;
/// Frames in which a line elsewhere must be the better one before it replaces the edge that is followed.
const RIVAL_FRAMES: u32 = 5;
/// How far off a rival is, metres.
const RIVAL_M: f64 = 0.5;
/// The vehicle's middle must be so far across an edge before it becomes the other side's, metres.
const CROSSED_M: f64 = 0.1;

/// How an edge is followed.
#[derive(Debug, Default)]
struct Followed {
    active: bool,
    /// Frames in a row that showed it, and frames since one did.
    seen_frames: u32,
    kept_frames: u32,
    shown: bool,
    rival_frames: u32,
    quality: Quality,
    /// What its paint looks like.
    look: PaintLook,
    notes: MarkingNotes,
}

impl Followed {
    fn forget(&mut self) {
        self.active = false;
        self.shown = false;
        self.quality = Quality::default();
        self.look = PaintLook::default();
        (self.seen_frames, self.kept_frames, self.rival_frames) = (0, 0, 0);
        self.notes.clear();
    }
}

/// The vehicle's motion as it was last known.
#[derive(Debug, Clone, Copy)]
struct HeldMotion {
    speed_mps: f64,
    yaw_rate_rps: f64,
    age_s: f64,
}

/// A candidate that bounds paint.
#[derive(Debug, Clone, Copy)]
struct Painted {
    index: usize,
    /// Sum of the steps in its rows, levels.
    paint: f64,
    /// How far beside the vehicle it passes, metres.
    beside_m: f64,
}

/// A lane that a candidate leads to.
struct Trial {
    filter: LaneFilter,
    quality: Quality,
    look: PaintLook,
}

/// Finds and follows the lane.
#[derive(Debug)]
pub struct LaneFinder {
    config: LanesConfig,
    edges: LaneEdges,
    lines: SectionLines,
    tracer: Tracer,
    filter: LaneFilter,
    followed: [Followed; 2],
    evidence: LaneEvidence,
    shape: EdgeShape,
    held: Option<HeldMotion>,
    painted: Vec<Painted>,
}

impl LaneFinder {
    /// A finder that has seen no frame yet.
    ///
    /// # Errors
    /// [`LaneError`] when the kernels cannot be set up as configured.
    pub fn new(config: &LanesConfig) -> Result<Self, LaneError> {
        Ok(Self {
            config: config.clone(),
            edges: LaneEdges::new(config)?,
            lines: SectionLines::new()?,
            tracer: Tracer::default(),
            filter: LaneFilter::new(),
            followed: Default::default(),
            evidence: LaneEvidence::default(),
            shape: EdgeShape::default(),
            held: None,
            painted: Vec::new(),
        })
    }

    /// Takes a frame in and sets `lane`, whose memory is used again.
    ///
    /// # Errors
    /// [`LaneError`] when the frame has not the camera's size.
    pub fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        let lane = lane.get_or_insert_default();
        let before = self.filter.clone();
        self.predict(input);
        let Self { config, edges, lines, tracer, filter, evidence, .. } = self;
        evidence.region.lay(config, camera, filter.pitch_rad(), input.vehicle.speed_mps);
        let view = RoadView::new(camera, filter.pitch_rad());
        let curvature =
            input.vehicle.yaw_rate_rps.zip(input.vehicle.speed_mps).filter(|(_, speed)| *speed > SLOWEST_MPS);
        let curvature_per_m = curvature.map_or(0.0, |(yaw_rate, speed)| yaw_rate / speed);
        edges.find(config, &evidence.region, &view, curvature_per_m, input.frame)?;
        lines.find(config, &evidence.region, &view, edges.thin());
        tracer.lay_rows(&evidence.region);

        self.follow(camera, input, before);
        for side in Side::BOTH {
            self.acquire(camera, input, side);
        }
        self.exchange_crossed();
        self.judge(input);

        self.evidence.candidates.clear();
        self.evidence.candidates.extend_from_slice(self.lines.candidates());
        self.evidence.pitch_rad = self.filter.pitch_rad();
        self.evidence.followed = [0, 1].map(|side| self.followed[side].active);
        for side in Side::BOTH {
            let followed = &self.followed[side.index()];
            lane.shown[side.index()] = followed.shown;
            if followed.shown {
                let edge = &mut lane.edges[side.index()];
                edge.marking = followed.notes.marking();
                edge.kept_frames = followed.kept_frames;
                self.shape.give_out(camera, &self.filter, &self.evidence.region, side, edge);
            }
        }
        Ok(&self.evidence)
    }

    /// Forgets the frames before, as at the start of a drive.
    pub fn reset(&mut self) {
        self.edges.clear();
        self.filter = LaneFilter::new();
        self.held = None;
        self.followed.iter_mut().for_each(Followed::forget);
    }

    fn predict(&mut self, input: &LaneInput<'_>) {
        let dt_s = input.dt_s.unwrap_or(0.0);
        match input.vehicle.speed_mps.zip(input.vehicle.yaw_rate_rps) {
            Some((speed_mps, yaw_rate_rps)) => {
                self.held = Some(HeldMotion { speed_mps, yaw_rate_rps, age_s: 0.0 });
            }
            // A motion that fails for a moment goes on as it was.
            None => {
                self.held.iter_mut().for_each(|held| held.age_s += dt_s);
                self.held = self.held.filter(|held| held.age_s <= MOST_HELD_S);
            }
        }
        let forward_m = self.held.map(|held| dt_s * held.speed_mps);
        let yaw_rad = self.held.map(|held| dt_s * held.yaw_rate_rps);
        self.filter.predict(&LaneMotion { dt_s: input.dt_s, forward_m, yaw_rad });
        for followed in &mut self.followed {
            followed.notes.advance(forward_m.unwrap_or(0.0));
        }
    }

    /// Reads the edges that are followed; `before` is the lane without the vehicle's motion.
    fn follow(&mut self, camera: &Camera, input: &LaneInput<'_>, mut before: LaneFilter) {
        self.evidence.traced.clear();
        self.shape.clear();
        let mut sides = [Side::Left; 2];
        let mut count = 0;
        for side in Side::BOTH.into_iter().filter(|side| self.followed[side.index()].active) {
            sides[count] = side;
            count += 1;
        }
        let sides = &sides[..count];
        if sides.is_empty() {
            return;
        }
        let was: usize = sides.iter().map(|side| self.followed[side.index()].quality.used).sum();
        let rows = self.read(camera, input, &self.filter.clone(), sides);
        // A motion that loses the paint which was there is wrong: then the lane goes on as it was.
        if self.held.is_some() && was >= NEW_ROWS && (rows as f64) < LOST_SHARE * was as f64 {
            before.predict(&LaneMotion { dt_s: input.dt_s, forward_m: None, yaw_rad: None });
            if self.read(camera, input, &before, sides) > rows {
                self.filter = before;
                self.held = None;
            } else {
                self.read(camera, input, &self.filter.clone(), sides);
            }
        }
        for &side in sides {
            let followed = &mut self.followed[side.index()];
            followed.look = self.tracer.look(side, followed.look);
        }
        let looks = [0, 1].map(|side| self.followed[side].look);
        self.tracer.fit(camera, &mut self.filter, sides, looks);
        self.tracer.evidence(sides, &mut self.evidence.traced);
        for &side in sides {
            let quality = self.tracer.quality(camera, &self.filter, side);
            self.note_quality(side, quality);
            self.shape.note(camera, &self.filter, side, self.tracer.points());
        }
        for &side in sides {
            self.step_inside(camera, input, side);
        }
    }

    /// Goes over to the inner line of a double marking.
    fn step_inside(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side) {
        let look = self.followed[side.index()].look;
        let inside_m = self.tracer.inner_line_m(camera, &self.filter, input.frame, side, look.step);
        let Some(inside_m) = inside_m else { return };
        let look = PaintLook { second_m: Some(inside_m), ..look };
        self.followed[side.index()].look = look;
        let offset_m = self.filter.offset_m(side) + side.outward() * inside_m;
        self.filter.place_edge(side, offset_m, INNER_SIGMA_M);
        self.tracer.read(camera, &self.filter, input.frame, side, Reach::Follow(look));
        self.tracer.drop_unlike(side, &mut self.followed[side.index()].look);
        self.tracer.fit(camera, &mut self.filter, &[side], [look; 2]);
        self.shape.note(camera, &self.filter, side, self.tracer.points());
    }

    /// Reads `sides` where a filter expects them; the rows that show their paint.
    fn read(&mut self, camera: &Camera, input: &LaneInput<'_>, filter: &LaneFilter, sides: &[Side]) -> usize {
        let mut rows = 0;
        for &side in sides {
            let look = &mut self.followed[side.index()].look;
            self.tracer.read(camera, filter, input.frame, side, Reach::Follow(*look));
            self.tracer.drop_unlike(side, look);
            rows += self.tracer.readings[side.index()].iter().filter(|r| r.paint.is_some()).count();
        }
        rows
    }

    fn note_quality(&mut self, side: Side, quality: Quality) {
        let followed = &mut self.followed[side.index()];
        followed.quality = quality;
        for reading in &self.tracer.readings[side.index()] {
            followed.notes.note(reading.ahead_m, reading.paint.as_ref(), reading.px_per_m);
        }
        if quality.used >= SEEN_ROWS && quality.near_m >= SEEN_NEAR_M {
            followed.seen_frames += 1;
            followed.kept_frames = 0;
        } else {
            followed.seen_frames = 0;
            followed.kept_frames += 1;
        }
    }

    /// Looks for an edge where none is followed, or where a better one shows.
    fn acquire(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side) {
        let followed = &self.followed[side.index()];
        if followed.active && followed.kept_frames < MISSED_FRAMES {
            let rival = self.lines.candidates().iter().position(|c| {
                c.side == side && c.section == 0 && c.verdict == LineVerdict::Kept && self.is_rival(camera, c)
            });
            let followed = &mut self.followed[side.index()];
            followed.rival_frames = if rival.is_some() { followed.rival_frames + 1 } else { 0 };
            if let Some(index) = rival.filter(|_| followed.rival_frames >= RIVAL_FRAMES) {
                followed.rival_frames = 0;
                self.try_candidate(camera, input, side, index);
            }
            return;
        }
        // Those that bound paint, the innermost first.
        let view = RoadView::new(camera, self.filter.pitch_rad());
        self.painted.clear();
        for (index, candidate) in self.lines.candidates().iter().enumerate() {
            let possible = !matches!(candidate.verdict, LineVerdict::Direction | LineVerdict::Distance);
            if candidate.side == side && possible {
                let paint = self.tracer.paint_along(&view, input.frame, candidate);
                let beside_m = beside_m(&view, candidate);
                self.painted.extend(beside_m.map(|beside_m| Painted { index, paint, beside_m }));
            }
        }
        let most = self.painted.iter().map(|candidate| candidate.paint).fold(0.0, f64::max);
        self.painted.retain(|candidate| candidate.paint > PAINT_SHARE * most);
        self.painted.sort_by(|a, b| a.beside_m.total_cmp(&b.beside_m).then(a.index.cmp(&b.index)));
        for trial in 0..TRIALS.min(self.painted.len()) {
            if self.try_candidate(camera, input, side, self.painted[trial].index) {
                return;
            }
        }
    }

    fn is_rival(&self, camera: &Camera, candidate: &LineCandidate) -> bool {
        let view = RoadView::new(camera, self.filter.pitch_rad());
        view.ground_of_pixel(candidate.lower_px)
            .is_some_and(|place| (place.y - self.filter.left_at(candidate.side, place.x)).abs() > RIVAL_M)
    }

    /// Fits a lane through a candidate and keeps it where it is one of paint.
    fn try_candidate(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side, index: usize) -> bool {
        let candidate = self.lines.candidates()[index];
        let Some(trial) = self.trial(camera, input, &candidate) else {
            self.lines.candidates_mut()[index].verdict = LineVerdict::NoPaint;
            return false;
        };
        self.filter = trial.filter;
        let width_m = self.filter.offset_m(Side::Left) - self.filter.offset_m(Side::Right);
        if !(self.config.min_width_m..=self.config.max_width_m).contains(&width_m) {
            self.followed[side.other().index()].forget();
        }
        let followed = &mut self.followed[side.index()];
        followed.forget();
        followed.active = true;
        followed.look = trial.look;
        self.lines.candidates_mut()[index].verdict = LineVerdict::Kept;
        self.tracer.evidence(&[side], &mut self.evidence.traced);
        self.note_quality(side, trial.quality);
        self.shape.note(camera, &self.filter, side, self.tracer.points());
        self.step_inside(camera, input, side);
        true
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
        let along = guess.left_at(side, near.x) - guess.offset_m(side);
        guess.place_edge(side, near.y - along, SEED_SIGMA_M);
        let mut straight = guess.clone();
        self.tracer.read(camera, &guess, input.frame, side, Reach::Seed);
        let mut look = self.tracer.look(side, PaintLook::default());
        self.tracer.drop_unlike(side, &mut look);
        self.tracer.fit(camera, &mut straight, &[side], [look; 2]);
        // Once more where the first fit says, for what the straight guess had missed.
        let mut settled = guess;
        self.tracer.read(camera, &straight, input.frame, side, Reach::Follow(look));
        let mut look = self.tracer.look(side, PaintLook::default());
        self.tracer.drop_unlike(side, &mut look);
        self.tracer.fit(camera, &mut settled, &[side], [look; 2]);
        let quality = self.tracer.quality(camera, &settled, side);
        let sound = quality.used >= NEW_ROWS
            && quality.painted_m >= NEW_PAINTED_M
            && quality.near_m >= NEW_NEAR_M
            && quality.residual_sigmas <= MOST_RESIDUAL_SIGMAS
            && quality.width_spread <= MOST_WIDTH_SPREAD
            && (quality.outliers as f64) <= MOST_OUTLIERS * quality.used as f64
            && settled.heading_rad().abs() <= 1.5 * self.config.max_heading_deg.to_radians();
        let width_m = settled.offset_m(Side::Left) - settled.offset_m(Side::Right);
        // Of two edges that make no lane the one that is seen far better is right.
        let stronger = quality.used > STRONGER * other.quality.used;
        let fits = !other_known
            || stronger
            || (self.config.min_width_m..=self.config.max_width_m).contains(&width_m);
        let inside = -side.outward() * settled.offset_m(side) <= 1.1 * self.config.max_offset_m;
        (sound && fits && inside).then_some(Trial { filter: settled, quality, look })
    }

    /// An edge that the vehicle has crossed is the other side's now.
    fn exchange_crossed(&mut self) {
        let crossed =
            |side: Side, filter: &LaneFilter| -side.outward() * filter.left_at(side, 0.0) < -CROSSED_M;
        for side in Side::BOTH {
            if self.followed[side.index()].active && crossed(side, &self.filter) {
                self.filter.exchange();
                self.followed.swap(0, 1);
                self.followed[side.index()].forget();
                break;
            }
        }
    }

    /// Decides which edges are given out: not before they have been seen for a while, not long after.
    fn judge(&mut self, input: &LaneInput<'_>) {
        // Two edges that make a lane speak for each other.
        let painted_m: f64 = self.followed.iter().filter(|f| f.active).map(|f| f.quality.painted_m).sum();
        let stands = input.vehicle.speed_mps.is_some_and(|speed| speed.abs() < SLOWEST_MPS);
        for followed in &mut self.followed {
            if !followed.active {
                continue;
            }
            let clear = followed.kept_frames == 0 && painted_m >= CLEAR_PAINTED_M;
            if clear || followed.seen_frames >= self.config.show_frames {
                followed.shown = true;
            }
            // A standing vehicle's lane stays where it is, whatever passes in front.
            if followed.kept_frames > self.config.keep_frames && !stands {
                followed.forget();
            }
        }
    }
}

/// How far outside the vehicle's middle a candidate's straight continuation passes, metres.
fn beside_m(view: &RoadView<'_>, candidate: &LineCandidate) -> Option<f64> {
    let near = view.ground_of_pixel(candidate.lower_px)?;
    let far = view.ground_of_pixel(candidate.upper_px)?;
    let slope = (far.y - near.y) / (far.x - near.x).max(1e-3);
    Some(-candidate.side.outward() * (near.y + (BESIDE_AHEAD_M - near.x) * slope))
}

/// Distance ahead at which candidates are compared, metres.
const BESIDE_AHEAD_M: f64 = 6.0;
/// Share of the most paint that a candidate must bound.
const PAINT_SHARE: f64 = 0.2;
/// How long a motion is held that is not known anew, seconds.
const MOST_HELD_S: f64 = 0.5;
/// Slower vehicles count as standing, m/s.
const SLOWEST_MPS: f64 = 0.3;
