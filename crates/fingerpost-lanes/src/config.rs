//! Settings of the lane finder.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::departure::DepartureConfig;
use super::{LaneDetector, LaneError, LaneFinder};

/// Whether lanes are looked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LaneMethod {
    /// By their markings' paint, followed on the road (beyond paper 3).
    #[default]
    Markings,
    /// By straight lines in sections of the picture, joined by a spline, paper 3's own (`fingerpost_papers::SectionTracker`);
    /// knows no paint, no lane widths and no kinds of markings.
    Sections,
    /// Not at all.
    Off,
}

/// Settings of the lane finder (paper 3, section III).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LanesConfig {
    /// How lanes are found.
    pub finder: LaneMethod,
    /// Paper 3's own (finder "sections"): time that a driver needs to begin to brake, seconds; with the speed it gives how far
    /// ahead of the vehicle's front lines are searched for; by default that of a driver on the telephone (table I). Of "markings"
    /// it only says where a new edge's first line is looked for.
    #[schemars(range(min = 0.1, max = 5.0))]
    pub reaction_time_s: f64,
    /// Least distance from the rear axle to which lines are searched for, however slow the vehicle, metres; by default that
    /// of the smallest region of the paper's table II.
    #[schemars(range(min = 8.0, max = 100.0))]
    pub least_range_m: f64,
    /// Distance from the rear axle to which an edge that is followed is read and given out, and lines are searched for at the
    /// most, and where the speed is not known, metres; no less than the least; by default that of the largest region of the
    /// paper's table II.
    #[schemars(range(min = 10.0, max = 150.0))]
    pub most_range_m: f64,
    /// Paper 3's own (finder "sections"): frames in the buffer that strengthens broken markings. Of "markings" it only says in
    /// what a new edge's first line is looked for.
    #[schemars(range(min = 1, max = 30))]
    pub buffer_frames: usize,
    /// Lower threshold of the edge detector against the upper one.
    #[schemars(range(min = 0.1, max = 1.0))]
    pub canny_low_share: f64,
    /// Upper threshold of the edge detector, in levels of the Sobel gradient (a step of one level reads about 4); on a
    /// rough road it is raised with the gradients that are common there.
    #[schemars(range(min = 8.0, max = 1000.0), extend("x-unit" = "levels of the Sobel gradient"))]
    pub canny_high: f64,
    /// How far a lane may point away from the vehicle's direction, degrees.
    #[schemars(range(min = 1.0, max = 45.0))]
    pub max_heading_deg: f64,
    /// Least area of a piece of edge, pixels of a picture 640 wide.
    #[schemars(range(min = 1.0, max = 10000.0))]
    pub min_area_px: f64,
    /// Sections into which the region is divided.
    #[schemars(range(min = 2, max = 8))]
    pub sections: usize,
    /// Height of each section against that of the one before it.
    #[schemars(range(min = 0.3, max = 1.0))]
    pub section_ratio: f64,
    /// How much a line may turn from one section to the next, degrees in the picture.
    #[schemars(range(min = 1.0, max = 45.0))]
    pub max_turn_deg: f64,
    /// How far beside the vehicle's middle a lane's edge may be, metres.
    #[schemars(range(min = 1.0, max = 10.0))]
    pub max_offset_m: f64,
    /// Least width of a lane, metres.
    #[schemars(range(min = 1.5, max = 4.0))]
    pub min_width_m: f64,
    /// Largest width of a lane, metres; no less than the least.
    #[schemars(range(min = 2.5, max = 12.0))]
    pub max_width_m: f64,
    /// Frames for which an edge is kept although nothing of it is seen.
    #[schemars(range(min = 0, max = 200))]
    pub keep_frames: u32,
    /// When leaving the lane is warned of.
    pub departure: DepartureConfig,
}

impl Default for LanesConfig {
    fn default() -> Self {
        Self {
            finder: LaneMethod::Markings,
            reaction_time_s: 0.465,
            least_range_m: 10.4,
            most_range_m: 35.0,
            buffer_frames: 3,
            canny_low_share: 0.4,
            canny_high: 50.0,
            max_heading_deg: 15.0,
            min_area_px: 25.0,
            sections: 4,
            section_ratio: 0.7,
            max_turn_deg: 8.0,
            max_offset_m: 3.6,
            min_width_m: 2.2,
            max_width_m: 5.2,
            keep_frames: 15,
            departure: DepartureConfig::default(),
        }
    }
}

impl LanesConfig {
    /// The finder of these settings; none where lanes are not wanted.
    ///
    /// # Errors
    /// [`LaneError`] when its kernels cannot be set up, or the papers' own is asked for, which is not a part of this crate.
    pub fn finder(&self) -> Result<Option<Box<dyn LaneDetector>>, LaneError> {
        Ok(match self.finder {
            LaneMethod::Markings => Some(Box::new(LaneFinder::new(self)?)),
            LaneMethod::Sections => return Err(LaneError::NotGiven),
            LaneMethod::Off => None,
        })
    }
}
