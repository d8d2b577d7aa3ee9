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
mod config;
mod decision;
mod directions;
mod expectation;
mod pitch_doubt;
mod pose_filter;
mod reach;
mod route_stop;
mod shown;
mod tracker;

use fingerpost_geometry::GroundGrid;
use fingerpost_map::FeatureKind;
use fingerpost_vision::picture::ValidityMask;
use fingerpost_vision::span::SpanError;
use nalgebra::{Isometry2, Matrix3, Point2};

use crate::feature_masks::{PlacedMasks, node_pixel};
use crate::feature_model::ArmModel;
use crate::matching::{LaidSurface, Match};
use crate::motion::{CameraAttitude, FeatureStep, Motion};
use crate::progress::{GpsUse, Travel};
use crate::road_surface::RoadSurface;

pub use alignment::{AlignmentConfig, CrossSection, CrossSectionUse};
pub use belief::BeliefTracker;
pub use candidates::{CandidateSearch, Tried};
pub use config::{BeliefConfig, TrackConfig, TrackMethod};
pub use decision::{Decision, Lack, Missing};
pub use directions::Directions;
pub use expectation::{Expectation, ExpectedAhead};
pub use pose_filter::PoseFilter;
pub use reach::Reach;
pub use route_stop::{RouteStop, TrackerSetting};
pub use tracker::Tracker;

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
    /// Its standard deviation, metres; none while unknown.
    pub route_sigma_m: Option<f64>,
    /// The feature that is searched for, where only its place is not sure enough to follow it.
    pub candidate: Option<CandidatePlace>,
    /// Index of a feature that was given up in this frame because it lies behind by all that is known and was never seen.
    pub skipped: Option<usize>,
    /// How the vehicle moved by the feature at hand, where edges of it were seen; none by the belief.
    pub step: Option<FeatureStep>,
}

impl TrackOutput {
    /// Forgets what is of the last frame alone.
    pub(crate) const fn begin_frame(&mut self) {
        (self.candidate, self.skipped, self.step) = (None, None, None);
    }
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

/// A feature that is searched for and seen, whose place is not sure enough yet to follow it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CandidatePlace {
    /// Index of the feature in the route.
    pub index: usize,
    /// Its likeliest place.
    pub vehicle_from_feature: Isometry2<f64>,
    /// Covariance of its forward (m), left (m) and heading (rad).
    pub covariance: Matrix3<f64>,
    /// Probability that it is there; by the rules P(F), which is of its masks alone.
    pub present: f64,
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
    /// The motion; none before there is one, as in the first frame.
    pub motion: Option<&'a Motion>,
    /// How the camera is turned against its mount; none where this frame says nothing of it.
    pub camera: Option<CameraAttitude>,
    /// Seconds that it took; none where frames have no times.
    pub dt_s: Option<f64>,
    /// Speed by the vehicle's bus, metres a second, positive forward; none where it says none.
    pub speed_mps: Option<f64>,
}

/// A motion less sure than this leaves the ground behind, metres: edges of the road are no longer where they are remembered.
const LEFT_BEHIND_M: f64 = 2.0;
/// Seconds from frame to frame where no times are known: ten frames a second.
const FRAME_S: f64 = 0.1;
/// Standard deviation of a speed that is not the camera's, share of it: wheels wear and slip.
const SPEED_SIGMA_SHARE: f64 = 0.03;
/// Standard deviation of the speed of a vehicle that hardly moves, metres a second.
const SPEED_SIGMA_MPS: f64 = 0.1;

impl Moved<'_> {
    /// Seconds that it took.
    fn time_s(&self) -> f64 {
        self.dt_s.unwrap_or(FRAME_S)
    }

    /// How far the vehicle came along its way: by the motion, or where that is not known by its bus; none in a first frame.
    fn travel(&self) -> Option<Travel> {
        let motion = self.motion?;
        let sigma_m = motion.covariance[(0, 0)].sqrt();
        if sigma_m < LEFT_BEHIND_M {
            return Some(Travel::Measured { forward_m: motion.previous_from_current.translation.x, sigma_m });
        }
        Some(self.speed_mps.map_or(Travel::Unknown, |forward_mps| Travel::Speed {
            forward_mps,
            sigma_mps: libm::hypot(SPEED_SIGMA_SHARE * forward_mps, SPEED_SIGMA_MPS),
        }))
    }
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
