//! Pieces of an arm, slid across its road to find the road's edges.

use fingerpost_vision::span::{RowSums, SpanError, SpanMask};
use nalgebra::{Isometry2, Point2, Vector2};

use super::AlignmentConfig;
use super::lines::{self, BrightLine};
use super::pavement::{Pavements, RoadEdges, without_pavements};
use super::pieces::{ArmPieces, CutPiece};
use super::profile::{Profile, Sample};
use super::section::{CrossSection, section};
use crate::matching::LaidSurface;

/// Share of a piece that must be seen.
const MIN_SEEN_SHARE: f64 = 0.7;
/// Length on either side of an edge over which the probability is compared, metres: longer than a marking or a shadow's
/// rim is wide, shorter than a pavement.
const WINDOW_M: f64 = 0.8;
/// The same for a whole arm of which no piece shows an edge: far from the camera a kerb is drawn out over metres.
const WHOLE_WINDOW_M: f64 = 2.0;
/// A piece beside which the kerbs stand back by no more than this belongs to the straight part of its arm, metres.
const STRAIGHT_FLARE_M: f64 = 0.2;
/// How far beyond the slide lines are looked for, metres: they lie inside of the edges.
const LINES_BEYOND_M: f64 = 1.0;
/// An edge counts where the grey values within this are seen, metres: one that is only remembered has been measured
/// before, and what tells it from a pavement's is not remembered.
const SEEN_ABOUT_M: f64 = 0.3;
/// Pieces whose middles are within so many of their lengths are neighbours.
const NEIGHBOURS: f64 = 2.0;

/// One piece, slid across its road.
#[derive(Debug)]
pub(super) struct Slid {
    /// What was measured.
    pub(super) section: CrossSection,
    /// Distance of its middle from the node along the arm, metres.
    pub(super) along_m: f64,
    /// How far the kerbs at its left and right stand back; none where the edge is rather another road's.
    pub(super) flare_m: [Option<f64>; 2],
}

/// What lies under a piece at each shift.
#[derive(Debug, Default)]
struct Under {
    p_in_vehicle: Point2<f64>,
    left: Vector2<f64>,
    along_m: f64,
    flare_m: [Option<f64>; 2],
    /// Where the probability falls, metres to the left.
    edges_m: [Option<f64>; 2],
    grey: Profile,
    lines: Vec<BrightLine>,
}

/// Slides pieces across roads; its memory is reused from arm to arm.
#[derive(Debug)]
pub(super) struct Slide {
    config: AlignmentConfig,
    pixels: Vec<[f64; 2]>,
    mask: SpanMask,
    profile: Profile,
    pavements: Pavements,
    /// The pieces of the arm, of which the first `count` are of this one.
    pieces: Vec<Under>,
    count: usize,
    /// Those lines of a piece that are believed.
    lines: Vec<BrightLine>,
    /// Whether the probability falls anywhere beside the arm.
    falls: bool,
    /// The mean of the arm's pieces beyond its kerbs.
    whole: Profile,
    /// Where along the arm they lie, metres.
    used_m: Vec<f64>,
}

impl Slide {
    /// A slide of pieces as wide as `config` says.
    pub(super) fn new(config: &AlignmentConfig) -> Self {
        Self {
            config: config.clone(),
            pixels: Vec::new(),
            mask: SpanMask::default(),
            profile: Profile::default(),
            pavements: Pavements::default(),
            pieces: Vec::new(),
            count: 0,
            lines: Vec::new(),
            falls: false,
            whole: Profile::default(),
            used_m: Vec::new(),
        }
    }

    /// Starts a new arm.
    pub(super) fn start_arm(&mut self) {
        self.count = 0;
        self.falls = false;
        self.whole.clear();
        self.used_m.clear();
    }

    /// Slides a piece of `arm` across its road, where enough of it is seen.
    ///
    /// # Errors
    /// [`SpanError`] when the piece cannot be drawn.
    pub(super) fn across(
        &mut self,
        laid: &LaidSurface<'_>,
        arm: &ArmPieces,
        piece: &CutPiece,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Result<(), SpanError> {
        let (config, grid) = (&self.config, laid.grid());
        let along = vehicle_from_feature.rotation * piece.along;
        let left = Vector2::new(-along.y, along.x);
        self.pixels.clear();
        self.pixels.extend(piece.course.points().iter().map(|p_in_feature| {
            let pixel = grid.ground_from_vehicle(vehicle_from_feature * p_in_feature);
            [pixel.column, pixel.row]
        }));
        self.mask.redraw_stroke(&self.pixels, config.piece_width_m / grid.metres_per_pixel())?;
        if laid.sums().cover(&self.mask, 0, 0).seen_share() < MIN_SEEN_SHARE {
            return Ok(());
        }
        let (step_m, left_px_per_m) = (config.slide_step_m, left / grid.metres_per_pixel());
        let reach_m = 0.5 * arm.width_m + config.slide_beyond_m;
        self.profile.take(profile(step_m, laid.sums(), &self.mask, left_px_per_m, reach_m));
        let falls_m = self.profile.edges_m(step_m, WINDOW_M, config.min_edge_step);
        self.falls |= falls_m != [None, None];
        if self.count == self.pieces.len() {
            self.pieces.push(Under::default());
        }
        let Some(under) = self.pieces.get_mut(self.count) else { return Ok(()) };
        self.count += 1;
        under.p_in_vehicle = vehicle_from_feature * piece.middle;
        (under.left, under.along_m, under.flare_m) = (left, piece.along_m, piece.flare_m);
        under.edges_m = falls_m;
        under.grey.clear();
        under.lines.clear();
        if let Some(grey) = laid.grey() {
            let reach_m = reach_m + LINES_BEYOND_M;
            under.grey.take(profile(step_m, grey, &self.mask, left_px_per_m, reach_m));
            lines::find(&under.grey, step_m, arm.width_m, &mut under.lines);
            let is_seen = |at_m: &f64| under.grey.is_seen_at(*at_m, step_m, SEEN_ABOUT_M);
            under.edges_m = falls_m.map(|edge_m| edge_m.filter(is_seen));
        }
        if piece.flare_m.iter().all(|flare_m| flare_m.is_some_and(|flare_m| flare_m <= STRAIGHT_FLARE_M)) {
            self.whole.add(&self.profile);
            self.used_m.push(piece.along_m);
        }
        Ok(())
    }

    /// What was measured on the pieces of `arm` that were slid since its start, from its mouth outwards.
    pub(super) fn slid(&mut self, arm: &ArmPieces, take: &mut dyn FnMut(Slid)) {
        let config = &self.config;
        let pieces = self.pieces.get(..self.count).unwrap_or_default();
        for (i, piece) in pieces.iter().enumerate() {
            let is_beside =
                |other: &Under| (other.along_m - piece.along_m).abs() < NEIGHBOURS * config.piece_length_m;
            let others = || pieces.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, other)| other);
            let goes_on = |line: &BrightLine| {
                others().filter(|other| is_beside(other)).any(|other| line.goes_on_in(&other.lines))
            };
            self.lines.clear();
            self.lines.extend(piece.lines.iter().filter(|line| line.is_clear() || goes_on(line)));
            let width = (arm.width_m, config.width_sigma_share * arm.width_m);
            let by_lines_m = lines::edges_m(&self.lines, width, piece.edges_m);
            let edges_m = (piece.edges_m, by_lines_m);
            let road =
                without_pavements(&piece.grey, config.slide_step_m, width, edges_m, &mut self.pavements);
            let section = section(config, arm, piece.p_in_vehicle, piece.left, road);
            take(Slid { section, along_m: piece.along_m, flare_m: piece.flare_m });
        }
    }

    /// The cross-section of all pieces of the arm together that were slid since its start, beyond its kerbs, and its
    /// place along the arm, metres; none where there was none, and where a single piece shows an edge.
    pub(super) fn whole_arm(
        &mut self,
        arm: &ArmPieces,
        vehicle_from_feature: &Isometry2<f64>,
    ) -> Option<(CrossSection, f64)> {
        if self.falls {
            return None;
        }
        let middle_m = *self.used_m.get(self.used_m.len() / 2)?;
        let piece = arm.pieces.iter().find(|piece| piece.along_m >= middle_m)?;
        let along = vehicle_from_feature.rotation * piece.along;
        let config = &self.config;
        let edges_m = self.whole.edges_m(config.slide_step_m, WHOLE_WINDOW_M, 0.5 * config.min_edge_step);
        let left = Vector2::new(-along.y, along.x);
        let road = RoadEdges::certain(edges_m);
        Some((section(config, arm, vehicle_from_feature * piece.middle, left, road), piece.along_m))
    }
}

/// What lies under the piece against its shift.
fn profile(
    step_m: f64,
    sums: &RowSums,
    mask: &SpanMask,
    left_px_per_m: Vector2<f64>,
    reach_m: f64,
) -> impl Iterator<Item = Sample> {
    let steps = (reach_m / step_m).ceil() as i32;
    (-steps..=steps).map(move |k| {
        let shift_m = f64::from(k) * step_m;
        // Left is smaller columns, forward smaller rows.
        let (column, row) = (-left_px_per_m.y * shift_m, -left_px_per_m.x * shift_m);
        let cover = sums.cover(mask, column.round() as i32, row.round() as i32);
        (shift_m, cover.probability().filter(|_| cover.seen_share() >= MIN_SEEN_SHARE))
    })
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use fingerpost_geometry::{GroundGrid, GroundPixel, Polyline};
    use fingerpost_vision::picture::{Plane, ValidityMask};

    use super::*;
    use crate::matching::{MatchConfig, Matcher};
    use crate::road_surface::RoadSurface;

    /// The ground ahead, each pixel by how far it lies to the left, metres.
    fn plane(grid: &GroundGrid, of: impl Fn(f64) -> u8) -> Plane<u8> {
        let mut plane = Plane::new(grid.columns(), grid.rows(), 0);
        for row in 0..grid.rows() {
            for (column, value) in plane.row_mut(row).iter_mut().enumerate() {
                let pixel = GroundPixel { column: column as f64, row: row as f64 };
                *value = of(grid.vehicle_from_ground(pixel).y);
            }
        }
        plane
    }

    /// The edges of a road 6 m wide, on a piece of it, where the frame shows what lies left of `seen_from_m`.
    fn edges_m(seen_from_m: f64) -> [Option<f64>; 2] {
        let grid = GroundGrid::new(4.0, 20.0, 10.0, 0.05).unwrap();
        let road = plane(&grid, |left_m| if left_m.abs() < 3.0 { 240 } else { 10 });
        let everywhere = ValidityMask::from_plane(plane(&grid, |_| 1));
        let seen = ValidityMask::from_plane(plane(&grid, |left_m| u8::from(left_m > seen_from_m)));
        let mut surface = RoadSurface { probability: road, ..RoadSurface::default() };
        surface.sums.rebuild(surface.probability.view(), &everywhere).unwrap();
        let grey = plane(&grid, |_| 90);
        let mut matcher = Matcher::new(&MatchConfig::default(), &grid);
        let laid = matcher.laid_with(&surface, (&grey, &seen)).unwrap();
        let (middle, along) = (Point2::new(10.75, 0.0), Vector2::new(1.0, 0.0));
        let course = Polyline::new(vec![Point2::new(10.0, 0.0), Point2::new(11.5, 0.0)]).unwrap();
        let piece = CutPiece { course, middle, along, along_m: 10.75, flare_m: [Some(0.0); 2] };
        let label = Arc::from("exit");
        let arm = ArmPieces { label, width_m: 6.0, leaves_the_line: false, pieces: Vec::new() };
        let mut slide = Slide::new(&AlignmentConfig::default());
        slide.start_arm();
        slide.across(&laid, &arm, &piece, &Isometry2::identity()).unwrap();
        let mut edges_m = [None; 2];
        slide.slid(&arm, &mut |slid| edges_m = slid.section.edges_m);
        edges_m
    }

    #[test]
    fn an_edge_that_is_only_remembered_is_not_measured_again() {
        let near = |edge_m: Option<f64>, m: f64| edge_m.is_some_and(|edge_m| (edge_m - m).abs() < 0.15);
        let [left_m, right_m] = edges_m(-12.0);
        assert!(near(left_m, 3.0) && near(right_m, -3.0), "{left_m:?} {right_m:?}");
        let [left_m, right_m] = edges_m(-1.0);
        assert!(near(left_m, 3.0) && right_m.is_none(), "{left_m:?} {right_m:?}");
    }
}
