//! Road surface: which pixels are road, as a probability.
//!
//! Paper 1, section IV-B. A [`RoadDetector`] turns a picture and the place where road is assumed into a probability
//! for every seen pixel and none for unseen ones; better detectors take the place of the papers' behind the trait. The papers' bank
//! of known surfaces and their detector before the ground view are in `fingerpost-papers`.

mod appearance;
mod backprojection;
mod colours;
mod drive_colours;
mod fused;
mod known_surfaces;
mod looked_at;
mod memory;
mod named;
mod network;
mod online;
mod onnx;
mod perspective;
mod reduced_frame;
mod region;

use fingerpost_vision::backprojection::BackProjectionError;
use fingerpost_vision::colour::ColourError;
use fingerpost_vision::error::PictureError;
use fingerpost_vision::histogram::HistogramError;
use fingerpost_vision::picture::{Plane, Rect, RgbImage, ValidityMask};
use fingerpost_vision::road_network::{RoadNetwork, RoadNetworkError};
use fingerpost_vision::span::RowSums;
use nalgebra::Point2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use thiserror::Error;

pub use backprojection::{Backprojection, BackprojectionConfig};
pub use known_surfaces::{
    BankConfig, BankEvidence, SurfaceFile, SurfaceMemory, SurfaceRecord, SurfacesError,
};
pub use memory::{Memory, MemoryConfig, MemoryEvidence, RememberedMethod};
pub use network::{NETWORK_WEIGHTS, Network, NetworkOutput};
pub use online::{Online, OnlineConfig, OnlineEvidence};
pub use onnx::{ChannelOrder, Onnx, OnnxConfig, ScoreKind, TensorLayout, UserNetwork};
pub use perspective::{KnownPerspective, clear_unseen};
pub use region::Region;

use appearance::Appearance;
use fused::Fused;
use named::Named;

use crate::ground_view::{GroundPicture, GroundView};
use crate::motion::Motion;

/// Settings of road surface detection.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct RoadSurfaceConfig {
    /// How the road is distinguished from what is beside it.
    pub detector: RoadMethod,
    /// The picture in which "backprojection" and "bank" look for road, alone or remembered; the others choose theirs. "camera" is
    /// the papers' own (paper 1, figure 4).
    pub picture: RoadPicture,
    /// Length of the region assumed to be road, metres from the nearest place seen ahead.
    #[schemars(range(min = 0.5, max = 20.0))]
    pub sample_length_m: f64,
    /// Width of that region, metres.
    #[schemars(range(min = 0.2, max = 10.0))]
    pub sample_width_m: f64,
    /// The papers' detector.
    pub backprojection: BackprojectionConfig,
    /// The bank of known surfaces.
    pub bank: BankConfig,
    /// The classifier trained as the drive goes.
    pub online: OnlineConfig,
    /// The network that a user brings.
    pub onnx: OnnxConfig,
    /// The memory.
    pub memory: MemoryConfig,
}

impl Default for RoadSurfaceConfig {
    fn default() -> Self {
        Self {
            detector: RoadMethod::default(),
            picture: RoadPicture::default(),
            sample_length_m: 4.0,
            sample_width_m: 1.8,
            backprojection: BackprojectionConfig::default(),
            bank: BankConfig::default(),
            online: OnlineConfig::default(),
            onnx: OnnxConfig::default(),
            memory: MemoryConfig::default(),
        }
    }
}

/// Ways to tell road from everything else.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RoadMethod {
    /// The papers' histogram back-projection ([`Backprojection`]).
    Backprojection,
    /// Whatever looks like a known surface, the papers' own (`fingerpost_papers::Bank`).
    Bank,
    /// A classifier trained as the drive goes ([`Online`]).
    Online,
    /// The small network that comes with the program ([`Network`]).
    Network,
    /// A segmentation network that a user brings, in programs built for it ([`Onnx`]).
    Onnx,
    /// What another of these sees, remembered as the vehicle moves on ([`Memory`]).
    Memory,
    /// The same, with the surface under way named by the bank.
    #[default]
    Combined,
}

impl RoadMethod {
    /// All of them, the simplest first.
    pub const ALL: [Self; 7] = [
        Self::Backprojection,
        Self::Bank,
        Self::Online,
        Self::Network,
        Self::Onnx,
        Self::Memory,
        Self::Combined,
    ];

    /// Its name in configurations, command lines and evidence.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Backprojection => "backprojection",
            Self::Bank => "bank",
            Self::Memory => "memory",
            Self::Combined => "combined",
            Self::Online => "online",
            Self::Network => "network",
            Self::Onnx => "onnx",
        }
    }
}

/// The picture in which a detector by colour looks for road.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum RoadPicture {
    /// The ground view (paper 1, IV-B).
    #[default]
    GroundView,
    /// The camera picture; what is found there is then laid into the ground view (paper 1, figure 4, left).
    Camera,
}

/// [`RoadEvidence::uninformed_log_odds`] of detectors by the drive's colours: measured as ln(share of road / share of ground beside
/// roads) against the probability, over 18 drawn worlds, where it is zero at 0.83.
pub const UNINFORMED_LOG_ODDS_BY_COLOUR: f64 = 1.6;

/// Sides of the region assumed to be road in a camera picture, shares of the picture's: left, top, right, bottom. It is
/// what a forward-looking camera shows of the lane some metres ahead, above the bonnet.
const CAMERA_SAMPLE: [f64; 4] = [0.35, 0.72, 0.65, 0.95];

impl RoadSurfaceConfig {
    /// The detector of these settings; it has learned nothing yet.
    ///
    /// # Errors
    /// [`RoadError`] when its settings are out of range, or what sees is not a part of this crate.
    pub fn detector(&self) -> Result<Box<dyn RoadDetector>, RoadError> {
        self.detector_with(None)
    }

    /// The same with another detector that sees, alone or to be remembered: an [`Onnx`] where [`Self::needs_onnx`], or the
    /// papers'.
    ///
    /// # Errors
    /// [`RoadError`] when settings are out of range, or what sees is not a part of this crate and was not given.
    pub fn detector_with(
        &self,
        seeing: Option<Box<dyn RoadDetector>>,
    ) -> Result<Box<dyn RoadDetector>, RoadError> {
        let seeing = seeing.map_or_else(|| self.seeing(), Ok)?;
        Ok(match self.detector {
            RoadMethod::Memory => Box::new(Memory::new(self.detector, &self.memory, seeing)),
            RoadMethod::Combined => {
                let named = Box::new(Named::new(&self.bank, seeing)?);
                Box::new(Memory::new(self.detector, &self.memory, named))
            }
            _ => seeing,
        })
    }

    /// Whether the detector asks a user's network, itself or as what is remembered.
    pub fn needs_onnx(&self) -> bool {
        self.seen_by() == RememberedMethod::Onnx
    }

    /// What sees: the detector itself, or the one whose surfaces it remembers.
    pub const fn seen_by(&self) -> RememberedMethod {
        match self.detector {
            RoadMethod::Backprojection => RememberedMethod::Backprojection,
            RoadMethod::Bank => RememberedMethod::Bank,
            RoadMethod::Online => RememberedMethod::Online,
            RoadMethod::Network => RememberedMethod::Network,
            RoadMethod::Onnx => RememberedMethod::Onnx,
            RoadMethod::Memory | RoadMethod::Combined => self.memory.of,
        }
    }

    fn seeing(&self) -> Result<Box<dyn RoadDetector>, RoadError> {
        Ok(match (self.seen_by(), self.picture) {
            (RememberedMethod::Backprojection, RoadPicture::GroundView) => {
                Box::new(Backprojection::new(&self.backprojection)?)
            }
            (RememberedMethod::Backprojection, RoadPicture::Camera) => {
                return Err(RoadError::NoCameraPicture);
            }
            (RememberedMethod::Bank, _) => return Err(RoadError::NoBank),
            (RememberedMethod::Online, _) => Box::new(Online::new(&self.online)),
            (RememberedMethod::Network, _) => Box::new(Network::new()?),
            (RememberedMethod::Onnx, _) => return Err(RoadError::NoOnnx),
            (RememberedMethod::Fused, _) => {
                let online = Online::new(&self.online);
                Box::new(Fused::new(Appearance::new(online, &self.backprojection)?)?)
            }
        })
    }

    /// The region assumed to be road in a camera picture of `width` x `height` pixels: the bottom middle, 0.35 to 0.65 of
    /// the width and 0.72 to 0.95 of the height.
    pub fn sample_region_of_camera(width: usize, height: usize) -> Rect {
        let [left, top, right, bottom] = CAMERA_SAMPLE;
        let share = |side: usize, share: f64| (side as f64 * share).round() as usize;
        let (x, y) = (share(width, left), share(height, top));
        Rect { x, y, width: share(width, right) - x, height: share(height, bottom) - y }
    }

    /// The region assumed to be road in a ground view: straight ahead, from the bottom of what is seen.
    pub fn sample_region(&self, view: &GroundView) -> Rect {
        let grid = view.grid();
        let near = view.nearest_seen_m();
        let half = 0.5 * self.sample_width_m;
        let top_left = grid.ground_from_vehicle(Point2::new(near + self.sample_length_m, half));
        let bottom_right = grid.ground_from_vehicle(Point2::new(near, -half));
        let clamp = |value: f64, limit: usize| (value + 0.5).round().clamp(0.0, limit as f64) as usize;
        let (x, y) = (clamp(top_left.column, grid.columns()), clamp(top_left.row, grid.rows()));
        let (right, bottom) =
            (clamp(bottom_right.column, grid.columns()), clamp(bottom_right.row, grid.rows()));
        Rect { x, y, width: right - x, height: bottom - y }
    }
}

/// What a detector looks at.
#[derive(Debug, Clone, Copy)]
pub struct RoadInput<'a> {
    /// The picture in which road is wanted: ground view or camera picture.
    pub picture: &'a GroundPicture,
    /// Where `picture` may show road: what is seen, of a camera picture only rows below the horizon; the same size.
    pub validity: &'a ValidityMask,
    /// The region in front of the vehicle that is assumed to be road, pixels of `picture`.
    pub sample: Rect,
    /// How `picture` shows the road.
    pub perspective: Perspective<'a>,
    /// How the vehicle moved since the frame before, where that is known.
    pub motion: Option<&'a Motion>,
}

/// How a picture shows the road.
#[derive(Debug, Clone, Copy)]
pub enum Perspective<'a> {
    /// As the camera does; rows above `horizon_row` show no road.
    Camera {
        /// Row of the horizon, pixels from the centre of the top row.
        horizon_row: f64,
    },
    /// From above.
    Ground {
        /// The ground view.
        view: &'a GroundView,
        /// The frame that it was made from.
        frame: &'a RgbImage,
    },
}

/// The road surface of one frame.
#[derive(Debug, Clone, Default)]
pub struct RoadSurface {
    /// Probability of road, 255 = 1; 0 where nothing is known.
    pub probability: Plane<u8>,
    /// Prefix sums of `probability` over what is known, ready for [`RowSums::cover`].
    pub sums: RowSums,
    /// As of [`RoadEvidence::uninformed_log_odds`].
    pub uninformed_log_odds: f64,
    /// As of [`RoadEvidence::reduced_rows`].
    pub reduced_rows: f64,
}

/// What a pixel of a road surface is known from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Knowledge {
    /// The frame shows it.
    Seen,
    /// Earlier frames showed it.
    Remembered,
    /// Nothing.
    Unknown,
}

impl RoadSurface {
    /// Where the probability of road is known, seen or remembered.
    pub fn known(&self) -> &ValidityMask {
        self.sums.validity()
    }

    /// What a pixel is known from, where the frame shows what `validity` says.
    pub fn knowledge(&self, validity: &Plane<u8>, column: usize, row: usize) -> Knowledge {
        let holds = |mask: &Plane<u8>| mask.get(column, row).is_some_and(|value| value != 0);
        match (holds(validity), holds(self.known().plane())) {
            (true, _) => Knowledge::Seen,
            (false, true) => Knowledge::Remembered,
            (false, false) => Knowledge::Unknown,
        }
    }
}

/// How a detector came to its surface.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RoadEvidence {
    /// Name of the detector.
    pub detector: &'static str,
    /// Where it sampled, pixels.
    pub sample: Rect,
    /// What became of the sample.
    pub sample_use: SampleUse,
    /// Mean probability inside the sample, 0 to 1.
    pub sample_probability: f64,
    /// Histograms in the rolling mean; 0 for a detector without one.
    pub histograms: usize,
    /// Log-odds that its probability has of ground of which it knows nothing: what a reader with a prior of its own takes off.
    pub uninformed_log_odds: f64,
    /// Rows of the camera's picture that a row of what it looks at spans, where that is a reduced picture whose log-odds are interpolated; 0
    /// of other detectors.
    pub reduced_rows: f64,
    /// Which known surface is under way; none for a detector that knows none.
    pub bank: Option<BankEvidence>,
    /// What was learned and weighed; none for a detector that is not trained online.
    pub online: Option<OnlineEvidence>,
    /// What was remembered; none for a detector without a memory, and in camera pictures.
    pub memory: Option<MemoryEvidence>,
    /// Share of the places that may show road, 0 to 1, where what was learned on the drive decided against the network; none for a
    /// detector that does not join them.
    pub by_colours: Option<f64>,
}

/// What became of a frame's sample of the assumed road.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum SampleUse {
    /// It joined the model.
    Learned,
    /// It did not look like the road so far and was left out.
    LeftOut,
    /// It did not look like the road so far, but for so long that the surface must have changed.
    SurfaceChanged,
    /// The detector learns nothing on the drive.
    Unused,
    /// Nothing of the region was seen.
    #[default]
    Unseen,
}

/// A detector that cannot be used as configured, or on such a picture.
#[derive(Debug, Error)]
pub enum RoadError {
    /// The numbers of histogram bins cannot be used.
    #[error("road_surface: {0}")]
    Colour(#[from] ColourError),
    /// The histograms cannot be used.
    #[error("road_surface: {0}")]
    Histogram(#[from] HistogramError),
    /// The look-up or the disc cannot be used.
    #[error("road_surface: {0}")]
    BackProjection(#[from] BackProjectionError),
    /// Picture and validity do not fit together.
    #[error("road_surface: {0}")]
    Picture(#[from] PictureError),
    /// The known surfaces cannot be used.
    #[error(transparent)]
    Surfaces(#[from] SurfacesError),
    /// The weights of the network are damaged.
    #[error("road_surface: {0}")]
    Weights(#[from] RoadNetworkError),
    /// What network and colours count is not finite.
    #[error(
        "road_surface: the road network's file does not end with three finite numbers, what network and colours count and an offset; write it anew"
    )]
    EvidenceWeights,
    /// A user's network is asked for, and none was given.
    #[error(
        "road_surface asks for \"onnx\" and this program runs no networks: build it with `--features onnx`, or choose another \
         detector"
    )]
    NoOnnx,
    /// The bank of known surfaces is asked for, and was not given.
    #[error(
        "road_surface asks for \"bank\", the papers' own: give the pipeline the parts of `fingerpost_papers::parts`, or choose \
         another detector"
    )]
    NoBank,
    /// Road is to be looked for in the camera picture, and no detector that does was given.
    #[error(
        "road_surface.picture = \"camera\" is the papers' own: give the pipeline the parts of `fingerpost_papers::parts`, or choose \
         \"ground_view\""
    )]
    NoCameraPicture,
    /// The user's network fails.
    #[error("road_surface: {reason}")]
    Network {
        /// What it says.
        reason: String,
    },
}

/// A way to tell road from everything else.
pub trait RoadDetector: Send {
    /// The probability of road (255 is 1) of every pixel of `input` that may show road, 0 elsewhere, into `probability`,
    /// whose memory is reused.
    ///
    /// # Errors
    /// [`RoadError`] when picture, validity and sample do not fit together.
    fn estimate(
        &mut self,
        input: RoadInput<'_>,
        probability: &mut Plane<u8>,
    ) -> Result<RoadEvidence, RoadError>;

    /// Finds the road surface of `input`, into `surface`, whose memory is reused.
    ///
    /// # Errors
    /// [`RoadError`] as of [`RoadDetector::estimate`].
    fn detect(&mut self, input: RoadInput<'_>, surface: &mut RoadSurface) -> Result<RoadEvidence, RoadError> {
        let evidence = self.estimate(input, &mut surface.probability)?;
        surface.uninformed_log_odds = evidence.uninformed_log_odds;
        surface.reduced_rows = evidence.reduced_rows;
        surface.sums.rebuild(surface.probability.view(), input.validity)?;
        Ok(evidence)
    }

    /// Takes over surfaces known from earlier drives, in place of what was learned; a detector that knows none passes them by.
    ///
    /// # Errors
    /// [`RoadError::Surfaces`] when they cannot be used.
    fn know(&mut self, _surfaces: &SurfaceFile) -> Result<(), RoadError> {
        Ok(())
    }

    /// The surfaces known by now; none of a detector that knows none.
    fn known_surfaces(&self) -> Option<SurfaceFile> {
        None
    }

    /// The network that looked at the last picture; none of a detector that asks none. Its logits say more than where road is, by
    /// [`NetworkOutput`], at [`RoadNetwork::logit_place`] of a pixel of the frame.
    fn network(&self) -> Option<&RoadNetwork> {
        None
    }

    /// Forgets what was learned, as at the start of a drive.
    fn reset(&mut self);
}
