//! Track: which feature of the route is followed, and where it is.
//!
//! Paper 1, section VI: a feature is searched for where the route has it, tracked with ego-motion while the road confirms it,
//! and arrived at when the start of the driving path curve reaches the bottom of the view; then the next feature of the route is
//! searched for while the one at hand is carried along until it is passed. Here all of that is read off one belief: how
//! probable it is that the feature is there, and where ([`BeliefTracker`]).

mod belief;
mod config;
mod decision;
mod route_stop;
mod shown;

use fingerpost_vision::picture::ValidityMask;
use nalgebra::{Isometry2, Matrix3, Point2};

use crate::matching::{LaidSurface, Match};
use crate::motion::{CameraAttitude, Motion};
use crate::progress::{GpsUse, Travel};
use crate::road_surface::RoadSurface;

pub use belief::BeliefTracker;
pub use config::TrackConfig;
pub use decision::{Decision, Lack};
pub use route_stop::{RouteStop, TrackerSetting};

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
    /// Probability that it is there.
    pub present: f64,
    /// The same by what is seen of it alone, where it was as likely there as not: for who knows by other means where the vehicle may be.
    pub present_by_sight: f64,
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
}

impl TrackOutput {
    /// Forgets what is of the last frame alone.
    pub(crate) const fn begin_frame(&mut self) {
        (self.candidate, self.skipped) = (None, None);
    }
}

/// The match of a feature that was searched for and is not followed.
#[derive(Debug, Clone, PartialEq)]
pub struct Sought {
    /// Index of the feature in the route.
    pub index: usize,
    /// Its likeliest place.
    pub vehicle_from_feature: Isometry2<f64>,
    /// The match there; its pose is where the ground view shows it.
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
    /// Probability that it is there.
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
    /// Places that were tried.
    pub tried: usize,
    /// The match at the likeliest place in a search, where the feature is not followed.
    pub sought: Option<Sought>,
    /// Where the feature that is followed or searched for may be, the likeliest first.
    pub places: Vec<PossiblePlace>,
    /// Edges of the road at the likeliest of them, vehicle frame, metres: both ends of every piece.
    pub edges: Vec<[Point2<f64>; 2]>,
    /// What became of the GPS position, where there was one.
    pub gps: Option<GpsUse>,
}

impl TrackEvidence {
    /// Makes it that of a frame of which nothing is known yet, keeping its memory.
    fn clear(&mut self) {
        let Self { places, edges, .. } = std::mem::take(self);
        *self = Self { places, edges, ..Self::default() };
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
