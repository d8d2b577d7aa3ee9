//! Paper 3's own tracker: the lane's edges as lines of the picture's sections, kept from frame to frame, and a spline through them.
//!
//! Paper 3, III-C. In each section and on either side the four most voted lines are candidates, of both edges of a marking; the one
//! with the largest inner angle, the innermost, is the edge. A section without a valid line keeps its last one for n frames, but
//! the uppermost, whose place is not drawn then (the paper's indicator). A side of which nothing has been valid for longer is
//! lost until it has been valid several frames in a row. The paper also stops while the driver changes lanes on purpose;
//! as its figure 19 has it, the lane goes on being found and the warning alone is silent (`fingerpost_lanes::departure`).
//!
//! Nothing here knows paint, the lane's width or the camera's pitch: what bounds no marking is taken for one where it leads the
//! same way.

mod road_edge;

use fingerpost_geometry::{Camera, Pchip};
use fingerpost_lanes::{
    Lane, LaneDetector, LaneEdges, LaneError, LaneEvidence, LaneInput, LaneRegion, LanesConfig,
    LineCandidate, LineSelection, Marking, MarkingEdges, RoadView, SectionLines, Side, lay_points,
};

use self::road_edge::RoadEdge;

/// Frames in a row with a valid line after which a side that was lost is given out again: the paper's "successive sequence";
/// number ours.
const SHOWN_AGAIN_AFTER_FRAMES: u32 = 3;

/// The last valid line of a section and how many frames ago that was.
#[derive(Debug, Clone, Copy, Default)]
struct SectionLine {
    line: Option<LineCandidate>,
    kept_frames: u32,
}

impl SectionLine {
    /// Takes a frame's line in, or keeps the last one for so many frames.
    fn take(&mut self, found: Option<LineCandidate>, most_frames: u32) {
        match found {
            Some(_) => *self = Self { line: found, kept_frames: 0 },
            None => {
                self.kept_frames = self.kept_frames.saturating_add(1);
                self.line = self.line.filter(|_| self.kept_frames <= most_frames);
            }
        }
    }
}

/// An edge as it is tracked.
#[derive(Debug, Default)]
struct TrackedEdge {
    /// One a section, the lowest first.
    sections: Vec<SectionLine>,
    /// Frames in a row with a valid line, and those since the last one.
    valid_frames: u32,
    missed_frames: u32,
    /// Nothing was valid for too long, and no successive sequence has come since.
    is_lost: bool,
}

impl TrackedEdge {
    /// Decides whether the edge is given out.
    fn judge(&mut self, most_frames: u32) {
        let is_valid = self.sections.iter().any(|section| section.line.is_some() && section.kept_frames == 0);
        if is_valid {
            (self.valid_frames, self.missed_frames) = (self.valid_frames.saturating_add(1), 0);
        } else {
            (self.valid_frames, self.missed_frames) = (0, self.missed_frames.saturating_add(1));
        }
        self.is_lost |= self.missed_frames > most_frames;
        self.is_lost &= self.valid_frames < SHOWN_AGAIN_AFTER_FRAMES;
    }

    fn forget(&mut self) {
        self.sections.iter_mut().for_each(|section| *section = SectionLine::default());
        (self.valid_frames, self.missed_frames, self.is_lost) = (0, 0, false);
    }
}

/// Finds the lane as paper 3 does.
#[derive(Debug)]
pub struct SectionTracker {
    config: LanesConfig,
    edges: LaneEdges,
    lines: SectionLines,
    tracked: [TrackedEdge; 2],
    evidence: LaneEvidence,
    /// Columns over rows, from the far end down.
    knots: Vec<[f64; 2]>,
    spline: Pchip,
}

impl SectionTracker {
    /// A tracker that has seen no frame yet.
    ///
    /// # Errors
    /// [`LaneError`] when the kernels cannot be set up as configured.
    pub fn new(config: &LanesConfig) -> Result<Self, LaneError> {
        let tracked =
            || TrackedEdge { sections: vec![SectionLine::default(); config.sections], ..Default::default() };
        Ok(Self {
            config: config.clone(),
            edges: LaneEdges::new(config, MarkingEdges::Both)?,
            lines: SectionLines::new(LineSelection::AsInPaper)?,
            tracked: [tracked(), tracked()],
            evidence: LaneEvidence::default(),
            knots: Vec::new(),
            spline: Pchip::default(),
        })
    }

    /// Lays a spline through the lines of a side's sections, from the far end down.
    fn lay_spline(&mut self, side: Side) {
        let Self { tracked, evidence, knots, spline, .. } = self;
        knots.clear();
        // Where the section beyond ends, and in which column its line does.
        let mut beyond: Option<(usize, f64)> = None;
        let rows_of = evidence.region.sections.iter();
        for (section, &[upper, lower]) in tracked[side.index()].sections.iter().zip(rows_of).rev() {
            let Some(line) = &section.line else {
                knots.extend(beyond.take().map(|(row, column)| [row as f64, column]));
                continue;
            };
            let [top, end] = [upper, lower].map(|row| line.column_at(row as f64));
            // Two lines that meet in a row share a point there.
            let column = beyond.map_or(top, |(_, column)| 0.5 * (column + top));
            knots.push([upper as f64, column]);
            beyond = Some((lower, end));
        }
        knots.extend(beyond.map(|(row, column)| [row as f64, column]));
        spline.fit(knots);
    }

    /// A side's edge on the road, where it is to be given out, with the spline that has been laid for it.
    fn road_edge(&mut self, camera: &Camera, side: Side) -> Option<RoadEdge> {
        if self.tracked[side.index()].is_lost {
            return None;
        }
        self.lay_spline(side);
        RoadEdge::through(&RoadView::new(camera, 0.0), &self.knots).filter(|_| !self.knots.is_empty())
    }
}

impl LaneDetector for SectionTracker {
    fn find(
        &mut self,
        camera: &Camera,
        input: &LaneInput<'_>,
        lane: &mut Option<Lane>,
    ) -> Result<&LaneEvidence, LaneError> {
        input.check_size(camera)?;
        let lane = lane.get_or_insert_default();
        let Self { config, edges, lines, tracked, evidence, .. } = self;
        let view = RoadView::new(camera, 0.0);
        evidence.region.lay(config, camera, 0.0, input.vehicle.speed_mps);
        let curvature_per_m = input.way_curvature_per_m();
        edges.find(config, &evidence.region, &view, curvature_per_m, input.frame, &mut evidence.steps)?;
        let last = evidence.region.sections.len().saturating_sub(1);
        lines.find(config, &evidence.region, &view, &evidence.steps.thin, |side, section, found| {
            let kept = tracked[side.index()].sections.get_mut(section)?;
            kept.take(found, if section == last { 0 } else { config.keep_frames });
            kept.line
        });
        evidence.candidates.clear();
        evidence.candidates.extend_from_slice(lines.candidates());
        for side in Side::BOTH {
            self.tracked[side.index()].judge(self.config.keep_frames);
            let Some(road_edge) = self.road_edge(camera, side) else {
                lane.withhold(side);
                continue;
            };
            let edge = lane.give_out(side);
            road_edge.write(edge);
            edge.marking = Marking::default();
            edge.kept_frames = self.tracked[side.index()].missed_frames;
            let base = self.evidence.region.base_row as f64 - 1.0;
            lay_points(&self.spline, base, camera.height(), &mut edge.points_px);
        }
        let is_followed = |edge: &TrackedEdge| edge.sections.iter().any(|section| section.line.is_some());
        self.evidence.followed = [0, 1].map(|side: usize| is_followed(&self.tracked[side]));
        Ok(&self.evidence)
    }

    fn reset(&mut self) {
        self.edges.clear();
        self.evidence.region = LaneRegion::default();
        self.tracked.iter_mut().for_each(TrackedEdge::forget);
    }
}
