//! Track: which feature of the route is followed, and where it is.
//!
//! Paper 1, section VI. A feature is searched for from the route distance; once its masks match in a few frames in a
//! row it is tracked: ego-motion moves it, the masks are redrawn there and matched again. A feature that is not
//! confirmed is bracketed about its prediction, and lost only when that fails for a while. When the driving line's
//! start reaches the bottom of the view the vehicle has arrived, and the next feature of the route is searched for
//! while the one at hand is carried along until it is passed.

mod alignment;
mod belief;
mod candidates;
mod expectation;
mod pitch_doubt;
mod pose_filter;
mod route_stop;
mod shown;
mod tracker;

use fingerpost_geometry::{GeometryError, GroundGrid};
use fingerpost_map::{FeatureKind, Route};
use fingerpost_vision::picture::ValidityMask;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Matrix3, Point2};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::camera_state::CameraEvidence;
use crate::feature_masks::{PlacedMasks, node_pixel};
use crate::feature_model::ArmModel;
use crate::matching::{LaidSurface, Match};
use crate::motion::{CameraAttitude, Motion};
use crate::progress::GpsUse;
use crate::road_surface::RoadSurface;

pub use alignment::{AlignmentConfig, CrossSection, CrossSectionUse};
pub use belief::BeliefTracker;
pub use candidates::{CandidateSearch, Tried};
pub use expectation::{Expectation, ExpectedAhead};
pub use pose_filter::PoseFilter;
pub use route_stop::{RouteStop, TrackerSetting};
pub use tracker::Tracker;

/// Settings of search and tracking.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct TrackConfig {
    /// How features are found and followed.
    pub method: TrackMethod,
    /// P(F) from which a feature counts as seen.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub detect_threshold: f64,
    /// P(F) that is enough where the arms that tell the feature stand out from their verges; at most
    /// `detect_threshold`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub detect_threshold_at_verge: f64,
    /// Contrast with the verge that is enough for detection in `detect_frames` frames: with less it takes longer, and
    /// half of it or less is none.
    #[schemars(range(min = 0.01, max = 1.0))]
    pub detect_contrast: f64,
    /// P(F) from which a tracked feature counts as confirmed; at most `detect_threshold`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub confirm_threshold: f64,
    /// Frames in a row in which a feature must be seen to be tracked.
    #[schemars(range(min = 1, max = 100))]
    pub detect_frames: usize,
    /// Frames in a row without confirmation after which a tracked feature is lost.
    #[schemars(range(min = 1, max = 1000))]
    pub lost_frames: usize,
    /// Step of the search along the road, metres.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub search_forward_step_m: f64,
    /// Step of the search across the road, metres.
    #[schemars(range(min = 0.05, max = 5.0))]
    pub search_left_step_m: f64,
    /// How far the vehicle's heading may differ from the road's in the search, degrees.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub search_heading_deg: f64,
    /// Step of the search over headings, degrees.
    #[schemars(range(min = 0.2, max = 45.0))]
    pub search_heading_step_deg: f64,
    /// Reach of the bracketing search along the road, metres.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bracket_forward_m: f64,
    /// Reach of the bracketing search across the road, metres.
    #[schemars(range(min = 0.0, max = 10.0))]
    pub bracket_left_m: f64,
    /// Reach of the bracketing search over headings, degrees.
    #[schemars(range(min = 0.0, max = 45.0))]
    pub bracket_heading_deg: f64,
    /// How the place of a matched feature is made precise.
    pub alignment: AlignmentConfig,
    /// What the method "belief" asks of a feature.
    pub belief: BeliefConfig,
}

/// How features are found and followed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum TrackMethod {
    /// By the match of the masks ([`Tracker`]).
    #[default]
    Rules,
    /// By the probability of every place and of none ([`BeliefTracker`]).
    Belief,
}

/// Settings of [`BeliefTracker`], which also takes `track.alignment.kerb_radius_m` and `track.alignment.width_sigma_share`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct BeliefConfig {
    /// Probability that a feature is there from which it is tracked.
    #[schemars(range(min = 0.5, max = 1.0))]
    pub detect_present: f64,
    /// Probability below which a tracked feature is lost; at most `detect_present`.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub lost_present: f64,
    /// Standard deviation of its place up to which a feature is tracked, metres: what a vehicle can still steer by.
    #[schemars(range(min = 0.1, max = 10.0))]
    pub detect_sigma_m: f64,
}

impl TrackConfig {
    /// The tracker of these settings at the start of `route`, or without one.
    ///
    /// # Errors
    /// [`GeometryError`] when a feature's arms have no extent.
    pub fn tracker(
        &self,
        setting: TrackerSetting<'_>,
        route: Option<&Route>,
        start_m: Option<f64>,
    ) -> Result<Box<dyn FeatureTracker>, GeometryError> {
        Ok(match self.method {
            TrackMethod::Rules => Box::new(Tracker::new(setting, route, start_m)?),
            TrackMethod::Belief => Box::new(BeliefTracker::new(setting, route, start_m)?),
        })
    }
}

impl Default for BeliefConfig {
    fn default() -> Self {
        Self { detect_present: 0.8, lost_present: 0.5, detect_sigma_m: 1.2 }
    }
}

impl Default for TrackConfig {
    fn default() -> Self {
        Self {
            method: TrackMethod::default(),
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
            belief: BeliefConfig::default(),
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
    /// Probability that it is there; none by the rules, which know none.
    pub present: Option<f64>,
    /// The match there; its pose is where the ground view shows the feature, which is made for the configured mount.
    pub matched: Match,
}

impl Followed {
    /// How far along the route it says that the vehicle is, and the standard deviation, metres.
    fn route_m(&self, stops: &[RouteStop]) -> Option<(f64, f64)> {
        let route_m = stops.get(self.index)?.model.route_m_of_vehicle(&self.vehicle_from_feature)?;
        Some((route_m, self.covariance.fixed_view::<2, 2>(0, 0).trace().sqrt()))
    }

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
    /// The next feature may be in view, but something is still missing.
    NotSure {
        /// Index of the feature.
        index: usize,
        /// What is missing.
        lack: Lack,
    },
    /// A tracked feature is not there, or its place is no longer sure.
    NoLongerSure {
        /// Index of the feature.
        index: usize,
        /// What is missing.
        lack: Lack,
    },
    /// Every feature has been passed.
    RouteDone,
}

/// What a feature lacks to be tracked by the belief: the first of the tests that it does not pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Lack {
    /// Evidence that it is there.
    Presence {
        /// Probability that it is.
        present: f64,
        /// The probability that is needed.
        needed: f64,
    },
    /// A sure place.
    Place {
        /// Probability that it is there.
        present: f64,
        /// Standard deviation of its place, metres.
        sigma_m: f64,
        /// The largest with which a feature is tracked, metres.
        most_m: f64,
    },
}

/// A place where a feature may be.
#[derive(Debug, Clone, PartialEq)]
pub struct PossiblePlace {
    /// The place.
    pub vehicle_from_feature: Isometry2<f64>,
    /// Covariance of its forward (m), left (m) and heading (rad).
    pub covariance: Matrix3<f64>,
    /// Probability that the feature is there.
    pub weight: f64,
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
    /// Where the feature that is followed or searched for may be, the likeliest first; none by the rules.
    pub places: Vec<PossiblePlace>,
    /// Edges of the road at the likeliest of them, vehicle frame, metres: both ends of every piece.
    pub edges: Vec<[Point2<f64>; 2]>,
    /// What became of the GPS position, where there was one.
    pub gps: Option<GpsUse>,
}

impl TrackEvidence {
    /// Makes it that of a frame of which nothing is known yet, keeping its memory.
    fn clear(&mut self) {
        let Self { sections, places, edges, .. } = std::mem::take(self);
        *self = Self { sections, places, edges, ..Self::default() };
        self.sections.clear();
        self.places.clear();
        self.edges.clear();
    }
}

/// How the vehicle moved since the last frame, and how the camera looks now.
#[derive(Debug, Clone, Copy, Default)]
pub struct Moved<'a> {
    /// The motion; none where it is not known.
    pub motion: Option<&'a Motion>,
    /// How the camera is turned against its mount; none where this frame says nothing of it.
    pub camera: Option<CameraAttitude>,
    /// Seconds that it took; none where frames have no times.
    pub dt_s: Option<f64>,
    /// Speed by the vehicle's bus, metres a second, positive forward; none where it says none.
    pub speed_mps: Option<f64>,
}

/// What a frame shows of the road.
#[derive(Debug, Clone, Copy)]
pub struct ShownSurface<'a> {
    /// The road surface.
    pub surface: &'a RoadSurface,
    /// Where this frame shows it, and it is not only remembered.
    pub seen: &'a ValidityMask,
    /// The same, ready for masks.
    pub laid: LaidSurface<'a>,
}

/// Finds and follows the features of a route, one after the other.
pub trait FeatureTracker: std::fmt::Debug + Send {
    /// The features of the route with their driving lines.
    fn stops(&self) -> &[RouteStop];

    /// Takes one frame in: how the vehicle moved, what it shows, and a GPS position in the map frame. Output and evidence take
    /// the place of the last frame's, whose memory is reused.
    ///
    /// # Errors
    /// [`SpanError`] when an arm cannot be drawn.
    fn step(
        &mut self,
        moved: Moved<'_>,
        shown: ShownSurface<'_>,
        gps_in_map: Option<Point2<f64>>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError>;

    /// Whether the vehicle is on its way through a junction at which the route turns: lanes end there, and lines cross its way.
    fn turns_through(&self, output: &TrackOutput) -> bool {
        let followed = output.followed.as_ref().filter(|_| output.state == State::Arrived);
        let model = followed.and_then(|followed| self.stops().get(followed.index)).map(|stop| &stop.model);
        model.is_some_and(|model| {
            model.kind == FeatureKind::Junction && model.exit().is_some_and(ArmModel::leaves_the_line)
        })
    }

    /// The masks of the followed feature, or else of the one searched for, where they matched.
    fn placed_masks(
        &self,
        output: &TrackOutput,
        evidence: &TrackEvidence,
        grid: &GroundGrid,
    ) -> Option<PlacedMasks<'_>> {
        let followed = output.followed.as_ref().map(|followed| (followed.index, &followed.matched));
        let sought = evidence.sought.as_ref().map(|sought| (sought.index, &sought.matched));
        let (index, matched) = followed.or(sought)?;
        let pose = &matched.vehicle_from_feature;
        let masks = self.stops().get(index)?.masks.drawn(pose.rotation.angle())?;
        let (column, row) = node_pixel(grid, pose);
        Some(PlacedMasks { masks, column, row })
    }
}
