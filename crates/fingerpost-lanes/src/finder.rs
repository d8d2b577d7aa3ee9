//! The stage: a frame in, the lane out.

mod acquisition;
mod motion;

use fingerpost_geometry::Camera;

use self::acquisition::Painted;
use self::motion::HeldMotion;
use super::dash_motion::DashMotion;
use super::edges::{LaneEdges, LaneError, MarkingEdges};
use super::lane_filter::{LaneFilter, LaneMotion};
use super::marking::MarkingNotes;
use super::paint_odds::of_both;
use super::region::LaneRegion;
use super::road_view::RoadView;
use super::sections::{LineSelection, SectionLines};
use super::shape::EdgeShape;
use super::tracing::{PaintLook, Quality, Reach, Tracer};
use super::{Lane, LaneEvidence, LaneInput, LanesConfig, Side};

/// Rows with paint that make an edge a sure one.
const NEW_ROWS: usize = 9;
/// Share of the rows with paint that a motion must keep.
const LOST_SHARE: f64 = 0.5;
/// Frames without any paint after which an edge is looked for anew, while it is still kept.
const MISSED_FRAMES: u32 = 2;
/// Logarithm of the odds of paint at which an edge is given out, 10 to 1 and more, and below whose negative it is none.
const SURE_LOG_ODDS: f64 = std::f64::consts::LN_10;
/// What a followed edge must show in a frame to count as seen.
const SEEN_NEAR_M: f64 = 0.6;
const SEEN_ROWS: usize = 4;
/// The vehicle's middle must be so far across an edge before it becomes the other side's, metres.
const CROSSED_M: f64 = 0.1;

/// Frames in a row that must show a line inside an edge before it is the edge: a patch's border shows for a frame or two.
const INSIDE_FRAMES: u32 = 3;
/// How well the place of a line inside another is known when it is first seen, metres.
const INNER_SIGMA_M: f64 = 0.03;

/// How an edge is followed.
#[derive(Debug, Default)]
struct Followed {
    active: bool,
    /// Frames since one showed it.
    kept_frames: u32,
    /// Frames that showed it in all, where it is now.
    times_seen: u32,
    shown: bool,
    rival_frames: u32,
    inside_frames: u32,
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
        (self.kept_frames, self.times_seen) = (0, 0);
        (self.rival_frames, self.inside_frames) = (0, 0);
        self.notes.clear();
    }
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
    dashes: DashMotion,
}

impl LaneFinder {
    /// A finder that has seen no frame yet.
    ///
    /// # Errors
    /// [`LaneError`] when the kernels cannot be set up as configured.
    pub fn new(config: &LanesConfig) -> Result<Self, LaneError> {
        Ok(Self {
            config: config.clone(),
            edges: LaneEdges::new(config, MarkingEdges::Inner)?,
            lines: SectionLines::new(LineSelection::ForPaint)?,
            tracer: Tracer::default(),
            filter: LaneFilter::new(),
            followed: Default::default(),
            evidence: LaneEvidence::default(),
            shape: EdgeShape::default(),
            held: None,
            painted: Vec::new(),
            dashes: DashMotion::default(),
        })
    }

    /// Takes a frame in and sets `lane`, whose memory is used again.
    ///
    /// # Errors
    /// [`LaneError::Picture`] when the frame has not the camera's size; the finder is then as before the frame.
    pub fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        input.check_size(camera)?;
        let lane = lane.get_or_insert_default();
        let before = self.filter.clone();
        self.predict(input);
        let Self { config, edges, lines, tracer, filter, evidence, .. } = self;
        evidence.region.lay(config, camera, filter.pitch_rad(), input.vehicle.speed_mps);
        let view = RoadView::new(camera, filter.pitch_rad());
        let curvature_per_m = input.way_curvature_per_m();
        edges.find(config, &evidence.region, &view, curvature_per_m, input.frame, &mut evidence.steps)?;
        lines.find(config, &evidence.region, &view, &evidence.steps.thin, |_, _, best| best);
        tracer.lay_rows(&evidence.region);

        self.follow(camera, input, before);
        let had_right = self.followed[1].active;
        for side in Side::BOTH {
            self.acquire(camera, input, side);
        }
        // A line that is now seen on the right speaks for one on the left, too.
        let [has_left, has_right] = [0, 1].map(|side: usize| self.followed[side].active);
        if !has_left && !had_right && has_right {
            self.acquire(camera, input, Side::Left);
        }
        self.look_at_dashes(camera, input);
        self.exchange_crossed();
        self.judge(input);

        self.evidence.candidates.clear();
        self.evidence.candidates.extend_from_slice(self.lines.candidates());
        self.evidence.pitch_rad = self.filter.pitch_rad();
        self.evidence.followed = [0, 1].map(|side| self.followed[side].active);
        for side in Side::BOTH {
            let followed = &self.followed[side.index()];
            if followed.shown {
                let edge = lane.give_out(side);
                edge.marking = followed.notes.marking();
                edge.kept_frames = followed.kept_frames;
                self.shape.give_out(camera, &self.filter, &self.evidence.region, side, edge);
            } else {
                lane.withhold(side);
            }
        }
        Ok(&self.evidence)
    }

    /// Forgets the frames before, as at the start of a drive.
    pub fn reset(&mut self) {
        self.edges.clear();
        self.evidence.region = LaneRegion::default();
        self.filter = LaneFilter::new();
        self.held = None;
        self.dashes = DashMotion::default();
        self.followed.iter_mut().for_each(Followed::forget);
    }

    /// Reads the edges that are followed; `before` is the lane without the vehicle's motion.
    fn follow(&mut self, camera: &Camera, input: &LaneInput<'_>, mut before: LaneFilter) {
        self.evidence.traced.clear();
        self.shape.clear(self.tracer.row_count());
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
            let (dt_s, pitch_change) = (input.dt_s, self.pitch_change(input));
            before.predict(&LaneMotion { dt_s, pitch_change, ..LaneMotion::default() });
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
            let inside_m = self.inner_line_m(camera, input, side);
            let followed = &mut self.followed[side.index()];
            followed.inside_frames = if inside_m.is_some() { followed.inside_frames + 1 } else { 0 };
            if let Some(inside_m) = inside_m.filter(|_| followed.inside_frames >= INSIDE_FRAMES) {
                self.step_inside(camera, input, side, inside_m);
            }
        }
    }

    /// How far inside an edge that has just been read the inner line of a double marking runs, metres.
    fn inner_line_m(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side) -> Option<f64> {
        let step = self.followed[side.index()].look.step;
        self.tracer.inner_line_m(camera, &self.filter, input.frame, side, step)
    }

    /// Goes over to the inner line of a double marking.
    fn step_inside(&mut self, camera: &Camera, input: &LaneInput<'_>, side: Side, inside_m: f64) {
        let followed = &mut self.followed[side.index()];
        (followed.inside_frames, followed.times_seen) = (0, 0);
        let look = PaintLook { second_m: Some(inside_m), ..followed.look };
        followed.look = look;
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
        for (reading, paint, point) in self.tracer.used(side) {
            followed.notes.note_bar(reading.ahead_m, paint, reading.px_per_m, point);
        }
        if quality.used >= SEEN_ROWS && quality.near_m >= SEEN_NEAR_M {
            followed.times_seen += 1;
            followed.kept_frames = 0;
        } else {
            followed.kept_frames += 1;
        }
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

    /// Decides which edges are given out: those that are surely painted by all that has been seen of them up to now, not long after that.
    fn judge(&mut self, input: &LaneInput<'_>) {
        let stands = input.vehicle.stands();
        let odds = of_both([0, 1].map(|side| self.followed[side].notes.log_odds()));
        for (followed, log_odds) in self.followed.iter_mut().zip(odds).filter(|(followed, _)| followed.active)
        {
            // A standing vehicle's lane stays where it is, whatever passes in front.
            followed.shown = log_odds >= SURE_LOG_ODDS || followed.shown && stands;
            if log_odds <= -SURE_LOG_ODDS || followed.kept_frames > self.config.keep_frames && !stands {
                followed.forget();
            }
        }
    }
}
