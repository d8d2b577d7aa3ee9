//! One line of `frames.jsonl`: what the program knew and decided in one frame.

use std::collections::BTreeMap;
use std::fmt::{self, Display, Formatter};

use serde::{Deserialize, Serialize};

use crate::FixStatus;
use crate::advice::AdviceRecord;
use crate::centreline::CentrelineRecord;
use crate::lanes::LanesRecord;

/// Where the search for a route feature stands (paper 1, section VI).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TrackState {
    /// No route was given.
    NoRoute,
    /// The next feature has not been found yet.
    Searching,
    /// A feature is followed.
    Tracking,
    /// The feature's driving line has begun; the vehicle is on its way through.
    Arrived,
    /// A followed feature could not be found again; it is searched for anew.
    Lost,
    /// Every feature of the route has been passed.
    RouteDone,
}

/// One frame of a run.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameRecord {
    /// Index of the frame in the input, from zero.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
    /// What the camera's picture was good for; none in broken frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<CameraRecord>,
    /// Where the search stands.
    pub state: TrackState,
    /// The followed or passed feature; none while searching.
    pub feature: Option<FeatureRecord>,
    /// The best match of the feature that is searched for; none while one is followed or none is in reach.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sought: Option<SoughtRecord>,
    /// Motion since the frame before; none in the first frame and after a broken one.
    pub motion: Option<MotionRecord>,
    /// Where the camera looks against its calibration; none for a camera known by points and in broken frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mount: Option<MountRecord>,
    /// What is known of the vehicle itself; none without its bus and in broken frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub signals: Option<SignalsRecord>,
    /// The road's surface; none after a broken frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub surface: Option<RoadSurfaceRecord>,
    /// The driving line through the feature: `[forward, left]` in the vehicle frame, metres.
    pub driving_line_m: Vec<[f64; 2]>,
    /// Signed curvature at each point of the driving line, 1/m, positive to the left.
    #[serde(default)]
    pub driving_line_curvature_per_m: Vec<f64>,
    /// The road's middle near the vehicle, and where to steer; none where it is not known.
    pub centreline: Option<CentrelineRecord>,
    /// Why there is no centreline: `nothing_shown`, `no_edges`, `too_few_sections`, `unsure`, `off`; none where there is one and
    /// in broken frames.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub no_centreline: Option<String>,
    /// Lane edges.
    pub lanes: Option<LanesRecord>,
    /// The vehicle's place on the map.
    pub fix: Option<FixRecord>,
    /// Steering angle and speed for a controller; none in records that do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub advice: Option<AdviceRecord>,
    /// Distance along the route at which the vehicle is believed to be, metres.
    #[serde(default)]
    pub route_m: Option<f64>,
    /// Wall time of every stage, milliseconds.
    pub stage_ms: BTreeMap<String, f64>,
    /// One sentence: what was decided and what decided it.
    pub why: String,
    /// What was wrong with the frame itself, where it could not be used.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
}

/// What the camera's picture was good for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct CameraRecord {
    /// Whether it shows anything.
    pub state: CameraRecordState,
    /// By how much a tenth of it differs from its neighbourhood at least, grey levels of 255.
    pub contrast: f64,
    /// The contrast that stands out from its noise, grey levels.
    pub needed_contrast: f64,
}

/// Whether a camera's picture shows anything.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CameraRecordState {
    /// It shows something, and something new.
    Clear,
    /// It is the picture of the frame before.
    Frozen,
    /// It is black.
    Black,
    /// Nothing in it stands out from noise: a covered or fogged lens.
    NoContrast,
}

impl Display for CameraRecordState {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Clear => "was clear",
            Self::Frozen => "was frozen",
            Self::Black => "was black",
            Self::NoContrast => "showed nothing (covered, fogged or dazzled)",
        })
    }
}

/// The followed feature in the vehicle frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FeatureRecord {
    /// OpenStreetMap node.
    pub id: i64,
    /// `junction`, `side_road` or `bend`.
    pub kind: String,
    /// P(F), paper 1 equation 2; none where no sub-mask could be seen.
    pub p: Option<f64>,
    /// P(F_sub) of each sub-mask that took part, paper 1 equation 1.
    pub sub: BTreeMap<String, f64>,
    /// How much more its arms are road than what lies just outside their edges.
    #[serde(default, skip_serializing_if = "ContrastRecord::is_unknown")]
    pub contrast: ContrastRecord,
    /// How sure it is, 0 to 1: P(F) times the probability that the arms which tell it end at a verge.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub confidence: Option<f64>,
    /// Probability that it is there, 0 to 1; none in records of programs that knew none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<f64>,
    /// Distance ahead, metres.
    pub forward_m: f64,
    /// Distance to the left, metres.
    pub left_m: f64,
    /// Direction of the feature's approach against the vehicle's, radians, positive to the left.
    pub heading_rad: f64,
    /// Standard deviations of `forward_m` and `left_m`, metres.
    pub sigma_m: [f64; 2],
    /// Other places where it may be, which `forward_m`, `left_m` and `sigma_m` contain.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<RivalRecord>,
}

/// A place where a feature may be, in the vehicle frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RivalRecord {
    /// Distance ahead, metres.
    pub forward_m: f64,
    /// Distance to the left, metres.
    pub left_m: f64,
    /// Standard deviations of `forward_m` and `left_m`, metres.
    pub sigma_m: [f64; 2],
    /// Probability that the feature is there, 0 to 1.
    pub present: f64,
}

/// The likeliest place of a feature that is searched for, and the match there, in the vehicle frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SoughtRecord {
    /// OpenStreetMap node.
    pub id: i64,
    /// P(F), paper 1 equation 2; none where no sub-mask could be seen.
    pub p: Option<f64>,
    /// P(F_sub) of each sub-mask that took part, paper 1 equation 1.
    pub sub: BTreeMap<String, f64>,
    /// How much more its arms are road there than what lies just outside their edges.
    #[serde(default)]
    pub contrast: ContrastRecord,
    /// Probability that it is anywhere in view, 0 to 1; none in records of programs that knew none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<f64>,
    /// Distance ahead of its likeliest place, metres.
    pub forward_m: f64,
    /// Distance of that place to the left, metres.
    pub left_m: f64,
}

/// How much more arms are road than what lies just outside their edges, -1 to 1.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct ContrastRecord {
    /// Mean over the arms that tell the feature from a plain road; none where no verge of theirs is seen.
    pub overall: Option<f64>,
    /// Each arm beside which a verge could be seen, by its label.
    pub arms: BTreeMap<String, f64>,
}

impl ContrastRecord {
    /// Whether no verge was seen, so that there is nothing to write.
    fn is_unknown(&self) -> bool {
        self.overall.is_none() && self.arms.is_empty()
    }
}

/// The vehicle's motion since the frame before, in the vehicle frame of that frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MotionRecord {
    /// Metres forward.
    pub forward_m: f64,
    /// Metres to the left.
    pub left_m: f64,
    /// Change of heading, radians, positive to the left.
    pub yaw_rad: f64,
    /// 0 (do not believe it) to 1.
    pub quality: f64,
    /// Why what was measured is not believed, so that nothing is known of the motion; none where nothing speaks against it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<MotionDoubtRecord>,
}

/// Why a motion is wrong: it goes less far forward than a vehicle whose camera is seen to travel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MotionDoubtRecord {
    /// What lies in the ground view clearly shows that motion.
    ViewStandsStill,
    /// The ground view does not show how far the vehicle moved.
    NothingToGoBy,
}

/// Whether the estimate of the camera's mount can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MountRecordState {
    /// Too little has been seen yet.
    NotYetValid,
    /// It can be used.
    Valid,
    /// The camera has been turned and its new direction is not known yet.
    Moved,
}

/// Where the camera looks against its calibration: what would have to be added to the mount's angles.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountRecord {
    /// Pitch, degrees, positive nose down, without the suspension's part.
    pub pitch_deg: f64,
    /// Yaw, degrees, positive left.
    pub yaw_deg: f64,
    /// Roll, degrees, positive left side up.
    pub roll_deg: f64,
    /// What the suspension adds to the pitch in this frame, degrees.
    pub suspension_pitch_deg: f64,
    /// Standard deviations of the four, in their order, degrees.
    pub sigma_deg: [f64; 4],
    /// Whether they can be used.
    pub state: MountRecordState,
    /// The camera's last move, while the state is `moved`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fault: Option<MountFaultRecord>,
    /// The calibrated angle that cannot be true by what the drive shows, while the state is `valid`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contradiction: Option<MountContradictionRecord>,
}

/// A calibrated angle of the mount that the drive contradicts.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountContradictionRecord {
    /// `pitch` or `yaw`.
    pub angle: String,
    /// What would have to be added to it, degrees.
    pub by_deg: f64,
    /// How much that may be at the most, degrees.
    pub most_deg: f64,
}

/// A camera that has been turned.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MountFaultRecord {
    /// `pitch`, `yaw` or `roll`.
    pub angle: String,
    /// By how much, degrees.
    pub by_deg: f64,
    /// The frame in which it began, as far as can be told.
    pub since_frame: u64,
}

/// Speed, yaw rate and turn signal, and where they come from.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct SignalsRecord {
    /// Speed, m/s.
    pub speed_mps: Option<f64>,
    /// Yaw rate, radians a second, positive to the left.
    pub yaw_rate_rps: Option<f64>,
    /// `left`, `right`, `off` or `unknown`.
    pub turn_signal: String,
    /// Where `speed`, `yaw_rate` and `turn_signal` come from: `can` or `camera`; those that are not known are left out.
    pub source: BTreeMap<String, String>,
    /// Why the bus's `speed`, `yaw_rate` or `turn_signal` was not used: `missing`, `late`, `out_of_range`, `jump`,
    /// `contradicts_camera`, `disagrees_with_camera`.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub not_used: BTreeMap<String, String>,
    /// Metres driven over the same way, where the bus's speed and the camera's disagree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disagreement_m: Option<DisagreementRecord>,
    /// Degrees turned in the same turns, where the bus's yaw rate and the camera's disagree.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disagreement_deg: Option<DisagreementRecord>,
}

/// What bus and camera say of the same stretches.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct DisagreementRecord {
    /// By the bus.
    pub bus: f64,
    /// By the camera.
    pub camera: f64,
    /// By what share of the larger they may differ, 0 to 1.
    pub allowed_share: f64,
}

/// The road's surface as it was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RoadSurfaceRecord {
    /// Name of the detector.
    pub detector: String,
    /// Mean probability of road just ahead of the vehicle, where road is assumed, 0 to 1.
    pub p: f64,
    /// The known surface under way, for a detector that knows any.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// How like that the road just ahead is, 0 to 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub likeness: Option<f64>,
    /// Share of the ground view that is not seen but remembered, for a detector with a memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remembered_share: Option<f64>,
}

impl Display for MountFaultRecord {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { angle, by_deg, since_frame } = self;
        write!(
            f,
            "the camera was turned by {by_deg:.1} degrees ({angle}) about frame {since_frame}; calibrate its mount anew"
        )
    }
}

/// The vehicle's place on the map.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FixRecord {
    /// Latitude, degrees.
    pub lat: f64,
    /// Longitude, degrees.
    pub lon: f64,
    /// Heading, radians anticlockwise from east.
    pub heading_rad: f64,
    /// Standard deviation of the place in its least sure direction, metres.
    pub sigma_m: f64,
    /// Protection level, metres; none where it cannot be said.
    pub bound_m: Option<f64>,
    /// What it is worth; none in records that do not say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub status: Option<FixStatus>,
    /// What was measured of the place in this frame, and what was made of it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measurements: Vec<MeasurementRecord>,
}

/// A measurement of the vehicle's place, beside its motion and the roads.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MeasurementRecord {
    /// `feature` or `gps`.
    pub kind: String,
    /// OpenStreetMap node of a feature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<i64>,
    /// Where it puts the vehicle against where it was expected, metres: of a feature, forward and left; of GPS, east and north. None
    /// where nothing was expected near.
    pub innovation_m: Option<[f64; 2]>,
    /// The same of its heading, radians, positive to the left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub innovation_rad: Option<f64>,
    /// Standard deviations of `innovation_m`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma_m: Option<[f64; 2]>,
    /// Probability that a feature is what it is taken for, once it is known where the vehicle may be.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub present: Option<f64>,
    /// Whether it counts.
    pub accepted: bool,
    /// Why it does not: `unlikely`, `disagrees`, `counted_before`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why_not: Option<String>,
}
