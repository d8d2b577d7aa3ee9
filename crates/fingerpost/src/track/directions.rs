//! Directions without a start: which of the route's features is next is a belief, until what is found says.
//!
//! Paper 1, section VII takes the features as directions in their order, begun at the first. A vehicle that begins in mid-route
//! sees a later one first, and junctions look alike: the first that looks like it would be taken for it. So every feature is followed
//! up as the first one to come, each by a tracker of its own, and weighed by what that finds and does not find where it
//! expects it (`directions/weights.rs`). Nothing is given out while none of them is sure; those that become improbable are given up.

mod weights;

use fingerpost_geometry::GeometryError;
use fingerpost_map::Route;
use fingerpost_vision::span::SpanError;
use nalgebra::Point2;

use self::weights::{Sighting, Weight};
use super::route_stop::route_stops;
use super::{
    Decision, FeatureTracker, Followed, Moved, RouteStop, ShownSurface, State, TrackEvidence, TrackOutput,
    Tracker, TrackerSetting,
};
use crate::feature_masks::SubMaskKind;
use crate::feature_model::ArmModel;
use crate::matching::{Participation, SubMatch};

/// Probability from which a feature is believed to be the first to come, and below which it is no more: trackers that see
/// something like it a frame later are no reason to let go of it.
const SURE: f64 = 0.9;
const STILL_SURE: f64 = 0.5;
/// A hypothesis less probable than this is given up: two features where it expects them would hardly bring it back.
const GIVEN_UP: f64 = 1e-4;

/// Trackers that seek the same feature and have the vehicle within this of each other say the same, metres: as much as a feature
/// may be off to count as found.
const SAME_M: f64 = 3.0;

/// The vehicle comes to one of the features first.
#[derive(Debug)]
struct Hypothesis {
    /// Index of that feature.
    first: usize,
    /// Without its stops, which all of them share.
    tracker: Tracker,
    weight: Weight,
    output: TrackOutput,
    evidence: TrackEvidence,
}

impl Hypothesis {
    /// Takes over the weight of another one, and its place where that was the likelier.
    fn take(&mut self, other: Self) {
        let both = self.weight.now() + other.weight.now();
        if other.weight.now() > self.weight.now() {
            *self = other;
        }
        self.weight.divide(self.weight.now() / both);
    }
}

/// Follows the features of a route on which the vehicle begins anywhere.
#[derive(Debug)]
pub struct Directions {
    stops: Vec<RouteStop>,
    hypotheses: Vec<Hypothesis>,
    /// The first to come, where that is sure.
    believed: Option<usize>,
    driven_m: f64,
}

impl Directions {
    /// Before the first frame of a drive along `route`.
    ///
    /// # Errors
    /// [`GeometryError`] when a feature's arms have no extent.
    pub fn new(setting: TrackerSetting<'_>, route: Option<&Route>) -> Result<Self, GeometryError> {
        let (stops, route_in_map) = route_stops(setting, route)?;
        let places_m: Vec<f64> = stops.iter().map(|stop| stop.model.route_m).collect();
        let hypothesis = |first: usize| Hypothesis {
            first,
            tracker: Tracker::at_directions(setting, first, route_in_map.clone()),
            weight: Weight::of_first(&places_m, first),
            output: TrackOutput::default(),
            evidence: TrackEvidence::default(),
        };
        let hypotheses = (0..stops.len()).map(hypothesis).collect();
        Ok(Self { stops, hypotheses, believed: None, driven_m: 0.0 })
    }

    /// Takes in what the hypotheses' trackers found in a frame, and gives up what is too improbable.
    fn weigh(&mut self) {
        let (stops, driven_m) = (&self.stops, self.driven_m);
        for Hypothesis { tracker, weight, output, evidence, .. } in &mut self.hypotheses {
            let found = output.followed.as_ref().filter(|_| evidence.decision == Decision::Detected);
            let sighting = found.and_then(|found| sighting(stops, found, tracker));
            let is_lost = matches!(evidence.decision, Decision::Lost { .. });
            weight.step(driven_m, sighting, tracker.next(), is_lost);
        }
        let total: f64 = self.hypotheses.iter().map(|hypothesis| hypothesis.weight.now()).sum();
        if total > 0.0 && total.is_finite() {
            self.hypotheses.iter_mut().for_each(|hypothesis| hypothesis.weight.divide(total));
            self.hypotheses.retain(|hypothesis| hypothesis.weight.now() >= GIVEN_UP);
        }
        self.join();
        self.hypotheses
            .sort_unstable_by(|a, b| b.weight.now().total_cmp(&a.weight.now()).then(a.first.cmp(&b.first)));
    }

    /// Makes one of hypotheses whose trackers have come to say the same: that one saw something else first makes no difference then.
    fn join(&mut self) {
        let mut index = 0;
        while let Some((one, others)) = self.hypotheses.get(index..).and_then(<[Hypothesis]>::split_first) {
            let same = others.iter().position(|other| one.tracker.agrees_with(&other.tracker, SAME_M));
            match same {
                Some(offset) => {
                    let other = self.hypotheses.remove(index + 1 + offset);
                    if let Some(one) = self.hypotheses.get_mut(index) {
                        one.take(other);
                    }
                }
                None => index += 1,
            }
        }
    }

    /// A position along the route says what comes next without any of this.
    fn believe_gps(&mut self) {
        let by_gps = |hypothesis: &Hypothesis| hypothesis.evidence.gps.is_some();
        if self.hypotheses.len() > 1 && self.hypotheses.iter().any(by_gps) {
            // The one that can still come to any of them.
            self.hypotheses.sort_unstable_by_key(|hypothesis| hypothesis.first);
            self.hypotheses.truncate(1);
        }
    }
}

/// A feature that a tracker has found, as its weight takes it in; none where no arm is seen that tells it from a plain road, which
/// the rules accept near a place at which they expect it.
fn sighting(stops: &[RouteStop], found: &Followed, tracker: &Tracker) -> Option<Sighting> {
    let (route_m, _) = found.route_m(stops)?;
    let model = &stops.get(found.index)?.model;
    let tells_it = |sub: &SubMatch| {
        let arm = match sub.kind {
            SubMaskKind::Arm { index, .. } => model.arms.get(index),
            SubMaskKind::DrivingLine => None,
        };
        sub.participation == Participation::TakesPart && arm.is_some_and(ArmModel::leaves_the_line)
    };
    let is_told = found.matched.subs.iter().any(tells_it);
    let (index, ahead_m) = (found.index, model.route_m - route_m);
    is_told.then(|| Sighting { index, ahead_m, off: tracker.found_off() })
}

impl FeatureTracker for Directions {
    fn stops(&self) -> &[RouteStop] {
        &self.stops
    }

    fn step(
        &mut self,
        moved: Moved<'_>,
        shown: ShownSurface<'_>,
        gps_in_map: Option<Point2<f64>>,
        output: &mut TrackOutput,
        evidence: &mut TrackEvidence,
    ) -> Result<(), SpanError> {
        self.driven_m += moved.motion.map_or(0.0, |motion| motion.previous_from_current.translation.x);
        for Hypothesis { tracker, output, evidence, .. } in &mut self.hypotheses {
            tracker.exchange_stops(&mut self.stops);
            let stepped = tracker.step(moved, shown, gps_in_map, output, evidence);
            tracker.exchange_stops(&mut self.stops);
            stepped?;
        }
        if self.hypotheses.len() > 1 {
            self.weigh();
            self.believe_gps();
        }
        let rival = self.hypotheses.get(1).map(|rival| (rival.first, rival.weight.now()));
        let Some(likeliest) = self.hypotheses.first_mut() else {
            evidence.clear();
            *output = TrackOutput::default();
            return Ok(());
        };
        let (first, p) = (likeliest.first, likeliest.weight.now());
        let needed_p = if self.believed == Some(first) { STILL_SURE } else { SURE };
        self.believed = (rival.is_none() || p >= needed_p).then_some(first);
        std::mem::swap(output, &mut likeliest.output);
        std::mem::swap(evidence, &mut likeliest.evidence);
        if let Some(rival) = rival.filter(|_| self.believed.is_none()) {
            output.state = State::Searching;
            output.followed = None;
            output.route_m = None;
            output.skipped = None;
            evidence.decision = Decision::NextUnknown { likeliest: (first, p), rival };
        }
        Ok(())
    }
}
