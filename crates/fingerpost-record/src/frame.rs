//! From what the method says to a line of `frames.jsonl`.

use std::collections::BTreeMap;

use fingerpost::camera_state::{CameraEvidence, CameraState};
use fingerpost::matching::{Match, Participation};
use fingerpost::motion::{Motion, MotionDoubt};
use fingerpost::mount::{MountAngle, MountEstimate, MountState};
use fingerpost::road_surface::RoadEvidence;
use fingerpost::track::{Followed, PossiblePlace, RouteStop, Sought, State};
use fingerpost::vehicle_signals::{Disagreement, SignalSource, SignalsEvidence, TurnSignal, VehicleState};
use fingerpost::{FrameEvidence, FrameOutput};
use fingerpost_eval::FeatureIdentity;
use fingerpost_format::{
    CameraRecord, CameraRecordState, ContrastRecord, DisagreementRecord, FeatureRecord, FrameRecord,
    MotionDoubtRecord, MotionRecord, MountContradictionRecord, MountFaultRecord, MountRecord,
    MountRecordState, RivalRecord, RoadSurfaceRecord, SignalsRecord, SoughtRecord, TrackState,
};
use fingerpost_map::FeatureKind;

use crate::advice::advice_record;
use crate::centreline::{centreline_record, no_centreline_name};
use crate::fix::fix_record;
use crate::lanes::lanes_record;

/// Digits behind the point of metres (a tenth of a millimetre), probabilities and curvatures in the files: finer than
/// anything the method resolves.
pub const DIGITS: i32 = 4;
/// Digits of angles in radians: 10 micrometres at 10 m.
pub const ANGLE_DIGITS: i32 = 6;
/// Digits of seconds.
const TIME_DIGITS: i32 = 6;

/// A frame's place in the input.
#[derive(Debug, Clone, Copy)]
pub struct FrameTime {
    /// Index, from zero.
    pub frame: u64,
    /// Seconds since the first frame.
    pub t_s: f64,
}

/// What the features of a route are called in the files.
pub fn feature_identities(stops: &[RouteStop]) -> Vec<FeatureIdentity> {
    stops
        .iter()
        .map(|stop| FeatureIdentity {
            id: stop.model.id,
            name: stop.model.name.clone(),
            kind: kind_name(stop.model.kind).to_owned(),
            at_m: rounded(stop.model.route_m, DIGITS),
        })
        .collect()
}

/// Name of a kind of feature in the files.
pub const fn kind_name(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Junction => "junction",
        FeatureKind::SideRoad => "side_road",
        FeatureKind::Bend => "bend",
    }
}

/// The record of a frame that was processed.
pub fn frame_record(
    time: FrameTime,
    output: &FrameOutput,
    evidence: &FrameEvidence<'_>,
    features: &[FeatureIdentity],
    stage_ms: BTreeMap<String, f64>,
) -> FrameRecord {
    let followed = output.track.followed.as_ref();
    let (sought, places) = (evidence.track.sought.as_ref(), evidence.track.places.as_slice());
    FrameRecord {
        sought: sought.and_then(|sought| Some(sought_record(sought, places, features.get(sought.index)?))),
        frame: time.frame,
        t_s: rounded(time.t_s, TIME_DIGITS),
        camera: Some(camera_record(&output.camera)),
        state: track_state(output.track.state),
        feature: followed
            .and_then(|followed| Some(feature_record(followed, places, features.get(followed.index)?))),
        motion: output.motion.as_ref().map(|motion| motion_record(motion, output.motion_doubt)),
        mount: output.mount.as_ref().map(|mount| mount_record(mount, time.frame)),
        signals: evidence.signals.as_ref().map(|signals| signals_record(&output.vehicle, signals)),
        surface: (output.camera.state == CameraState::Clear).then(|| surface_record(&evidence.road)),
        driving_line_m: output.driving_line.iter().map(|p| [p.x, p.y].map(|m| rounded(m, DIGITS))).collect(),
        driving_line_curvature_per_m: output
            .driving_line_curvature_per_m
            .iter()
            .map(|curvature| rounded(*curvature, DIGITS))
            .collect(),
        centreline: output.centreline.as_ref().map(|found| centreline_record(found, evidence.centreline)),
        no_centreline: evidence.centreline.none_because.map(|why| no_centreline_name(why).to_owned()),
        lanes: output.lane.as_ref().map(|lane| lanes_record(lane, output.departure.as_ref())),
        advice: Some(advice_record(&output.advice)),
        fix: output.fix.as_ref().map(|fix| fix_record(fix, evidence.fix.as_ref(), features)),
        route_m: output.track.route_m.map(|m| rounded(m, DIGITS)),
        stage_ms,
        why: output.why.clone(),
        error: None,
    }
}

/// The record of a frame that could not be used: the state of the one before, or `at_first`, and what was wrong.
pub fn broken_record(
    time: FrameTime,
    before: Option<&FrameRecord>,
    at_first: TrackState,
    error: String,
) -> FrameRecord {
    FrameRecord {
        sought: None,
        frame: time.frame,
        t_s: rounded(time.t_s, TIME_DIGITS),
        camera: None,
        state: before.map_or(at_first, |record| record.state),
        feature: None,
        motion: None,
        mount: None,
        signals: None,
        surface: None,
        driving_line_m: Vec::new(),
        driving_line_curvature_per_m: Vec::new(),
        centreline: None,
        no_centreline: None,
        lanes: None,
        fix: None,
        advice: None,
        route_m: before.and_then(|record| record.route_m),
        stage_ms: BTreeMap::new(),
        why: "the frame could not be used and was passed over".to_owned(),
        error: Some(error),
    }
}

fn camera_record(camera: &CameraEvidence) -> CameraRecord {
    CameraRecord {
        state: match camera.state {
            CameraState::Clear => CameraRecordState::Clear,
            CameraState::Frozen => CameraRecordState::Frozen,
            CameraState::Black => CameraRecordState::Black,
            CameraState::NoContrast => CameraRecordState::NoContrast,
        },
        contrast: rounded(camera.contrast, DIGITS),
        needed_contrast: rounded(camera.needed_contrast, DIGITS),
    }
}

const fn angle_name(angle: MountAngle) -> &'static str {
    match angle {
        MountAngle::Pitch => "pitch",
        MountAngle::Yaw => "yaw",
        MountAngle::Roll => "roll",
    }
}

fn mount_record(mount: &MountEstimate, frame: u64) -> MountRecord {
    let degrees = |rad: f64| rounded(rad.to_degrees(), DIGITS);
    MountRecord {
        pitch_deg: degrees(mount.pitch_rad),
        yaw_deg: degrees(mount.yaw_rad),
        roll_deg: degrees(mount.roll_rad),
        suspension_pitch_deg: degrees(mount.suspension_pitch_rad),
        sigma_deg: mount.sigma_rad.map(degrees),
        state: match mount.state {
            MountState::NotYetValid => MountRecordState::NotYetValid,
            MountState::Valid => MountRecordState::Valid,
            MountState::Moved => MountRecordState::Moved,
        },
        fault: mount.fault.map(|fault| MountFaultRecord {
            angle: angle_name(fault.angle).to_owned(),
            by_deg: degrees(fault.by_rad),
            since_frame: frame.saturating_sub(fault.frames_since as u64),
        }),
        contradiction: mount.contradiction.map(|found| MountContradictionRecord {
            angle: angle_name(found.angle).to_owned(),
            by_deg: degrees(found.by_rad),
            most_deg: degrees(found.most_rad),
        }),
    }
}

fn signals_record(state: &VehicleState, evidence: &SignalsEvidence) -> SignalsRecord {
    let uses =
        [("speed", evidence.speed), ("yaw_rate", evidence.yaw_rate), ("turn_signal", evidence.turn_signal)];
    let source = |source| match source {
        SignalSource::Nowhere => None,
        SignalSource::Can => Some("can".to_owned()),
        SignalSource::Camera => Some("camera".to_owned()),
    };
    let disagreement = |found: Option<Disagreement>, unit: f64| {
        found.map(|Disagreement { bus, camera, allowed_share }| DisagreementRecord {
            bus: rounded(bus * unit, DIGITS),
            camera: rounded(camera * unit, DIGITS),
            allowed_share,
        })
    };
    SignalsRecord {
        disagreement_m: disagreement(evidence.speed_disagreement, 1.0),
        disagreement_deg: disagreement(evidence.yaw_rate_disagreement, 1_f64.to_degrees()),
        speed_mps: state.speed_mps.map(|mps| rounded(mps, DIGITS)),
        yaw_rate_rps: state.yaw_rate_rps.map(|rps| rounded(rps, ANGLE_DIGITS)),
        turn_signal: match state.turn_signal {
            TurnSignal::Unknown => "unknown",
            TurnSignal::Off => "off",
            TurnSignal::Left => "left",
            TurnSignal::Right => "right",
        }
        .to_owned(),
        source: uses.iter().filter_map(|(name, of)| Some(((*name).to_owned(), source(of.source)?))).collect(),
        not_used: uses
            .iter()
            .filter_map(|(name, of)| Some(((*name).to_owned(), of.not_used?.name().to_owned())))
            .collect(),
    }
}

const fn track_state(state: State) -> TrackState {
    match state {
        State::NoRoute => TrackState::NoRoute,
        State::Searching => TrackState::Searching,
        State::Tracking => TrackState::Tracking,
        State::Arrived => TrackState::Arrived,
        State::Lost => TrackState::Lost,
        State::RouteDone => TrackState::RouteDone,
    }
}

fn feature_record(
    followed: &Followed,
    places: &[PossiblePlace],
    identity: &FeatureIdentity,
) -> FeatureRecord {
    let pose = &followed.vehicle_from_feature;
    let sigma_m = [0, 1].map(|axis| followed.covariance[(axis, axis)].max(0.0).sqrt());
    FeatureRecord {
        id: identity.id,
        kind: identity.kind.clone(),
        p: followed.matched.p.map(|p| rounded(p, DIGITS)),
        sub: sub_probabilities(&followed.matched),
        contrast: contrast_record(&followed.matched),
        confidence: followed.matched.confidence().map(|p| rounded(p, DIGITS)),
        present: Some(rounded(followed.present, DIGITS)),
        forward_m: rounded(pose.translation.x, DIGITS),
        left_m: rounded(pose.translation.y, DIGITS),
        heading_rad: rounded(pose.rotation.angle(), ANGLE_DIGITS),
        sigma_m: sigma_m.map(|m| rounded(m, DIGITS)),
        rivals: places.iter().skip(1).map(rival_record).collect(),
    }
}

fn rival_record(place: &PossiblePlace) -> RivalRecord {
    let at = &place.vehicle_from_feature.translation;
    let sigma_m = [0, 1].map(|axis| place.covariance[(axis, axis)].max(0.0).sqrt());
    RivalRecord {
        forward_m: rounded(at.x, DIGITS),
        left_m: rounded(at.y, DIGITS),
        sigma_m: sigma_m.map(|m| rounded(m, DIGITS)),
        present: rounded(place.weight, DIGITS),
    }
}

fn sought_record(sought: &Sought, places: &[PossiblePlace], identity: &FeatureIdentity) -> SoughtRecord {
    let place = sought.vehicle_from_feature.translation;
    SoughtRecord {
        id: identity.id,
        p: sought.matched.p.map(|p| rounded(p, DIGITS)),
        sub: sub_probabilities(&sought.matched),
        contrast: contrast_record(&sought.matched),
        present: Some(rounded(places.iter().map(|place| place.weight).sum(), DIGITS)),
        forward_m: rounded(place.x, DIGITS),
        left_m: rounded(place.y, DIGITS),
    }
}

/// P(F_sub) of the sub-masks that take part.
fn sub_probabilities(matched: &Match) -> BTreeMap<String, f64> {
    let taking_part = matched.subs.iter().filter(|sub| sub.participation == Participation::TakesPart);
    taking_part.filter_map(|sub| Some((sub.label.to_string(), rounded(sub.p?, DIGITS)))).collect()
}

/// How much more the sub-masks that take part are road than their verges.
fn contrast_record(matched: &Match) -> ContrastRecord {
    let taking_part = matched.subs.iter().filter(|sub| sub.participation == Participation::TakesPart);
    let arms = taking_part.filter_map(|sub| Some((sub.label.to_string(), rounded(sub.contrast()?, DIGITS))));
    ContrastRecord {
        overall: matched.contrast().map(|contrast| rounded(contrast, DIGITS)),
        arms: arms.collect(),
    }
}

fn surface_record(road: &RoadEvidence) -> RoadSurfaceRecord {
    let known = road.bank.as_ref().filter(|bank| bank.surface.is_some());
    RoadSurfaceRecord {
        detector: road.detector.to_owned(),
        p: rounded(road.sample_probability, DIGITS),
        name: known.and_then(|bank| Some(bank.surface.as_ref()?.to_string())),
        likeness: known.map(|bank| rounded(bank.likeness, DIGITS)),
        remembered_share: road.memory.map(|memory| rounded(memory.remembered_share, DIGITS)),
    }
}

fn motion_record(motion: &Motion, doubt: Option<MotionDoubt>) -> MotionRecord {
    let pose = &motion.previous_from_current;
    MotionRecord {
        forward_m: rounded(pose.translation.x, DIGITS),
        left_m: rounded(pose.translation.y, DIGITS),
        yaw_rad: rounded(pose.rotation.angle(), ANGLE_DIGITS),
        quality: rounded(motion.quality, DIGITS),
        doubt: doubt.map(|doubt| match doubt {
            MotionDoubt::ViewStandsStill => MotionDoubtRecord::ViewStandsStill,
            MotionDoubt::NothingToGoBy => MotionDoubtRecord::NothingToGoBy,
        }),
    }
}

/// The doubt that a record has.
pub const fn motion_doubt(record: MotionDoubtRecord) -> MotionDoubt {
    match record {
        MotionDoubtRecord::ViewStandsStill => MotionDoubt::ViewStandsStill,
        MotionDoubtRecord::NothingToGoBy => MotionDoubt::NothingToGoBy,
    }
}

/// A number to so many digits behind the point.
pub fn rounded(value: f64, digits: i32) -> f64 {
    let scale = 10_f64.powi(digits);
    // Adding zero turns a negative zero into a plain one.
    (value * scale).round() / scale + 0.0
}
