//! High level: straight lines in the region's sections, and which of them are the lane's (paper 3, III-C).
//!
//! Each section is searched on either side of the way ahead; its four strongest lines are candidates. In the lowest section
//! with any, a candidate must lie within the angles and the distances that a lane's edge can have; of those the innermost
//! counts, the one with the largest inner angle. Further sections go on from the one before: a line that turns away from it
//! is dropped, and so is one that begins elsewhere unless lines are chosen as in the paper.

use fingerpost_geometry::Pixel;
use fingerpost_vision::hough::{HoughError, HoughLines, HoughParams};
use fingerpost_vision::picture::{Plane, Rect};

use super::region::LaneRegion;
use super::road_view::RoadView;
use super::{LanesConfig, Side};

/// Lines of a section and side that are considered (paper 3: the four most relevant pairs of coordinates).
const STRONGEST: usize = 4;
/// Share of a section's rows that must vote for a line.
const VOTE_SHARE: f64 = 0.22;
/// Fewest votes of a line.
const FEWEST_VOTES: u32 = 7;
/// Lines whose ends lie nearer to each other than this are one, share of the picture's width.
const SAME_LINE_SHARE: f64 = 0.008;
/// A section's line must begin so near to the end of the one before, metres.
const JOINT_M: f64 = 0.45;

/// Why a candidate was kept or dropped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineVerdict {
    /// It is the lane's edge in its section.
    Kept,
    /// Its direction is none that a lane can have.
    Direction,
    /// It is too far from the vehicle, or on its other side.
    Distance,
    /// It turns away from the line in the section before.
    Turns,
    /// It is no continuation of the line in the section before.
    Joint,
    /// Another is nearer to the vehicle.
    NotInnermost,
    /// It bounds no bar of paint.
    NoPaint,
}

/// A line that the Hough transform found in a section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LineCandidate {
    /// The side of the vehicle.
    pub side: Side,
    /// Index of its section, 0 for the lowest.
    pub section: usize,
    /// Where it meets the section's lower end, pixels.
    pub lower_px: Pixel,
    /// Where it meets the section's upper end, pixels.
    pub upper_px: Pixel,
    /// Pixels that voted for it.
    pub votes: u32,
    /// What became of it.
    pub verdict: LineVerdict,
}

impl LineCandidate {
    /// The angle inside the lane between the line and the picture's base, radians, 0 to pi.
    pub fn inner_angle_rad(&self) -> f64 {
        let inward = -self.side.outward() * (self.upper_px.u - self.lower_px.u);
        libm::atan2(self.lower_px.v - self.upper_px.v, inward)
    }

    /// The column of its line in any row, within its section or not, pixels.
    #[inline]
    pub fn column_at(&self, row: f64) -> f64 {
        let rows = self.upper_px.v - self.lower_px.v;
        self.lower_px.u + (row - self.lower_px.v) / rows * (self.upper_px.u - self.lower_px.u)
    }
}

/// How lines are chosen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LineSelection {
    /// Weak ones too, where the picture itself is read afterwards; those of further sections by their direction and by where they
    /// begin.
    ForPaint,
    /// As the paper has it, where lines are all that is known: of an accumulator's peaks those above half of the largest
    /// (`houghpeaks` of MATLAB), lest what runs across a marking from one edge to the other is taken; those of further sections
    /// by their direction alone.
    AsInPaper,
}

/// Finds the candidates of a frame, with the buffers that it needs.
#[derive(Debug)]
pub struct SectionLines {
    hough: HoughLines,
    selection: LineSelection,
    candidates: Vec<LineCandidate>,
}

impl SectionLines {
    /// A finder that chooses lines as `selection` says.
    ///
    /// # Errors
    /// [`HoughError`] when the accumulator cannot be set up.
    pub fn new(selection: LineSelection) -> Result<Self, HoughError> {
        let params = HoughParams {
            rho_step_px: 1.0,
            theta_step_rad: std::f64::consts::PI / 180.0,
            votes: FEWEST_VOTES,
        };
        Ok(Self { hough: HoughLines::new(params)?, selection, candidates: Vec::new() })
    }

    /// All candidates of the last frame, section by section from the lowest.
    pub fn candidates(&self) -> &[LineCandidate] {
        &self.candidates
    }

    pub(super) fn candidates_mut(&mut self) -> &mut [LineCandidate] {
        &mut self.candidates
    }

    /// Finds and judges the lines of all sections in `thin`, a picture of edges (255) whose first row is the region's top. `settle` is given the best line
    /// of every side's sections, from the lowest on, and says which line further ones go on from.
    pub fn find(
        &mut self,
        config: &LanesConfig,
        region: &LaneRegion,
        view: &RoadView<'_>,
        thin: &Plane<u8>,
        mut settle: impl FnMut(Side, usize, Option<LineCandidate>) -> Option<LineCandidate>,
    ) {
        self.candidates.clear();
        for (section, &[upper, lower]) in region.sections.iter().enumerate() {
            let middle_row = (upper + lower) as f64 / 2.0;
            let ahead = ahead_column(view, middle_row, thin.width());
            for side in Side::BOTH {
                let (x, width) = match side {
                    Side::Left => (0, ahead),
                    Side::Right => (ahead, thin.width() - ahead),
                };
                let rect = Rect { x, y: upper - region.top_row, width, height: lower - upper };
                self.collect(side, section, rect, region.top_row, thin);
            }
        }
        for side in Side::BOTH {
            self.judge(config, view, (side, region.sections.len()), &mut settle);
        }
    }

    fn collect(&mut self, side: Side, section: usize, rect: Rect, top_row: usize, thin: &Plane<u8>) {
        let Ok(part) = thin.view().crop(rect) else { return };
        let (upper, lower) = ((top_row + rect.y) as f64, (top_row + rect.y + rect.height) as f64);
        let mut least = (VOTE_SHARE * rect.height as f64) as u32;
        let first = self.candidates.len();
        let same_px = SAME_LINE_SHARE * thin.width() as f64;
        for line in self.hough.find(part) {
            if self.selection == LineSelection::AsInPaper {
                least = least.max(line.votes.div_ceil(2));
            }
            if line.votes < least || self.candidates.len() - first == STRONGEST {
                break;
            }
            let cosine = libm::cos(line.theta_rad);
            // Level lines meet no end of their section.
            if cosine.abs() < 0.05 {
                continue;
            }
            let column =
                |v: f64| rect.x as f64 + (line.rho_px - (v - upper) * libm::sin(line.theta_rad)) / cosine;
            let candidate = LineCandidate {
                side,
                section,
                lower_px: Pixel::new(column(lower), lower),
                upper_px: Pixel::new(column(upper), upper),
                votes: line.votes,
                verdict: LineVerdict::NotInnermost,
            };
            let same = |other: &LineCandidate| {
                (other.lower_px.u - candidate.lower_px.u).abs() < same_px
                    && (other.upper_px.u - candidate.upper_px.u).abs() < same_px
            };
            if !self.candidates[first..].iter().any(same) {
                self.candidates.push(candidate);
            }
        }
    }

    /// Judges the candidates of a side in so many sections, from the lowest on.
    fn judge(
        &mut self,
        config: &LanesConfig,
        view: &RoadView<'_>,
        (side, sections): (Side, usize),
        settle: &mut impl FnMut(Side, usize, Option<LineCandidate>) -> Option<LineCandidate>,
    ) {
        let mut before: Option<LineCandidate> = None;
        for section in 0..sections {
            let of_section = |c: &LineCandidate| c.side == side && c.section == section;
            let selection = self.selection;
            for candidate in self.candidates.iter_mut().filter(|c| of_section(c)) {
                candidate.verdict =
                    verdict(config, view, candidate, before.as_ref().map(|line| (line, selection)));
            }
            // The largest inner angle is the edge nearest to the vehicle.
            let best = self
                .candidates
                .iter_mut()
                .filter(|c| of_section(c) && c.verdict == LineVerdict::NotInnermost)
                .max_by(|a, b| a.inner_angle_rad().total_cmp(&b.inner_angle_rad()));
            let best = best.map(|best| {
                best.verdict = LineVerdict::Kept;
                *best
            });
            before = settle(side, section, best).or(before);
        }
    }
}

/// The column straight ahead in a row, kept inside the picture.
fn ahead_column(view: &RoadView<'_>, row: f64, width: usize) -> usize {
    let middle = (width - 1) as f64 / 2.0;
    let ahead = view
        .ground_of_pixel(Pixel::new(middle, row))
        .and_then(|place| view.pixel_of_ground(nalgebra::Point2::new(place.x, 0.0)));
    ahead.map_or(middle, |pixel| pixel.u).clamp(1.0, (width - 1) as f64) as usize
}

/// What can be said of a candidate without the others of its section; `NotInnermost` when nothing speaks against it.
fn verdict(
    config: &LanesConfig,
    view: &RoadView<'_>,
    candidate: &LineCandidate,
    before: Option<(&LineCandidate, LineSelection)>,
) -> LineVerdict {
    let (Some(near), Some(far)) =
        (view.ground_of_pixel(candidate.lower_px), view.ground_of_pixel(candidate.upper_px))
    else {
        return LineVerdict::Distance;
    };
    let direction = far - near;
    // The camera's pitch makes lines seem to spread or to meet; the limit has twice the room for that.
    let heading = libm::atan(direction.y / direction.x.max(1e-6));
    if direction.x <= 0.0 || heading.abs() > 2.0 * config.max_heading_deg.to_radians() {
        return LineVerdict::Direction;
    }
    let left_m = -candidate.side.outward() * near.y;
    if before.is_none() && !(-0.2..=config.max_offset_m).contains(&left_m) {
        return LineVerdict::Distance;
    }
    if let Some((before, selection)) = before {
        let turn = candidate.inner_angle_rad() - before.inner_angle_rad();
        if turn.abs() > config.max_turn_deg.to_radians() {
            return LineVerdict::Turns;
        }
        if selection == LineSelection::AsInPaper {
            return LineVerdict::NotInnermost;
        }
        let end =
            view.ground_of_pixel(Pixel::new(before.column_at(candidate.lower_px.v), candidate.lower_px.v));
        if end.is_none_or(|end| (end.y - near.y).abs() > JOINT_M) {
            return LineVerdict::Joint;
        }
    }
    LineVerdict::NotInnermost
}

#[cfg(test)]
mod tests;
