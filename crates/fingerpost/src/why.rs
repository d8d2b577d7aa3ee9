//! The sentence that says what was decided in a frame and what decided it: of the route's feature, of the place on the map, then of the
//! lane.

mod words;

use std::fmt::{self, Display, Formatter, Write};

use self::words::{
    Along, CameraWords, DepartureWords, FeatureName, FixWords, FollowedWords, LackWords, LaneWords,
    MountContradictionWords, MountFaultWords, RoadWords, SignalsWords, SoughtWords, TooTightWords, WaysWords,
};
use crate::camera_state::CameraEvidence;
use crate::centreline::CentrelineEvidence;
use crate::driving_line::DrivingLine;
use crate::fix::FixEvidence;
use crate::lanes::departure::DepartureOutput;
use crate::lanes::{Lane, LaneEvidence, Side};
use crate::motion::MotionDoubt;
use crate::mount::MountEstimate;
use crate::track::{Decision, Followed, RouteStop, State, TrackEvidence, TrackOutput};
use crate::vehicle_signals::SignalsEvidence;

/// What was decided in a frame and what decided it, as one sentence.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Why<'a> {
    /// What the camera's picture was good for.
    pub(crate) camera: &'a CameraEvidence,
    /// Why the vehicle's motion is not believed, where it is not.
    pub(crate) motion_doubt: Option<MotionDoubt>,
    /// What the tracker says.
    pub(crate) track: &'a TrackOutput,
    /// How it came to that.
    pub(crate) evidence: &'a TrackEvidence,
    /// The features of the route.
    pub(crate) stops: &'a [RouteStop],
    /// The camera's mount, where it is estimated.
    pub(crate) mount: Option<&'a MountEstimate>,
    /// How the vehicle's signals were judged, where it has a bus.
    pub(crate) signals: Option<&'a SignalsEvidence>,
    /// The lane and how it was found, where it is looked for.
    pub(crate) lane: Option<(&'a Lane, &'a LaneEvidence)>,
    /// Whether no lane is looked for because the vehicle turns through a junction.
    pub(crate) turns_through: bool,
    /// How the road's middle was found.
    pub(crate) centreline: &'a CentrelineEvidence,
    /// Share of the places in which the drive's own colours decided what is road against the network, where these two did.
    pub(crate) by_colours: Option<f64>,
    /// How the vehicle moves towards the lane's edges, where that is known.
    pub(crate) departure: Option<&'a DepartureOutput>,
    /// What was made of measurements of the vehicle's place, where there is a map.
    pub(crate) fix: Option<&'a FixEvidence>,
}

impl Why<'_> {
    /// Writes the sentence in place of what `text` was, reusing its memory.
    pub(crate) fn write_to(self, text: &mut String) {
        text.clear();
        // Writing to a string cannot fail.
        let _ = write!(text, "{self}");
    }
}

impl Display for Why<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        if let Some(fault) = self.mount.and_then(|mount| mount.fault.as_ref()) {
            write!(f, "{}; ", MountFaultWords(fault))?;
        }
        if let Some(contradiction) = self.mount.and_then(|mount| mount.contradiction.as_ref()) {
            write!(f, "{}; ", MountContradictionWords(contradiction))?;
        }
        if let Some(doubt) = self.motion_doubt {
            write!(f, "the motion is not believed: {doubt}; ")?;
        }
        if let Some(signals) = self.signals {
            write!(f, "{}", SignalsWords(signals))?;
        }
        self.write_feature(f)?;
        if let Some(ways) = self.centreline.ways.as_ref().filter(|ways| ways.is_ambiguous()) {
            write!(f, "; {}", WaysWords(ways))?;
        }
        if self.turns_through {
            f.write_str("; no lane is claimed while the vehicle turns through the junction")?;
        }
        if let Some(evidence) = self.fix {
            write!(f, "{}", FixWords { evidence, stops: self.stops })?;
        }
        if let Some(share) = self.by_colours {
            write!(f, "; {}", RoadWords { by_colours: share })?;
        }
        let Some((lane, evidence)) = self.lane else { return Ok(()) };
        let kept_frames = Side::BOTH.map(|side| lane.edge(side).map(|edge| edge.kept_frames));
        write!(f, "; {}", LaneWords { kept_frames, followed: evidence.followed })?;
        self.departure.map_or(Ok(()), |departure| write!(f, "{}", DepartureWords(departure)))
    }
}

impl Why<'_> {
    fn write_feature(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { track, evidence, stops, .. } = *self;
        let name = |index: &usize| FeatureName(stops.get(*index));
        match (&evidence.decision, &track.followed) {
            (Decision::NoRoute, _) => {
                f.write_str("no route: nothing is looked for but the road, its lanes and the motion")
            }
            (Decision::NothingShown, _) => write!(f, "{}", CameraWords(self.camera)),
            (Decision::RouteDone, _) => f.write_str(ROUTE_DONE),
            (Decision::NotInReach { index, ahead_m }, _) => {
                write!(f, "{} is believed {}, out of the view's reach", name(index), Along(*ahead_m))
            }
            (Decision::NotFound { index, places }, _) => {
                write!(
                    f,
                    "{} not seen: at none of {places} places in view does the ground look like it",
                    name(index)
                )
            }
            (Decision::NotSure { index, lack }, _) => {
                write!(
                    f,
                    "{} may be ahead{}: {}",
                    name(index),
                    SoughtWords(evidence.sought.as_ref()),
                    LackWords(lack)
                )
            }
            (Decision::NoLongerSure { index, lack }, _) => {
                write!(f, "{} lost: {}", name(index), LackWords(lack))
            }
            (Decision::NextUnknown { likeliest, rival }, _) => write!(
                f,
                "no start was given and it is not sure yet where on the route the vehicle is: the first to come was {} ({:.2}), {} \
                 ({:.2}) or another",
                name(&likeliest.0),
                likeliest.1,
                name(&rival.0),
                rival.1
            ),
            (Decision::Skipped { index }, _) => {
                write!(f, "{} lies behind by all that is known and was never seen", name(index))
            }
            (decision, Some(followed)) => self.write_followed(f, decision, followed),
            (_, None) => {
                f.write_str(if track.state == State::RouteDone { ROUTE_DONE } else { "nothing is followed" })
            }
        }
    }

    /// Where the followed feature is, and by what.
    fn write_followed(&self, f: &mut Formatter<'_>, decision: &Decision, followed: &Followed) -> fmt::Result {
        let forward_m = followed.vehicle_from_feature.translation.x;
        write!(f, "{} {:.1}", FeatureName(self.stops.get(followed.index)), Along(forward_m))?;
        let words = FollowedWords(followed);
        match decision {
            Decision::Detected => write!(f, ", detected: {words}"),
            Decision::Arrived => {
                f.write_str(": the start of the curve through it reached the bottom of the view")
            }
            Decision::Passing => f.write_str(": on the driving line through it"),
            _ => write!(f, ": {words}"),
        }?;
        let line = self.stops.get(followed.index).and_then(|stop| stop.line.as_ref());
        match line.filter(|line| !line.within_turning_circle()) {
            Some(&DrivingLine { tightest_radius_m, turning_radius_m, .. }) => {
                write!(f, "; {}", TooTightWords { tightest_radius_m, turning_radius_m })
            }
            None => Ok(()),
        }
    }
}

const ROUTE_DONE: &str = "every feature of the route has been passed";

#[cfg(test)]
mod tests;
