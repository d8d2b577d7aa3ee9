//! What the stage says of the road's middle, and how it found it.

use fingerpost_vision::canny::CannyError;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::hough::HoughError;
use nalgebra::Point2;
use thiserror::Error;

use super::section::RoadEdge;
use super::turn::{Corner, RoadLine};
use super::way::{WayKind, Ways};

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
    /// Where to steer; none where the road ahead is ambiguous ([`Ways::is_ambiguous`]).
    pub steer: Option<Steer>,
    /// Whether this frame shows an edge of the road; else its middle lies where it did.
    pub is_shown: bool,
    /// How the road goes on by its surface; none where that was not asked.
    pub way_on: Option<WayKind>,
    /// How far ahead of the rear axle the kerbs of its next corner begin, metres; none where no corner is in sight.
    pub corner_begins_m: Option<f64>,
}

/// A direction to steer in.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Steer {
    /// The direction, radians, positive to the left: towards the way ahead at the look-ahead, on which the vehicle comes gently
    /// nearer to its lane.
    pub direction_rad: f64,
    /// Its standard deviation, radians.
    pub sigma_rad: f64,
    /// What it goes by.
    pub by: SteerBy,
}

/// What a steering direction goes by.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SteerBy {
    /// The road's surface ahead.
    #[default]
    Road,
    /// The driving line through the route's feature.
    DrivingLine,
}

impl Centreline {
    /// How far left of the vehicle's centre line it is at some distance ahead, metres.
    pub fn left_m(&self, forward_m: f64) -> f64 {
        self.offset_m
            + libm::tan(self.heading_rad) * forward_m
            + 0.5 * self.curvature_per_m * forward_m * forward_m
    }

    /// The same in a frame that shows nothing of it.
    #[must_use]
    pub(crate) const fn unseen(self) -> Self {
        Self { is_shown: false, way_on: None, corner_begins_m: None, ..self }
    }

    /// Its tangent beside the rear axle.
    pub(super) fn line(&self) -> RoadLine {
        RoadLine { place: Point2::new(0.0, self.offset_m), heading_rad: self.heading_rad }
    }

    /// Standard deviation of its place across itself, metres.
    pub(super) fn across_sigma_m(&self) -> f64 {
        self.sigma_m * libm::cos(self.heading_rad)
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
    /// It lies beyond a corner.
    BeyondCorner,
    /// One edge took part.
    OneEdge,
    /// Both edges took part.
    BothEdges,
}

impl SectionUse {
    /// Whether an edge of the road took part.
    pub(super) const fn shows_edge(self) -> bool {
        matches!(self, Self::OneEdge | Self::BothEdges)
    }
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
    /// Which ways the road goes on by its surface; none where that was not asked.
    pub ways: Option<Ways>,
    /// The corner that the road turns at.
    pub corner: Option<Corner>,
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
