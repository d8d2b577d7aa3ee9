//! Track: which feature of the route is followed, and where it is.
//!
//! Paper 1, section VI. A feature is searched for from the route distance; once its masks match in a few frames in a
//! row it is tracked: ego-motion moves it, the masks are redrawn there and matched again. A feature that is not
//! confirmed is bracketed about its prediction, and lost only when that fails for a while. When the driving line's
//! start reaches the bottom of the view the vehicle has arrived, and the next feature of the route is searched for
//! while the one at hand is carried along until it is passed.

mod alignment;
mod candidates;
mod expectation;
mod pitch_doubt;
mod pose_filter;
mod route_stop;
mod shown;
mod tracker;

use nalgebra::{Isometry2, Matrix3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::camera_state::CameraEvidence;
use crate::matching::Match;
use crate::route_progress::GpsUse;

pub use alignment::{AlignmentConfig, CrossSection, CrossSectionUse};
pub use candidates::{CandidateSearch, Tried};
pub use expectation::{Expectation, ExpectedAhead};
pub use pose_filter::PoseFilter;
pub use route_stop::{RouteStop, TrackerSetting};
pub use tracker::{Moved, Tracker};

/// Settings of search and tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackConfig {
    /// P(F) from which a feature counts as seen, 0 to 1; default 0.75.
    pub detect_threshold: f64,
    /// P(F) that is enough where the arms that tell the feature stand out from their verges, 0 to detect_threshold;
    /// default 0.5.
    pub detect_threshold_at_verge: f64,
    /// Contrast with the verge that is enough for detection in `detect_frames` frames, above 0 to 1: with less it takes
    /// longer, and half of it or less is none; default 0.12.
    pub detect_contrast: f64,
    /// P(F) from which a tracked feature counts as confirmed, 0 to detect_threshold; default 0.65.
    pub confirm_threshold: f64,
    /// Frames in a row in which a feature must be seen to be tracked, at least 1; default 3.
    pub detect_frames: usize,
    /// Frames in a row without confirmation after which a tracked feature is lost, at least 1; default 10.
    pub lost_frames: usize,
    /// Step of the search along the road, metres; default 0.5.
    pub search_forward_step_m: f64,
    /// Step of the search across the road, metres; default 0.4.
    pub search_left_step_m: f64,
    /// How far the vehicle's heading may differ from the road's in the search, degrees; default 6.
    pub search_heading_deg: f64,
    /// Step of the search over headings, degrees; default 2.
    pub search_heading_step_deg: f64,
    /// Reach of the bracketing search along the road, metres; default 2.
    pub bracket_forward_m: f64,
    /// Reach of the bracketing search across the road, metres; default 1.
    pub bracket_left_m: f64,
    /// Reach of the bracketing search over headings, degrees; default 6.
    pub bracket_heading_deg: f64,
    /// How the place of a matched feature is made precise.
    pub alignment: AlignmentConfig,
}

impl Default for TrackConfig {
    fn default() -> Self {
        Self {
            detect_threshold: 0.75,
            detect_threshold_at_verge: 0.5,
            detect_contrast: 0.12,
            confirm_threshold: 0.65,
            detect_frames: 3,
            lost_frames: 10,
            search_forward_step_m: 0.5,
            search_left_step_m: 0.4,
            search_heading_deg: 6.0,
            search_heading_step_deg: 2.0,
            bracket_forward_m: 2.0,
            bracket_left_m: 1.0,
            bracket_heading_deg: 6.0,
            alignment: AlignmentConfig::default(),
        }
    }
}

impl TrackConfig {
    /// The least P(F) that confirms a tracked feature with this contrast.
    fn confirming_p(&self, contrast: Option<f64>) -> f64 {
        let stands_out = contrast.is_some_and(|contrast| contrast >= self.detect_contrast);
        if stands_out {
            self.detect_threshold_at_verge.min(self.confirm_threshold)
        } else {
            self.confirm_threshold
        }
    }

    /// Whether a tracked feature with this P(F) and contrast counts as confirmed.
    fn confirms(&self, p: f64, contrast: Option<f64>) -> bool {
        p >= self.confirming_p(contrast)
    }
}

/// Where the search stands after a frame.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum State {
    /// No route was given.
    #[default]
    NoRoute,
    /// The next feature has not been found yet.
    Searching,
    /// A feature is followed.
    Tracking,
    /// Its driving line has begun; the vehicle is on its way through.
    Arrived,
    /// It could not be found again and is searched for anew.
    Lost,
    /// Every feature of the route has been passed.
    RouteDone,
}

/// The followed feature after a frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// Index of the feature in the route.
    pub index: usize,
    /// Its pose.
    pub vehicle_from_feature: Isometry2<f64>,
    /// Covariance of its forward (m), left (m) and heading (rad).
    pub covariance: Matrix3<f64>,
    /// The match there; its pose is where the ground view shows the feature, which is made for the configured mount.
    pub matched: Match,
}

impl Followed {
    /// From places on the road to those at which the ground view shows them, near the feature: the view is made for the
    /// configured mount, the camera may look elsewhere.
    pub fn shown_from_road(&self) -> Isometry2<f64> {
        self.matched.vehicle_from_feature * self.vehicle_from_feature.inverse()
    }
}

/// What the tracker says after a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TrackOutput {
    /// Where the search stands.
    pub state: State,
    /// The followed feature; none while searching.
    pub followed: Option<Followed>,
    /// Believed distance along the route, metres; none while unknown.
    pub route_m: Option<f64>,
}

/// The best match of a feature that was searched for and is not followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Sought {
    /// Index of the feature in the route.
    pub index: usize,
    /// The best of the poses that were tried.
    pub vehicle_from_feature: Isometry2<f64>,
    /// The match there, good enough or not; its pose is where the ground view shows it.
    pub matched: Match,
}

/// What a candidate lacks to be detected: the first of the tests that it does not pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Missing {
    /// Frames in a row.
    Frames {
        /// How many are needed.
        needed: usize,
    },
    /// Contrast with the verge, summed over the frames beyond half of the one that is needed.
    Contrast {
        /// The sum.
        sum: f64,
        /// The sum that is needed.
        needed: f64,
    },
    /// A sure distance.
    Distance {
        /// Its standard deviation, metres.
        sigma_m: f64,
        /// The largest with which a feature is taken, metres.
        most_m: f64,
    },
}

/// What decided a frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub enum Decision {
    /// There is no route.
    #[default]
    NoRoute,
    /// The camera showed nothing, or nothing new, and nothing was looked for.
    NothingShown {
        /// What is wrong with the picture.
        camera: CameraEvidence,
    },
    /// The next feature is not in reach of the view yet.
    NotInReach {
        /// Index of the feature.
        index: usize,
        /// Believed distance to it, metres.
        ahead_m: f64,
    },
    /// The next feature was searched for and nothing matched well enough.
    NotFound {
        /// Index of the feature.
        index: usize,
    },
    /// The next feature matched, but something is still missing.
    Candidate {
        /// Index of the feature.
        index: usize,
        /// Frames in a row so far.
        frames: usize,
        /// P(F).
        p: f64,
        /// What is missing.
        missing: Missing,
    },
    /// It matched for many frames without ever being sure enough, and is looked for anew.
    Dropped {
        /// Index of the feature.
        index: usize,
        /// Frames in a row.
        frames: usize,
        /// Frames after which a candidate is given up.
        most_frames: usize,
    },
    /// It matched, but no verge is in view, and without one it does not match well enough.
    NoVergeInView {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// P(F) that is needed without a verge.
        needed_p: f64,
    },
    /// It matched without a verge in view, but where it is not expected.
    NotExpected {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// Loss in rank for the place, 0 where it is expected.
        surprise: f64,
        /// The loss from which on it is not taken.
        most: f64,
    },
    /// It matched where the vehicle would not be on the feature's approach.
    OffApproach {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// How far beside the approach's axis the vehicle would be, metres.
        beside_m: f64,
        /// How far it may be, metres.
        most_m: f64,
    },
    /// It matched, but none of the arms that tell it showed an edge of its road or a verge.
    Unbounded {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
    },
    /// It matched, but what lies beside the arms that tell it is road as well, or not verge enough so far from where the
    /// feature is expected.
    NoVerge {
        /// Index of the feature.
        index: usize,
        /// P(F).
        p: f64,
        /// How much more the arms are road than what lies beside them.
        contrast: f64,
        /// What more is needed because the feature is not expected there.
        surprise: f64,
    },
    /// It matched, but not where the edges of its arms say that it would have to be.
    EdgesDisagree {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// P(F) at the place that the edges say.
        aligned_p: f64,
        /// P(F) that is needed there.
        needed_p: f64,
    },
    /// It matched, but more edges of the arms that tell it lie too far from there than near it.
    EdgesElsewhere {
        /// Index of the feature.
        index: usize,
        /// P(F) at the best place.
        p: f64,
        /// How many edges lie too far off.
        gated: usize,
    },
    /// The feature matched in enough frames: it is tracked from now on.
    Detected,
    /// The masks at the predicted place confirmed it.
    Confirmed,
    /// They did not, but bracketing found it nearby.
    FoundByBracketing,
    /// Neither did; its place is dead reckoning.
    NotConfirmed {
        /// Frames in a row so far.
        frames: usize,
    },
    /// It was not confirmed for too long.
    Lost {
        /// Index of the feature.
        index: usize,
    },
    /// The driving line's start reached the bottom of the view.
    Arrived,
    /// The vehicle is on its way through.
    Passing,
    /// The next feature lies behind by all that is known; the one after it is searched for.
    Skipped {
        /// Index of the feature.
        index: usize,
    },
    /// Every feature has been passed.
    RouteDone,
}

/// How the tracker came to its output.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TrackEvidence {
    /// What decided the frame.
    pub decision: Decision,
    /// Where ego-motion put the followed feature, before any match, as the ground view shows it.
    pub predicted: Option<Isometry2<f64>>,
    /// P(F) there.
    pub predicted_p: Option<f64>,
    /// The bound that P(F) was held against, in a search, a confirmation or bracketing; none where it was not.
    pub needed_p: Option<f64>,
    /// Poses that were tried in a search or bracketing.
    pub tried: usize,
    /// The best match in a search, where the feature is not followed.
    pub sought: Option<Sought>,
    /// The cross-sections of the arms that made the place precise.
    pub sections: Vec<CrossSection>,
    /// What became of the GPS position, where there was one.
    pub gps: Option<GpsUse>,
}

impl TrackEvidence {
    /// Makes it that of a frame of which nothing is known yet, keeping its memory.
    fn clear(&mut self) {
        let mut sections = std::mem::take(&mut self.sections);
        sections.clear();
        *self = Self { sections, ..Self::default() };
    }
}
