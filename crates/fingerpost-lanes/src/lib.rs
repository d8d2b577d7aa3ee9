//! Lanes: the edges of the lane in which the vehicle is, by their markings.
//!
//! Paper 3 ("Drivable-Region and Lane-Detection System for Autonomous Vehicle Navigation"): low level (grey, frame buffer,
//! region of interest), mid level (Canny, gradient orientation, dilation, labels, thinning) and high level (sections, Hough
//! lines, selection, spline). Beyond the paper: an edge counts as one only where it bounds a bar that is likelier paint than
//! anything else, by what lies on both sides of it (`paint_odds`); its places are read from the picture to fractions of a
//! pixel (`paint`); and the lane is followed as a curve on the road, which fills the gaps of broken lines and carries it
//! through frames that show nothing. The paper's own way from the sections on is
//! `fingerpost_papers::SectionTracker`.
//!
//! A frame, the camera and what is known of the vehicle in ([`LaneInput`]), the [`Lane`] and its [`LaneEvidence`] out, by
//! whatever is behind [`LaneDetector`]; [`departure`] warns where the lane is being left. Frames and signs are those of
//! `CONVENTIONS.md`. No file, clock or environment is read, and a frame in a steady state allocates nothing.

mod config;
mod dash_motion;
pub mod departure;
mod detector;
mod edges;
mod finder;
pub mod geometry;
mod lane_filter;
mod marking;
mod paint;
mod paint_odds;
mod region;
mod road_view;
mod sections;
mod shape;
mod tracing;

use fingerpost_control::VehicleState;
use fingerpost_geometry::{Camera, ObservedAngle, Pixel};
use fingerpost_vision::error::PictureError;
use fingerpost_vision::picture::RgbImage;

use self::geometry::{EdgeOnRoad, LaneOnRoad};

pub use config::{LaneMethod, LanesConfig};
pub use detector::LaneDetector;
pub use edges::{EdgeSteps, LaneEdges, LaneError, MarkingEdges};
pub use finder::LaneFinder;
pub use marking::{Marking, MarkingColour, MarkingKind};
pub use region::LaneRegion;
pub use road_view::RoadView;
pub use sections::{LineCandidate, LineSelection, LineVerdict, SectionLines};
pub use shape::lay_points;
pub use tracing::{Traced, TracedPoint};

/// A side of the vehicle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Side {
    /// Left.
    Left,
    /// Right.
    Right,
}

impl Side {
    /// Both, left first.
    pub const BOTH: [Self; 2] = [Self::Left, Self::Right];

    /// The side across the vehicle.
    pub const fn other(self) -> Self {
        match self {
            Self::Left => Self::Right,
            Self::Right => Self::Left,
        }
    }

    /// +1 where columns further outside are further right, else -1.
    #[inline]
    pub const fn outward(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }

    /// 0 for the left and 1 for the right, as pairs have them.
    #[inline]
    pub const fn index(self) -> usize {
        match self {
            Self::Left => 0,
            Self::Right => 1,
        }
    }
}

/// What a frame brings for the lanes.
#[derive(Debug, Clone, Copy)]
pub struct LaneInput<'a> {
    /// The camera's picture.
    pub frame: &'a RgbImage,
    /// Seconds since the frame before; none in the first one.
    pub dt_s: Option<f64>,
    /// Speed, yaw rate and turn signal, where they are known.
    pub vehicle: &'a VehicleState,
    /// Change of the camera's pitch since the frame before, radians, positive nose down, where the picture shows it.
    pub pitch_change: Option<ObservedAngle>,
}

impl LaneInput<'_> {
    /// Curvature of the vehicle's way by its yaw rate, 1/m, positive left; 0 where it stands or that is not known.
    pub fn way_curvature_per_m(&self) -> f64 {
        let VehicleState { speed_mps, yaw_rate_rps, .. } = *self.vehicle;
        let moving =
            yaw_rate_rps.zip(speed_mps).filter(|(_, speed)| *speed > VehicleState::STANDING_BELOW_MPS);
        moving.map_or(0.0, |(yaw_rate, speed)| yaw_rate / speed)
    }

    /// Refuses a frame that has not the size that the calibration is for.
    ///
    /// # Errors
    /// [`PictureError::SizeMismatch`] with both sizes.
    pub fn check_size(&self, camera: &Camera) -> Result<(), PictureError> {
        let (expected_width, expected_height) = (camera.width(), camera.height());
        let (found_width, found_height) = (self.frame.width(), self.frame.height());
        if (found_width, found_height) == (expected_width, expected_height) {
            return Ok(());
        }
        let what = "frame";
        Err(PictureError::SizeMismatch { what, expected_width, expected_height, found_width, found_height })
    }
}

/// An edge of the lane.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LaneEdge {
    /// The inner edge of its marking, near to far, pixels.
    pub points_px: Vec<Pixel>,
    /// Where it passes the rear axle, metres to the left.
    pub offset_m: f64,
    /// Standard deviation of that, metres.
    pub offset_sigma_m: f64,
    /// Its direction against the vehicle's, radians, positive left.
    pub heading_rad: f64,
    /// Its curvature, 1/m, positive left.
    pub curvature_per_m: f64,
    /// Its marking.
    pub marking: Marking,
    /// Frames for which nothing new has been seen of it.
    pub kept_frames: u32,
}

/// The lane in which the vehicle is.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Lane {
    /// Left and right; kept where they are not given out, with their memory.
    edges: [LaneEdge; 2],
    shown: [bool; 2],
}

impl Lane {
    /// A lane with these edges, left and right; one that is none is not known.
    pub fn between(edges: [Option<LaneEdge>; 2]) -> Self {
        let shown = [edges[0].is_some(), edges[1].is_some()];
        Self { edges: edges.map(Option::unwrap_or_default), shown }
    }

    /// The edge on a side, where there is one.
    pub fn edge(&self, side: Side) -> Option<&LaneEdge> {
        Some(&self.edges[side.index()]).filter(|_| self.shown[side.index()])
    }

    /// Gives the edge on a side out; what it was when it was given out last is to be replaced, and its memory used again.
    pub const fn give_out(&mut self, side: Side) -> &mut LaneEdge {
        self.shown[side.index()] = true;
        &mut self.edges[side.index()]
    }

    /// Gives no edge out on a side.
    pub const fn withhold(&mut self, side: Side) {
        self.shown[side.index()] = false;
    }

    /// Its edges as lines on the road.
    pub fn on_road(&self) -> LaneOnRoad {
        let line = |side: Side| {
            self.edge(side).map(|edge| EdgeOnRoad {
                offset_m: edge.offset_m,
                heading_rad: edge.heading_rad,
                curvature_per_m: edge.curvature_per_m,
                kept_frames: edge.kept_frames,
            })
        };
        LaneOnRoad { left: line(Side::Left), right: line(Side::Right) }
    }

    /// Distance between the edges at the rear axle, metres.
    pub fn width_m(&self) -> Option<f64> {
        Some(self.edge(Side::Left)?.offset_m - self.edge(Side::Right)?.offset_m)
    }
}

/// How the lane was found.
#[derive(Debug, Clone, Default)]
pub struct LaneEvidence {
    /// Rows searched, and the sections.
    pub region: LaneRegion,
    /// What the steps up to thin lines made of the region.
    pub steps: EdgeSteps,
    /// Every line that the sections showed, and what became of it.
    pub candidates: Vec<LineCandidate>,
    /// Every place at which paint was looked for; none by the sections alone.
    pub traced: Vec<TracedPoint>,
    /// The camera's pitch against its mount by the lane's edges, radians.
    pub pitch_rad: f64,
    /// Whether each edge, left and right, is followed, given out or not.
    pub followed: [bool; 2],
}
