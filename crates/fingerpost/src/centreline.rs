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
//! Limits: the road's surface must be told from its verges, and the offset be sure to half a metre; where it is not, there is
//! no centreline, and the evidence says why. On the corner of a turn, where two roads meet, the middle is that of the one
//! whose edges are seen. Without a motion the road is taken to go on as before.

mod config;
mod fit;
mod section;

use std::ops::Range;

use fingerpost_geometry::GroundGrid;
use fingerpost_vision::canny::{Canny, CannyError, CannyParams, GradientNorm};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::hough::{HoughError, HoughLines, HoughParams};
use fingerpost_vision::picture::{Plane, Rect, ValidityMask};
use nalgebra::Point2;
use thiserror::Error;

pub use config::CentrelineConfig;
pub use section::RoadEdge;

use self::fit::Course;
use self::section::{Finder, Window};
use crate::ground_view::GroundView;
use crate::motion::Motion;
use crate::road_surface::RoadSurface;
use crate::vehicle::VehicleConfig;

/// Step of the lines' angles, radians: a degree moves the end of a section by two pixels.
const THETA_STEP_RAD: f64 = 1.0 / 57.3;
/// Least rows of a section: fewer make no line.
const MIN_ROWS: usize = 8;

/// Pixels to either side of the border of what the camera sees in which there are no edges: there, what is seen meets what
/// is remembered.
const BORDER_PX: usize = 3;

/// The road's middle near the vehicle.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Centreline {
    /// How far left of the rear axle's middle it passes, metres.
    pub offset_m: f64,
    /// Standard deviation of the offset, metres; never zero.
    pub sigma_m: f64,
    /// Its direction there against the vehicle's, radians, positive to the left.
    pub heading_rad: f64,
    /// Its curvature, 1/m, positive to the left.
    pub curvature_per_m: f64,
    /// Width of the road, metres.
    pub width_m: f64,
    /// Direction to steer in, radians, positive to the left: towards the vehicle's place on the road at the look-ahead.
    pub steer_rad: f64,
}

impl Centreline {
    /// How far left of the vehicle's centre line it is at some distance ahead, metres.
    pub fn left_m(&self, forward_m: f64) -> f64 {
        self.offset_m
            + self.heading_rad.tan() * forward_m
            + 0.5 * self.curvature_per_m * forward_m * forward_m
    }
}

/// What a section of the window shows.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct SectionEvidence {
    /// Where it begins and ends ahead of the rear axle, metres.
    pub forward_m: [f64; 2],
    /// Left and right edge of the road, where they were found.
    pub edges: [Option<RoadEdge>; 2],
    /// Whether it took part.
    pub section_use: SectionUse,
}

/// What became of a section.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SectionUse {
    /// Neither edge was found.
    #[default]
    NoEdges,
    /// Its edges are not where those of the others have them.
    OtherWidth,
    /// One edge took part.
    OneEdge,
    /// Both edges took part.
    BothEdges,
}

/// Why there is no centreline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoCentreline {
    /// The camera shows nothing, or nothing new.
    NothingShown,
    /// No section has both edges.
    NoEdges,
    /// Too few sections agree.
    TooFewSections,
    /// They agree, but do not yet say where the road's middle passes the vehicle.
    Unsure,
    /// It is switched off.
    Off,
}

/// How the centreline was found.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CentrelineEvidence {
    /// The sections, near to far.
    pub sections: Vec<SectionEvidence>,
    /// Why there is none.
    pub none_because: Option<NoCentreline>,
}

/// A centreline that cannot be looked for.
#[derive(Debug, Error)]
pub enum CentrelineError {
    /// The thresholds of the edges do not work.
    #[error("centreline: {0}")]
    Canny(#[from] CannyError),
    /// The lines' steps do not work.
    #[error("centreline: {0}")]
    Hough(#[from] HoughError),
    /// The window does not fit the picture.
    #[error("centreline: {0}")]
    Picture(#[from] PictureError),
}

/// The stage with its buffers.
#[derive(Debug)]
pub struct CentrelineFinder {
    config: CentrelineConfig,
    left_share: f64,
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
            left_share: vehicle.traffic.left_share(),
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
            evidence: CentrelineEvidence { sections: Vec::with_capacity(sections), none_because: None },
            config: config.clone(),
        })
    }

    /// The road's middle on this surface, if its edges are sound, after the vehicle's motion since the surface before.
    ///
    /// # Errors
    /// [`CentrelineError::Picture`] when the surface is not of the finder's ground view.
    pub fn find(
        &mut self,
        surface: &RoadSurface,
        motion: Option<&Motion>,
    ) -> Result<(Option<Centreline>, &CentrelineEvidence), CentrelineError> {
        self.evidence.sections.clear();
        self.course.move_on(motion);
        let found = if self.config.enabled { self.find_in_window(surface)? } else { Err(NoCentreline::Off) };
        self.evidence.none_because = found.err();
        Ok((found.ok(), &self.evidence))
    }

    /// In place of [`CentrelineFinder::find`] where there is no surface of this frame.
    pub(crate) fn pass_over(&mut self) -> &CentrelineEvidence {
        self.evidence.sections.clear();
        self.evidence.none_because = Some(NoCentreline::NothingShown);
        &self.evidence
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
        for index in 1..=self.rect.height / self.section_rows {
            let top = self.rect.height - index * self.section_rows;
            let rect = Rect { x: 0, y: top, width: self.rect.width, height: self.section_rows };
            let lines = self.hough.find(self.edges.view().crop(rect)?);
            self.evidence.sections.push(finder.section(lines, rect, &self.course));
        }
        let course = &mut self.course;
        Ok(course.take(&self.config, &mut self.evidence.sections).map(|curve| {
            let ahead_m = self.config.look_ahead_m;
            let aim_m = curve.left_m(ahead_m) + self.left_share * curve.width_m;
            Centreline { steer_rad: aim_m.atan2(ahead_m), ..curve }
        }))
    }
}

/// The pixels of a window about the border of what the camera sees.
fn border(validity: &ValidityMask, rect: Rect) -> Vec<(usize, Range<usize>)> {
    let of_row = |row: usize| {
        let ends = validity.runs(rect.y + row).iter().flat_map(|run| [run.start, run.end]);
        ends.map(move |end| (row, end.saturating_sub(BORDER_PX)..(end + BORDER_PX).min(rect.width)))
    };
    (0..rect.height).flat_map(of_row).collect()
}
