//! Features, numbers, mounts and lanes as the sentence has them.

use std::fmt::{self, Display, Formatter};

use fingerpost_locate::{PoseInnovation, Verdict};
use fingerpost_map::FeatureKind;

use crate::camera_state::{CameraEvidence, CameraState};
use crate::centreline::Ways;
use crate::feature_masks::SubMaskKind;
use crate::fix::FixEvidence;
use crate::lanes::Side;
use crate::lanes::departure::{DepartureOutput, Silence};
use crate::matching::{Match, Participation};
use crate::mount::{MountAngle, MountContradiction, MountFault};
use crate::track::{Followed, Lack, RouteStop, Sought};
use crate::vehicle_signals::{Disagreement, SignalsEvidence};

/// Name of a kind of feature as a sentence has it.
fn kind_name(kind: FeatureKind) -> &'static str {
    match kind {
        FeatureKind::Junction => "junction",
        FeatureKind::SideRoad => "side road",
        FeatureKind::Bend => "bend",
    }
}

/// What decided where road is as a sentence has it: the network, or the drive's own colours against it.
pub(super) struct RoadWords {
    /// Share of the places that the colours decided, 0 to 1.
    pub(super) by_colours: f64,
}

impl Display for RoadWords {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("the network decided what is road")?;
        let percent = 100.0 * self.by_colours;
        if percent < 0.5 {
            Ok(())
        } else {
            write!(f, ", in {percent:.0} % of the places the colours of this drive")
        }
    }
}

/// A camera that has been moved as a sentence has it.
pub(super) struct MountFaultWords<'a>(pub(super) &'a MountFault);

impl Display for MountFaultWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let MountFault { angle, by_rad, frames_since } = self.0;
        let degrees = by_rad.abs().to_degrees();
        let way = match (angle, *by_rad > 0.0) {
            (MountAngle::Pitch, true) => "down",
            (MountAngle::Pitch, false) => "up",
            (MountAngle::Yaw, true) => "to the left",
            (MountAngle::Yaw, false) => "to the right",
            (MountAngle::Roll, true) => "about its axis, left side up",
            (MountAngle::Roll, false) => "about its axis, right side up",
        };
        write!(f, "the camera was turned by {degrees:.1} degrees {way}")?;
        write!(f, " {} ago, calibrate its mount anew", Frames(*frames_since))
    }
}

/// A calibration that cannot be true as a sentence has it.
pub(super) struct MountContradictionWords<'a>(pub(super) &'a MountContradiction);

impl Display for MountContradictionWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let MountContradiction { angle, by_rad, most_rad } = self.0;
        let angle = match angle {
            MountAngle::Pitch => "pitch",
            MountAngle::Yaw => "yaw",
            MountAngle::Roll => "roll",
        };
        write!(
            f,
            "the calibrated {angle} cannot be true: the drive shows it {:+.1} degrees off, at most {:.1} are believed, calibrate \
             the mount anew",
            by_rad.to_degrees(),
            most_rad.to_degrees()
        )
    }
}

/// The arms between which nothing decides, as a sentence has them.
pub(super) struct WaysWords<'a>(pub(super) &'a Ways);

impl Display for WaysWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let [left, _, right] = self.0.probability;
        write!(f, "the road ahead is ambiguous: to the left {left:.2}, to the right {right:.2}")
    }
}

/// Signals of the bus that do not agree with the camera, each ended by a semicolon; nothing where all do.
pub(super) struct SignalsWords<'a>(pub(super) &'a SignalsEvidence);

impl Display for SignalsWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let SignalsEvidence { speed_disagreement, yaw_rate_disagreement, .. } = self.0;
        if let Some(Disagreement { bus, camera, allowed_share }) = speed_disagreement {
            write!(
                f,
                "bus and camera disagree on the speed: {bus:.0} m against {camera:.0} m of the same way, at most {:.0} % can be, the \
                 camera's is used; check can.speed_unit, can.speed and the camera's height; ",
                100.0 * allowed_share
            )?;
        }
        if let Some(Disagreement { bus, camera, allowed_share }) = yaw_rate_disagreement {
            write!(
                f,
                "bus and camera disagree on the yaw rate: {:.0} degrees against {:.0} in the same turns, at most {:.0} % can be, the \
                 camera's is used; check can.yaw_rate_positive, can.yaw_rate_unit and the camera's mount; ",
                bus.to_degrees(),
                camera.to_degrees(),
                100.0 * allowed_share
            )?;
        }
        Ok(())
    }
}

/// A feature as a sentence has it.
pub(super) struct FeatureName<'a>(pub(super) Option<&'a RouteStop>);

impl Display for FeatureName<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(stop) => write!(f, "{} {}", kind_name(stop.model.kind), stop.model.id),
            None => f.write_str("no feature"),
        }
    }
}

/// A distance along the way, metres, as a sentence has it; with the digits that are asked for, else whole metres.
pub(super) struct Along(pub(super) f64);

impl Display for Along {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let side = if self.0 >= 0.0 { "ahead" } else { "behind" };
        write!(f, "{:.*} m {side}", f.precision().unwrap_or(0), self.0.abs())
    }
}

/// A number that may be negative, to hundredths; what rounds to zero has no sign.
struct Hundredths(f64);

impl Display for Hundredths {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let rounded = (100.0 * self.0).round() / 100.0;
        // Negative zero plus zero is zero.
        write!(f, "{:.2}", rounded + 0.0)
    }
}

/// A number of frames.
struct Frames(usize);

impl Display for Frames {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            1 => f.write_str("1 frame"),
            frames => write!(f, "{frames} frames"),
        }
    }
}

/// What a feature lacks to be tracked.
pub(super) struct LackWords<'a>(pub(super) &'a Lack);

impl Display for LackWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match self.0 {
            Lack::Presence { present, needed } => {
                write!(f, "there with probability {present:.2}, {needed:.2} is needed")
            }
            Lack::Place { present, sigma_m, most_m } => write!(
                f,
                "there with probability {present:.2}, but its place is known to {sigma_m:.2} m only, {most_m:.2} m is needed"
            ),
        }
    }
}

/// The likeliest place of a feature that is not followed.
pub(super) struct SoughtWords<'a>(pub(super) Option<&'a Sought>);

impl Display for SoughtWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        self.0.map_or(Ok(()), |sought| {
            write!(f, ", likeliest {:.1}", Along(sought.vehicle_from_feature.translation.x))
        })
    }
}

/// How probable a followed feature is, how well its place is known, and what its masks match.
pub(super) struct FollowedWords<'a>(pub(super) &'a Followed);

impl Display for FollowedWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Followed { present, covariance, matched, .. } = self.0;
        let sigma_m = covariance.fixed_view::<2, 2>(0, 0).trace().sqrt();
        write!(f, "there with probability {present:.2}, known to {sigma_m:.2} m; {}", MatchWords(matched))
    }
}

/// A driving line that the vehicle cannot drive: the radius of its tightest place, and that of the vehicle's turning circle.
pub(super) struct TooTightWords {
    pub(super) tightest_radius_m: f64,
    pub(super) turning_radius_m: f64,
}

impl Display for TooTightWords {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { tightest_radius_m, turning_radius_m } = self;
        write!(
            f,
            "the driving line turns at {tightest_radius_m:.2} m, the vehicle at no less than {turning_radius_m:.2} m"
        )
    }
}

/// The weakest sub-mask, and those that took no part.
struct MatchWords<'a>(&'a Match);

impl Display for MatchWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self(matched) = self;
        match matched.weakest.and_then(|i| matched.subs.get(i)) {
            Some(sub) => {
                let what = if sub.kind == SubMaskKind::DrivingLine { "weakest" } else { "weakest arm" };
                let p = sub.p.unwrap_or(0.0);
                write!(f, "{what} {} {p:.2}", sub.label)?;
            }
            None => f.write_str("no arm is seen")?,
        }
        if let Some(contrast) = matched.contrast() {
            write!(f, "; contrast with the verge {}", Hundredths(contrast))?;
        }
        let mut separator = ";";
        for sub in &matched.subs {
            let where_it_is = match sub.participation {
                Participation::TakesPart => continue,
                Participation::CutByValidity => "outside the picture",
                Participation::TooShort => "out of view",
            };
            write!(f, "{separator} {} {where_it_is}", sub.label)?;
            separator = ",";
        }
        Ok(())
    }
}

/// The lane's edges, left and right, as a sentence has them.
pub(super) struct LaneWords {
    /// For how many frames each has been kept without being seen; none where it is not given out.
    pub(super) kept_frames: [Option<u32>; 2],
    /// Whether each is followed, given out or not.
    pub(super) followed: [bool; 2],
}

impl Display for LaneWords {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        match (self.kept_frames, self.followed) {
            ([Some(0), Some(0)], _) => return f.write_str("both edges of the lane are seen"),
            ([None, None], [false, false]) => return f.write_str("no edge of a lane is seen"),
            _ => {}
        }
        let edges = self.kept_frames.into_iter().zip(self.followed);
        for (subject, (kept_frames, followed)) in
            ["the lane's left edge ", ", its right edge "].into_iter().zip(edges)
        {
            f.write_str(subject)?;
            match kept_frames {
                Some(0) => f.write_str("is seen")?,
                Some(1) => f.write_str("is not seen and kept")?,
                Some(frames) => write!(f, "has not been seen for {frames} frames and is kept")?,
                None if followed => f.write_str("is not sure yet")?,
                None => f.write_str("is not seen")?,
            }
        }
        Ok(())
    }
}

/// How the lane is left, as the end of a sentence has it; nothing while it is not.
pub(super) struct DepartureWords<'a>(pub(super) &'a DepartureOutput);

impl Display for DepartureWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let because = match (self.0.warning, self.0.silence) {
            (Some(Side::Left), _) => {
                return f.write_str("; warning: the vehicle leaves the lane to the left");
            }
            (Some(Side::Right), _) => {
                return f.write_str("; warning: the vehicle leaves the lane to the right");
            }
            (None, None) => return Ok(()),
            (None, Some(Silence::TurnSignal)) => "the driver signals",
            (None, Some(Silence::Slow)) => "the vehicle is slow",
            (None, Some(Silence::LaneChange)) => "the lane is being changed",
            (None, Some(Silence::CoolDown)) => "there has just been a warning",
        };
        write!(f, "; a wheel is at an edge, no warning because {because}")
    }
}

/// What measurements said of the vehicle's place on the map, as the end of a sentence has it; nothing where there were none.
pub(super) struct FixWords<'a> {
    pub(super) evidence: &'a FixEvidence,
    pub(super) stops: &'a [RouteStop],
}

impl Display for FixWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(seen) = &self.evidence.feature {
            write!(f, "; on the map {} ", FeatureName(self.stops.get(seen.landmark)))?;
            match (seen.verdict, &seen.innovation) {
                (Verdict::Accepted, Some(PoseInnovation { off: [forward_m, left_m, _], .. })) => {
                    let ahead = if *forward_m < 0.0 { "back" } else { "ahead" };
                    let side = if *left_m < 0.0 { "right" } else { "left" };
                    write!(
                        f,
                        "puts the vehicle {:.1} m {ahead} and {:.1} m to the {side} of where it was expected ({:.2} that it is this one)",
                        forward_m.abs(),
                        left_m.abs(),
                        seen.present
                    )?;
                }
                (Verdict::Counted, _) => f.write_str("has counted before")?,
                (Verdict::Unlikely, _) => f.write_str("does not count: it is hardly there")?,
                (Verdict::Accepted | Verdict::Disagrees, _) => {
                    write!(
                        f,
                        "does not count: no possible place agrees with it ({:.2} that it is this one)",
                        seen.present
                    )?;
                }
            }
        }
        let Some(gps) = &self.evidence.gps else { return Ok(()) };
        let [east_m, north_m] = gps.innovation_m;
        let believed = if gps.believed { "" } else { " and not believed" };
        write!(f, "; GPS {:.1} m off{believed}", libm::hypot(east_m, north_m))
    }
}

/// What is wrong with the camera's picture, and what follows from it.
pub(super) struct CameraWords<'a>(pub(super) &'a CameraEvidence);

impl Display for CameraWords<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let CameraEvidence { state, contrast, needed_contrast } = *self.0;
        match state {
            CameraState::Clear => return f.write_str("the camera shows the road"),
            CameraState::Frozen => {
                return f.write_str(
                    "the camera is frozen: its picture is that of the frame before, so nothing new is seen and the motion is \
                     not known",
                );
            }
            CameraState::Black => f.write_str("the camera is black: ")?,
            CameraState::NoContrast => {
                f.write_str("the camera shows nothing, as if it were covered, fogged or dazzled: ")?;
            }
        }
        write!(
            f,
            "a contrast of {contrast:.1} grey levels where {needed_contrast:.1} would stand out, so nothing is looked for and \
             the motion is not known"
        )
    }
}
