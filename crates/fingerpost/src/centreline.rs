//! The road's middle without markings, from the edges of its surface (paper 1, section VII-A; paper 2, section 3).
//!
//! In a window of the ground view just ahead, Canny finds the edges of the road's probability and the Hough transform
//! lines among them; the strongest on the left and on the right are the road's edges, and midway between them is its
//! middle. The papers take one line a side, which a bend bends away from: here the window is cut into short sections, each
//! with its own two lines (`section`). What they show is kept where it lies while the vehicle moves over it, and a curve
//! through the edges ahead of the vehicle and beneath it says where the road's middle passes the rear axle's middle (`fit`).
//! A line counts only where the probability falls across it, and an edge only where one width fits the others, which leaves
//! out crossings and yards.
//!
//! At a corner no one curve holds the edges: the road that leads to it is held as it was, and when the rear axle is past it the
//! next begins where the surface shows it (`settle`). Where the road turns says the route's feature, where one is followed
//! (`guide`), and elsewhere how much road lies under the ways on (`way`). The direction to steer in is that of the feature's
//! driving line or of the likeliest way; where the road ends at another and nothing says which arm is taken there is none.
//!
//! Limits: the road's surface must be told from its verges, and the offset be sure to half a metre; where it is not, there is
//! no centreline, and the evidence says why. Without a motion the road is taken to go on as before.

mod band;
mod config;
mod fit;
mod guide;
mod output;
mod section;
mod settle;
mod turn;
mod way;

use std::ops::Range;

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::canny::{Canny, CannyParams, GradientNorm};
use fingerpost_vision::hough::{HoughLines, HoughParams};
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use nalgebra::Point2;

pub use config::CentrelineConfig;
pub use guide::Guide;
pub use output::{
    Centreline, CentrelineError, CentrelineEvidence, NoCentreline, SectionEvidence, SectionUse, Steer,
    SteerBy,
};
pub use section::RoadEdge;
pub use turn::{Corner, RoadLine};
pub use way::{WayKind, Ways};

use self::band::{Keeping, Shown};
use self::fit::{Course, Lasts};
use self::section::{Finder, Window};
use self::settle::settle;
use self::way::WayFinder;
use crate::ground_view::GroundView;
use crate::motion::Motion;
use crate::road_surface::RoadSurface;
use crate::vehicle::{Traffic, VehicleConfig};

/// Step of the lines' angles, radians: a degree moves the end of a section by two pixels.
const THETA_STEP_RAD: f64 = 1.0 / 57.3;
/// Least rows of a section: fewer make no line.
const MIN_ROWS: usize = 8;

/// Pixels to either side of the border of what the camera sees in which there are no edges: there, what is seen meets what
/// is remembered.
const BORDER_PX: usize = 3;

/// Length of road on which a vehicle moves over into its lane, metres: drivers take 4 to 6 s for a lane (Toledo and Zohar 2007),
/// 40 m at the pace of a side street.
const MOVING_OVER_M: f64 = 40.0;

/// How much less sure a road is that is carried on unseen, metres for each metre: of motion, as for kept edges.
const HELD_SIGMA: f64 = 0.015;
/// A road farther from the vehicle's direction has no place beside the rear axle, radians (80 degrees).
const ACROSS_RAD: f64 = 1.4;
/// Rounds in which the road behind a corner is settled when it begins: each makes its steps finer by a half or more.
const SETTLE_ROUNDS: usize = 3;

/// The stage with its buffers.
#[derive(Debug)]
pub struct CentrelineFinder {
    config: CentrelineConfig,
    traffic: Traffic,
    grid: GroundGrid,
    /// The window in the ground view; its rows are a whole number of sections.
    rect: Rect,
    section_rows: usize,
    canny: Canny,
    hough: HoughLines,
    edges: Plane<u8>,
    /// Row and columns of the window about the border of what the camera sees.
    border: Vec<(usize, Range<usize>)>,
    course: Course,
    corner: Option<Corner>,
    /// The road's middle as edges last told it, and how sure that is across it, metres.
    before_corner: Option<(RoadLine, f64)>,
    ways: WayFinder,
    evidence: CentrelineEvidence,
}

impl CentrelineFinder {
    /// A finder for a ground view.
    ///
    /// # Errors
    /// [`CentrelineError`] when a setting does not work.
    pub fn new(
        config: &CentrelineConfig,
        vehicle: &VehicleConfig,
        view: &GroundView,
    ) -> Result<Self, CentrelineError> {
        let grid = *view.grid();
        let scale_m = grid.metres_per_pixel();
        let section_rows = ((config.section_m / scale_m).round() as usize).max(MIN_ROWS);
        let sections = ((config.length_m / config.section_m).floor() as usize).max(1);
        let nearest = grid.ground_from_vehicle(Point2::new(view.nearest_seen_m(), 0.0)).row;
        let bottom = (nearest.max(0.0).ceil() as usize).min(grid.rows());
        let sections = sections.min(bottom / section_rows);
        let height = sections * section_rows;
        let rect = Rect { x: 0, y: bottom - height, width: grid.columns(), height };
        let params = HoughParams {
            rho_step_px: 1.0,
            theta_step_rad: THETA_STEP_RAD,
            votes: (config.min_line_share * section_rows as f64) as u32,
        };
        Ok(Self {
            traffic: vehicle.traffic,
            grid,
            rect,
            section_rows,
            canny: Canny::new(CannyParams {
                low: config.edge_low,
                high: config.edge_high,
                norm: GradientNorm::L1,
            })?,
            hough: HoughLines::new(params)?,
            edges: Plane::new(rect.width, rect.height, 0),
            border: border(view.validity(), rect),
            course: Course::default(),
            corner: None,
            before_corner: None,
            ways: WayFinder::default(),
            evidence: CentrelineEvidence {
                sections: Vec::with_capacity(sections),
                ..CentrelineEvidence::default()
            },
            config: config.clone(),
        })
    }

    /// The road's middle on this surface, if it is known, after the vehicle's motion since the surface before.
    ///
    /// # Errors
    /// [`CentrelineError::Picture`] when the surface is not of the finder's ground view.
    pub fn find(
        &mut self,
        surface: &RoadSurface,
        motion: Option<&Motion>,
    ) -> Result<(Option<Centreline>, &CentrelineEvidence), CentrelineError> {
        self.find_guided(surface, motion, None)
    }

    /// The same where the route's feature ahead is followed: it says where the road turns, and its driving line where to steer.
    ///
    /// # Errors
    /// [`CentrelineError::Picture`] when the surface is not of the finder's ground view.
    pub fn find_guided(
        &mut self,
        surface: &RoadSurface,
        motion: Option<&Motion>,
        guide: Option<&Guide<'_>>,
    ) -> Result<(Option<Centreline>, &CentrelineEvidence), CentrelineError> {
        self.evidence.sections.clear();
        (self.evidence.ways, self.evidence.corner) = (None, None);
        let found = if self.config.enabled {
            self.move_on(motion);
            self.pass_corner(surface, guide);
            self.find_in_window(surface)?.map(|road| self.steered(surface, road, guide))
        } else {
            Err(NoCentreline::Off)
        };
        self.evidence.none_because = found.err();
        self.evidence.corner = self.corner;
        Ok((found.ok().map(|road| self.with_surroundings(road)), &self.evidence))
    }

    /// The road's middle with what else the frame shows of the road.
    fn with_surroundings(&self, road: Centreline) -> Centreline {
        Centreline {
            is_shown: self.evidence.sections.iter().any(|section| section.section_use.shows_edge()),
            way_on: self.evidence.ways.map(|ways| ways.kind),
            corner_begins_m: self.corner.map(|corner| corner.begins_m(road.width_m)),
            ..road
        }
    }

    /// In place of [`CentrelineFinder::find`] where there is no surface of this frame.
    pub(crate) fn pass_over(&mut self) -> &CentrelineEvidence {
        self.evidence.sections.clear();
        (self.evidence.ways, self.evidence.corner) = (None, None);
        self.evidence.none_because = Some(NoCentreline::NothingShown);
        &self.evidence
    }

    /// Moves what is known with the vehicle.
    fn move_on(&mut self, motion: Option<&Motion>) {
        let lasts = if self.corner.is_some() { Lasts::RoundCorner } else { Lasts::Along };
        self.course.move_on(motion, lasts);
        let Some(motion) = motion else { return };
        let (moved, ahead_m) =
            (motion.previous_from_current.inverse(), motion.previous_from_current.translation.x.abs());
        self.corner = self.corner.map(|corner| corner.moved(&moved));
        self.before_corner =
            self.before_corner.map(|(line, sigma_m)| (line.moved(&moved), sigma_m + HELD_SIGMA * ahead_m));
    }

    /// Takes the corner of the route's feature for that of the road; behind a corner the road begins anew.
    fn pass_corner(&mut self, surface: &RoadSurface, guide: Option<&Guide<'_>>) {
        let guided = guide.and_then(|guide| guide.corner);
        if let Some(corner) = guided.filter(|corner| !corner.is_passed()) {
            self.corner = Some(corner);
        }
        let Some(corner) = self.corner.take_if(|corner| corner.is_passed()) else { return };
        self.course.begin(&corner.exit(), [corner.sigma_m, corner.sigma_rad]);
        self.before_corner = None;
        for _ in 0..SETTLE_ROUNDS {
            self.settle(surface);
        }
    }

    /// Lays the road that is believed where the surface shows it: across the vehicle's direction it has no edges in the sections.
    fn settle(&mut self, surface: &RoadSurface) {
        let shown = shown(surface, &self.grid);
        let (line, sigma) =
            settle(&shown, self.ways.log_odds(), &self.course.road(), self.course.line_sigma());
        self.course.begin(&line, sigma);
    }

    fn find_in_window(
        &mut self,
        surface: &RoadSurface,
    ) -> Result<Result<Centreline, NoCentreline>, CentrelineError> {
        let probability = surface.probability.view().crop(self.rect)?;
        let known = surface.known().plane().view().crop(self.rect)?;
        if self.rect.height == 0 {
            return Ok(Err(NoCentreline::NoEdges));
        }
        self.canny.apply(probability, &mut self.edges)?;
        for (row, columns) in &self.border {
            self.edges.row_mut(*row)[columns.clone()].fill(0);
        }
        let window = Window { probability, known };
        let finder = Finder { config: &self.config, window, grid: self.grid, top: self.rect.y };
        let corner_m = self.corner.map(|corner| corner.begins_m(self.course.width_m()));
        for index in 1..=self.rect.height / self.section_rows {
            let top = self.rect.height - index * self.section_rows;
            let rect = Rect { x: 0, y: top, width: self.rect.width, height: self.section_rows };
            let slopes = finder.slopes(rect, &self.course);
            let lines = self.hough.find_leaning(self.edges.view().crop(rect)?, slopes);
            let mut section = finder.section(lines, rect, &self.course);
            if corner_m.is_some_and(|corner_m| section.forward_m[1] > corner_m) {
                (section.edges, section.section_use) = ([None; 2], SectionUse::BeyondCorner);
            }
            self.evidence.sections.push(section);
        }
        let taken = self.course.take(&self.config, &mut self.evidence.sections);
        Ok(taken
            .inspect(|road| self.before_corner = Some((road.line(), road.across_sigma_m())))
            .or_else(|why| self.without_edges(surface).ok_or(why)))
    }

    /// The road's middle where no edges tell it: up to a corner on as it was, less and less surely, and elsewhere by the surface.
    fn without_edges(&mut self, surface: &RoadSurface) -> Option<Centreline> {
        let held = self.corner.and(self.before_corner);
        if let Some((line, sigma_m)) = held.filter(|(line, _)| line.heading_rad.abs() < ACROSS_RAD) {
            return Some(Centreline {
                offset_m: line.offset_m(),
                sigma_m: sigma_m / libm::cos(line.heading_rad),
                heading_rad: line.heading_rad,
                width_m: self.course.width_m(),
                ..Centreline::default()
            });
        }
        if self.course.is_known() {
            self.settle(surface);
        }
        self.course.believed()
    }

    /// The road's middle with the direction to steer in.
    fn steered(&mut self, surface: &RoadSurface, road: Centreline, guide: Option<&Guide<'_>>) -> Centreline {
        let look_ahead_m = self.config.look_ahead_m;
        let keeping = Keeping {
            look_ahead_m,
            lane_left_m: self.traffic.lane_left_m(road.width_m),
            share: (look_ahead_m / MOVING_OVER_M).min(1.0),
        };
        if let Some((direction_rad, sigma_rad)) = guide.and_then(|guide| guide.direction(&keeping)) {
            let steer = Steer { direction_rad, sigma_rad, by: SteerBy::DrivingLine };
            return Centreline { steer: Some(steer), ..road };
        }
        let shown = shown(surface, &self.grid);
        let nearest_m = self.grid.near_m();
        let remembered = self.corner.filter(|corner| corner.begins_m(road.width_m) < nearest_m);
        let ways = self.ways.find(&shown, &road, remembered.as_ref(), &keeping);
        if guide.is_none() {
            self.corner = ways.corner;
        }
        self.evidence.ways = Some(ways);
        let steer = Steer { direction_rad: ways.bearing_rad, sigma_rad: ways.sigma_rad, by: SteerBy::Road };
        Centreline { steer: (!ways.is_ambiguous()).then_some(steer), ..road }
    }
}

fn shown<'a>(surface: &'a RoadSurface, grid: &'a GroundGrid) -> Shown<'a> {
    Shown { probability: surface.probability.view(), known: surface.known().plane().view(), grid }
}

/// The pixels of a window about the border of what the camera sees.
fn border(validity: &ValidityMask, rect: Rect) -> Vec<(usize, Range<usize>)> {
    let of_row = |row: usize| {
        let ends = validity.runs(rect.y + row).iter().flat_map(|run| [run.start, run.end]);
        ends.map(move |end| (row, end.saturating_sub(BORDER_PX)..(end + BORDER_PX).min(rect.width)))
    };
    (0..rect.height).flat_map(of_row).collect()
}
