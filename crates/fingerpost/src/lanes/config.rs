//! Settings of the lane finder.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::departure::DepartureConfig;
use super::{LaneError, LaneFinder};
use crate::config::{ConfigError, check_ranges};

/// Whether lanes are looked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum LaneMethod {
    /// By their markings (paper 3).
    #[default]
    Markings,
    /// Not at all.
    Off,
}

/// Settings of the lane finder (paper 3, section III).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct LanesConfig {
    /// "markings": lanes are found by their markings; "off": none are looked for; default "markings".
    pub finder: LaneMethod,
    /// Time that a driver needs to begin to brake, seconds, 0.1 to 5; with the speed it gives how far ahead of the vehicle's
    /// front lanes must be read; default 0.465, a driver on the telephone (paper 3, table I).
    pub reaction_time_s: f64,
    /// Least distance from the rear axle to which lanes are read, metres, 8 to 100; default 35, the largest region
    /// of the paper's table II.
    pub least_range_m: f64,
    /// Farthest distance from the rear axle to which lanes are read, metres, 10 to 150; default 60.
    pub most_range_m: f64,
    /// Frames in the buffer that strengthens broken markings, 1 to 30; default 3.
    pub buffer_frames: usize,
    /// Lower threshold of the edge detector against the upper one, 0.1 to 1; default 0.4.
    pub canny_low_share: f64,
    /// Upper threshold of the edge detector, in levels of the Sobel gradient (a step of one level reads about 4), 8 to
    /// 1000; on a rough road it is raised with the gradients that are common there; default 50.
    pub canny_high: f64,
    /// How far a lane may point away from the vehicle's direction, degrees, 1 to 45; default 15.
    pub max_heading_deg: f64,
    /// Least area of a piece of edge, pixels of a picture 640 wide, 1 to 10000; default 25.
    pub min_area_px: f64,
    /// Sections into which the region is divided, 2 to 8; default 4.
    pub sections: usize,
    /// Height of each section against that of the one before it, 0.3 to 1; default 0.7.
    pub section_ratio: f64,
    /// How much a line may turn from one section to the next, degrees in the picture, 1 to 45; default 8.
    pub max_turn_deg: f64,
    /// How far beside the vehicle's middle a lane's edge may be, metres, 1 to 10; default 3.6.
    pub max_offset_m: f64,
    /// Least width of a lane, metres, 1.5 to 4; default 2.2.
    pub min_width_m: f64,
    /// Largest width of a lane, metres, 2.5 to 12; default 5.2.
    pub max_width_m: f64,
    /// Frames for which an edge is kept although nothing of it is seen, 0 to 200; default 15.
    pub keep_frames: u32,
    /// Frames in a row that must show a faint edge before it is given out, 1 to 50; a clear one is given out at once;
    /// default 3.
    pub show_frames: u32,
    /// When leaving the lane is warned of.
    pub departure: DepartureConfig,
}

impl Default for LanesConfig {
    fn default() -> Self {
        Self {
            finder: LaneMethod::Markings,
            reaction_time_s: 0.465,
            least_range_m: 35.0,
            most_range_m: 60.0,
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
            show_frames: 3,
            departure: DepartureConfig::default(),
        }
    }
}

impl LanesConfig {
    /// The finder of these settings; none where lanes are not wanted.
    ///
    /// # Errors
    /// [`LaneError`] when its kernels cannot be set up.
    pub fn finder(&self) -> Result<Option<LaneFinder>, LaneError> {
        match self.finder {
            LaneMethod::Markings => LaneFinder::new(self).map(Some),
            LaneMethod::Off => Ok(None),
        }
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`ConfigError`] names the first key out of range.
    pub fn check(&self) -> Result<(), ConfigError> {
        check_ranges(&[
            ("lanes.reaction_time_s", self.reaction_time_s, 0.1, 5.0, "0.1 to 5 seconds"),
            ("lanes.least_range_m", self.least_range_m, 8.0, 100.0, "8 to 100 metres"),
            (
                "lanes.most_range_m",
                self.most_range_m,
                self.least_range_m.max(10.0),
                150.0,
                "10 to 150 metres, no less than the least",
            ),
            ("lanes.buffer_frames", self.buffer_frames as f64, 1.0, 30.0, "1 to 30 frames"),
            ("lanes.canny_low_share", self.canny_low_share, 0.1, 1.0, "a share, 0.1 to 1"),
            ("lanes.canny_high", self.canny_high, 8.0, 1000.0, "8 to 1000 levels"),
            ("lanes.max_heading_deg", self.max_heading_deg, 1.0, 45.0, "1 to 45 degrees"),
            ("lanes.min_area_px", self.min_area_px, 1.0, 1e4, "1 to 10000 pixels"),
            ("lanes.sections", self.sections as f64, 2.0, 8.0, "2 to 8 sections"),
            ("lanes.section_ratio", self.section_ratio, 0.3, 1.0, "a ratio, 0.3 to 1"),
            ("lanes.max_turn_deg", self.max_turn_deg, 1.0, 45.0, "1 to 45 degrees"),
            ("lanes.max_offset_m", self.max_offset_m, 1.0, 10.0, "1 to 10 metres"),
            ("lanes.min_width_m", self.min_width_m, 1.5, 4.0, "1.5 to 4 metres"),
            (
                "lanes.max_width_m",
                self.max_width_m,
                self.min_width_m.max(2.5),
                12.0,
                "2.5 to 12 metres, no less than the least",
            ),
            ("lanes.keep_frames", f64::from(self.keep_frames), 0.0, 200.0, "0 to 200 frames"),
            ("lanes.show_frames", f64::from(self.show_frames), 1.0, 50.0, "1 to 50 frames"),
        ])?;
        self.departure.check()
    }
}
